"""Compiled tests of one convex body: clearance from the lattice, hits on the triangles.

`field` is an `ObjectField`, `hand` a `ClosingHand`, `work` a `Workspace`; poses are (4, 4) maps
from a link's frame into the object's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.kernel_options import entry, inner, leaf

#: Lattice values are off by at most this many spacings between nodes (half a cell's diagonal).
SLACK = float(np.sqrt(3.0) / 2.0) * (1.0 + 1e-6)
#: A plane this far [m] above all corners of a triangle is not the nearest of its body.
NEAR_PLANE = 1e-4
#: Largest polygon that clipping a triangle by a body can leave.
POLYGON = 192


class Workspace(NamedTuple):
    """Scratch arrays of one closing loop; build with `workspace`."""

    stamps: np.ndarray
    counter: np.ndarray
    faces: np.ndarray
    polygon: np.ndarray
    spare: np.ndarray
    local: np.ndarray
    poses: np.ndarray
    at_joint: np.ndarray
    motion: np.ndarray
    near: np.ndarray
    bound: np.ndarray
    slope: np.ndarray
    active: np.ndarray
    active_count: np.ndarray
    cutting: np.ndarray
    hint: np.ndarray
    part_low: np.ndarray
    part_high: np.ndarray


def workspace(field: Any, hand: Any) -> Workspace:
    """Scratch arrays for one object and one hand."""
    faces = len(field.triangles)
    return Workspace(
        stamps=np.zeros(faces, dtype=np.int64),
        counter=np.zeros(1, dtype=np.int64),
        faces=np.zeros(faces, dtype=np.int64),
        polygon=np.zeros((POLYGON, 3)),
        spare=np.zeros((POLYGON, 3)),
        local=np.zeros((3, 3)),
        poses=np.tile(np.eye(4), (len(hand.parent), 1, 1)),
        at_joint=np.zeros((4, 4)),
        motion=np.zeros((4, 4)),
        near=np.zeros(len(hand.body_link), dtype=np.bool_),
        bound=np.zeros((3, 2)),
        slope=np.zeros(len(hand.planes)),
        active=np.zeros(len(hand.planes), dtype=np.int64),
        active_count=np.zeros(1, dtype=np.int64),
        cutting=np.zeros(len(hand.planes), dtype=np.int64),
        hint=np.array(hand.plane_start[:-1]),
        part_low=np.zeros((len(hand.body_link), 3)),
        part_high=np.zeros((len(hand.body_link), 3)),
    )


@leaf
def lattice_clearance(field: Any, x: float, y: float, z: float) -> float:
    """Distance [m] that the surface keeps from a point at the least."""
    shape = field.distances.shape
    h = field.spacing
    u = (x - field.origin[0]) / h
    v = (y - field.origin[1]) / h
    w = (z - field.origin[2]) / h
    a = min(max(u, 0.0), shape[0] - 1.000001)
    b = min(max(v, 0.0), shape[1] - 1.000001)
    c = min(max(w, 0.0), shape[2] - 1.000001)
    outside = (u - a) ** 2 + (v - b) ** 2 + (w - c) ** 2
    if outside > 1e-6:
        # The lattice reaches well beyond the object: the way to its border is a lower bound.
        return h * np.sqrt(outside)
    i, j, k = int(a), int(b), int(c)
    a, b, c = a - i, b - j, c - k
    d = field.distances
    low = (d[i, j, k] * (1 - c) + d[i, j, k + 1] * c) * (1 - b) + (
        d[i, j + 1, k] * (1 - c) + d[i, j + 1, k + 1] * c
    ) * b
    high = (d[i + 1, j, k] * (1 - c) + d[i + 1, j, k + 1] * c) * (1 - b) + (
        d[i + 1, j + 1, k] * (1 - c) + d[i + 1, j + 1, k + 1] * c
    ) * b
    return low * (1 - a) + high * a - SLACK * h


@entry
def point_clearance(field: Any, x: float, y: float, z: float) -> float:
    """`lattice_clearance` for callers outside compiled code."""
    return lattice_clearance(field, x, y, z)


@leaf
def moved(pose: np.ndarray, points: np.ndarray, row: int) -> tuple[float, float, float]:
    """One of many points (n, 3), moved by a pose."""
    p, q, r = points[row, 0], points[row, 1], points[row, 2]
    return (
        pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3],
        pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3],
        pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3],
    )


@inner
def body_clearance(field: Any, hand: Any, body: int, pose: np.ndarray, enough: float) -> float:
    """Distance [m] that the object's surface keeps from a body's surface at the least.

    Stops early once it is known to be below zero; values above `enough` need not be exact.
    """
    best = enough
    for g in range(hand.group_start[body], hand.group_start[body + 1]):
        x, y, z = moved(pose, hand.group_center, g)
        slack = hand.group_radius[g] + hand.cover[body]
        if lattice_clearance(field, x, y, z) - slack >= best:
            continue
        for s in range(hand.sample_start[g], hand.sample_start[g + 1]):
            x, y, z = moved(pose, hand.samples, s)
            value = lattice_clearance(field, x, y, z) - hand.cover[body]
            if value < best:
                best = value
        if best <= 0.0:
            return best
    return best


@inner
def near_part(
    field: Any, hand: Any, body: int, pose: np.ndarray, reach: float, enough: float, work: Any
) -> float:
    """Clearance of a body as in `body_clearance`, and the part of it that is within `reach` [m].

    The part is a box in the link's frame, in ``work.part_low`` and ``work.part_high`` at the
    body's row: no other point of its surface is within reach of the object's surface.
    """
    best = enough
    for a in range(3):
        work.part_low[body, a] = 1e9
        work.part_high[body, a] = -1e9
    cover = hand.cover[body]
    for g in range(hand.group_start[body], hand.group_start[body + 1]):
        x, y, z = moved(pose, hand.group_center, g)
        radius = hand.group_radius[g] + cover
        if lattice_clearance(field, x, y, z) - radius >= max(best, reach):
            continue
        least = 1e9
        for s in range(hand.sample_start[g], hand.sample_start[g + 1]):
            x, y, z = moved(pose, hand.samples, s)
            value = lattice_clearance(field, x, y, z) - cover
            least = min(least, value)
            if value < reach:
                for a in range(3):
                    work.part_low[body, a] = min(work.part_low[body, a], hand.samples[s, a] - cover)
                    work.part_high[body, a] = max(
                        work.part_high[body, a], hand.samples[s, a] + cover
                    )
        best = min(best, least)
    for a in range(3):
        work.part_low[body, a] = max(work.part_low[body, a], hand.box_low[body, a])
        work.part_high[body, a] = min(work.part_high[body, a], hand.box_high[body, a])
    return best


@inner
def way_out_of_inside(
    field: Any, hand: Any, body: int, pose: np.ndarray, approach: np.ndarray, way: float
) -> float:
    """Retreat [m] of at least `way` after which no sample of a body is well inside the object.

    A sample inside stays inside until it leaves, so no free pose is passed over.
    """
    shape = field.distances.shape
    h = field.spacing
    for s in range(
        hand.sample_start[hand.group_start[body]], hand.sample_start[hand.group_start[body + 1]]
    ):
        x, y, z = moved(pose, hand.samples, s)
        while True:
            i = round((x - way * approach[0] - field.origin[0]) / h)
            j = round((y - way * approach[1] - field.origin[1]) / h)
            k = round((z - way * approach[2] - field.origin[2]) / h)
            if not (0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2]):
                break
            if not field.inside[i, j, k]:
                break
            # Too near the surface to know the depth: a small certain step out instead.
            way += max(field.distances[i, j, k] - SLACK * h, 0.2 * h)
    return way


@inner
def deepest_inside(field: Any, hand: Any, body: int, pose: np.ndarray) -> float:
    """Depth [m] that some sample of a body surely has inside the object, 0 if none surely is."""
    shape = field.distances.shape
    deepest = 0.0
    for s in range(
        hand.sample_start[hand.group_start[body]], hand.sample_start[hand.group_start[body + 1]]
    ):
        x, y, z = moved(pose, hand.samples, s)
        i = round((x - field.origin[0]) / field.spacing)
        j = round((y - field.origin[1]) / field.spacing)
        k = round((z - field.origin[2]) / field.spacing)
        if 0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2] and field.inside[i, j, k]:
            known = field.distances[i, j, k] - SLACK * field.spacing
            deepest = max(deepest, known, 0.2 * field.spacing)
    return deepest


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
def _corners_beyond(planes: np.ndarray, f: int, local: np.ndarray, margin: float) -> int:
    """How many corners of a triangle lie beyond a plane that is moved out by `margin` [m]."""
    n0, n1, n2, d = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, 3] + margin
    out = 0
    for v in range(3):
        if n0 * local[v, 0] + n1 * local[v, 1] + n2 * local[v, 2] > d:
            out += 1
    return out


@leaf
def parted(
    field: Any, hand: Any, body: int, face: int, pose: np.ndarray, margin: float, work: Any
) -> bool:
    """Whether the plane that parted the last face from this body parts this one too.

    Settles most faces without a call of `clip_to_body`; leaves the face in ``work.local``.
    """
    to_link(pose, field.triangles[face], work.local)
    return _corners_beyond(hand.planes, work.hint[body], work.local, margin) == 3


@inner
def clip_to_body(hand: Any, body: int, local: np.ndarray, margin: float, work: Any) -> int:
    """Part of a triangle inside a body grown by `margin` [m]; its corners are in `work.polygon`.

    Returns the number of corners, 0 when triangle and body are apart. ``work.active`` lists the
    planes that some corner of the triangle is near or beyond.
    """
    planes = hand.planes
    # The plane that parted the last face from this body mostly parts the next one too.
    if _corners_beyond(planes, work.hint[body], local, margin) == 3:
        return 0
    cut = active = 0
    for f in range(hand.plane_start[body], hand.plane_start[body + 1]):
        n0, n1, n2, d = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, 3]
        h0 = n0 * local[0, 0] + n1 * local[0, 1] + n2 * local[0, 2] - d
        h1 = n0 * local[1, 0] + n1 * local[1, 1] + n2 * local[1, 2] - d
        h2 = n0 * local[2, 0] + n1 * local[2, 1] + n2 * local[2, 2] - d
        top = max(h0, h1, h2)
        if top <= -NEAR_PLANE:
            continue
        if min(h0, h1, h2) > margin:
            work.hint[body] = f
            return 0
        work.active[active] = f
        active += 1
        if top > margin:
            work.cutting[cut] = f
            cut += 1
    work.active_count[0] = active
    polygon, spare = work.polygon, work.spare
    for v in range(3):
        for a in range(3):
            polygon[v, a] = local[v, a]
    count = 3
    swapped = False
    for e in range(cut):
        f = work.cutting[e]
        n0, n1, n2, d = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, 3] + margin
        kept = 0
        for v in range(count):
            w = v + 1 if v + 1 < count else 0
            hp = n0 * polygon[v, 0] + n1 * polygon[v, 1] + n2 * polygon[v, 2] - d
            hq = n0 * polygon[w, 0] + n1 * polygon[w, 1] + n2 * polygon[w, 2] - d
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
                work.polygon[v, a] = polygon[v, a]
    return count


@leaf
def slab_interval(
    start: float, slope: float, low: float, high: float, first: float, last: float
) -> tuple[float, float]:
    """Part of [first, last] where start + slope * t lies in [low, high]; empty if reversed."""
    if abs(slope) < 1e-12:
        if start < low or start > high:
            return 1.0, 0.0
        return first, last
    a = (low - start) / slope
    b = (high - start) / slope
    return max(first, min(a, b)), min(last, max(a, b))


@inner
def collect_faces(
    field: Any, hand: Any, body: int, pose: np.ndarray, reach: float, work: Any
) -> int:
    """Faces that may come within `reach` [m] of a body's box, into `work.faces`; how many."""
    for a in range(3):
        work.part_low[body, a] = hand.box_low[body, a]
        work.part_high[body, a] = hand.box_high[body, a]
    return collect_part(field, body, pose, reach, work)


@inner
def collect_part(field: Any, body: int, pose: np.ndarray, reach: float, work: Any) -> int:
    """Faces that may come within `reach` [m] of the part of a body that `near_part` found."""
    h = field.spacing
    low, high = work.part_low, work.part_high
    if low[body, 0] > high[body, 0]:
        return 0
    bound = work.bound
    cells = (
        field.distances.shape[0] - 1,
        field.distances.shape[1] - 1,
        field.distances.shape[2] - 1,
    )
    for a in range(3):
        middle, half = pose[a, 3], reach
        for b in range(3):
            middle += pose[a, b] * 0.5 * (low[body, b] + high[body, b])
            half += abs(pose[a, b]) * 0.5 * (high[body, b] - low[body, b])
        bound[a, 0] = max(np.floor((middle - half - field.origin[a]) / h), 0.0)
        bound[a, 1] = min(np.floor((middle + half - field.origin[a]) / h), cells[a] - 1.0)
    work.counter[0] += 1
    stamp = work.counter[0]
    grown = reach + SLACK * h
    found = 0
    for i in range(int(bound[0, 0]), int(bound[0, 1]) + 1):
        dx = field.origin[0] + (i + 0.5) * h - pose[0, 3]
        for j in range(int(bound[1, 0]), int(bound[1, 1]) + 1):
            row = (i * cells[1] + j) * cells[2]
            k0, k1 = bound[2, 0], bound[2, 1]
            if field.cell_start[row + int(k0)] == field.cell_start[row + int(k1) + 1]:
                continue
            dy = field.origin[1] + (j + 0.5) * h - pose[1, 3]
            dz = field.origin[2] + 0.5 * h - pose[2, 3]
            for a in range(3):
                start = pose[0, a] * dx + pose[1, a] * dy + pose[2, a] * dz
                k0, k1 = slab_interval(
                    start, pose[2, a] * h, low[body, a] - grown, high[body, a] + grown, k0, k1
                )
            if k0 > k1:
                continue
            first, last = int(np.ceil(k0)), int(np.floor(k1))
            if first > last:
                continue
            # the faces of neighbouring cells of a row follow each other in the list
            for e in range(field.cell_start[row + first], field.cell_start[row + last + 1]):
                face = field.cell_faces[e]
                if work.stamps[face] != stamp:
                    work.stamps[face] = stamp
                    if _ball_meets_part(field, face, body, pose, reach, work):
                        work.faces[found] = face
                        found += 1
    return found


@leaf
def _ball_meets_part(
    field: Any, face: int, body: int, pose: np.ndarray, reach: float, work: Any
) -> bool:
    """Whether the ball around a face comes within `reach` of a body's part, axis by axis."""
    dx = field.centers[face, 0] - pose[0, 3]
    dy = field.centers[face, 1] - pose[1, 3]
    dz = field.centers[face, 2] - pose[2, 3]
    grown = field.radii[face] + reach
    for a in range(3):
        value = pose[0, a] * dx + pose[1, a] * dy + pose[2, a] * dz
        if value < work.part_low[body, a] - grown or value > work.part_high[body, a] + grown:
            return False
    return True


@inner
def body_hits_object(field: Any, hand: Any, body: int, pose: np.ndarray, work: Any) -> bool:
    """Whether some triangle of the object and a body share a point; exact."""
    found = collect_faces(field, hand, body, pose, 0.0, work)
    for e in range(found):
        if parted(field, hand, body, work.faces[e], pose, 0.0, work):
            continue
        if clip_to_body(hand, body, work.local, 0.0, work) > 0:
            return True
    return False


@entry
def bodies_gap(
    hand: Any,
    a: int,
    pose_a: np.ndarray,
    b: int,
    pose_b: np.ndarray,
    enough: float,
    relative: np.ndarray,
) -> float:
    """Least height [m] of samples of each body over the other's planes; `enough` when beyond.

    `relative` (3, 4) or larger is scratch.
    """
    best = _samples_over(hand, a, pose_a, b, pose_b, enough, relative)
    return _samples_over(hand, b, pose_b, a, pose_a, best, relative)


@inner
def _samples_over(
    hand: Any,
    a: int,
    pose_a: np.ndarray,
    b: int,
    pose_b: np.ndarray,
    enough: float,
    relative: np.ndarray,
) -> float:
    """Least height [m] of the samples of body a over the planes of body b."""
    best = enough
    for i in range(3):
        for j in range(4):
            relative[i, j] = 0.0
            for k in range(3):
                offset = pose_b[k, 3] if j == 3 else 0.0
                relative[i, j] += pose_b[k, i] * (pose_a[k, j] - offset)
    for g in range(hand.group_start[a], hand.group_start[a + 1]):
        x, y, z = moved(relative, hand.group_center, g)
        outside = max(hand.box_low[b, 0] - x, x - hand.box_high[b, 0])
        outside = max(outside, max(hand.box_low[b, 1] - y, y - hand.box_high[b, 1]))
        outside = max(outside, max(hand.box_low[b, 2] - z, z - hand.box_high[b, 2]))
        # the box is cheap; the planes decide only about groups that it lets through
        reach = best + hand.group_radius[g]
        if outside >= reach or _height(hand, b, x, y, z, reach) >= reach:
            continue
        for s in range(hand.sample_start[g], hand.sample_start[g + 1]):
            x, y, z = moved(relative, hand.samples, s)
            best = min(best, _height(hand, b, x, y, z, best))
    return best


@leaf
def _height(hand: Any, body: int, x: float, y: float, z: float, enough: float) -> float:
    """Largest height [m] of a point over the planes of a body, in its link's frame."""
    top = -1e9
    planes = hand.planes
    for f in range(hand.plane_start[body], hand.plane_start[body + 1]):
        height = planes[f, 0] * x + planes[f, 1] * y + planes[f, 2] * z - planes[f, 3]
        if height > top:
            top = height
            if top >= enough:
                return top
    return top


@inner
def balls_gap(hand: Any, a: int, pose_a: np.ndarray, b: int, pose_b: np.ndarray) -> float:
    """Gap [m] between the balls around two bodies."""
    squared = 0.0
    for i in range(3):
        d = pose_a[i, 3] - pose_b[i, 3]
        for j in range(3):
            d += pose_a[i, j] * hand.ball_center[a, j] - pose_b[i, j] * hand.ball_center[b, j]
        squared += d * d
    return np.sqrt(squared) - hand.ball_radius[a] - hand.ball_radius[b]
