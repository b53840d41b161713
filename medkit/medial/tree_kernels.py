"""Compiled balanced tree of samples, with bounds that hug a curved surface.

Every loop has a plain numpy twin in the tests. Points and normals are in tree order, so that
neighbours in memory are neighbours in space.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

#: Samples per leaf of the tree: small leaves prune well, large ones cost fewer tests.
LEAF_SIZE = 16
#: Room for the nodes that wait during a walk down the tree.
STACK = 128
# columns of Tree.nodes: box (low 0-2, high 3-5), mean normal (6-8), tangents (9-11, 12-14), then
SPREAD, SIZE, TOP, BOTTOM, BEND, WIDTH = 15, 16, 17, 18, 19, 21
COLUMNS = 24  # three cache lines a node


class Tree(NamedTuple):
    """Samples in tree order and what bounds them: one flat struct for the kernels.

    Node ``i`` has the children ``2 i`` and ``2 i + 1``, the root is 1, the leaves come last. In
    the frame of a node, from the middle of its box, its samples lie no farther than the two WIDTH
    along the tangents s and t, and along the normal below TOP and above the saddle or bowl
    ``BOTTOM - (BEND_0 s^2 + BEND_1 t^2) / 2``. SPREAD is the largest distance of a sample's
    normal from the mean normal, SIZE half the box's diagonal.
    """

    points: Any
    normals: Any
    first: Any
    last: Any
    nodes: Any


@njit(cache=True)
def sort_samples(points, leaves):
    """Order (n,) of points in a balanced binary tree with `leaves` (a power of two) leaves.

    Also the first and last place of each node, shape (2 leaves,).
    """
    n = len(points)
    moved = points.copy()
    order = np.arange(n)
    first = np.zeros(2 * leaves, np.int64)
    last = np.zeros(2 * leaves, np.int64)
    last[1] = n
    for node in range(1, leaves):
        begin, end = first[node], last[node]
        widest, axis = -1.0, 0
        for k in range(3):
            low, high = np.inf, -np.inf
            for i in range(begin, end):
                low, high = min(low, moved[i, k]), max(high, moved[i, k])
            if high - low > widest:
                widest, axis = high - low, k
        middle = (begin + end) // 2
        _select(moved, order, begin, end, middle, axis)
        first[2 * node], last[2 * node] = begin, middle
        first[2 * node + 1], last[2 * node + 1] = middle, end
    return order, first, last


@njit(cache=True)
def _select(points, order, first, last, middle, axis):
    """Quickselect: put the element of rank `middle` along `axis` at its place."""
    low, high = first, last - 1
    while low < high:
        pivot = points[(low + high) // 2, axis]
        i, j = low, high
        while i <= j:
            while points[i, axis] < pivot:
                i += 1
            while points[j, axis] > pivot:
                j -= 1
            if i <= j:
                for k in range(3):
                    points[i, k], points[j, k] = points[j, k], points[i, k]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@njit(cache=True)
def bound_nodes(points, normals, first, last):
    """Box, frame and bowl of every node of a tree; see `Tree` for the columns."""
    nodes = np.zeros((len(first), COLUMNS))
    for node in range(1, len(first)):
        begin, end = first[node], last[node]
        size2 = 0.0
        for k in range(3):
            low, high, total = np.inf, -np.inf, 0.0
            for i in range(begin, end):
                low, high = min(low, points[i, k]), max(high, points[i, k])
                total += normals[i, k]
            nodes[node, k], nodes[node, 3 + k], nodes[node, 6 + k] = low, high, total
            size2 += 0.25 * (high - low) ** 2
        nodes[node, SIZE] = np.sqrt(size2)
        _set_normal(nodes, node)
        _fit_bends(points, normals, begin, end, nodes, node)
        _bound_bowl(points, normals, begin, end, nodes, node)
    return nodes


@njit(cache=True)
def _set_normal(nodes, node):
    """Unit mean normal, and any two tangents that complete the frame."""
    x, y, z = nodes[node, 6], nodes[node, 7], nodes[node, 8]
    length = np.sqrt(x * x + y * y + z * z)
    if length < 1e-6:
        x, y, z, length = 0.0, 0.0, 1.0, 1.0
    x, y, z = x / length, y / length, z / length
    a, b, c = (0.0, z, -y) if abs(x) < 0.6 else (-z, 0.0, x)
    across = np.sqrt(a * a + b * b + c * c)
    a, b, c = a / across, b / across, c / across
    nodes[node, 6], nodes[node, 7], nodes[node, 8] = x, y, z
    nodes[node, 9], nodes[node, 10], nodes[node, 11] = a, b, c
    nodes[node, 12], nodes[node, 13], nodes[node, 14] = y * c - z * b, z * a - x * c, x * b - y * a


@njit(cache=True)
def _offset(points, i, nodes, node, column):
    """Component of a sample, seen from the middle of its node's box, along an axis of the frame."""
    total = 0.0
    for k in range(3):
        middle = 0.5 * (nodes[node, k] + nodes[node, 3 + k])
        total += (points[i, k] - middle) * nodes[node, column + k]
    return total


@njit(cache=True)
def _fit_bends(points, normals, begin, end, nodes, node):
    """Turn the tangents to the principal directions, and store the two principal curvatures.

    The curvature tensor is the linear map from offsets to turns of the normal that fits best. It
    only decides how tight the bound is, never whether it holds.
    """
    ss, st, tt, su, sv, tu, tv = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(begin, end):
        s, t = _offset(points, i, nodes, node, 9), _offset(points, i, nodes, node, 12)
        u, v = 0.0, 0.0
        for k in range(3):
            u += normals[i, k] * nodes[node, 9 + k]
            v += normals[i, k] * nodes[node, 12 + k]
        ss, st, tt = ss + s * s, st + s * t, tt + t * t
        su, sv, tu, tv = su + s * u, sv + s * v, tu + t * u, tv + t * v
    det = ss * tt - st * st
    if det <= 1e-6 * (ss + tt) ** 2:
        return
    p, q = (su * tt - tu * st) / det, (tv * ss - sv * st) / det
    m = 0.5 * ((tu * ss - su * st) + (sv * tt - tv * st)) / det
    angle = 0.5 * np.arctan2(2.0 * m, p - q)
    co, si = np.cos(angle), np.sin(angle)
    nodes[node, BEND] = p * co * co + 2.0 * m * co * si + q * si * si
    nodes[node, BEND + 1] = p * si * si - 2.0 * m * co * si + q * co * co
    for k in range(3):
        a, b = nodes[node, 9 + k], nodes[node, 12 + k]
        nodes[node, 9 + k], nodes[node, 12 + k] = co * a + si * b, co * b - si * a


@njit(cache=True)
def _bound_bowl(points, normals, begin, end, nodes, node):
    spread2, top, bottom = 0.0, -np.inf, np.inf
    for i in range(begin, end):
        away2 = 0.0
        for k in range(3):
            away2 += (normals[i, k] - nodes[node, 6 + k]) ** 2
        s, t = _offset(points, i, nodes, node, 9), _offset(points, i, nodes, node, 12)
        height = _offset(points, i, nodes, node, 6)
        fallen = 0.5 * (nodes[node, BEND] * s * s + nodes[node, BEND + 1] * t * t)
        spread2, top, bottom = max(spread2, away2), max(top, height), min(bottom, height + fallen)
        nodes[node, WIDTH] = max(nodes[node, WIDTH], abs(s))
        nodes[node, WIDTH + 1] = max(nodes[node, WIDTH + 1], abs(t))
    nodes[node, SPREAD], nodes[node, TOP], nodes[node, BOTTOM] = np.sqrt(spread2), top, bottom


@njit(cache=True, inline="always")
def box_distance2(nodes, node, x, y, z):
    """Squared distance of (x, y, z) from a node's box."""
    dx = max(nodes[node, 0] - x, 0.0, x - nodes[node, 3])
    dy = max(nodes[node, 1] - y, 0.0, y - nodes[node, 4])
    dz = max(nodes[node, 2] - z, 0.0, z - nodes[node, 5])
    return dx * dx + dy * dy + dz * dz


@njit(cache=True, inline="always")
def ball_misses(nodes, node, x, y, z, r):
    """Whether a node's bowl alone shows that none of its samples is inside the ball (x, y, z), r.

    The ball's upper side is below a paraboloid of curvature 1 / r and the samples are above the
    bowl; the least gap between the two over the node's widths decides, each tangent for itself.
    """
    a = x - 0.5 * (nodes[node, 0] + nodes[node, 3])
    b = y - 0.5 * (nodes[node, 1] + nodes[node, 4])
    c = z - 0.5 * (nodes[node, 2] + nodes[node, 5])
    height = a * nodes[node, 6] + b * nodes[node, 7] + c * nodes[node, 8]
    if r <= 0.0 or height - nodes[node, TOP] >= r:
        return True
    s = abs(a * nodes[node, 9] + b * nodes[node, 10] + c * nodes[node, 11])
    t = abs(a * nodes[node, 12] + b * nodes[node, 13] + c * nodes[node, 14])
    gap = 2.0 * r * (nodes[node, BOTTOM] - height - r)
    gap += _least_gap(r * nodes[node, BEND], s, nodes[node, WIDTH])
    gap += _least_gap(r * nodes[node, BEND + 1], t, nodes[node, WIDTH + 1])
    return gap >= 0.0


@njit(cache=True, inline="always")
def _least_gap(bend, s, width):
    """Least value of ``(u - s)^2 - bend u^2`` over ``|u| <= width``, for s >= 0."""
    flat = 1.0 - bend
    if s < width * flat:
        return -bend * s * s / flat
    return (width - s) ** 2 - bend * width * width
