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
def list_neighbors(queries, radius, points, starts, low, width, counts, offsets, members):
    """Write the cell-sorted positions of each query's neighbours, as counted before."""
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
                        members[place] = j
                        place += 1


@njit(cache=True)
def local_moments(queries, radius, points, starts, low, width, counts):
    """Number, mean offset (3) and central second moments (6) of each query's neighbours.

    Offsets are taken from the query itself, so that nothing cancels far from the origin.
    """
    number = np.zeros(len(queries), np.int64)
    moments = np.zeros((len(queries), 9))
    for q in range(len(queries)):
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        a0, a1 = _cell_range(x, radius, low[0], width[0], counts[0])
        b0, b1 = _cell_range(y, radius, low[1], width[1], counts[1])
        c0, c1 = _cell_range(z, radius, low[2], width[2], counts[2])
        n = 0
        sx = sy = sz = xx = yy = zz = xy = xz = yz = 0.0
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                row = (a * counts[1] + b) * counts[2]
                for j in range(starts[row + c0], starts[row + c1 + 1]):
                    dx, dy, dz = points[j, 0] - x, points[j, 1] - y, points[j, 2] - z
                    if dx * dx + dy * dy + dz * dz <= radius * radius:
                        n += 1
                        sx, sy, sz = sx + dx, sy + dy, sz + dz
                        xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
                        xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        number[q] = n
        if n == 0:
            continue
        mx, my, mz = sx / n, sy / n, sz / n
        moments[q, 0], moments[q, 1], moments[q, 2] = mx, my, mz
        moments[q, 3], moments[q, 4] = xx / n - mx * mx, yy / n - my * my
        moments[q, 5], moments[q, 6] = zz / n - mz * mz, xy / n - mx * my
        moments[q, 7], moments[q, 8] = xz / n - mx * mz, yz / n - my * mz
    return number, moments


@njit(cache=True)
def principal_axes(moments):
    """Eigenvalues (n, 3), falling, and eigenvectors (n, 3, 3), as rows, by Jacobi rotations."""
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
            for axis in range(3):
                vectors[q, rank, axis] = v[axis, k]
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
