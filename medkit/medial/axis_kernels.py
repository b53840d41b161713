"""Compiled loops of the medial axis: shrinking balls on a tree of samples.

Every loop has a plain numpy twin in the tests. Arrays of points are in tree order, so that
neighbours in memory are neighbours in space.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.surface_kernels import bucket
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
    WIDTH,
    first_child,
    inner,
    lanes,
    least_gap,
    push_near,
)

#: An opposite wall may reach into a ball by this share of its depth below the tangent plane.
THIN = 0.1


@inner
def _largest_radius(points, normals, i, j, slack):
    """Radius of the ball tangent at sample i into which sample j reaches `slack` deep."""
    d2 = 0.0
    h = 0.0
    dot = 0.0
    for k in range(3):
        d = points[i, k] - points[j, k]
        d2 += d * d
        h += d * normals[i, k]
        dot += normals[i, k] * normals[j, k]
    # opposite walls are never noise: they bound the ball however thin the wall is
    allowed = slack if dot > 0.0 else min(slack, THIN * h)
    if h <= allowed or d2 == 0.0:
        return np.inf
    return (d2 - allowed * allowed) / (2.0 * (h - allowed))


@njit(cache=True)
def shrink_balls(tree, largest, slack, trust):
    """Largest tangent ball of every sample that no other sample enters deeper than `slack`.

    A ball that sticks out of one already found empty by less than `trust` is taken as empty too:
    it saves the search where many samples share a centre. Returns the radii and the index of the
    sample that stops each ball (-1: none within `largest`).
    """
    points, normals = tree.points, tree.normals
    radii = np.empty(len(points))
    stop = np.full(len(points), -1, np.int64)
    stack, distance = np.empty(STACK, np.int64), np.empty(STACK)
    known = np.full(4 * len(tree.leaves), -1, np.int64)
    width = max(2.0 * trust, 1e-300)
    for leaf in range(len(tree.leaves)):
        for i in range(tree.start[leaf], tree.start[leaf + 1]):
            r, best = _warm_start(tree, i, leaf, largest, stop, slack)
            seen = _bucket_of(points, normals, i, r, width, len(known))
            if best < 0 or not _covered(points, normals, i, r, radii, known[seen], trust):
                r, best = _shrink_one(tree, i, r, best, slack, stack, distance)
                known[_bucket_of(points, normals, i, r, width, len(known))] = i
            radii[i] = r
            stop[i] = best
    return radii, stop


@inner
def _warm_start(tree, i, leaf, r, stop, slack):
    """Shrink a ball over its own leaf and what stopped the balls of its neighbours."""
    best = -1
    # what stopped the neighbours' balls nearly always stops this one
    for back in range(max(0, i - 4), i):
        if stop[back] >= 0 and stop[back] != i:
            value = _largest_radius(tree.points, tree.normals, i, stop[back], slack)
            if value < r:
                r, best = value, stop[back]
    return _shrink_in_leaf(tree, leaf, i, r, best, slack)


@inner
def _bucket_of(points, normals, i, r, width, size):
    """Place in the hash table of the cell that the centre of sample i's ball is in."""
    a = np.int64(np.floor((points[i, 0] - r * normals[i, 0]) / width))
    b = np.int64(np.floor((points[i, 1] - r * normals[i, 1]) / width))
    c = np.int64(np.floor((points[i, 2] - r * normals[i, 2]) / width))
    return bucket(a, b, c, size)


@inner
def _covered(points, normals, i, r, radii, k, trust):
    """Whether the ball of sample i sticks out of that of sample k by no more than `trust`."""
    if k < 0:
        return False
    d2 = 0.0
    for axis in range(3):
        d2 += (
            points[i, axis] - r * normals[i, axis] - points[k, axis] + radii[k] * normals[k, axis]
        ) ** 2
    room = radii[k] - r + trust
    return room >= 0.0 and d2 <= room * room


@inner
def _shrink_one(tree, i, r, best, slack, stack, distance):
    """Shrink the ball of sample i over all samples, beginning with what is known of it."""
    x, y, z = tree.points[i, 0], tree.points[i, 1], tree.points[i, 2]
    u, v, w = tree.normals[i, 0], tree.normals[i, 1], tree.normals[i, 2]
    blocks = len(tree.blocks)
    children = tree.blocks.shape[1] // COLUMNS  # a constant would be unrolled into single steps
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if node >= blocks:
            r, best = _shrink_in_leaf(tree, node - blocks, i, r, best, slack)
            continue
        block = tree.blocks[node]
        a, b, c = x - r * u, y - r * v, z - r * w
        found = reached_children(block, children, a, b, c, u, v, w, r, slack)
        top = push_near(block, found, first_child(tree, node), a, b, c, stack, distance, top)
    return r, best


@inner
def _shrink_in_leaf(tree, leaf, i, r, best, slack):
    x, y, z = tree.points[i, 0], tree.points[i, 1], tree.points[i, 2]
    u, v, w = tree.normals[i, 0], tree.normals[i, 1], tree.normals[i, 2]
    j = tree.start[leaf]
    filled = (tree.start[leaf + 1] - j + 3) // 4 * 4
    found = entered_samples(tree.leaves[leaf], filled, x, y, z, u, v, w, r, slack)
    while found:
        if found & 1:
            value = _largest_radius(tree.points, tree.normals, i, j, slack)
            if value < r:
                r, best = value, j
        j += 1
        found >>= 1
    return r, best


@lanes
def reached_children(block, count, x, y, z, u, v, w, r, slack):
    """Bits of the children that may hold a sample deeper than `slack` in the ball (x, y, z), r.

    The ball's upper side is below a paraboloid of curvature 1 / r and the samples are above the
    child's bowl; the least gap between the two over the child's widths decides, each tangent for
    itself, and so does the distance from the box of the bowl. (u, v, w) is the normal of the
    ball's own sample.
    """
    found = 0
    for k in range(count):
        a, b, c = x - block[k], y - block[FAN + k], z - block[2 * FAN + k]
        e, f, g = block[3 * FAN + k], block[4 * FAN + k], block[5 * FAN + k]
        height = a * e + b * f + c * g
        s = abs(a * block[6 * FAN + k] + b * block[7 * FAN + k] + c * block[8 * FAN + k])
        t = abs(a * block[9 * FAN + k] + b * block[10 * FAN + k] + c * block[11 * FAN + k])
        wide, long = block[WIDTH * FAN + k], block[(WIDTH + 1) * FAN + k]
        # less slack where an opposite wall may be
        deep = u * a + v * b + w * c + r - block[SIZE * FAN + k]
        thin = min(slack, THIN * max(0.0, deep))
        faced = u * e + v * f + w * g <= block[SPREAD * FAN + k]
        reach = r - (thin if faced else slack)
        gap = 2.0 * reach * (block[BOTTOM * FAN + k] - height - reach)
        gap += least_gap(reach * block[BEND * FAN + k], s, wide)
        gap += least_gap(reach * block[(BEND + 1) * FAN + k], t, long)
        ds, dt = max(s - wide, 0.0), max(t - long, 0.0)
        dh = max(max(height - block[TOP * FAN + k], block[LOW * FAN + k] - height), 0.0)
        near = (ds * ds + dt * dt + dh * dh < reach * reach) & (reach > 0.0)
        found |= (1 << k) if near & (gap < 0.0) else 0
    return found


@lanes
def entered_samples(leaf, count, x, y, z, u, v, w, r, slack):
    """Bits of a leaf's samples that allow the ball of (x, y, z), (u, v, w) less than radius r."""
    found = 0
    larger = 2.000000001 * r  # rounding here must not lose a sample
    for k in range(count):
        a, b, c = x - leaf[k], y - leaf[LEAF_SIZE + k], z - leaf[2 * LEAF_SIZE + k]
        d2 = a * a + b * b + c * c
        h = a * u + b * v + c * w
        e, f, g = leaf[3 * LEAF_SIZE + k], leaf[4 * LEAF_SIZE + k], leaf[5 * LEAF_SIZE + k]
        allowed = slack if u * e + v * f + w * g > 0.0 else min(slack, THIN * h)
        less = d2 - allowed * allowed < larger * (h - allowed)
        found |= (1 << k) if (h > allowed) & less else 0
    return found


@njit(cache=True)
def refine_balls(tree, radii, stop, reach):
    """Radius of the ball tangent at sample i and to the surface near the sample that stops it.

    The two-point formula is off by the square of the distance between that sample and the true
    touch point; the tangent plane at the sample removes this error. It may only shrink a ball,
    and only when the foot on the plane is within `reach` of the sample. Samples exactly on a sharp
    edge get radius zero.
    """
    points, normals = tree.points, tree.normals
    refined = np.full(len(points), np.inf)
    for i in range(len(points)):
        j = stop[i]
        if j < 0:
            continue
        refined[i] = min(radii[i], _largest_radius(points, normals, i, j, 0.0))
        along = 0.0
        dot = 0.0
        for k in range(3):
            along += normals[j, k] * (points[j, k] - points[i, k])
            dot += normals[j, k] * normals[i, k]
        r = along / (1.0 - dot) if dot < 0.9 else np.inf
        if dot < 0.9 and abs(along) <= 1e-9 * reach:
            refined[i] = 0.0  # the sample lies on a sharp edge, where spheres have no size
            continue
        if 0.0 < r < refined[i]:
            offset2 = 0.0
            for k in range(3):
                foot = points[i, k] - r * normals[i, k] + r * normals[j, k]
                offset2 += (foot - points[j, k]) ** 2
            if offset2 <= reach * reach:
                refined[i] = r
    return refined
