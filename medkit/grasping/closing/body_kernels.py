"""Compiled tests of one convex body against one triangle, and the scratch of a closing loop.

`hulls` is a `HullTable`; poses are (4, 4) maps from a link's frame into the object's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.kernel_options import inner, leaf
from medkit.grasping.closing.sight_kernels import Sight, height_over, hint_at, sight

#: A plane this far [m] above all corners of a triangle is not the nearest of its body.
NEAR_PLANE = 1e-4
#: Largest polygon that clipping a triangle by a body can leave.
POLYGON = 192


class ClipScratch(NamedTuple):
    """Scratch arrays of clipping one triangle."""

    local: np.ndarray
    low: np.ndarray
    top: np.ndarray
    over: np.ndarray
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
    sight: Sight
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
            low=np.zeros(planes),
            top=np.zeros(planes),
            over=np.zeros(POLYGON),
            polygon=np.zeros((POLYGON, 3)),
            spare=np.zeros((POLYGON, 3)),
            active=np.zeros(planes + 1, dtype=np.int64),
            cutting=np.zeros(planes + 1, dtype=np.int64),
            active_count=np.zeros(1, dtype=np.int64),
        ),
        sight=sight(),
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
    first, last = hulls.plane_start[body], hulls.plane_start[body + 1]
    _span(hulls.columns, first, last, clip.local, clip.low, clip.top)
    # without branches, since which planes matter is no pattern that the processor could learn
    active, cut = 0, 0
    for f in range(last - first):
        clip.active[active] = f
        active += 1 if clip.top[f] > -NEAR_PLANE else 0
    for e in range(active):
        f = clip.active[e]
        if clip.low[f] > margin:
            return 0
        clip.active[e] = clip.cutting[cut] = first + f
        cut += 1 if clip.top[f] > margin else 0
    clip.active_count[0] = active
    for v in range(3):
        for a in range(3):
            clip.polygon[v, a] = clip.local[v, a]
    return _cut_polygon(hulls.planes, cut, margin, clip)


@inner
def _span(
    columns: np.ndarray, first: int, last: int, local: np.ndarray, low: np.ndarray, top: np.ndarray
) -> None:
    """Heights of a triangle's ends over the planes ``columns[:, first:last]`` (4, p)."""
    nx, ny, nz = columns[0, first:last], columns[1, first:last], columns[2, first:last]
    d = columns[3, first:last]
    ax, ay, az = local[0, 0], local[0, 1], local[0, 2]
    bx, by, bz = local[1, 0], local[1, 1], local[1, 2]
    cx, cy, cz = local[2, 0], local[2, 1], local[2, 2]
    for f in range(nx.shape[0]):
        ha = nx[f] * ax + ny[f] * ay + nz[f] * az - d[f]
        hb = nx[f] * bx + ny[f] * by + nz[f] * bz - d[f]
        hc = nx[f] * cx + ny[f] * cy + nz[f] * cz - d[f]
        low[f], top[f] = min(min(ha, hb), hc), max(max(ha, hb), hc)


@inner
def _cut_polygon(planes: np.ndarray, cut: int, margin: float, clip: Any) -> int:
    """Clip the triangle in ``clip.polygon`` by the planes in ``clip.cutting``; corners left."""
    over, count = clip.over, 3
    for e in range(cut):
        lowest, highest = _heights_of_corners(planes, clip.cutting[e], margin, count, clip)
        if lowest > 0.0:
            return 0
        if highest <= 0.0:
            continue
        kept = 0
        for v in range(count):
            w = v + 1 if v + 1 < count else 0
            if over[v] <= 0.0:
                for a in range(3):
                    clip.spare[kept, a] = clip.polygon[v, a]
                kept += 1
            if (over[v] < 0.0 and over[w] > 0.0) or (over[v] > 0.0 and over[w] < 0.0):
                t = over[v] / (over[v] - over[w])
                for a in range(3):
                    p, q = clip.polygon[v, a], clip.polygon[w, a]
                    clip.spare[kept, a] = p + t * (q - p)
                kept += 1
        count = min(kept, POLYGON - 2)
        for v in range(count):
            for a in range(3):
                clip.polygon[v, a] = clip.spare[v, a]
    return count


@leaf
def _heights_of_corners(
    planes: np.ndarray, f: int, margin: float, count: int, clip: Any
) -> tuple[float, float]:
    """Heights [m] of a polygon's corners over a plane moved out, into ``clip.over``; the ends."""
    lowest, highest = 1e9, -1e9
    for v in range(count):
        x, y, z = clip.polygon[v, 0], clip.polygon[v, 1], clip.polygon[v, 2]
        clip.over[v] = height_over(planes, f, x, y, z) - margin
        lowest, highest = min(lowest, clip.over[v]), max(highest, clip.over[v])
    return lowest, highest
