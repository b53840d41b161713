"""Compiled search for the touch points that span a medial sphere's object angle."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.tree_kernels import (
    BEND,
    BOTTOM,
    COLUMNS,
    FAN,
    LEAF_SIZE,
    LOW,
    SIZE,
    SPREAD,
    STACK,
    TOP,
    TURN,
    WIDTH,
    first_child,
    inner,
    lanes,
    least_gap,
    push_turned,
)

#: A sample this much aside of the foot on its own tangent plane is a touch of its own (cosine).
SLANTED = 0.95
#: Most searches for a wider partner, each from the partner found last.
STEPS = 6
#: Cosines that differ by less are equal: a flat face has one direction, whatever rounding says.
SAME = 1e-12
NONE = -2.0  # no cosine is below this


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
    limits = np.array([np.cos(enough), np.cos(modest)])
    # rows: the two directions that every sphere has, the one to search from, its widest partner,
    # and the widest partner of the second
    rows = np.empty((5, 3))
    hints = np.full(2, -1, np.int64)
    for i in range(n):
        x, y, z = centers[i, 0], centers[i, 1], centers[i, 2]
        ball = (x, y, z, radii[i], tolerances[0], tolerances[1], reach)
        # where the sample that stopped the ball stands a little aside, its normal still counts
        wide = max(reach, 0.3 * radii[i])
        u, v, w = _direction(x, y, z, tree.points, tree.normals, stop[i], wide)
        _put(rows, 1, u, v, w)
        u, v, w = tree.normals[own[i], 0], tree.normals[own[i], 1], tree.normals[own[i], 2]
        _put(rows, 0, u, v, w)
        best = _widest_pair(tree, ball, rows, limits, stack, hints)
        angles[i] = np.arccos(min(1.0, max(-1.0, best)))
        for k in range(3):
            pairs[i, 0, k] = centers[i, k] + radii[i] * rows[2, k]
            pairs[i, 1, k] = centers[i, k] + radii[i] * rows[3, k]
    return angles, pairs


@inner
def _widest_pair(tree, ball, rows, limits, stack, hints):
    """Cosine of the widest pair that is found from the first two rows; it is left in 2 and 3."""
    goal, narrow = limits[0], limits[1]
    _copy(rows, 0, 2)
    _copy(rows, 1, 3)
    best = _cosine(rows, rows[1, 0], rows[1, 1], rows[1, 2], 0)
    if best <= goal:
        return best
    # the second search starts from the partner: nearly always row 1, so it is done in one walk
    second = best if best <= narrow else NONE
    found, least, also, wider = _farthest(
        tree, ball, rows, min(best, narrow), second, goal, stack, hints[0]
    )
    if found >= 0:
        hints[0], best = found, least
    _swap(rows, 2, 3)
    other = _cosine(rows, rows[1, 0], rows[1, 1], rows[1, 2], 2)
    if other < best:
        best = other
        _copy(rows, 1, 3)
    known = found < 0 and second > NONE and wider > goal
    for _ in range(1, STEPS):
        if best <= goal or best > narrow:
            break
        if known:
            found, least = also, wider
            if found >= 0:
                _copy(rows, 4, 3)
            known = False
        else:
            found, least, _, _ = _farthest(tree, ball, rows, best, NONE, goal, stack, hints[1])
        if found >= 0:
            hints[1], best = found, least
        _swap(rows, 2, 3)
        if found < 0:
            break
    return best


@inner
def _direction(x, y, z, points, normals, j, reach):
    """Direction from (x, y, z) to the foot on the plane of sample j, or to the sample itself."""
    x, y, z = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
    d2 = x * x + y * y + z * z
    h = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
    if h > 0.0 and d2 - h * h <= reach * reach:
        return normals[j, 0], normals[j, 1], normals[j, 2]
    d = max(np.sqrt(d2), 1e-300)
    return x / d, y / d, z / d


@lanes
def _put(rows, k, u, v, w):
    rows[k, 0], rows[k, 1], rows[k, 2] = u, v, w


@lanes
def _copy(rows, k, to):
    _put(rows, to, rows[k, 0], rows[k, 1], rows[k, 2])


@lanes
def _swap(rows, k, to):
    u, v, w = rows[k, 0], rows[k, 1], rows[k, 2]
    _copy(rows, to, k)
    _put(rows, to, u, v, w)


@lanes
def _cosine(rows, u, v, w, k):
    """Cosine of the angle between a direction and that of row `k`."""
    return rows[k, 0] * u + rows[k, 1] * v + rows[k, 2] * w


@inner
def _farthest(tree, ball, rows, best, second, goal, stack, hint):
    """Touches with the least cosine to row 2, below `best`, and to row 1, below `second`.

    Returns their samples (-1: none) and cosines; the directions are put into rows 3 and 4. The
    second is given up as soon as there is a first.
    """
    found, also = -1, -1
    blocks = len(tree.blocks)
    children = tree.blocks.shape[1] // COLUMNS  # a constant would be unrolled into single steps
    if hint >= 0:
        touches, u, v, w = _touch(tree.points, tree.normals, hint, ball, rows)
        dot = _cosine(rows, u, v, w, 2)
        if touches and dot < best:
            best, second, found = dot, NONE, hint
            _put(rows, 3, u, v, w)
    stack[0] = 0
    top = 1
    while top > 0 and best > goal:
        top -= 1
        node = stack[top]
        if node < blocks:
            block = tree.blocks[node]
            bits, turned = touched_children(block, children, ball, rows, best, second)
            top = push_turned(bits, turned, first_child(tree, node), stack, top)
            continue
        j = tree.start[node - blocks]
        filled = (tree.start[node - blocks + 1] - j + 3) // 4 * 4
        bits = touching_samples(tree.leaves[node - blocks], filled, ball, rows, best, second)
        while bits:
            if bits & 1:
                touches, u, v, w = _touch(tree.points, tree.normals, j, ball, rows)
                dot = _cosine(rows, u, v, w, 2)
                if touches and dot < best:
                    best, second, found = dot, NONE, j
                    _put(rows, 3, u, v, w)
                dot = _cosine(rows, u, v, w, 1)
                if touches and dot < second:
                    second, also = dot, j
                    _put(rows, 4, u, v, w)
            j += 1
            bits >>= 1
    return found, best, also, second


@lanes
def touched_children(block, count, ball, rows, best, second):
    """Bits of the children that may hold a wanted touch, and of the splits to take the other way.

    Wanted is a touch with a cosine below `best` to row 2 or one below `second` to row 1. The
    widest partner of a touch would be its antipode: the half that lies that way comes first.
    """
    x, y, z, radius, along, wide, reach = ball
    p, q, r = rows[0, 0], rows[0, 1], rows[0, 2]
    i, m, n = rows[1, 0], rows[1, 1], rows[1, 2]
    u, v, w = rows[2, 0], rows[2, 1], rows[2, 2]
    high = radius + wide
    lean = radius + 0.5 * reach * reach / radius
    far = radius + max(2.0 * along, wide)
    far2 = far * far + reach * reach
    # the way to a touch is at least the radius less what samples may be inside, at most the limit
    way = reach + best * (radius + 2.0 * along if best > 0.0 else radius - 2.0 * wide)
    also = reach + second * (radius + 2.0 * along if second > 0.0 else radius - 2.0 * wide)
    also = also if second > NONE else -np.inf
    found, turned = 0, 0
    for k in range(count):
        a, b, c = block[k] - x, block[FAN + k] - y, block[2 * FAN + k] - z
        e, f, g = block[3 * FAN + k], block[4 * FAN + k], block[5 * FAN + k]
        spread = block[SPREAD * FAN + k]
        height = a * e + b * f + c * g
        turn = e * i + f * m + g * n
        # a touch at a foot looks along its normal; others are steep to theirs
        steep = height + block[LOW * FAN + k] - high * spread < SLANTED * high
        first = (e * u + f * v + g * w - spread < best - SAME) | steep
        first &= a * u + b * v + c * w - block[SIZE * FAN + k] < way
        other = (turn - spread < second - SAME) | steep
        other &= a * i + b * m + c * n - block[SIZE * FAN + k] < also
        near = max(e * p + f * q + g * r, turn) - spread
        chord = np.sqrt(min(4.0, max(0.0, 2.0 - 2.0 * near)))
        limit = max(lean + along * chord, high)
        s = abs(a * block[6 * FAN + k] + b * block[7 * FAN + k] + c * block[8 * FAN + k])
        t = abs(a * block[9 * FAN + k] + b * block[10 * FAN + k] + c * block[11 * FAN + k])
        broad, long = block[WIDTH * FAN + k], block[(WIDTH + 1) * FAN + k]
        gap = 2.0 * limit * (block[BOTTOM * FAN + k] + height - limit)
        gap += least_gap(limit * block[BEND * FAN + k], s, broad)
        gap += least_gap(limit * block[(BEND + 1) * FAN + k], t, long)
        ds, dt = max(s - broad, 0.0), max(t - long, 0.0)
        dh = max(max(-height - block[TOP * FAN + k], block[LOW * FAN + k] + height), 0.0)
        meets = (gap < 0.0) & (ds * ds + dt * dt + dh * dh <= far2) & (first | other)
        found |= (1 << k) if meets else 0
        a, b, c = block[TURN * FAN + k], block[(TURN + 1) * FAN + k], block[(TURN + 2) * FAN + k]
        turned |= (1 << k) if a * u + b * v + c * w < 0.0 else 0
    return found, turned


@lanes
def touching_samples(leaf, count, ball, rows, best, second):
    """Bits of the samples of a leaf that nearly are wanted touches; see `_touch`."""
    x, y, z, radius, along, wide, reach = ball
    p, q, r = rows[0, 0], rows[0, 1], rows[0, 2]
    i, m, n = rows[1, 0], rows[1, 1], rows[1, 2]
    u, v, w = rows[2, 0], rows[2, 1], rows[2, 2]
    least, high = max(0.0, radius - 2.0 * wide), radius + wide
    found = 0
    for k in range(count):
        a, b, c = leaf[k] - x, leaf[LEAF_SIZE + k] - y, leaf[2 * LEAF_SIZE + k] - z
        e, f, g = leaf[3 * LEAF_SIZE + k], leaf[4 * LEAF_SIZE + k], leaf[5 * LEAF_SIZE + k]
        d2 = a * a + b * b + c * c
        h = a * e + b * f + c * g
        turn = e * i + f * m + g * n
        over = max(h - radius, 0.0)
        chord2 = 2.000001 - 2.0 * max(e * p + f * q + g * r, turn)
        flat = (e * u + f * v + g * w < best) | (turn < second)
        flat &= (h > 0.0) & (d2 - h * h <= reach * reach)
        flat &= (h >= radius - 2.0 * wide) & (over * over <= along * along * chord2)
        d = np.sqrt(d2)
        steep = a * u + b * v + c * w < best * d + SAME * d
        steep |= a * i + b * m + c * n < second * d + SAME * d
        steep &= (h <= 0.0) | (d2 - h * h > reach * reach)
        steep &= (d >= least * 0.999999) & (d <= high * 1.000001) & (h < SLANTED * 1.000001 * d)
        found |= (1 << k) if flat | steep else 0
    return found


@inner
def _touch(points, normals, j, ball, rows):
    """Whether sample j touches the ball, and the direction of that touch."""
    x, y, z, radius, along, wide, reach = ball
    a, b, c = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
    u, v, w = normals[j, 0], normals[j, 1], normals[j, 2]
    d2 = a * a + b * b + c * c
    h = a * u + b * v + c * w
    if h > 0.0 and d2 - h * h <= reach * reach:
        # a centre moved by e along its sheet changes a gap by at most e times this chord
        near = max(_cosine(rows, u, v, w, 0), _cosine(rows, u, v, w, 1))
        over = radius + along * np.sqrt(max(0.0, 2.0 - 2.0 * near))
        return radius - 2.0 * wide <= h <= over, u, v, w
    # a sample beside the foot on a smooth surface looks along its normal: not a touch of its own
    low, high = max(0.0, radius - 2.0 * wide), radius + wide
    steep = h <= 0.0 or h * h < SLANTED * SLANTED * d2
    d = max(np.sqrt(d2), 1e-300)
    return steep and low * low <= d2 <= high * high, a / d, b / d, c / d
