"""The size of an object, whichever way it is turned: the diagonal of its smallest box."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from medkit.geometry import Floats
from medkit.medial.surface_kernels import ends_along

_DIRECTIONS = 128  # in each of which the two outermost vertices stand for the object
_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0
_TIE = 1e-6  # share of a length or angle under which two are taken for equal


def smallest_diagonal(vertices: Floats) -> float:
    """Diagonal of the smallest box around some points, in any direction [unit of the points].

    The diagonal of the box along x, y and z changes when an object is turned, by up to 70 % for a
    cube, and with it everything that is measured in shares of it. Here every box is tried that
    lies flush with a face and an edge of the convex hull, and the shortest diagonal is taken:
    a number that knows no pose.

    Parameters
    ----------
    vertices : ndarray, shape (n, 3)
        At least one finite point.

    Returns
    -------
    float
        The diagonal; for flat points, or points on a line, twice the distance of the outermost
        from the middle. Round objects may come out up to 1 % small, since only some 500
        outermost points are looked at.

    Examples
    --------
    >>> import trimesh
    >>> box = trimesh.creation.box((4.0, 4.0, 2.0))
    >>> round(smallest_diagonal(box.vertices), 9)
    6.0
    >>> turned = box.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3]))
    >>> round(smallest_diagonal(turned.vertices), 9)
    6.0
    """
    offsets = vertices - vertices.mean(axis=0)
    reach = float(np.linalg.norm(offsets, axis=1).max())
    if reach == 0.0:
        return 0.0
    offsets = offsets / reach
    outer = _outermost(offsets)
    try:
        hull = ConvexHull(outer)
    except (QhullError, ValueError):
        return 2.0 * reach
    directions = _flush_frames(outer, hull).reshape(-1, 3)
    low, high = ends_along(outer, directions)
    extents = np.sum((outer[high] - outer[low]) * directions, axis=1).reshape(-1, 3)
    return reach * float(np.sqrt(np.sum(extents**2, axis=1).min()))


def in_own_frame(points: Floats) -> Floats:
    """Coordinates (n, 3) about the middle of some points, in a frame that turns with them."""
    offsets = points - points.mean(axis=0)
    reach = float(np.linalg.norm(offsets, axis=1).max())
    if reach == 0.0:
        return offsets
    return np.asarray(offsets @ _own_frame(offsets / reach).T)


def _own_frame(offsets: Floats) -> Floats:
    """Frame (3, 3), as rows, that turns with the points: no direction of the world enters.

    Where several points would do, as at the corners of a box, the first in the list is taken;
    rounding must not choose.
    """
    first = offsets[_first_largest(np.linalg.norm(offsets, axis=1))]
    first = first / np.linalg.norm(first)
    aside = offsets - np.outer(offsets @ first, first)
    second = aside[_first_largest(np.linalg.norm(aside, axis=1))]
    length = np.linalg.norm(second)
    if length < _TIE:
        second = np.eye(3)[np.argmin(np.abs(first))]
        second = second - (second @ first) * first
        length = np.linalg.norm(second)
    second = second / length
    return np.array([first, second, np.cross(first, second)])


def _first_largest(values: Floats) -> int:
    return int(np.argmax(values >= (1.0 - _TIE) * values.max()))


def _outermost(offsets: Floats) -> Floats:
    """The points (m, 3) that lie outermost in many even directions of the points' own frame."""
    index = np.arange(_DIRECTIONS) + 0.5
    z = 1.0 - index / _DIRECTIONS  # the other half sphere are the other ends
    turn = 2.0 * np.pi * index / _GOLDEN
    flat = np.sqrt(1.0 - z * z)
    directions = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    ends = ends_along(offsets, directions @ _own_frame(offsets))
    return offsets[np.unique(np.concatenate(ends))]


def _flush_frames(points: Floats, hull: ConvexHull) -> Floats:
    """Frames (m, 3, 3), as rows, along a face's normal and one of its edges."""
    normals = hull.equations[:, :3]
    face, corner = np.nonzero(
        np.linalg.norm(normals[hull.neighbors] - normals[:, None], axis=2) > _TIE
    )
    # an edge between two halves of one flat face is an accident of cutting it: left out above
    ends = hull.simplices[face[:, None], (corner[:, None] + [1, 2]) % 3]
    edges = points[ends[:, 1]] - points[ends[:, 0]]
    edges -= np.sum(edges * normals[face], axis=1, keepdims=True) * normals[face]
    length = np.linalg.norm(edges, axis=1)
    face, edges = face[length > _TIE], edges[length > _TIE] / length[length > _TIE, None]
    return np.stack([normals[face], edges, np.cross(normals[face], edges)], axis=1)
