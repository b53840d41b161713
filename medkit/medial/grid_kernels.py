"""Compiled loops over the grid of medial spheres: neighbourhoods, and their PCA in one pass."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def _cell_range(value, radius, low, width, count):
    """First and last cell along one axis that an interval about `value` reaches."""
    # the small margin keeps neighbours that sit exactly on the border of the search ball
    first = int(np.floor((value - radius - low) / width - 1e-9))
    last = int(np.floor((value + radius - low) / width + 1e-9))
    return max(first, 0), min(last, count - 1)


@njit(cache=True)
def count_neighbors(queries, radius, points, starts, low, width, counts):
    """How many of the cell-sorted points are within `radius` of each query."""
    result = np.zeros(len(queries), np.int64)
    for q in range(len(queries)):
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        a0, a1 = _cell_range(x, radius, low[0], width[0], counts[0])
        b0, b1 = _cell_range(y, radius, low[1], width[1], counts[1])
        c0, c1 = _cell_range(z, radius, low[2], width[2], counts[2])
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                row = (a * counts[1] + b) * counts[2]
                for j in range(starts[row + c0], starts[row + c1 + 1]):
                    dx, dy, dz = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
                    if dx * dx + dy * dy + dz * dz <= radius * radius:
                        result[q] += 1
    return result


@njit(cache=True)
def list_neighbors(queries, radius, points, starts, low, width, counts, order, offsets, members):
    """Write each query's neighbours, counted before, by the numbers in `order`, ascending."""
    for q in range(len(queries)):
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        a0, a1 = _cell_range(x, radius, low[0], width[0], counts[0])
        b0, b1 = _cell_range(y, radius, low[1], width[1], counts[1])
        c0, c1 = _cell_range(z, radius, low[2], width[2], counts[2])
        place = offsets[q]
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                row = (a * counts[1] + b) * counts[2]
                for j in range(starts[row + c0], starts[row + c1 + 1]):
                    dx, dy, dz = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
                    if dx * dx + dy * dy + dz * dz <= radius * radius:
                        members[place] = order[j]
                        place += 1
        # one query at a time, while its few hundred members are still in the cache
        members[offsets[q] : place].sort()


@njit(cache=True)
def count_work(queries, radius, points, starts, low, width, counts):
    """How many cells a search around each query opens, and how many points it tests there."""
    opened = np.zeros(len(queries), np.int64)
    tested = np.zeros(len(queries), np.int64)
    for q in range(len(queries)):
        a0, a1 = _cell_range(queries[q, 0], radius, low[0], width[0], counts[0])
        b0, b1 = _cell_range(queries[q, 1], radius, low[1], width[1], counts[1])
        c0, c1 = _cell_range(queries[q, 2], radius, low[2], width[2], counts[2])
        opened[q] = (a1 - a0 + 1) * (b1 - b0 + 1) * (c1 - c0 + 1)
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                row = (a * counts[1] + b) * counts[2]
                tested[q] += starts[row + c1 + 1] - starts[row + c0]
    return opened, tested


@njit(cache=True)
def _distance2(dx, dy, dz):
    """Squared length, rounded as everywhere else: what is a neighbour must not depend on speed."""
    return dx * dx + dy * dy + dz * dz


# Only the order of the sums may change, so that several spheres can be summed at a time.
@njit(cache=True, fastmath={"reassoc", "nsz"})
def _add_row(sums, px, py, pz, first, last, x, y, z, reach2):
    """Add number, offsets (3) and their products (6) of the neighbours in one row of cells."""
    n = sx = sy = sz = xx = yy = zz = xy = xz = yz = 0.0
    for j in range(first, last):
        dx, dy, dz = px[j] - x, py[j] - y, pz[j] - z
        # a weight instead of a branch: a branch would stop the compiler from using wide registers
        own = 1.0 if _distance2(dx, dy, dz) <= reach2 else 0.0
        dx, dy, dz = own * dx, own * dy, own * dz
        n += own
        sx, sy, sz = sx + dx, sy + dy, sz + dz
        xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
        xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
    for k, value in enumerate((n, sx, sy, sz, xx, yy, zz, xy, xz, yz)):
        sums[k] += value


@njit(cache=True)
def _range(value, half, low, width, count):
    """First and last cell along one axis within `half` of a value, none if `half` is negative."""
    if half < 0.0:
        return 1, 0
    return _cell_range(value, half, low, width, count)


@njit(cache=True)
def _chord(value, reach, low, width, cell):
    """Half the chord that a slab of cells cuts from a ball of radius `reach`; negative: none."""
    start = low + cell * width
    away = max(start - value, value - start - width, 0.0) * (1.0 - 1e-9)
    return np.sqrt(reach * reach - away * away) if away <= reach else -1.0


@njit(cache=True)
def _surround(m, inner2, outer2, px, py, pz, starts, low, width, counts, sums, near):
    """Sort the points around m into those of every ball about its cell and those of some balls.

    Adds the moments about m of the points within the inner radius to `sums`, copies the points
    between the radii to `near` (3, n), and returns their number.
    """
    outer = np.sqrt(outer2)
    found = 0
    a0, a1 = _cell_range(m[0], outer, low[0], width[0], counts[0])
    for a in range(a0, a1 + 1):
        half = _chord(m[0], outer, low[0], width[0], a)
        b0, b1 = _range(m[1], half, low[1], width[1], counts[1])
        c0, c1 = _range(m[2], half, low[2], width[2], counts[2])
        # rows that span the whole z edge follow each other in memory: walk them as one
        whole = c0 == 0 and c1 == counts[2] - 1
        for b in range(b0, b0 + 1 if whole and b1 >= b0 else b1 + 1):
            if not whole:
                part = _chord(m[1], half, low[1], width[1], b)
                c0, c1 = _range(m[2], part, low[2], width[2], counts[2])
            row = (a * counts[1] + b) * counts[2]
            end = (a * counts[1] + (b1 if whole else b)) * counts[2] + c1 + 1
            first, last = starts[row + c0], starts[end] if c1 >= c0 else starts[row + c0]
            _add_row(sums, px, py, pz, first, last, m[0], m[1], m[2], inner2)
            for j in range(first, last):
                d2 = _distance2(px[j] - m[0], py[j] - m[1], pz[j] - m[2])
                near[0, found], near[1, found], near[2, found] = px[j], py[j], pz[j]
                # overwritten by the next one unless it counts: cheaper than a branch
                found += 1 if inner2 < d2 <= outer2 else 0
    return found


@njit(cache=True)
def _shifted(about, x, y, z, sums):
    """Sums of offsets about a point, taken about one that lies (x, y, z) away from it."""
    n, sx, sy, sz = about[0], about[1], about[2], about[3]
    sums[0] = n
    sums[1], sums[2], sums[3] = sx - n * x, sy - n * y, sz - n * z
    sums[4] = about[4] - 2.0 * x * sx + n * x * x
    sums[5] = about[5] - 2.0 * y * sy + n * y * y
    sums[6] = about[6] - 2.0 * z * sz + n * z * z
    sums[7] = about[7] - x * sy - y * sx + n * x * y
    sums[8] = about[8] - x * sz - z * sx + n * x * z
    sums[9] = about[9] - y * sz - z * sy + n * y * z


@njit(cache=True)
def _middle_of(points, first, last, m):
    """Write the middle of a few points to m and return the distance of the outermost."""
    for k in range(3):
        lowest, highest = np.inf, -np.inf
        for i in range(first, last):
            lowest, highest = min(lowest, points[i, k]), max(highest, points[i, k])
        m[k] = 0.5 * (lowest + highest)
    most = 0.0
    for i in range(first, last):
        away = _distance2(points[i, 0] - m[0], points[i, 1] - m[1], points[i, 2] - m[2])
        most = max(most, away)
    return np.sqrt(most)


@njit(cache=True)
def local_moments(radius, points, starts, low, width, counts):
    """Number, mean offset (3) and central second moments (6) of the neighbours of every point.

    The points of a cell have most of their neighbours in common: what lies within the radius of
    all of them is summed once, and only a shell is tested for each. Offsets are taken from the
    point itself, so that nothing cancels far from the origin.
    """
    n = len(points)
    number = np.zeros(n, np.int64)
    moments = np.zeros((n, 9))
    px, py, pz = points[:, 0].copy(), points[:, 1].copy(), points[:, 2].copy()
    near = np.empty((3, n + 1))
    m, common, sums = np.empty(3), np.empty(10), np.empty(10)
    # rounding must not decide what is common to all: the brute-force test has the last word
    unsure = 4e-15 * np.abs(points).max()
    for cell in range(len(starts) - 1):
        first, last = starts[cell], starts[cell + 1]
        if last == first:
            continue
        spread = _middle_of(points, first, last, m)
        unsure_here = unsure + 1e-9 * (radius + spread)
        inner = radius - spread - unsure_here
        inner2 = inner * inner if inner > 0.0 else -1.0
        common[:] = 0.0
        found = _surround(
            m, inner2, (radius + spread + unsure_here) ** 2, px, py, pz, starts, low, width, counts,
            common, near,
        )  # fmt: skip
        for i in range(first, last):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            _shifted(common, x - m[0], y - m[1], z - m[2], sums)
            _add_row(sums, near[0], near[1], near[2], 0, found, x, y, z, radius * radius)
            number[i] = np.int64(sums[0])
            _central(sums, moments[i])
    return number, moments


@njit(cache=True)
def _central(sums, moments):
    """Means (3) and central second moments (6: xx, yy, zz, xy, xz, yz) from the sums."""
    for k in range(3):
        moments[k] = sums[1 + k] / sums[0]
        moments[3 + k] = sums[4 + k] / sums[0] - moments[k] * moments[k]
    moments[6] = sums[7] / sums[0] - moments[0] * moments[1]
    moments[7] = sums[8] / sums[0] - moments[0] * moments[2]
    moments[8] = sums[9] / sums[0] - moments[1] * moments[2]


@njit(cache=True)
def principal_axes(moments):
    """Eigenvalues (n, 3), falling, and eigenvectors (n, 3, 3), as rows, by Jacobi rotations.

    Of the two signs of an eigenvector, the one is taken whose largest component is positive.
    """
    values = np.empty((len(moments), 3))
    vectors = np.empty((len(moments), 3, 3))
    m = np.empty((3, 3))
    v = np.empty((3, 3))
    for q in range(len(moments)):
        for k in range(3):
            m[k, k] = moments[q, 3 + k]
        m[0, 1] = m[1, 0] = moments[q, 6]
        m[0, 2] = m[2, 0] = moments[q, 7]
        m[1, 2] = m[2, 1] = moments[q, 8]
        _diagonalise(m, v)
        a = 0
        c = 0
        for k in range(1, 3):
            if m[k, k] > m[a, a]:
                a = k
            if m[k, k] <= m[c, c]:
                c = k
        c = c if c != a else (a + 1) % 3
        b = 3 - a - c
        for rank, k in enumerate((a, b, c)):
            values[q, rank] = max(m[k, k], 0.0)
            largest = 0
            for axis in range(1, 3):
                if abs(v[axis, k]) > abs(v[largest, k]):
                    largest = axis
            sign = -1.0 if v[largest, k] < 0.0 else 1.0
            for axis in range(3):
                vectors[q, rank, axis] = sign * v[axis, k]
    return values, vectors


@njit(cache=True)
def _diagonalise(m, v):
    """Turn the symmetric `m` into its diagonal form in place; the columns of `v` are its axes."""
    for i in range(3):
        for j in range(3):
            v[i, j] = 1.0 if i == j else 0.0
    for _ in range(12):
        off = m[0, 1] ** 2 + m[0, 2] ** 2 + m[1, 2] ** 2
        if off <= 1e-32 * (m[0, 0] ** 2 + m[1, 1] ** 2 + m[2, 2] ** 2):
            return
        for p in range(2):
            for q in range(p + 1, 3):
                if m[p, q] == 0.0:
                    continue
                theta = 0.5 * (m[q, q] - m[p, p]) / m[p, q]
                t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
                t = -t if theta < 0.0 else t
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                m[p, p] -= t * m[p, q]
                m[q, q] += t * m[p, q]
                m[p, q] = m[q, p] = 0.0
                r = 3 - p - q
                rp, rq = m[r, p], m[r, q]
                m[r, p] = m[p, r] = c * rp - s * rq
                m[r, q] = m[q, r] = s * rp + c * rq
                for k in range(3):
                    kp, kq = v[k, p], v[k, q]
                    v[k, p], v[k, q] = c * kp - s * kq, s * kp + c * kq
