"""Compiled loops of the medial axis: shrinking balls on a tree of samples.

Every loop has a plain numpy twin in the tests. Arrays of points are in tree order, so that
neighbours in memory are neighbours in space.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.surface_kernels import bucket
from medkit.medial.tree_kernels import SIZE, SPREAD, STACK, ball_misses, box_distance2

#: An opposite wall may reach into a ball by this share of its depth below the tangent plane.
THIN = 0.1


@njit(cache=True)
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
    n = len(points)
    leaves = len(tree.first) // 2
    radii = np.empty(n)
    stop = np.full(n, -1, np.int64)
    stack = np.empty(STACK, np.int64)
    known = np.full(4 * leaves, -1, np.int64)
    width = max(2.0 * trust, 1e-300)
    for leaf in range(leaves, 2 * leaves):
        for i in range(tree.first[leaf], tree.last[leaf]):
            r = largest
            best = -1
            for j in range(tree.first[leaf], tree.last[leaf]):
                value = _largest_radius(points, normals, i, j, slack)
                if value < r:
                    r, best = value, j
            # warm start: what stopped the neighbours' balls nearly always stops this one
            for back in range(max(0, i - 4), i):
                if stop[back] >= 0 and stop[back] != i:
                    value = _largest_radius(points, normals, i, stop[back], slack)
                    if value < r:
                        r, best = value, stop[back]
            seen = _bucket_of(points, normals, i, r, width, len(known))
            if best < 0 or not _covered(points, normals, i, r, radii, known[seen], trust):
                r, best = _shrink_one(tree, i, r, best, slack, stack)
                known[_bucket_of(points, normals, i, r, width, len(known))] = i
            radii[i] = r
            stop[i] = best
    return radii, stop


@njit(cache=True)
def _bucket_of(points, normals, i, r, width, size):
    """Place in the hash table of the cell that the centre of sample i's ball is in."""
    a = np.int64(np.floor((points[i, 0] - r * normals[i, 0]) / width))
    b = np.int64(np.floor((points[i, 1] - r * normals[i, 1]) / width))
    c = np.int64(np.floor((points[i, 2] - r * normals[i, 2]) / width))
    return bucket(a, b, c, size)


@njit(cache=True)
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


@njit(cache=True)
def _shrink_one(tree, i, r, best, slack, stack):
    """Shrink the ball of sample i over all samples, beginning with what is known of it."""
    points, normals, nodes = tree.points, tree.normals, tree.nodes
    leaves = len(tree.first) // 2
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    u, v, w = normals[i, 0], normals[i, 1], normals[i, 2]
    stack[0] = 1
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        a, b, c = x - r * u, y - r * v, z - r * w
        faced = u * nodes[node, 6] + v * nodes[node, 7] + w * nodes[node, 8]
        reach = r - slack
        # less slack where an opposite wall may be
        if faced <= nodes[node, SPREAD]:
            deep = (
                u * (x - 0.5 * (nodes[node, 0] + nodes[node, 3]))
                + v * (y - 0.5 * (nodes[node, 1] + nodes[node, 4]))
                + w * (z - 0.5 * (nodes[node, 2] + nodes[node, 5]))
                - nodes[node, SIZE]
            )
            reach = r - min(slack, THIN * max(0.0, deep))
        if ball_misses(nodes, node, a, b, c, reach):
            continue
        if node >= leaves:
            for j in range(tree.first[node], tree.last[node]):
                value = _largest_radius(points, normals, i, j, slack)
                if value < r:
                    r, best = value, j
            continue
        near, far = 2 * node, 2 * node + 1
        near2, far2 = box_distance2(nodes, near, a, b, c), box_distance2(nodes, far, a, b, c)
        if near2 > far2:
            near, far, near2, far2 = far, near, far2, near2
        if far2 < r * r:
            stack[top] = far
            top += 1
        if near2 < r * r:
            stack[top] = near
            top += 1
    return r, best


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
