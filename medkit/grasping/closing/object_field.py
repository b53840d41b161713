"""The object as closing sees it: a lattice of distances to come near, its triangles to confirm.

Distances are unsigned and exact in a band about the surface. Nothing here asks on which side of
the surface a nearby node lies, so an open mesh does no harm; only nodes well away from the
surface carry an inside flag, from a flood fill that starts at the border.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.grasping.closing.face_tree import FaceTree, face_tree, measured
from medkit.grasping.closing.object_kernels import splat_distances

#: Finest and coarsest spacing of the lattice [m], and the number of nodes aimed at.
FINEST, COARSEST, NODES = 0.0025, 0.02, 1_500_000
#: Width of the band of exact distances, in spacings.
BAND = 2.0
#: Half a cell's diagonal, in spacings: no point is further from the nearest node.
HALF_DIAGONAL = float(np.sqrt(3.0) / 2.0)


class ObjectField(NamedTuple):
    """An object prepared for closing hands around it (arrays only, so that kernels take it).

    Attributes
    ----------
    triangles : ndarray, shape (f, 3, 3)
        Corners of the faces [m].
    normals : ndarray, shape (f, 3)
        Outward unit normals of the faces; zero where a face has no area worth the name.
    tree : FaceTree
        The faces, in pieces no longer than a few cells.
    origin : ndarray, shape (3,)
        Lowest corner of the lattice [m].
    spacing : float
        Spacing of the lattice [m].
    distances : ndarray, shape (nx, ny, nz), float32
        At each node a distance [m] that is never above the true one to the surface.
    inside : ndarray, shape (nx, ny, nz), bool
        Whether the node lies inside, for nodes well away from the surface.
    """

    triangles: Floats
    normals: Floats
    tree: FaceTree
    origin: Floats
    spacing: float
    distances: NDArray[np.float32]
    inside: NDArray[np.bool_]


def object_field(triangles: Floats, *, spacing: float | None = None) -> ObjectField:
    """Prepare an object's triangles for closing.

    Parameters
    ----------
    triangles : ndarray, shape (f, 3, 3)
        Corners of the faces [m], counter-clockwise seen from outside.
    spacing : float, optional
        Spacing of the distance lattice [m]; chosen from the object's size when left out. It
        changes the speed of closing, not its result.

    Returns
    -------
    ObjectField
        Arrays that the closing kernels take.

    Raises
    ------
    InputError
        If there is no triangle or a corner is not finite.

    Examples
    --------
    >>> import trimesh
    >>> field = object_field(trimesh.creation.box([0.1, 0.1, 0.1]).triangles, spacing=0.01)
    >>> bool(field.inside.any()), len(field.triangles)
    (True, 12)
    """
    corners = np.array(triangles, dtype=float, order="C")  # writable, as kernels are compiled
    if corners.ndim != 3 or corners.shape[1:] != (3, 3) or not len(corners):
        raise InputError(
            f"Expected triangles of shape (f, 3, 3), but got shape {corners.shape}; pass"
            " mesh.triangles of a mesh that has faces."
        )
    if not np.isfinite(corners).all():
        raise InputError("Expected finite corners of triangles, but one is not; repair the mesh.")
    low, high = (np.array([side(corners[..., a]) for a in range(3)]) for side in (np.min, np.max))
    step = lattice_spacing(high - low) if spacing is None else float(spacing)
    margin = (BAND + 1.0) * step
    shape = tuple(int(n) for n in np.ceil((high - low + 2.0 * margin) / step).astype(int) + 1)
    # Pieces no longer than a few cells keep the boxes around tilted faces small.
    pieces, faces = split_long_edges(corners, 4.0 * step)
    distances, inside = _distances(pieces, low - margin, step, shape)
    return ObjectField(
        corners,
        _face_normals(corners),
        face_tree(pieces, faces),
        low - margin,
        step,
        distances,
        inside,
    )


def lattice_spacing(extents: Floats) -> float:
    """Spacing [m] that keeps the lattice of an object with these extents [m] near its aim."""
    volume = float(np.prod(np.maximum(extents, 0.02)))
    return float(np.clip(np.cbrt(volume / NODES), FINEST, COARSEST))


def split_long_edges(triangles: Floats, longest: float) -> tuple[Floats, NDArray[np.int32]]:
    """Halve triangles at their longest edge until no edge exceeds `longest` [m].

    Returns
    -------
    pieces : ndarray, shape (p, 3, 3)
        The pieces, those of one triangle in sequence.
    source : ndarray of int32, shape (p,)
        The triangle that each piece is from.
    """
    halves, source = triangles, np.arange(len(triangles), dtype=np.int32)
    pieces, sources = [], []
    while len(halves):
        length, edge = measured(halves)
        long = length > longest
        pieces.append(halves[~long])
        sources.append(source[~long])
        a, b, c = (halves[long, (edge[long] + shift) % 3] for shift in range(3))
        middle = 0.5 * (a + b)
        halves = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        source = np.concatenate([source[long], source[long]])
    if len(pieces) == 1:
        return triangles, sources[0]
    source = np.concatenate(sources)
    order = np.argsort(source, kind="stable")
    return np.ascontiguousarray(np.concatenate(pieces)[order]), source[order]


def _distances(
    pieces: Floats, origin: Floats, step: float, shape: tuple[int, ...]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Lower bounds of the distance at the nodes, and which nodes are inside."""
    squared = np.full(shape, np.inf, dtype=np.float32)
    splat_distances(pieces, origin, step, BAND * step, squared)
    distances = np.sqrt(squared)
    # Every surface point has a node of the shell within half a diagonal, and vice versa.
    shell = distances <= HALF_DIAGONAL * step * (1.0 + 1e-6)
    far = ndimage.distance_transform_edt(~shell, sampling=step) - HALF_DIAGONAL * step
    distances = np.minimum(distances, np.maximum(far, 0.0), where=~shell, out=distances)
    exact = squared <= (BAND * step) ** 2
    distances[exact] = np.sqrt(squared[exact])
    parts, _ = ndimage.label(distances > 0.5 * step)
    inside = (parts > 0) & (parts != parts[0, 0, 0])
    return distances, inside


def _face_normals(corners: Floats) -> Floats:
    """Outward unit normals; zero for slivers, whose direction is rounding noise."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    good = length > 1e-6 * measured(corners)[0] ** 2
    normals = np.zeros_like(cross)
    normals[good] = cross[good] / length[good, None]
    return normals
