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
    vertices = _fine_corners(body.vertices, body.faces, 0.5 * SAMPLE_SPACING)
    return _thinned(vertices, SAMPLE_SPACING).astype(np.float32).astype(float)


def _fine_corners(vertices: Floats, faces: Ints, longest: float) -> Floats:
    """Corners (v, 3) of faces whose edges are halved until none exceeds `longest` [m].

    Those of `trimesh.remesh.subdivide_to_size`, in its order; but faces that are small enough
    are not looked at again, and the edges are sorted as numbers.
    """
    corners, left = np.array(vertices, dtype=float), np.array(faces, dtype=np.int64)
    while True:
        ends = np.sort(np.stack([left, np.roll(left, -1, axis=1)], axis=2), axis=2)
        numbers = ends[..., 1] * len(corners) + ends[..., 0]
        edges, row = np.unique(numbers, return_inverse=True)
        low, high = corners[edges % len(corners)], corners[edges // len(corners)]
        long = ((low - high) ** 2).sum(axis=1) ** 0.5 > longest
        if not long.any():
            return corners
        middle = np.where(long, len(corners) + np.cumsum(long) - 1, -1)[row].reshape(-1, 3)
        corners = np.vstack([corners, 0.5 * (low + high)[long]])
        left = _split_faces(corners, left, middle)


def _split_faces(corners: Floats, faces: Ints, middle: Ints) -> Ints:
    """Parts of the faces of which some edge has a corner half way, `middle` (f, 3), else -1."""
    split = middle >= 0
    count = split.sum(axis=1)
    # turned so that the only edge to split is the first, or the only one to keep the last
    first = np.where(count == 2, split.argmin(axis=1) + 1, split.argmax(axis=1))
    turn = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, turn, axis=1).T
    p, q, r = np.take_along_axis(middle, turn, axis=1).T
    one, two, three = (count == n for n in (1, 2, 3))
    across = ((corners[a] - corners[q]) ** 2).sum(axis=1) <= ((corners[p] - corners[c]) ** 2).sum(
        axis=1
    )
    parts = [
        (one, (a, p, c)),
        (one, (p, b, c)),
        (two, (p, b, q)),
        (two, (a, p, np.where(across, q, c))),
        (two, (np.where(across, a, p), q, c)),
        (three, (a, p, r)),
        (three, (p, b, q)),
        (three, (r, q, c)),
        (three, (p, q, r)),
    ]
    return np.vstack([np.column_stack(part)[mask] for mask, part in parts])


def _points_as_balls(points: Floats) -> Floats:
    return np.column_stack([points, np.zeros(len(points))])


def _thinned(points: Floats, spacing: float) -> Floats:
    """Keep in each cell of a lattice the point nearest to the others."""
    cells = np.floor(points / spacing).astype(np.int64)
    cells -= cells.min(axis=0)
    _, y, z = (cells.max(axis=0) + 1).tolist()  # numbers sort faster than rows, and alike
    _, cell = np.unique((cells[:, 0] * y + cells[:, 1]) * z + cells[:, 2], return_inverse=True)
    counts = np.bincount(cell)
    means = np.column_stack([np.bincount(cell, weights=column) / counts for column in points.T])
    off = np.linalg.norm(points - means[cell], axis=1)
    order = np.lexsort((off, cell))
    return np.asarray(points[order[np.concatenate([[True], np.diff(cell[order]) > 0])]])
