"""A closed surface from any bag of triangles: the half level of its winding number."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from medkit.geometry import Floats

CELLS = 110  # along the diagonal
BAND = 2  # cells on either side of the surface where distances are computed


def remesh_by_winding_number(
    vertices: Floats, faces: NDArray[np.int64], *, cells: int = CELLS
) -> tuple[Floats, NDArray[np.int64]]:
    """Rebuild a surface as the zero level of a distance whose sign is the winding number's.

    Parameters
    ----------
    vertices : ndarray, shape (n, 3)
        Vertices [any unit].
    faces : ndarray, shape (f, 3)
        Triangles, turned outwards for the greater part.
    cells : int
        Grid cells along the diagonal; details under two cells are lost.

    Returns
    -------
    vertices : ndarray, shape (p, 3)
        Vertices of a closed surface, same unit.
    faces : ndarray, shape (q, 3)
        Outward triangles; none when the input encloses nothing.
    """
    from skimage.measure import marching_cubes

    low, high = vertices.min(axis=0), vertices.max(axis=0)
    cell = float(np.linalg.norm(high - low)) / cells
    low = low - (BAND + 2) * cell
    shape = np.ceil((high - low) / cell).astype(int) + BAND + 3
    near = _near_surface(vertices, faces, low, cell, shape)
    index = np.argwhere(near)
    points = np.ascontiguousarray(low + cell * index)
    squared, _, _ = igl.point_mesh_squared_distance(points, vertices, faces)
    inside = igl.fast_winding_number(vertices, faces, points) > 0.5
    field = np.full(tuple(shape), (BAND + 1) * cell)
    field[near] = np.sqrt(squared) * np.where(inside, -1.0, 1.0)
    _sign_regions(field, near, vertices, faces, low, cell)
    if not (field < 0.0).any():
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    points, triangles, _, _ = marching_cubes(field, 0.0, spacing=(cell,) * 3)
    return (
        np.ascontiguousarray(points + low, dtype=float),
        np.ascontiguousarray(triangles.astype(np.int64)),
    )


def _near_surface(
    vertices: Floats, faces: NDArray[np.int64], low: Floats, cell: float, shape: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Mark the grid points within the band, by marking samples of every triangle and growing."""
    corners = vertices[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    near = np.zeros(tuple(shape), dtype=bool)
    steps = np.clip(np.ceil(longest / (0.7 * cell)).astype(int), 1, None)
    for step in np.unique(steps):
        grid = np.array([(i, j) for i in range(step + 1) for j in range(step + 1 - i)]) / step
        weight = np.column_stack([grid, 1.0 - grid.sum(axis=1)])
        points = np.einsum("wk,fkd->fwd", weight, corners[steps == step]).reshape(-1, 3)
        near[tuple(np.round((points - low) / cell).astype(int).T)] = True
    return np.asarray(ndimage.binary_dilation(near, iterations=BAND, structure=np.ones((3, 3, 3))))


def _sign_regions(
    field: Floats,
    near: NDArray[np.bool_],
    vertices: Floats,
    faces: NDArray[np.int64],
    low: Floats,
    cell: float,
) -> None:
    """Give every region away from the surface the sign of one of its points."""
    labels, count = ndimage.label(~near)
    if count == 0:
        return
    _, first = np.unique(labels.ravel(), return_index=True)
    probes = np.column_stack(np.unravel_index(first, labels.shape))
    order = labels.ravel()[first]
    points = np.ascontiguousarray(low + cell * probes)
    inside = igl.fast_winding_number(vertices, faces, points) > 0.5
    for label, is_inside in zip(order, inside, strict=True):
        if label > 0 and is_inside:
            field[labels == label] *= -1.0
