"""Compiled loops of surface sampling: thinning of candidates, normals at the corners of faces."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


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
                    j = head[bucket(a, b, c, size)]
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
            own = bucket(x, y, z, size)
            following[i] = head[own]
            head[own] = i
    return keep


@njit(cache=True)
def bucket(a, b, c, size):
    """Place of a cell in a hash table whose size is a power of two."""
    return (a * 73856093 ^ b * 19349663 ^ c * 83492791) & (size - 1)


@njit(cache=True)
def ends_along(points, directions):
    """Index of the first and of the last point along each direction."""
    low = np.zeros(len(directions), np.int64)
    high = np.zeros(len(directions), np.int64)
    for k in range(len(directions)):
        u, v, w = directions[k, 0], directions[k, 1], directions[k, 2]
        least, most = np.inf, -np.inf
        for i in range(len(points)):
            along = u * points[i, 0] + v * points[i, 1] + w * points[i, 2]
            if along < least:
                least = along
                low[k] = i
            if along > most:
                most = along
                high[k] = i
    return low, high


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
