"""Compiled search for the touch points that span a medial sphere's object angle."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.tree_kernels import SPREAD, STACK, ball_misses, box_distance2

#: A sample this much aside of the foot on its own tangent plane is a touch of its own (cosine).
SLANTED = 0.95
#: Most searches for a wider partner, each from the partner found last.
STEPS = 6


@njit(cache=True)
def widest_touch(centers, radii, own, stop, tree, tolerances, reach, enough, modest):
    """Object angle of every sphere over the samples it touches, and the two touch points.

    A sample touches when its tangent plane has its foot within `reach` of the sample and moving
    the centre by ``tolerances[0]`` could close the gap; or, at a reentrant edge, when the sample
    itself is no farther than radius plus ``tolerances[1]``. The touch that is widest from the
    sphere's own sample is taken, then the one that is widest from that, and so on while the
    angle grows. Angles wider than `enough` are not widened further. Where no touch is wider than
    `modest` from the own sample, the two first touches are kept: no pair at all is wider than
    twice that [rad].
    """
    n = len(centers)
    angles = np.empty(n)
    pairs = np.empty((n, 2, 3))
    stack = np.empty(STACK, np.int64)
    goal, narrow = np.cos(enough), np.cos(modest)
    # rows: the two directions that every sphere has, the one to search from, its widest partner
    rows = np.empty((4, 3))
    hints = np.full(2, -1, np.int64)
    for i in range(n):
        # where the sample that stopped the ball stands a little aside, its normal still counts
        wide = max(reach, 0.3 * radii[i])
        u, v, w = _direction(centers, i, tree.points, tree.normals, stop[i], wide)
        rows[1, 0], rows[1, 1], rows[1, 2] = u, v, w
        rows[3, 0], rows[3, 1], rows[3, 2] = u, v, w
        for k in range(3):
            rows[0, k] = rows[2, k] = tree.normals[own[i], k]
        best = _cosine(rows, u, v, w, 0)
        found = -1
        for step in range(STEPS):
            if best <= goal or (step == 1 and best > narrow) or (step > 1 and found < 0):
                break
            bound = min(best, narrow)
            least, u, v, w, found = _farthest(
                centers,
                i,
                radii[i],
                tree,
                tolerances,
                reach,
                rows,
                bound,
                goal,
                stack,
                hints[min(step, 1)],
            )
            if found >= 0:
                hints[min(step, 1)] = found
                best = least
                rows[3, 0], rows[3, 1], rows[3, 2] = u, v, w
            if step == 0:
                # the second search starts from the partner; the first two directions compete
                for k in range(3):
                    rows[2, k], rows[3, k] = rows[3, k], rows[2, k]
                other = _cosine(rows, rows[1, 0], rows[1, 1], rows[1, 2], 2)
                if other < best:
                    best = other
                    for k in range(3):
                        rows[3, k] = rows[1, k]
            else:
                for k in range(3):
                    rows[2, k], rows[3, k] = rows[3, k], rows[2, k]
        angles[i] = np.arccos(min(1.0, max(-1.0, best)))
        for k in range(3):
            pairs[i, 0, k] = centers[i, k] + radii[i] * rows[2, k]
            pairs[i, 1, k] = centers[i, k] + radii[i] * rows[3, k]
    return angles, pairs


@njit(cache=True)
def _direction(centers, i, points, normals, j, reach):
    """Direction from centre i to the foot on the plane of sample j, or to the sample itself."""
    x = points[j, 0] - centers[i, 0]
    y = points[j, 1] - centers[i, 1]
    z = points[j, 2] - centers[i, 2]
    d2 = x * x + y * y + z * z
    h = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
    if h > 0.0 and d2 - h * h <= reach * reach:
        return normals[j, 0], normals[j, 1], normals[j, 2]
    d = max(np.sqrt(d2), 1e-300)
    return x / d, y / d, z / d


@njit(cache=True, inline="always")
def _cosine(rows, u, v, w, k):
    """Cosine of the angle between a direction and that of row `k`."""
    return rows[k, 0] * u + rows[k, 1] * v + rows[k, 2] * w


@njit(cache=True, inline="always")
def _may_touch(nodes, node, x, y, z, radius, along, wide, reach, rows, best):
    """Whether a node may hold a touch with a cosine below `best` to row 2."""
    e = 0.5 * (nodes[node, 3] - nodes[node, 0])
    f = 0.5 * (nodes[node, 4] - nodes[node, 1])
    g = 0.5 * (nodes[node, 5] - nodes[node, 2])
    a, b, c = nodes[node, 0] + e - x, nodes[node, 1] + f - y, nodes[node, 2] + g - z
    # the way to a touch is at least the radius less what samples may be inside, at most the limit
    way = radius + 2.0 * along if best > 0.0 else radius - 2.0 * wide
    u, v, w = rows[2, 0], rows[2, 1], rows[2, 2]
    ahead = a * u + b * v + c * w - (e * abs(u) + f * abs(v) + g * abs(w))
    if ahead - reach >= best * way:
        return False
    m, n, o = nodes[node, 6], nodes[node, 7], nodes[node, 8]
    near = max(_cosine(rows, m, n, o, 0), _cosine(rows, m, n, o, 1)) - nodes[node, SPREAD]
    chord = np.sqrt(min(4.0, max(0.0, 2.0 - 2.0 * near)))
    limit = max(radius + along * chord + 0.5 * reach * reach / radius, radius + wide)
    return not ball_misses(nodes, node, x, y, z, limit)


@njit(cache=True)
def _farthest(centers, i, radius, tree, tolerances, reach, rows, best, goal, stack, hint):
    """Least cosine below `best` of a touch to row 2, and its direction."""
    nodes, points, normals = tree.nodes, tree.points, tree.normals
    first, last = tree.first, tree.last
    x, y, z = centers[i, 0], centers[i, 1], centers[i, 2]
    along, wide = tolerances[0], tolerances[1]
    leaves = len(first) // 2
    limit = radius + max(2.0 * along, wide)
    limit2 = limit * limit + reach * reach
    p, q, r = 0.0, 0.0, 0.0
    found = -1
    if hint >= 0:
        dot, u, v, w = _touch(
            points, normals, hint, x, y, z, radius, along, wide, reach, rows, best
        )
        if dot < best:
            best, p, q, r, found = dot, u, v, w, hint
    stack[0] = 1
    top = 1
    while top > 0 and best > goal:
        top -= 1
        node = stack[top]
        if not _may_touch(nodes, node, x, y, z, radius, along, wide, reach, rows, best):
            continue
        if node < leaves:
            near, far = 2 * node, 2 * node + 1
            ahead = 0.0
            for k in range(3):
                apart = nodes[far, k] + nodes[far, 3 + k] - nodes[near, k] - nodes[near, 3 + k]
                ahead += apart * rows[2, k]
            # the widest partner of a touch would be its antipode: look there first
            if ahead < 0.0:
                near, far = far, near
            if box_distance2(nodes, far, x, y, z) <= limit2:
                stack[top] = far
                top += 1
            if box_distance2(nodes, near, x, y, z) <= limit2:
                stack[top] = near
                top += 1
            continue
        for j in range(first[node], last[node]):
            a, b, c = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
            if a * a + b * b + c * c > limit2:
                continue
            dot, u, v, w = _touch(
                points, normals, j, x, y, z, radius, along, wide, reach, rows, best
            )
            if dot < best:
                best, p, q, r, found = dot, u, v, w, j
    return best, p, q, r, found


@njit(cache=True, inline="always")
def _touch(points, normals, j, x, y, z, radius, along, wide, reach, rows, best):
    """Cosine of sample j's touch to row 2, and its direction; 2 if it is none."""
    a, b, c = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
    u, v, w = normals[j, 0], normals[j, 1], normals[j, 2]
    d2 = a * a + b * b + c * c
    h = a * u + b * v + c * w
    if h > 0.0 and d2 - h * h <= reach * reach:
        dot = _cosine(rows, u, v, w, 2)
        if dot < best and h >= radius - 2.0 * wide:
            # a centre moved by e along its sheet changes a gap by at most e times this chord
            near = max(_cosine(rows, u, v, w, 0), _cosine(rows, u, v, w, 1))
            if h <= radius + along * np.sqrt(max(0.0, 2.0 - 2.0 * near)):
                return dot, u, v, w
        return 2.0, u, v, w
    # a sample beside the foot on a smooth surface looks along its normal: not a touch of its own
    low, high = max(0.0, radius - 2.0 * wide), radius + wide
    if d2 < low * low or d2 > high * high or (h > 0.0 and h * h >= SLANTED * SLANTED * d2):
        return 2.0, u, v, w
    d = max(np.sqrt(d2), 1e-300)
    u, v, w = a / d, b / d, c / d
    return _cosine(rows, u, v, w, 2), u, v, w
