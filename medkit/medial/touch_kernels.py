"""Compiled search for the touch points that span a medial sphere's object angle."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.axis_kernels import STACK, box_distance2

_TOUCHES = 48  # most directions kept per sphere


@njit(cache=True)
def widest_touch(
    centers, radii, own, stop, points, normals, first, last, boxes, slabs, tolerances, reach, enough
):
    """Object angle of every sphere over all samples it touches, and the two touch points.

    A sample touches when its tangent plane has its foot within `reach` of the sample and moving
    the centre by ``tolerances[0]`` could close the gap; or, at a reentrant edge, when the sample
    itself is no farther than radius plus ``tolerances[1]``. Touches that are wider from one of
    the first two than these are apart are collected, and the widest pair of all is taken. The
    search ends early once an angle is wider than `enough` [rad].
    """
    n = len(centers)
    angles = np.empty(n)
    pairs = np.empty((n, 2, 3))
    stack = np.empty(STACK, np.int64)
    goal = np.cos(enough)
    touches = np.empty((_TOUCHES, 3))
    for i in range(n):
        # where the sample that stopped the ball stands a little aside, its normal still counts
        wide = max(reach, 0.3 * radii[i])
        _, u, v, w = _foot(centers, i, points, normals, stop[i], wide)
        touches[1, 0], touches[1, 1], touches[1, 2] = u, v, w
        for k in range(3):
            touches[0, k] = normals[own[i], k]
        count = _collect_touches(
            centers, i, radii[i], touches, points, normals, first, last, boxes, slabs,
            tolerances, reach, goal, stack,
        )  # fmt: skip
        a, b, cosine = _widest_pair(touches, count)
        angles[i] = np.arccos(min(1.0, max(-1.0, cosine)))
        for k in range(3):
            pairs[i, 0, k] = centers[i, k] + radii[i] * touches[a, k]
            pairs[i, 1, k] = centers[i, k] + radii[i] * touches[b, k]
    return angles, pairs


@njit(cache=True)
def _widest_pair(touches, count):
    """Rows of the two directions with the least cosine, and that cosine."""
    best = 2.0
    first, second = 0, 1
    for a in range(count):
        for b in range(a + 1, count):
            dot = 0.0
            for k in range(3):
                dot += touches[a, k] * touches[b, k]
            if dot < best:
                best, first, second = dot, a, b
    return first, second, best


@njit(cache=True)
def _foot(centers, i, points, normals, j, reach):
    """Distance and direction from centre i to the surface near sample j, and its kind.

    The distance is positive for a foot on the tangent plane within `reach` of the sample, and
    negative for the sample itself.
    """
    x = points[j, 0] - centers[i, 0]
    y = points[j, 1] - centers[i, 1]
    z = points[j, 2] - centers[i, 2]
    d2 = x * x + y * y + z * z
    h = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
    if h > 0.0 and d2 - h * h <= reach * reach:
        return h, normals[j, 0], normals[j, 1], normals[j, 2]
    d = max(np.sqrt(d2), 1e-300)
    return -d, x / d, y / d, z / d


@njit(cache=True)
def _touches(distance, u, v, w, normals, j, radius, touches, tolerances):
    if distance > 0.0:
        first = u * touches[0, 0] + v * touches[0, 1] + w * touches[0, 2]
        second = u * touches[1, 0] + v * touches[1, 1] + w * touches[1, 2]
        # a centre moved by e along its sheet changes a gap by at most e times this chord
        chord = np.sqrt(max(0.0, 2.0 - 2.0 * max(first, second)))
        return distance <= radius + tolerances[0] * chord
    # a sample beside the foot on a smooth surface looks along its normal: not a touch of its own
    slanted = u * normals[j, 0] + v * normals[j, 1] + w * normals[j, 2] < 0.95
    return slanted and -distance <= radius + tolerances[1]


@njit(cache=True)
def _no_touch(boxes, slabs, node, x, y, z, limit, touching, reach):
    """Whether no sample of a node can be a touch of the sphere about (x, y, z)."""
    distance2 = box_distance2(boxes, node, x, y, z)
    if distance2 > limit * limit:
        return True
    m, n, o = slabs[node, 0], slabs[node, 1], slabs[node, 2]
    along = m * x + n * y + o * z
    height = max(slabs[node, 3] - along, along - slabs[node, 4])
    if height > limit:
        return True
    if distance2 <= touching * touching and height <= touching:
        return False
    # only feet of tangent planes are left: none if every normal points past the centre
    a = 0.5 * (boxes[node, 0] + boxes[node, 3]) - x
    b = 0.5 * (boxes[node, 1] + boxes[node, 4]) - y
    c = 0.5 * (boxes[node, 2] + boxes[node, 5]) - z
    h = a * m + b * n + c * o
    most = reach + slabs[node, 6] + limit * slabs[node, 5]
    return a * a + b * b + c * c - h * h > most * most


@njit(cache=True)
def _collect_touches(
    centers, i, radius, touches, points, normals, first, last, boxes, slabs, tolerances, reach,
    goal, stack,
):  # fmt: skip
    """Add to the two directions in `touches` those that are wider from one of them.

    Returns the number of directions. When the table is full only the widest so far is replaced.
    """
    count = 2
    apart = 0.0
    for k in range(3):
        apart += touches[0, k] * touches[1, k]
    best = apart
    leaves = len(first) // 2
    limit = np.sqrt((radius + max(2.0 * tolerances[0], tolerances[1])) ** 2 + reach * reach)
    touching = radius + tolerances[1]
    x, y, z = centers[i, 0], centers[i, 1], centers[i, 2]
    p, q, r = x - radius * touches[0, 0], y - radius * touches[0, 1], z - radius * touches[0, 2]
    stack[0] = 1
    top = 1
    while top > 0 and best > goal:
        top -= 1
        node = stack[top]
        if _no_touch(boxes, slabs, node, x, y, z, limit, touching, reach) or (
            _least_along(boxes, node, centers, i, touches) - reach >= apart * radius
        ):
            continue
        if node < leaves:
            near, far = 2 * node, 2 * node + 1
            # the widest partner of a touch would be its antipode: look there first
            if box_distance2(boxes, near, p, q, r) > box_distance2(boxes, far, p, q, r):
                near, far = far, near
            stack[top] = far
            stack[top + 1] = near
            top += 2
            continue
        for j in range(first[node], last[node]):
            a, b, c = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
            d2 = a * a + b * b + c * c
            h = a * normals[j, 0] + b * normals[j, 1] + c * normals[j, 2]
            if d2 > limit * limit or (d2 - h * h > reach * reach and d2 > touching * touching):
                continue
            distance, u, v, w = _foot(centers, i, points, normals, j, reach)
            dot = min(
                u * touches[0, 0] + v * touches[0, 1] + w * touches[0, 2],
                u * touches[1, 0] + v * touches[1, 1] + w * touches[1, 2],
            )
            full = count == _TOUCHES
            if dot < (best if full else apart) and _touches(
                distance, u, v, w, normals, j, radius, touches, tolerances
            ):
                place = count - 1 if full else count
                touches[place, 0], touches[place, 1], touches[place, 2] = u, v, w
                count = place + 1
                best = min(best, dot)
    return count


@njit(cache=True)
def _least_along(boxes, node, centers, i, touches):
    """Least component along either of two directions of a vector from a centre into a box."""
    least = np.inf
    for seed in range(2):
        total = 0.0
        for k in range(3):
            edge = boxes[node, k] if touches[seed, k] > 0.0 else boxes[node, 3 + k]
            total += touches[seed, k] * (edge - centers[i, k])
        least = min(least, total)
    return least
