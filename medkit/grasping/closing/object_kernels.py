"""Compiled pieces that know the object only: point to triangle, distance lattice."""

from __future__ import annotations

import numpy as np

from medkit.grasping.closing.kernel_options import exact, exact_inner

#: Sine squared of a corner's angle below which a triangle has no area worth the name.
SLIVER = 1e-20


@exact_inner
def point_side_distance_squared(
    px: float, py: float, pz: float, a: np.ndarray, b: np.ndarray
) -> float:
    """Squared distance [m^2] of a point from the side between two corners (3,), however short."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    dx, dy, dz = px - a[0], py - a[1], pz - a[2]
    square = ux * ux + uy * uy + uz * uz
    t = 0.0
    if square > 0.0:
        t = min(max((ux * dx + uy * dy + uz * dz) / square, 0.0), 1.0)
    dx, dy, dz = dx - t * ux, dy - t * uy, dz - t * uz
    return dx * dx + dy * dy + dz * dz


@exact
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
    if bb * cc - bc * bc <= SLIVER * bb * cc:  # the regions below would divide by its area
        first = point_side_distance_squared(px, py, pz, triangle[0], triangle[1])
        second = point_side_distance_squared(px, py, pz, triangle[1], triangle[2])
        return min(first, second, point_side_distance_squared(px, py, pz, triangle[2], triangle[0]))
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


@exact_inner
def index_range(
    low: float, high: float, origin: float, spacing: float, count: int
) -> tuple[int, int]:
    """First and one-past-last lattice index between two coordinates, clipped to the lattice."""
    first = int(np.ceil((low - origin) / spacing))
    last = int(np.floor((high - origin) / spacing)) + 1
    return max(first, 0), min(last, count)


@exact
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
