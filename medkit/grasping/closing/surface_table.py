"""Samples of the surfaces of the hand's bodies, and a tree of balls around those of each body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.grasping.closing.face_tree import ball_tree
from medkit.robots.hand import LinkBody

Ints = NDArray[np.int64]

#: Spacing of the samples on a body's surface [m].
SAMPLE_SPACING = 0.004


class SurfaceTable(NamedTuple):
    """Samples of each body's surface (arrays only, so that kernels take it), in its link's frame.

    Attributes
    ----------
    start : ndarray of int, shape (b + 1,)
        Body k has the samples ``start[k]:start[k + 1]``.
    samples : ndarray, shape (s, 3)
        The samples [m], as exact in single precision.
    root, fan, first_leaf : ndarray of int, shape (b,)
        Where a body's tree begins in `blocks`, and how it is numbered from there, see `FaceTree`.
    blocks : ndarray, shape (n, 4 * FAN), float32
        The trees' blocks; the balls of leaves are samples.
    """

    start: Ints
    samples: Floats
    root: Ints
    fan: Ints
    first_leaf: Ints
    blocks: NDArray[np.float32]


def surface_table(bodies: tuple[LinkBody, ...] | list[LinkBody]) -> SurfaceTable:
    """Sample the surfaces of bodies and grow their trees.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> table = surface_table(load_hand("wsg50").bodies)
    >>> len(table.fan), table.samples.shape[1]
    (5, 3)
    """
    samples = [_samples(body) for body in bodies]
    trees = [ball_tree(points[:, None], _points_as_balls(points)) for points in samples]
    counts = [len(tree.blocks) for tree in trees]
    return SurfaceTable(
        np.concatenate([[0], np.cumsum([len(points) for points in samples])]).astype(np.int64),
        np.vstack([points[tree.order] for points, tree in zip(samples, trees, strict=True)]),
        np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64),
        np.array([tree.fan for tree in trees], dtype=np.int64),
        np.array([tree.first_leaf for tree in trees], dtype=np.int64),
        np.vstack([tree.blocks for tree in trees]),
    )


def _samples(body: LinkBody) -> Floats:
    """Samples (s, 3) of a body's surface."""
    import trimesh

    vertices, _ = trimesh.remesh.subdivide_to_size(
        body.vertices, body.faces, max_edge=0.5 * SAMPLE_SPACING, max_iter=20
    )
    return _thinned(vertices, SAMPLE_SPACING).astype(np.float32).astype(float)


def _points_as_balls(points: Floats) -> Floats:
    return np.column_stack([points, np.zeros(len(points))])


def _thinned(points: Floats, spacing: float) -> Floats:
    """Keep in each cell of a lattice the point nearest to the others."""
    _, cell = np.unique(np.floor(points / spacing), axis=0, return_inverse=True)
    cell = cell.ravel()
    counts = np.bincount(cell)
    means = np.column_stack([np.bincount(cell, weights=column) / counts for column in points.T])
    off = np.linalg.norm(points - means[cell], axis=1)
    order = np.lexsort((off, cell))
    return np.asarray(points[order[np.concatenate([[True], np.diff(cell[order]) > 0])]])
