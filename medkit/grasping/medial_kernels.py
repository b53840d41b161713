"""Compiled loops of the medial axis: thinning of samples, a balanced tree, shrinking balls.

Every loop has a plain numpy twin in the tests. Arrays of points are in tree order unless said
otherwise, so that neighbours in memory are neighbours in space.
"""

from __future__ import annotations

import numpy as np
from numba import njit

#: Samples per leaf of the tree: small leaves prune well, large ones cost fewer box tests.
LEAF_SIZE = 8
_STACK = 128


@njit(cache=True)
def thin_samples(points, normals, distance, min_cosine):
    """Keep, in the order given, each sample that no kept one is nearer to than `distance`.

    Samples whose normals differ by more than the given cosine do not compete: the two sides of a
    thin wall, or of an edge, are both needed.
    """
    n = len(points)
    size = 1
    while size < n:
        size *= 2
    head = np.full(size, -1, np.int32)
    following = np.full(n, -1, np.int32)
    keep = np.zeros(n, np.bool_)
    low = np.array([points[:, 0].min(), points[:, 1].min(), points[:, 2].min()])
    for i in range(n):
        x = np.int64((points[i, 0] - low[0]) / distance)
        y = np.int64((points[i, 1] - low[1]) / distance)
        z = np.int64((points[i, 2] - low[2]) / distance)
        free = True
        for a in range(x - 1, x + 2):
            for b in range(y - 1, y + 2):
                for c in range(z - 1, z + 2):
                    j = head[_bucket(a, b, c, size)]
                    while j >= 0 and free:
                        d2 = 0.0
                        dot = 0.0
                        for k in range(3):
                            d2 += (points[i, k] - points[j, k]) ** 2
                            dot += normals[i, k] * normals[j, k]
                        free = d2 >= distance * distance or dot < min_cosine
                        j = following[j]
                if not free:
                    break
            if not free:
                break
        if free:
            keep[i] = True
            own = _bucket(x, y, z, size)
            following[i] = head[own]
            head[own] = i
    return keep


@njit(cache=True)
def _bucket(a, b, c, size):
    return (a * 73856093 ^ b * 19349663 ^ c * 83492791) & (size - 1)


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
def _box_distance2(boxes, node, x, y, z):
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
def shrink_balls(points, normals, first, last, boxes, largest, slack):
    """Largest tangent ball of every sample that no other sample enters deeper than `slack`.

    Returns the radii (with slack) and the index of the sample that stops each ball (-1: none
    within `largest`).
    """
    n = len(points)
    leaves = len(first) // 2
    radii = np.empty(n)
    stop = np.full(n, -1, np.int64)
    stack = np.empty(_STACK, np.int64)
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
            r, best = _shrink_one(
                points, normals, first, last, boxes, leaves, i, r, best, slack, stack
            )
            radii[i] = r
            stop[i] = best
    return radii, stop


@njit(cache=True)
def _shrink_one(points, normals, first, last, boxes, leaves, i, r, best, slack, stack):
    x, y, z = points[i, 0], points[i, 1], points[i, 2]
    u, v, w = normals[i, 0], normals[i, 1], normals[i, 2]
    stack[0] = 1
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        reach = max(r - slack, 0.0)
        a, b, c = x - r * u, y - r * v, z - r * w
        if _box_distance2(boxes, node, a, b, c) >= reach * reach:
            continue
        if node >= leaves:
            for j in range(first[node], last[node]):
                value = _largest_radius(points, normals, i, j, slack)
                if value < r:
                    r, best = value, j
            continue
        near, far = 2 * node, 2 * node + 1
        if _box_distance2(boxes, near, a, b, c) > _box_distance2(boxes, far, a, b, c):
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
    and only when the foot on the plane is within `reach` of the sample.
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
        if 0.0 < r < refined[i]:
            offset2 = 0.0
            for k in range(3):
                foot = points[i, k] - r * normals[i, k] + r * normals[j, k]
                offset2 += (foot - points[j, k]) ** 2
            if offset2 <= reach * reach:
                refined[i] = r
    return refined


@njit(cache=True)
def widest_touch(
    centers, radii, own, stop, points, normals, first, last, boxes, tolerance, reach, enough
):
    """Object angle of every sphere over all samples it touches, and the two touch points.

    A sample touches when its tangent plane (within `reach` of it), or the sample itself, is no
    farther from the centre than radius plus `tolerance`. The farthest touch from one touch is
    sought, then the farthest from that, until the angle no longer grows or is wider than
    `enough` [rad].
    """
    n = len(centers)
    angles = np.empty(n)
    pairs = np.empty((n, 2, 3))
    stack = np.empty(_STACK, np.int64)
    goal = np.cos(enough)
    pair = np.empty((2, 3))
    trial = np.empty((2, 3))
    for i in range(n):
        _, u, v, w = _direction(centers, i, points, normals, stop[i], reach)
        pair[1, 0], pair[1, 1], pair[1, 2] = u, v, w
        cosine = 0.0
        for k in range(3):
            pair[0, k] = normals[own[i], k]
            cosine += pair[0, k] * pair[1, k]
        for start in range(2):
            for k in range(3):
                trial[0, k] = pair[start, k]
            for _ in range(4):
                found = _farthest(
                    centers, i, radii[i], trial, points, normals, first, last, boxes,
                    tolerance, reach, cosine, goal, stack,
                )  # fmt: skip
                if found >= cosine:
                    break
                cosine = found
                for k in range(3):
                    pair[0, k], pair[1, k] = trial[0, k], trial[1, k]
                    trial[0, k] = trial[1, k]
        angles[i] = np.arccos(min(1.0, max(-1.0, cosine)))
        for k in range(3):
            pairs[i, 0, k] = centers[i, k] + radii[i] * pair[0, k]
            pairs[i, 1, k] = centers[i, k] + radii[i] * pair[1, k]
    return angles, pairs


@njit(cache=True)
def _direction(centers, i, points, normals, j, reach):
    """Distance and direction from centre i to where the surface at sample j is nearest."""
    x = points[j, 0] - centers[i, 0]
    y = points[j, 1] - centers[i, 1]
    z = points[j, 2] - centers[i, 2]
    d2 = x * x + y * y + z * z
    h = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
    if h > 0.0 and d2 - h * h <= reach * reach:
        return h, normals[j, 0], normals[j, 1], normals[j, 2]
    d = np.sqrt(d2)
    return d, x / d, y / d, z / d


@njit(cache=True)
def _farthest(
    centers,
    i,
    radius,
    trial,
    points,
    normals,
    first,
    last,
    boxes,
    tolerance,
    reach,
    best,
    goal,
    stack,
):
    """Touch whose direction has the least cosine with ``trial[0]``, if less than `best`."""
    if best <= goal:
        return best
    leaves = len(first) // 2
    limit2 = (radius + tolerance) ** 2 + reach * reach
    x, y, z = centers[i, 0], centers[i, 1], centers[i, 2]
    stack[0] = 1
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if (
            _box_distance2(boxes, node, x, y, z) > limit2
            or _least_along(boxes, node, centers, i, trial) - reach >= best * radius
        ):
            continue
        if node < leaves:
            near, far = 2 * node, 2 * node + 1
            if _least_along(boxes, near, centers, i, trial) > _least_along(
                boxes, far, centers, i, trial
            ):
                near, far = far, near
            stack[top] = far
            stack[top + 1] = near
            top += 2
            continue
        for j in range(first[node], last[node]):
            distance, u, v, w = _direction(centers, i, points, normals, j, reach)
            dot = u * trial[0, 0] + v * trial[0, 1] + w * trial[0, 2]
            if distance <= radius + tolerance and dot < best:
                best = dot
                trial[1, 0], trial[1, 1], trial[1, 2] = u, v, w
                if best <= goal:
                    return best
    return best


@njit(cache=True)
def _least_along(boxes, node, centers, i, trial):
    """Least component along the first trial direction of a vector from a centre into a box."""
    total = 0.0
    for k in range(3):
        edge = boxes[node, k] if trial[0, k] > 0.0 else boxes[node, 3 + k]
        total += trial[0, k] * (edge - centers[i, k])
    return total


@njit(cache=True)
def blend_corners(face_normals, vertex, face, angle, order, begin, count, min_cosine):
    """Mean normal at each corner over the faces around its vertex that turn little from its own."""
    result = np.empty((len(vertex), 3))
    total = np.empty(3)
    for corner in range(len(vertex)):
        own = face[corner]
        total[:] = 0.0
        start = begin[vertex[corner]]
        for place in range(start, start + count[vertex[corner]]):
            other = order[place]
            f = face[other]
            dot = 0.0
            for k in range(3):
                dot += face_normals[own, k] * face_normals[f, k]
            if dot >= min_cosine:
                for k in range(3):
                    total[k] += angle[other] * face_normals[f, k]
        length = np.sqrt(total[0] ** 2 + total[1] ** 2 + total[2] ** 2)
        for k in range(3):
            result[corner, k] = total[k] / length if length > 0.0 else face_normals[own, k]
    return result
