"""Compiled tests of one convex body against one triangle, and the scratch of a closing loop.

`hulls` is a `HullTable`; poses are (4, 4) maps from a link's frame into the object's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.hull_tables import CELL
from medkit.grasping.closing.kernel_options import inner, leaf

#: Cells of the table of planes per metre.
PER_CELL = 1.0 / CELL
#: A plane this far [m] above all corners of a triangle is not the nearest of its body.
NEAR_PLANE = 1e-4
#: Largest polygon that clipping a triangle by a body can leave.
POLYGON = 192
#: Deepest way down a `FaceTree`, with both children on the stack.
STACK = 128


class ClipScratch(NamedTuple):
    """Scratch arrays of clipping one triangle."""

    local: np.ndarray
    heights: np.ndarray
    polygon: np.ndarray
    spare: np.ndarray
    active: np.ndarray
    cutting: np.ndarray
    active_count: np.ndarray


class Workspace(NamedTuple):
    """Scratch arrays of one closing loop; build with `workspace`.

    ``poses`` are those of the links, ``slack`` what each body may surely travel before it meets
    the object [m], ``hit`` the piece of the object that was met last, or -1; ``room`` is what
    the two bodies of each pair of partners may surely travel before they meet [m].
    """

    clip: ClipScratch
    stack: np.ndarray
    bounds: np.ndarray
    hit: np.ndarray
    poses: np.ndarray
    at_joint: np.ndarray
    motion: np.ndarray
    here: np.ndarray
    slack: np.ndarray
    fresh: np.ndarray
    room: np.ndarray
    slope: np.ndarray
    stamps: np.ndarray
    stamp: np.ndarray
    faces: np.ndarray


def workspace(field: Any, hand: Any) -> Workspace:
    """Scratch arrays for one object and one hand."""
    faces, planes, bodies = len(field.triangles), len(hand.hulls.planes), len(hand.body_link)
    return Workspace(
        clip=ClipScratch(
            local=np.zeros((3, 3)),
            heights=np.zeros(planes),
            polygon=np.zeros((POLYGON, 3)),
            spare=np.zeros((POLYGON, 3)),
            active=np.zeros(planes, dtype=np.int64),
            cutting=np.zeros(planes, dtype=np.int64),
            active_count=np.zeros(1, dtype=np.int64),
        ),
        stack=np.zeros(STACK, dtype=np.int64),
        bounds=np.zeros(STACK),
        hit=np.zeros(1, dtype=np.int64),
        poses=np.tile(np.eye(4), (len(hand.parent), 1, 1)),
        at_joint=np.zeros((4, 4)),
        motion=np.zeros((4, 4)),
        here=np.zeros((4, 4)),
        slack=np.zeros(bodies),
        fresh=np.zeros(bodies),
        room=np.zeros(len(hand.partner)),
        slope=np.zeros(planes),
        stamps=np.zeros(faces, dtype=np.int64),
        stamp=np.zeros(1, dtype=np.int64),
        faces=np.zeros(faces, dtype=np.int64),
    )


@leaf
def moved(pose: np.ndarray, points: np.ndarray, row: int) -> tuple[float, float, float]:
    """One of many points (n, 3 or more), moved by a pose."""
    p, q, r = points[row, 0], points[row, 1], points[row, 2]
    return (
        pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3],
        pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3],
        pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3],
    )


@leaf
def to_link(pose: np.ndarray, triangle: np.ndarray, local: np.ndarray) -> None:
    """Write a triangle (3, 3) of the object into `local`, in a link's frame."""
    for v in range(3):
        dx = triangle[v, 0] - pose[0, 3]
        dy = triangle[v, 1] - pose[1, 3]
        dz = triangle[v, 2] - pose[2, 3]
        for a in range(3):
            local[v, a] = pose[0, a] * dx + pose[1, a] * dy + pose[2, a] * dz


@leaf
def hint_at(hulls: Any, body: int, x: float, y: float, z: float) -> Any:
    """Entry of the table of planes for a point in a link's frame; negative well inside."""
    counts = hulls.cells
    i = int(min(max((x - hulls.origin[body, 0]) * PER_CELL, 0.0), counts[body, 0] - 1.0))
    j = int(min(max((y - hulls.origin[body, 1]) * PER_CELL, 0.0), counts[body, 1] - 1.0))
    k = int(min(max((z - hulls.origin[body, 2]) * PER_CELL, 0.0), counts[body, 2] - 1.0))
    row = hulls.cell_start[body] + (i * counts[body, 1] + j) * counts[body, 2] + k
    return np.int64(hulls.hints[row])


@leaf
def height_over(planes: np.ndarray, f: int, x: float, y: float, z: float) -> float:
    """Height [m] of a point over one plane."""
    return planes[f, 0] * x + planes[f, 1] * y + planes[f, 2] * z - planes[f, 3]


@leaf
def sure_height(hulls: Any, body: int, x: float, y: float, z: float) -> float:
    """Height [m] that a point in a link's frame has over a body at the least."""
    f = hint_at(hulls, body, x, y, z)
    return height_over(hulls.planes, max(f, -1 - f), x, y, z)


@leaf
def lowest_corner(planes: np.ndarray, f: int, local: np.ndarray) -> float:
    """Height [m] of a triangle's lowest corner over one plane."""
    return min(
        height_over(planes, f, local[0, 0], local[0, 1], local[0, 2]),
        height_over(planes, f, local[1, 0], local[1, 1], local[1, 2]),
        height_over(planes, f, local[2, 0], local[2, 1], local[2, 2]),
    )


@leaf
def apart(hulls: Any, body: int, margin: float, local: np.ndarray) -> bool:
    """Whether one of the planes next to a triangle's corners parts it from a body; not all do."""
    for v in range(3):
        f = hint_at(hulls, body, local[v, 0], local[v, 1], local[v, 2])
        if f >= 0 and lowest_corner(hulls.planes, f, local) > margin:
            return True
    return False


@inner
def touches(hulls: Any, body: int, clip: Any) -> bool:
    """Whether the triangle in ``clip.local`` and a body share a point; exact."""
    local = clip.local
    for v in range(3):
        f = hint_at(hulls, body, local[v, 0], local[v, 1], local[v, 2])
        if f < 0:
            return True
        if lowest_corner(hulls.planes, f, local) > 0.0:
            return False
    return clip_to_body(hulls, body, 0.0, clip) > 0


@inner
def clip_to_body(hulls: Any, body: int, margin: float, clip: Any) -> int:
    """Part of the triangle ``clip.local`` inside a body grown by `margin` [m].

    Returns the number of its corners, which are in ``clip.polygon``; 0 when triangle and body
    are apart. ``clip.active`` lists the planes that some corner is near or beyond.
    """
    planes, local = hulls.planes, clip.local
    first, last = hulls.plane_start[body], hulls.plane_start[body + 1]
    x = (local[0, 0] + local[1, 0] + local[2, 0]) / 3.0
    y = (local[0, 1] + local[1, 1] + local[2, 1]) / 3.0
    z = (local[0, 2] + local[1, 2] + local[2, 2]) / 3.0
    radius = 0.0
    for v in range(3):
        d0, d1, d2 = local[v, 0] - x, local[v, 1] - y, local[v, 2] - z
        radius = max(radius, d0 * d0 + d1 * d1 + d2 * d2)
    radius = np.sqrt(radius)
    # Most planes are far above all of the triangle: that takes one corner each to see, and
    # a loop without branches.
    _heights(hulls.columns, first, last, x, y, z, clip.heights)
    cut = active = 0
    for f in range(first, last):
        if clip.heights[f - first] + radius <= -NEAR_PLANE:
            continue
        h0 = height_over(planes, f, local[0, 0], local[0, 1], local[0, 2])
        h1 = height_over(planes, f, local[1, 0], local[1, 1], local[1, 2])
        h2 = height_over(planes, f, local[2, 0], local[2, 1], local[2, 2])
        top = max(h0, h1, h2)
        if top <= -NEAR_PLANE:
            continue
        if min(h0, h1, h2) > margin:
            return 0
        clip.active[active] = f
        active += 1
        if top > margin:
            clip.cutting[cut] = f
            cut += 1
    clip.active_count[0] = active
    for v in range(3):
        for a in range(3):
            clip.polygon[v, a] = local[v, a]
    return _cut_polygon(planes, cut, margin, clip)


@inner
def _heights(
    columns: np.ndarray, first: int, last: int, x: float, y: float, z: float, out: np.ndarray
) -> None:
    """Heights of a point over the planes ``columns[:, first:last]`` (4, p), into `out`."""
    nx, ny, nz, d = (
        columns[0, first:last],
        columns[1, first:last],
        columns[2, first:last],
        columns[3, first:last],
    )
    for f in range(nx.shape[0]):
        out[f] = nx[f] * x + ny[f] * y + nz[f] * z - d[f]


@inner
def _cut_polygon(planes: np.ndarray, cut: int, margin: float, clip: Any) -> int:
    """Clip the triangle in ``clip.polygon`` by the planes in ``clip.cutting``; corners left."""
    polygon, spare = clip.polygon, clip.spare
    count = 3
    swapped = False
    for e in range(cut):
        f = clip.cutting[e]
        kept = 0
        for v in range(count):
            w = v + 1 if v + 1 < count else 0
            hp = height_over(planes, f, polygon[v, 0], polygon[v, 1], polygon[v, 2]) - margin
            hq = height_over(planes, f, polygon[w, 0], polygon[w, 1], polygon[w, 2]) - margin
            if hp <= 0.0:
                for a in range(3):
                    spare[kept, a] = polygon[v, a]
                kept += 1
            if (hp < 0.0 and hq > 0.0) or (hp > 0.0 and hq < 0.0):
                t = hp / (hp - hq)
                for a in range(3):
                    spare[kept, a] = polygon[v, a] + t * (polygon[w, a] - polygon[v, a])
                kept += 1
        if kept == 0:
            return 0
        polygon, spare = spare, polygon
        swapped = not swapped
        count = min(kept, POLYGON - 2)
    if swapped:
        for v in range(count):
            for a in range(3):
                clip.polygon[v, a] = polygon[v, a]
    return count
