"""Compiled balanced tree of samples, eight children at a time, with bounds that hug a surface.

Every loop has a plain numpy twin in the tests. Points and normals are in tree order, so that
neighbours in memory are neighbours in space. Numbers of eight children, and of the samples of a
leaf, stand side by side: one loop without branches over them is run four at a time by the
processor, and gives back one bit for each.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

_compiled: Any = njit  # numba takes these options, but its type hints do not list them
# Reference counts and wrappers for Python cost compile time where no one allocates or calls.
_BARE = {"_nrt": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
#: For kernels that only other kernels call.
inner: Any = _compiled(cache=True, error_model="numpy", **_BARE)
#: For loops over children or samples, which are called by the dozen for every sphere.
lanes: Any = _compiled(cache=True, error_model="numpy", **_BARE, forceinline=True)

#: Most samples per leaf of the tree: small leaves prune well, large ones cost fewer tests.
LEAF_SIZE = 16
#: Children of a node.
FAN = 8
#: Room for the nodes that wait during a walk down the tree.
STACK = 128
# columns of a block, FAN numbers each: middle of the box (0-2), mean normal (3-5), tangents (6-8,
# 9-11), then
SPREAD, SIZE, TOP, LOW, BOTTOM, BEND, WIDTH, TURN = 12, 13, 14, 15, 16, 17, 19, 21
COLUMNS = 24
FAR = 1e100  # where what does not exist is: no ball reaches it


class Tree(NamedTuple):
    """Samples in tree order and what bounds them: one flat struct for the kernels.

    Nodes are numbered by level from the root, node 0; the leaves come last, and leaf k holds the
    samples from ``start[k]`` to ``start[k + 1]``. The root has `fan` children, all others FAN.
    What bounds the children of a node is in its row of `blocks`, shape (nodes, COLUMNS * FAN): in
    the frame of a child, from the middle of its box, its samples lie no farther than the two WIDTH
    along the tangents s and t, and along the normal between LOW and TOP and above the saddle or
    bowl ``BOTTOM - (BEND_0 s^2 + BEND_1 t^2) / 2``. SPREAD is the largest distance of a sample's
    normal from the mean normal, SIZE half the diagonal of the box. TURN, three columns of a heap
    of seven splits, is the way from the first to the second half of a split (see `push_turned`).
    Points and normals of a leaf are again in its row of `leaves`, shape (leaves, 6 * LEAF_SIZE).
    """

    points: Any
    normals: Any
    start: Any
    blocks: Any
    leaves: Any
    fan: int


@njit(cache=True)
def sort_samples(points, leaves):
    """Order (n,) of points in a balanced binary tree with `leaves` (a power of two) leaves.

    Also the first and last place of each node, shape (2 leaves,): node ``i`` has the children
    ``2 i`` and ``2 i + 1``, the root is 1, the leaves come last.
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


@inner
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


@lanes
def first_child(tree, node):
    """Number of a node's first child."""
    return 1 if node == 0 else 1 + tree.fan + FAN * (node - 1)


@lanes
def least_gap(bend, s, width):
    """Least value of ``(u - s)^2 - bend u^2`` over ``|u| <= width``, for s >= 0."""
    flat = 1.0 - bend
    inner = -bend * s * s / flat
    outer = (width - s) * (width - s) - bend * width * width
    return inner if s < width * flat else outer


@lanes
def push_near(block, found, child, x, y, z, stack, distance, top):
    """Put the children whose bits are set onto the stack, the nearest to (x, y, z) on top."""
    bottom = top
    k = 0
    while found:
        if found & 1:
            a, b, c = block[k] - x, block[FAN + k] - y, block[2 * FAN + k] - z
            d2 = a * a + b * b + c * c
            j = top
            while j > bottom and distance[j - 1] < d2:
                distance[j], stack[j] = distance[j - 1], stack[j - 1]
                j -= 1
            distance[j], stack[j] = d2, child + k
            top += 1
        k += 1
        found >>= 1
    return top


@lanes
def push_turned(found, turned, child, stack, top):
    """Put the children whose bits are set onto the stack, in the order of three splits in two.

    At each split, number 1 and below it 2, 3 and 4 to 7 as in a heap, the second half goes on
    top where its bit in `turned` is set, else the first.
    """
    for a in range(1, -1, -1):
        p = a ^ (turned >> 1 & 1)
        if found >> (4 * p) & 15:
            for b in range(1, -1, -1):
                q = 2 * p + (b ^ (turned >> (2 + p) & 1))
                for c in range(1, -1, -1):
                    k = 2 * q + (c ^ (turned >> (4 + q) & 1))
                    if found >> k & 1:
                        stack[top] = child + k
                        top += 1
    return top
