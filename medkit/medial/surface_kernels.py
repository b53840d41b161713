"""Compiled loops of surface sampling: thinning of candidates, normals at the corners of faces."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def lay_candidates(edges, count, phase, stride, corners, corner_normals, face_normals):
    """Face, place and normal of candidates, in proportion to area and even inside the faces.

    `edges` are the areas added up, `corners` the vertices by face and corner. Neighbours in the
    sequence are `stride` apart on the surface.
    """
    g = 1.32471795724474602596  # the plastic number's recurrence fills the unit square evenly
    faces = np.empty(count, np.int64)
    f = 0
    for i in range(count):
        area = (i + phase) / count * edges[-1]
        while f < len(edges) - 1 and edges[f] < area:
            f += 1
        faces[i] = f
    chosen = np.empty(count, np.int64)
    points, normals = np.empty((count, 3)), np.empty((count, 3))
    for place in range(count):
        i = place * stride % count
        f = faces[i]
        u, v = (0.5 + i / g) % 1.0, (0.5 + i / (g * g)) % 1.0
        if u + v > 1.0:
            u, v = 1.0 - u, 1.0 - v
        w = 1.0 - u - v
        chosen[place] = f
        d2 = 0.0
        for k in range(3):
            points[place, k] = w * corners[f, 0, k] + u * corners[f, 1, k] + v * corners[f, 2, k]
            normals[place, k] = (
                w * corner_normals[f, 0, k]
                + u * corner_normals[f, 1, k]
                + v * corner_normals[f, 2, k]
            )
            d2 += normals[place, k] * normals[place, k]
        length = np.sqrt(d2)
        for k in range(3):
            # normals that cancel say nothing: there the face's own counts
            smooth = normals[place, k] / max(length, 0.5)
            normals[place, k] = smooth if length > 0.5 else face_normals[f, k]
    return chosen, points, normals


@njit(cache=True)
def thin_samples(points, normals, distance, min_cosine):
    """Keep, in the order given, each sample that no kept one is nearer to than `distance`.

    Samples whose normals differ by more than the given cosine do not compete: the two sides of a
    thin wall, or of an edge, are both needed. Returns the places of those that are kept.
    """
    n = len(points)
    size = 1
    while size < n:
        size *= 2
    head = np.full(size, -1, np.int32)
    following = np.empty(n, np.int32)
    places = np.empty(n, np.int32)
    kept = np.empty((n // 2 + 16, 6))  # next to each other in memory
    low = np.array([points[:, 0].min(), points[:, 1].min(), points[:, 2].min()])
    width = 2.0 * distance
    count = 0
    for i in range(n):
        x, y, z = (
            (points[i, 0] - low[0]) / width,
            (points[i, 1] - low[1]) / width,
            (points[i, 2] - low[2]) / width,
        )
        a, b, c = np.int64(x), np.int64(y), np.int64(z)
        # in cells twice as wide only the nearer neighbour on each axis can hold a competitor
        p = 1 if x - a > 0.5 else -1
        q = 1 if y - b > 0.5 else -1
        r = 1 if z - c > 0.5 else -1
        free = True
        for corner in range(8):
            j = head[
                bucket(a + p * (corner & 1), b + q * (corner >> 1 & 1), c + r * (corner >> 2), size)
            ]
            while j >= 0 and free:
                d2 = 0.0
                for k in range(3):
                    d2 += (points[i, k] - kept[j, k]) ** 2
                if d2 < distance * distance:
                    dot = 0.0
                    for k in range(3):
                        dot += normals[i, k] * kept[j, 3 + k]
                    free = dot < min_cosine
                j = following[j]
            if not free:
                break
        if free:
            if count == len(kept):
                larger = np.empty((2 * count, 6))
                larger[:count] = kept
                kept = larger
            for k in range(3):
                kept[count, k], kept[count, 3 + k] = points[i, k], normals[i, k]
            places[count] = i
            own = bucket(a, b, c, size)
            following[count] = head[own]
            head[own] = count
            count += 1
    return places[:count]


@njit(cache=True)
def bucket(a, b, c, size):
    """Place of a cell in a hash table whose size is a power of two."""
    return (a * 73856093 ^ b * 19349663 ^ c * 83492791) & (size - 1)


@njit(cache=True)
def ends_along(points, directions):
    """Index of the first and of the last point along each direction."""
    n = len(directions)
    u, v, w = directions[:, 0].copy(), directions[:, 1].copy(), directions[:, 2].copy()
    low, high = np.zeros(n, np.int64), np.zeros(n, np.int64)
    least, most = np.full(n, np.inf), np.full(n, -np.inf)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        # one loop without branches over the directions is run four at a time
        for k in range(n):
            along = u[k] * x + v[k] * y + w[k] * z
            low[k] = i if along < least[k] else low[k]
            least[k] = along if along < least[k] else least[k]
            high[k] = i if along > most[k] else high[k]
            most[k] = along if along > most[k] else most[k]
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
