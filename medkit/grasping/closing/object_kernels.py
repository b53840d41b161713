"""Compiled pieces that know the object only: point to triangle, distance lattice, cell lists."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def point_triangle_distance_squared(px: float, py: float, pz: float, triangle: np.ndarray) -> float:
    """Squared distance [m^2] of a point from a triangle (3, 3), by the triangle's seven regions."""
    ax, ay, az = triangle[0, 0], triangle[0, 1], triangle[0, 2]
    abx, aby, abz = triangle[1, 0] - ax, triangle[1, 1] - ay, triangle[1, 2] - az
    acx, acy, acz = triangle[2, 0] - ax, triangle[2, 1] - ay, triangle[2, 2] - az
    apx, apy, apz = px - ax, py - ay, pz - az
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    bb = abx * abx + aby * aby + abz * abz
    cc = acx * acx + acy * acy + acz * acz
    bc = abx * acx + aby * acy + abz * acz
    # Barycentric weights v, w of the nearest point; which of them is clamped names the region.
    d3, d4 = d1 - bb, d2 - bc
    d5, d6 = d1 - bc, d2 - cc
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        v, w = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        v, w = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        v, w = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v, w = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        v, w = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        scale = 1.0 / (va + vb + vc)
        v, w = vb * scale, vc * scale
    dx = apx - v * abx - w * acx
    dy = apy - v * aby - w * acy
    dz = apz - v * abz - w * acz
    return dx * dx + dy * dy + dz * dz


@njit(cache=True)
def index_range(
    low: float, high: float, origin: float, spacing: float, count: int
) -> tuple[int, int]:
    """First and one-past-last lattice index between two coordinates, clipped to the lattice."""
    first = int(np.ceil((low - origin) / spacing))
    last = int(np.floor((high - origin) / spacing)) + 1
    return max(first, 0), min(last, count)


@njit(cache=True)
def splat_distances(
    triangles: np.ndarray, origin: np.ndarray, spacing: float, band: float, squared: np.ndarray
) -> None:
    """Lower each node of `squared` [m^2] to its distance from every triangle within `band` [m]."""
    for t in range(len(triangles)):
        triangle = triangles[t]
        i0, i1 = index_range(
            min(triangle[0, 0], triangle[1, 0], triangle[2, 0]) - band,
            max(triangle[0, 0], triangle[1, 0], triangle[2, 0]) + band,
            origin[0],
            spacing,
            squared.shape[0],
        )
        j0, j1 = index_range(
            min(triangle[0, 1], triangle[1, 1], triangle[2, 1]) - band,
            max(triangle[0, 1], triangle[1, 1], triangle[2, 1]) + band,
            origin[1],
            spacing,
            squared.shape[1],
        )
        k0, k1 = index_range(
            min(triangle[0, 2], triangle[1, 2], triangle[2, 2]) - band,
            max(triangle[0, 2], triangle[1, 2], triangle[2, 2]) + band,
            origin[2],
            spacing,
            squared.shape[2],
        )
        for i in range(i0, i1):
            x = origin[0] + i * spacing
            for j in range(j0, j1):
                y = origin[1] + j * spacing
                for k in range(k0, k1):
                    d = point_triangle_distance_squared(x, y, origin[2] + k * spacing, triangle)
                    if d < squared[i, j, k]:
                        squared[i, j, k] = d


@njit(cache=True)
def list_cell_faces(
    triangles: np.ndarray,
    faces: np.ndarray,
    origin: np.ndarray,
    spacing: float,
    shape: tuple[int, int, int],
    start: np.ndarray,
    listed: np.ndarray,
    fill: bool,
) -> None:
    """Count (into start[c + 1]) or fill the faces that may cross each cell of the lattice.

    `triangles` are pieces of faces, the pieces of one face in sequence; a face is listed once a
    cell. With `fill`, start[c] is the place of the next entry of cell c and moves on.
    """
    half = 0.5 * spacing
    reach = 3.0 * half * half * (1.0 + 1e-9)
    last = np.zeros(shape[0] * shape[1] * shape[2], np.int32)
    low = np.zeros(3, np.int64)
    high = np.zeros(3, np.int64)
    for t in range(len(triangles)):
        triangle = triangles[t]
        for a in range(3):
            least = min(triangle[0, a], triangle[1, a], triangle[2, a]) - origin[a]
            most = max(triangle[0, a], triangle[1, a], triangle[2, a]) - origin[a]
            low[a] = max(int(np.floor(least / spacing)), 0)
            high[a] = min(int(np.floor(most / spacing)) + 1, shape[a])
        for i in range(low[0], high[0]):
            x = origin[0] + i * spacing + half
            for j in range(low[1], high[1]):
                y = origin[1] + j * spacing + half
                for k in range(low[2], high[2]):
                    z = origin[2] + k * spacing + half
                    cell = (i * shape[1] + j) * shape[2] + k
                    if last[cell] == faces[t] + 1:
                        continue
                    if point_triangle_distance_squared(x, y, z, triangle) > reach:
                        continue
                    last[cell] = faces[t] + 1
                    if fill:
                        listed[start[cell]] = faces[t]
                        start[cell] += 1
                    else:
                        start[cell + 1] += 1
