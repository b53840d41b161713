"""Compiled halving of points along the longest side of their box, and of the halves again.

A half is not sorted but parted at its middle, which takes a time in proportion to its points. The
order is strict: by the coordinate of the last halving, where that is the same by that of the one
before, and so on, in the end by number. So the order is that of sorting every half stably.
"""

from __future__ import annotations

import numpy as np

from medkit.grasping.closing.kernel_options import exact, exact_inner


@exact
def halve(points: np.ndarray, order: np.ndarray, depth: int, axes: np.ndarray) -> None:
    """Sort points (p, 3) and their numbers (p,) so that halves of halves are neighbours in space.

    The nodes of the last level are sorted; `axes` (2 ** (depth + 1), 3) is scratch, -1 all over.
    """
    count = len(points)
    for level in range(depth + 1):
        for k in range(2**level):
            low, high = (count * k) >> level, (count * (k + 1)) >> level
            node = 2**level + k
            _put_first(_longest_side(points, low, high), axes, node)
            # the few points of a node of the last level are parted one by one
            first = (count * (2 * k + 1)) >> (level + 1) if level < depth else low + 1
            for middle in range(first, first + 1 if level < depth else high):
                _part(points, order, low, high, middle, axes, node)
                low = middle


@exact_inner
def _longest_side(points: np.ndarray, low: int, high: int) -> int:
    """Longest side of the box around points ``low:high``, the first of equals."""
    best, longest = 0, -1.0
    for a in range(3):
        least = most = points[low, a]
        for i in range(low + 1, high):
            least, most = min(least, points[i, a]), max(most, points[i, a])
        if most - least > longest:
            best, longest = a, most - least
    return best


@exact_inner
def _put_first(axis: int, axes: np.ndarray, node: int) -> None:
    """Write the axis and then the others of the node above, in their order, as a node's axes."""
    axes[node, 0] = axis
    filled = 1
    for k in range(3):
        other = axes[node >> 1, k]
        if other >= 0 and other != axis:
            axes[node, filled] = other
            filled += 1


@exact_inner
def _precedes(
    points: np.ndarray, order: np.ndarray, i: int, j: int, axes: np.ndarray, node: int
) -> bool:
    """Whether point i comes before point j in the order of the node's axes."""
    for k in range(3):
        a = axes[node, k]
        if a < 0:
            break
        if points[i, a] != points[j, a]:
            return bool(points[i, a] < points[j, a])
    return bool(order[i] < order[j])


@exact_inner
def _swap(points: np.ndarray, order: np.ndarray, i: int, j: int) -> None:
    for a in range(3):
        points[i, a], points[j, a] = points[j, a], points[i, a]
    order[i], order[j] = order[j], order[i]


@exact_inner
def _part(
    points: np.ndarray,
    order: np.ndarray,
    low: int,
    high: int,
    middle: int,
    axes: np.ndarray,
    node: int,
) -> None:
    """Reorder points ``low:high`` so that those before `middle` precede the others."""
    draw = 1
    while high - low > 1:
        draw = (draw * 1103515245 + 12345) % 2147483648  # so that no order of points is a bad one
        last = high - 1
        _swap(points, order, low + draw % (high - low), last)
        pivot, a, less = points[last, axes[node, 0]], axes[node, 0], low
        for i in range(low, last):
            x = points[i, a]
            if x < pivot or (x == pivot and _precedes(points, order, i, last, axes, node)):
                _swap(points, order, i, less)
                less += 1
        _swap(points, order, less, last)
        if less == middle:
            return
        if less < middle:
            low = less + 1
        else:
            high = less
