"""The hand's convex bodies as planes, and for each place about a body the plane that tells most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from medkit.geometry import Floats

#: Size of the cells in which a body's best plane is looked up, and their reach beyond it [m].
CELL, MARGIN = 0.003, 0.009
#: Cells whose heights are told at once: as many as the processor's own memory holds.
STRETCH = 512


class HullTable(NamedTuple):
    """Convex bodies as planes (arrays only, so that kernels take it), each in its link's frame.

    ``planes[plane_start[b]:plane_start[b + 1]]`` are body b's outward planes ``n . x <= d`` [m].
    A box of cells about it names for each cell the plane f that is highest below its middle: f,
    or -1 - f where all of the cell is inside the body. Any plane is a lower bound of the distance,
    so the table only has to be good, not exact.

    Attributes
    ----------
    plane_start : ndarray of int, shape (b + 1,)
    planes, columns : ndarray, shape (p, 4) and (4, p)
    origin : ndarray, shape (b, 3)
        Lowest corner of each body's cells [m].
    cells : ndarray of int, shape (b, 3)
        Cells along each axis.
    cell_start : ndarray of int, shape (b,)
        A body's first entry in `hints`.
    hints : ndarray of int, shape (sum of cells,)
    """

    plane_start: NDArray[np.int64]
    planes: Floats
    columns: Floats
    origin: Floats
    cells: NDArray[np.int64]
    cell_start: NDArray[np.int64]
    hints: NDArray[Any]


def hull_table(bodies: Sequence[Floats]) -> HullTable:
    """Planes and cells of convex bodies given by their corners (v, 3) [m].

    Examples
    --------
    >>> corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.02
    >>> table = hull_table([corners])
    >>> len(table.planes), table.cells.tolist()
    (6, [[13, 13, 13]])
    """
    planes = [distinct_planes(corners) for corners in bodies]
    start = np.concatenate([[0], np.cumsum([len(p) for p in planes])]).astype(np.int64)
    origin = np.array([corners.min(axis=0) - MARGIN for corners in bodies])
    high = np.array([corners.max(axis=0) + MARGIN for corners in bodies])
    cells = np.ceil((high - origin) / CELL).astype(np.int64)
    counts = cells.prod(axis=1)
    hints = [_hints(p, origin[b], cells[b]) for b, p in enumerate(planes)]
    rows = [np.where(h >= 0, h + start[b], h - start[b]) for b, h in enumerate(hints)]
    # looked up all over a body, so it has to stay in the processor's own memory
    small = np.int16 if start[-1] < 2**15 else np.int32
    return HullTable(
        start,
        np.vstack(planes),
        np.ascontiguousarray(np.vstack(planes).T),
        origin,
        cells,
        np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64),
        np.concatenate(rows).astype(small),
    )


def distinct_planes(corners: Floats) -> Floats:
    """Outward planes (p, 4) of the convex hull of `corners` (v, 3), largest face first."""
    hull = ConvexHull(corners)
    faces = corners[hull.simplices]
    areas = 0.5 * np.linalg.norm(
        np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1
    )
    planes, member = np.unique(hull.equations.round(9), axis=0, return_inverse=True)
    total = np.bincount(member.ravel(), weights=areas, minlength=len(planes))
    planes = planes[np.argsort(-total, kind="stable")]
    return np.column_stack([planes[:, :3], -planes[:, 3]])


def least_width(planes: Floats, corners: Floats) -> float:
    """Least extent [m] of a body across its planes (p, 4)."""
    spans = corners @ planes[:, :3].T
    return float((spans.max(axis=0) - spans.min(axis=0)).min())


def _hints(planes: Floats, origin: Floats, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """The highest plane below the middle of each cell, as -1 - plane if the cell is inside."""
    steps = [origin[a] + (np.arange(cells[a]) + 0.5) * CELL for a in range(3)]
    middles = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    best, top = np.empty(len(middles), dtype=np.int64), np.empty(len(middles))
    for first in range(0, len(middles), STRETCH):
        heights = middles[first : first + STRETCH] @ planes[:, :3].T - planes[:, 3]
        best[first : first + STRETCH] = heights.argmax(axis=1)
        top[first : first + STRETCH] = heights.max(axis=1)
    inside = top < -0.5 * np.sqrt(3.0) * CELL * (1.0 + 1e-9)
    return np.where(inside, -1 - best, best)
