"""Convex link bodies from a few numbers: rounded boxes, spheres and their hulls."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError

from medkit.errors import InputError
from medkit.geometry import Floats, unit

#: A body with more vertices is replaced by its extreme points in this many directions, which lie
#: inside it by up to a fortieth of its radius: closing asks for every vertex of every body.
MOST_VERTICES = 200

#: Edges of a rounded corner's triangle lattice: 10 directions an octant, 80 vertices a box.
CORNER_DIVISIONS = 3


@lru_cache(maxsize=8)
def _octant(divisions: int) -> Floats:
    steps = [
        (i, j, divisions - i - j) for i in range(divisions + 1) for j in range(divisions + 1 - i)
    ]
    return unit(np.array(steps, dtype=float))


def rounded_box(lower: ArrayLike, upper: ArrayLike, rounding: ArrayLike = 0.0) -> Floats:
    """Vertices of a box with edges rounded by eighths of ellipsoids.

    Parameters
    ----------
    lower, upper : array-like, shape (3,)
        Opposite corners, which the body just reaches [m].
    rounding : float or array-like, shape (3,)
        Semi-axes of the rounding along x, y and z [m]; cut at half the box.

    Returns
    -------
    ndarray, shape (m, 3)
        Points whose convex hull is the body [m].

    Examples
    --------
    >>> rounded_box([0, 0, 0], [2, 2, 4], 0.5).max(axis=0)
    array([2., 2., 4.])
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    radius = np.minimum(np.broadcast_to(rounding, 3), 0.5 * (high - low))
    octant = _octant(CORNER_DIVISIONS if np.all(radius > 0.0) else 1)
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    centers = np.where(signs < 0, low + radius, high - radius)
    return (centers[:, None] + signs[:, None] * octant * radius).reshape(-1, 3)


def sphere_points(center: ArrayLike, radius: float) -> Floats:
    """Vertices on a sphere around `center` (3,) [m] of `radius` [m]."""
    middle = np.asarray(center, dtype=float)
    return np.unique(rounded_box(middle - radius, middle + radius, radius).round(9), axis=0)


def cylinder_points(radius: float, length: float, sides: int = 24) -> Floats:
    """Vertices of a cylinder about z, centred at the origin (URDF's convention) [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(sides)])
    half = np.array([0.0, 0.0, 0.5 * length])
    return np.vstack([ring - half, ring + half])


def convex_body(points: ArrayLike) -> tuple[Floats, NDArray[np.int64]]:
    """Convex hull of points as vertices and outward triangles.

    Parameters
    ----------
    points : array-like, shape (n, 3)
        At least four points that do not lie in one plane [m].

    Returns
    -------
    vertices : ndarray, shape (m, 3)
        The points on the hull [m].
    faces : ndarray, shape (f, 3)
        Indices into `vertices`, counter-clockwise seen from outside.

    Raises
    ------
    InputError
        If the points span no solid.
    """
    array = np.unique(np.asarray(points, dtype=float).round(9), axis=0)
    hull = _hull(array)
    if len(hull.vertices) > MOST_VERTICES:
        array = array[np.unique(np.argmax(array @ _directions().T, axis=0))]
        hull = _hull(array)
    kept, faces = np.unique(hull.simplices, return_inverse=True)
    faces = faces.reshape(hull.simplices.shape)
    vertices = array[kept]
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward, ::-1]
    return vertices, faces.astype(np.int64)


def _hull(points: Floats) -> ConvexHull:
    try:
        return ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise InputError(
            f"Expected at least four points of a solid body, but got {len(points)} points that"
            " span none; give it some thickness."
        ) from error


@lru_cache(maxsize=1)
def _directions() -> Floats:
    """Directions spread evenly over the sphere, on a spiral, and the six along the axes."""
    k = np.arange(MOST_VERTICES - 6) + 0.5
    height = 1.0 - 2.0 * k / len(k)
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - height**2)
    spiral = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    return np.vstack([spiral, np.eye(3), -np.eye(3)])
