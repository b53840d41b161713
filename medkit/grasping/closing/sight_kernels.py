"""Compiled walks down trees of balls: how a body sees a block of them, FAN at a time.

`hulls` is a `HullTable`; `pose` (4, 4) maps from the body's link's frame into the balls' frame.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.face_tree import FAN
from medkit.grasping.closing.hull_tables import CELL
from medkit.grasping.closing.kernel_options import inner, leaf

#: Cells of the table of planes per metre.
PER_CELL = 1.0 / CELL
#: Deepest way down a tree, with all children on the stack.
STACK = 128


class Sight(NamedTuple):
    """Scratch arrays of a walk down a tree; build with `sight`.

    Of the block looked at last, ``middle`` (3 FAN) holds the balls' middles in the link's frame,
    ``plane`` what `hint_at` says there, ``gap`` how far each ball surely is from the body [m].
    """

    stack: np.ndarray
    bounds: np.ndarray
    middle: np.ndarray
    cell: np.ndarray
    plane: np.ndarray
    gap: np.ndarray
    relative: np.ndarray


def sight() -> Sight:
    """Scratch arrays for walks down trees."""
    return Sight(
        stack=np.zeros(STACK, dtype=np.int64),
        bounds=np.zeros(STACK),
        middle=np.zeros(3 * FAN),
        cell=np.zeros(FAN, dtype=np.int32),
        plane=np.zeros(FAN, dtype=np.int64),
        gap=np.zeros(FAN),
        relative=np.zeros((4, 4)),
    )


@leaf
def cell_row(dx: float, dy: float, dz: float, nx: float, ny: float, nz: float) -> Any:
    """Row of the cell, out of nx, ny, nz, nearest to a point so far [m] from the lowest corner."""
    i = float(np.int32(min(max(dx * PER_CELL, 0.0), nx - 1.0)))
    j = float(np.int32(min(max(dy * PER_CELL, 0.0), ny - 1.0)))
    k = float(np.int32(min(max(dz * PER_CELL, 0.0), nz - 1.0)))
    return np.int32((i * ny + j) * nz + k)  # of doubles, which the processor converts in groups


@leaf
def hint_at(hulls: Any, body: int, x: float, y: float, z: float) -> Any:
    """Entry of the table of planes for a point in a link's frame; negative well inside."""
    origin, counts = hulls.origin, hulls.cells
    row = cell_row(
        x - origin[body, 0], y - origin[body, 1], z - origin[body, 2],
        counts[body, 0], counts[body, 1], counts[body, 2],
    )  # fmt: skip
    return np.int64(hulls.hints[hulls.cell_start[body] + row])


@leaf
def height_over(planes: np.ndarray, f: int, x: float, y: float, z: float) -> float:
    """Height [m] of a point over one plane."""
    return planes[f, 0] * x + planes[f, 1] * y + planes[f, 2] * z - planes[f, 3]


@leaf
def first_child(fan: int, node: int) -> int:
    """Number of a node's first child in a tree whose root has `fan` children."""
    return max(FAN * node + fan + 1 - FAN, 1)


@leaf
def look_at(block: np.ndarray, hulls: Any, body: int, pose: np.ndarray, sight: Any) -> None:
    """Write a block (4 FAN) as a body sees it into ``sight.middle``, ``plane`` and ``gap``."""
    middle, cell = sight.middle, sight.cell
    _place_block(block, pose, hulls.origin[body], hulls.cells[body], middle, cell)
    first = hulls.cell_start[body]
    for k in range(FAN):
        f = np.int64(hulls.hints[first + cell[k]])
        sight.plane[k] = f
        f = max(f, -1 - f)
        height = height_over(hulls.planes, f, middle[k], middle[FAN + k], middle[2 * FAN + k])
        sight.gap[k] = height - block[3 * FAN + k]


@inner
def _place_block(
    block: np.ndarray,
    pose: np.ndarray,
    low: np.ndarray,
    counts: np.ndarray,
    middle: np.ndarray,
    cell: np.ndarray,
) -> None:
    """Middles of a block in a link's frame, and the cells about the body that they are in."""
    # All that stays the same is taken out of the loop, and its length is not a constant: else
    # the compiler writes it out eight times instead of having it run four at a time.
    a, b, c, x0 = pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3]
    d, e, f, y0 = pose[1, 0], pose[1, 1], pose[1, 2], pose[1, 3]
    g, h, i, z0 = pose[2, 0], pose[2, 1], pose[2, 2], pose[2, 3]
    low_x, low_y, low_z = low[0], low[1], low[2]
    nx, ny, nz = float(counts[0]), float(counts[1]), float(counts[2])
    for k in range(cell.shape[0]):
        dx, dy, dz = block[k] - x0, block[FAN + k] - y0, block[2 * FAN + k] - z0
        x, y, z = a * dx + d * dy + g * dz, b * dx + e * dy + h * dz, c * dx + f * dy + i * dz
        middle[k], middle[FAN + k], middle[2 * FAN + k] = x, y, z
        cell[k] = cell_row(x - low_x, y - low_y, z - low_z, nx, ny, nz)


@leaf
def push_near(child: int, limit: float, sight: Any, top: int) -> int:
    """Put the children nearer than `limit` [m] on the stack, the nearest on top; its new height."""
    stack, bounds, gap = sight.stack, sight.bounds, sight.gap
    bottom, nearest, least = top, top, 1e9
    for k in range(FAN):  # without branches, which the processor would guess wrong
        stack[top], bounds[top] = child + k, gap[k]
        nearest = top if gap[k] < least else nearest
        least = min(least, gap[k])
        top += 1 if gap[k] < limit else 0
    if top > bottom:
        last = top - 1
        stack[last], stack[nearest] = stack[nearest], stack[last]
        bounds[last], bounds[nearest] = bounds[nearest], bounds[last]
    return top
