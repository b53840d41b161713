"""Compiled loops of the medial axis: a balanced tree, shrinking balls.

Every loop has a plain numpy twin in the tests. Arrays of points are in tree order unless said
otherwise, so that neighbours in memory are neighbours in space.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit

from medkit.medial.surface_kernels import bucket

#: Samples per leaf of the tree: small leaves prune well, large ones cost fewer box tests.
LEAF_SIZE = 8
#: Room for the nodes that wait during a walk down the tree.
STACK = 128


@njit(cache=True)
def build_tree(points, leaves):
    """Order points into a balanced binary tree with `leaves` (a power of two) leaves.

    Node ``i`` has the children ``2 i`` and ``2 i + 1``, the root is 1, the leaves come last.
    Returns the order, the first and last index of each node, and the boxes.
    """
    n = len(points)
    sorted_points = points.copy()
    order = np.arange(n)
    first = np.zeros(2 * leaves, np.int64)
    last = np.zeros(2 * leaves, np.int64)
    boxes = np.zeros((2 * leaves, 6))
    last[1] = n
    for node in range(1, 2 * leaves):
        _bound(sorted_points, first[node], last[node], boxes, node)
        if node >= leaves:
            continue
        extent = boxes[node, 3:] - boxes[node, :3]
        middle = (first[node] + last[node]) // 2
        _select(sorted_points, order, first[node], last[node], middle, np.argmax(extent))
        first[2 * node], last[2 * node] = first[node], middle
        first[2 * node + 1], last[2 * node + 1] = middle, last[node]
    return order, sorted_points, first, last, boxes


@njit(cache=True)
def _bound(points, first, last, boxes, node):
    for k in range(3):
        low = np.inf
        high = -np.inf
        for i in range(first, last):
            low = min(low, points[i, k])
            high = max(high, points[i, k])
        boxes[node, k] = low
        boxes[node, 3 + k] = high


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
def box_distance2(boxes, node, x, y, z):
    """Squared distance of (x, y, z) from a node's box."""
    dx = max(boxes[node, 0] - x, 0.0, x - boxes[node, 3])
    dy = max(boxes[node, 1] - y, 0.0, y - boxes[node, 4])
    dz = max(boxes[node, 2] - z, 0.0, z - boxes[node, 5])
    return dx * dx + dy * dy + dz * dz


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
    allowed = slack if dot > 0.0 else 0.0
    if h <= allowed or d2 == 0.0:
        return np.inf
    return (d2 - allowed * allowed) / (2.0 * (h - allowed))


@njit(cache=True)
def bound_slabs(points, normals, first, last, boxes):
    """Slab of every node along its mean normal: direction (3), range (2), spread of normals, size.

    The slab of a curved patch hugs it more closely than its box, which decides how many nodes a
    ball has to look into that touches the surface all around.
    """
    slabs = np.zeros((len(first), 7))
    for node in range(1, len(first)):
        for i in range(first[node], last[node]):
            for k in range(3):
                slabs[node, k] += normals[i, k]
        length = np.sqrt(slabs[node, 0] ** 2 + slabs[node, 1] ** 2 + slabs[node, 2] ** 2)
        for k in range(3):
            slabs[node, k] /= max(length, 1e-300)
        low, high = np.inf, -np.inf
        for i in range(first[node], last[node]):
            along = 0.0
            apart2 = 0.0
            for k in range(3):
                along += slabs[node, k] * points[i, k]
                apart2 += (slabs[node, k] - normals[i, k]) ** 2
            low, high = min(low, along), max(high, along)
            slabs[node, 5] = max(slabs[node, 5], apart2)
        slabs[node, 3], slabs[node, 4] = low, high
        slabs[node, 5] = np.sqrt(slabs[node, 5])
        for k in range(3):
            slabs[node, 6] += (0.5 * (boxes[node, 3 + k] - boxes[node, k])) ** 2
        slabs[node, 6] = np.sqrt(slabs[node, 6])
    return slabs


@njit(cache=True)
def shrink_balls(points, normals, first, last, boxes, slabs, largest, slack, trust):
    """Largest tangent ball of every sample that no other sample enters deeper than `slack`.

    A ball that sticks out of one already found empty by less than `trust` is taken as empty too:
    it saves the search where many samples share a centre. Returns the radii and the index of the
    sample that stops each ball (-1: none within `largest`).
    """
    n = len(points)
    leaves = len(first) // 2
    radii = np.empty(n)
    stop = np.full(n, -1, np.int64)
    stack = np.empty(STACK, np.int64)
    known = np.full(4 * leaves, -1, np.int64)
    width = max(2.0 * trust, 1e-300)
    for leaf in range(leaves, 2 * leaves):
        for i in range(first[leaf], last[leaf]):
            r = largest
            best = -1
            for j in range(first[leaf], last[leaf]):
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
                r, best = _shrink_one(
                    points, normals, first, last, boxes, slabs, leaves, i, r, best, slack, stack
                )
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
def _shrink_one(points, normals, first, last, boxes, slabs, leaves, i, r, best, slack, stack):
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    u, v, w = normals[i, 0], normals[i, 1], normals[i, 2]
    stack[0] = 1
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        reach = max(r - slack, 0.0)
        a, b, c = x - r * u, y - r * v, z - r * w
        if box_distance2(boxes, node, a, b, c) >= reach * reach:
            continue
        along = slabs[node, 0] * a + slabs[node, 1] * b + slabs[node, 2] * c
        if max(slabs[node, 3] - along, along - slabs[node, 4]) >= reach:
            continue
        if node >= leaves:
            for j in range(first[node], last[node]):
                value = _largest_radius(points, normals, i, j, slack)
                if value < r:
                    r, best = value, j
            continue
        near, far = 2 * node, 2 * node + 1
        if box_distance2(boxes, near, a, b, c) > box_distance2(boxes, far, a, b, c):
            near, far = far, near
        stack[top] = far
        stack[top + 1] = near
        top += 2
    return r, best


@njit(cache=True)
def refine_balls(points, normals, radii, stop, reach):
    """Radius of the ball tangent at sample i and to the surface near the sample that stops it.

    The two-point formula is off by the square of the distance between that sample and the true
    touch point; the tangent plane at the sample removes this error. It may only shrink a ball,
    and only when the foot on the plane is within `reach` of the sample. Samples exactly on a sharp
    edge get radius zero.
    """
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
