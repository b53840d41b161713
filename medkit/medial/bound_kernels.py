"""Compiled bounds of the nodes of a tree of samples; see `medkit.medial.tree_kernels.Tree`."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.tree_kernels import (
    BEND,
    BOTTOM,
    COLUMNS,
    FAN,
    FAR,
    LEAF_SIZE,
    LOW,
    SIZE,
    SPREAD,
    TOP,
    TURN,
    WIDTH,
    inner,
    lanes,
)


@njit(cache=True)
def bound_samples(points, normals, first, last):
    """Bounds of all nodes, the samples of all leaves, and the number of the root's children.

    `first` and `last` are those of the binary tree, of which every third level is kept, counted
    from the leaves.
    """
    leaves = len(first) // 2
    level = leaves
    while level > FAN:
        level //= FAN
    fan = level
    count = 1
    while level < leaves:
        count += level
        level *= FAN
    blocks = np.zeros((count, COLUMNS, FAN))
    blocks[0, BOTTOM, fan:] = FAR  # children that do not exist are never reached
    boxes = _box_nodes(points, first, last)
    for b in range(count):
        binary = _binary_node(b, fan)
        width = fan if b == 0 else FAN
        _keep_turns(boxes, binary, width, blocks[b])
        for k in range(width):
            node = binary * width + k
            _bound(points, normals, first[node], last[node], boxes[node], blocks[b], k)
    return blocks.reshape(count, COLUMNS * FAN), _copy_leaves(points, normals, first, last), fan


@inner
def _binary_node(b, fan):
    """Node of the binary tree that block `b` belongs to."""
    if b == 0:
        return 1
    begin, level = 1, fan
    while b >= begin + level:
        begin += level
        level *= FAN
    return level + b - begin


@njit(cache=True)
def _box_nodes(points, first, last):
    """Lower and upper end of the box of every node of the binary tree, shape (nodes, 2, 3)."""
    boxes = np.empty((len(first), 2, 3))
    leaves = len(first) // 2
    for node in range(len(first) - 1, 0, -1):
        for k in range(3):
            if node < leaves:
                one, two = boxes[2 * node], boxes[2 * node + 1]
                low, high = min(one[0, k], two[0, k]), max(one[1, k], two[1, k])
            else:
                low, high = np.inf, -np.inf
                for i in range(first[node], last[node]):
                    low, high = min(low, points[i, k]), max(high, points[i, k])
            boxes[node, 0, k], boxes[node, 1, k] = low, high
    return boxes


@inner
def _keep_turns(boxes, binary, width, block):
    """Way from the first to the second half of each split between the children of a block."""
    place, split = FAN // width, binary
    span = 1
    while span < width:
        for e in range(span):
            one, two = boxes[2 * (split + e)], boxes[2 * (split + e) + 1]
            for k in range(3):
                block[TURN + k, place + e] = two[0, k] + two[1, k] - one[0, k] - one[1, k]
        place, split, span = 2 * place, 2 * split, 2 * span


@njit(cache=True)
def _copy_leaves(points, normals, first, last):
    leaves = len(first) // 2
    copied = np.zeros((leaves, 6, LEAF_SIZE))
    copied[:, :3] = FAR
    for leaf in range(leaves):
        begin = first[leaves + leaf]
        for i in range(begin, last[leaves + leaf]):
            for k in range(3):
                copied[leaf, k, i - begin] = points[i, k]
                copied[leaf, 3 + k, i - begin] = normals[i, k]
    return copied.reshape(leaves, 6 * LEAF_SIZE)


@inner
def _bound(points, normals, begin, end, box, block, k):
    """Box, frame and bowl of the samples from `begin` to `end`, into column `k` of a block."""
    size2 = 0.0
    for axis in range(3):
        total = 0.0
        for i in range(begin, end):
            total += normals[i, axis]
        block[axis, k] = 0.5 * (box[0, axis] + box[1, axis])
        block[3 + axis, k] = total
        size2 += 0.25 * (box[1, axis] - box[0, axis]) ** 2
    block[SIZE, k] = np.sqrt(size2)
    _set_normal(block, k)
    _fit_bends(points, normals, begin, end, block, k)
    _bound_bowl(points, normals, begin, end, block, k)


@inner
def _set_normal(block, k):
    """Unit mean normal, and any two tangents that complete the frame."""
    x, y, z = block[3, k], block[4, k], block[5, k]
    length = np.sqrt(x * x + y * y + z * z)
    if length < 1e-6:
        x, y, z, length = 0.0, 0.0, 1.0, 1.0
    x, y, z = x / length, y / length, z / length
    a, b, c = (0.0, z, -y) if abs(x) < 0.6 else (-z, 0.0, x)
    across = np.sqrt(a * a + b * b + c * c)
    a, b, c = a / across, b / across, c / across
    block[3, k], block[4, k], block[5, k] = x, y, z
    block[6, k], block[7, k], block[8, k] = a, b, c
    block[9, k], block[10, k], block[11, k] = y * c - z * b, z * a - x * c, x * b - y * a


@lanes
def _along(block, column, k, x, y, z):
    """Component of a vector along an axis of the frame."""
    return x * block[column, k] + y * block[column + 1, k] + z * block[column + 2, k]


@inner
def _fit_bends(points, normals, begin, end, block, k):
    """Turn the tangents to the principal directions, and store the two principal curvatures.

    The curvature tensor is the linear map from offsets to turns of the normal that fits best. It
    only decides how tight the bound is, never whether it holds.
    """
    ss, st, tt, su, sv, tu, tv = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(begin, end):
        x, y, z = points[i, 0] - block[0, k], points[i, 1] - block[1, k], points[i, 2] - block[2, k]
        s, t = _along(block, 6, k, x, y, z), _along(block, 9, k, x, y, z)
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        u, v = _along(block, 6, k, x, y, z), _along(block, 9, k, x, y, z)
        ss, st, tt = ss + s * s, st + s * t, tt + t * t
        su, sv, tu, tv = su + s * u, sv + s * v, tu + t * u, tv + t * v
    det = ss * tt - st * st
    if det <= 1e-6 * (ss + tt) ** 2:
        return
    p, q = (su * tt - tu * st) / det, (tv * ss - sv * st) / det
    m = 0.5 * ((tu * ss - su * st) + (sv * tt - tv * st)) / det
    angle = 0.5 * np.arctan2(2.0 * m, p - q)
    co, si = np.cos(angle), np.sin(angle)
    block[BEND, k] = p * co * co + 2.0 * m * co * si + q * si * si
    block[BEND + 1, k] = p * si * si - 2.0 * m * co * si + q * co * co
    for axis in range(3):
        a, b = block[6 + axis, k], block[9 + axis, k]
        block[6 + axis, k], block[9 + axis, k] = co * a + si * b, co * b - si * a


@inner
def _bound_bowl(points, normals, begin, end, block, k):
    spread2, top, low, bottom, wide, long = 0.0, -np.inf, np.inf, np.inf, 0.0, 0.0
    for i in range(begin, end):
        away2 = 0.0
        for axis in range(3):
            away2 += (normals[i, axis] - block[3 + axis, k]) ** 2
        x, y, z = points[i, 0] - block[0, k], points[i, 1] - block[1, k], points[i, 2] - block[2, k]
        s, t = _along(block, 6, k, x, y, z), _along(block, 9, k, x, y, z)
        height = _along(block, 3, k, x, y, z)
        fallen = 0.5 * (block[BEND, k] * s * s + block[BEND + 1, k] * t * t)
        spread2, bottom = max(spread2, away2), min(bottom, height + fallen)
        top, low = max(top, height), min(low, height)
        wide, long = max(wide, abs(s)), max(long, abs(t))
    block[SPREAD, k], block[BOTTOM, k] = np.sqrt(spread2), bottom
    block[TOP, k], block[LOW, k] = top, low
    block[WIDTH, k], block[WIDTH + 1, k] = wide, long
