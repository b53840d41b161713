"""Compiled core: a polytope that grows inside the wrench space where it is nearest to the origin.

The polytope is simplicial. A facet keeps its vertices, its neighbours (slot j lies across from
vertex j), its outward unit normal and its signed distance from the origin. The facet with the
smallest signed distance is asked for the support point in its own direction; the point is added,
the facets that see it are replaced by the cone over their horizon. While the origin is still
outside, that distance is negative and the same step searches for a separating plane, so neither
phase needs a starting simplex around the origin.
The last facet is measured anew from its vertices.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from medkit.quality.facets import Workspace, attach, find_visible, nearest, push, workspace
from medkit.quality.reach import support

__all__ = ["Workspace", "expand", "workspace"]

CONVERGED, OPEN, FLAT, BUDGET, FAILED, CLOSED, FULL = 0, 1, 2, 3, 4, 5, 6


@njit(cache=True, error_model="numpy")
def _strip(vector, basis, count):  # type: ignore[no-untyped-def]
    """Take from `vector` its parts along `count` unit rows and make it a unit; the length left."""
    for _ in range(2):
        for row in range(count):
            part = 0.0
            for a in range(vector.shape[0]):
                part += vector[a] * basis[row, a]
            for a in range(vector.shape[0]):
                vector[a] -= part * basis[row, a]
    square = 0.0
    for a in range(vector.shape[0]):
        square += vector[a] * vector[a]
    length = np.sqrt(square)
    if length > 0.0:
        for a in range(vector.shape[0]):
            vector[a] /= length
    return length


@njit(cache=True, error_model="numpy")
def _widest(centers, axes, profile, total, points, k, basis, u, shadow):  # type: ignore[no-untyped-def]
    """Search all directions not yet spanned for the furthest point k + 1; its distance."""
    d = u.shape[0]
    best, found, spare = 0.0, k, k + 2
    for axis in range(d):
        for a in range(d):
            u[a] = 0.0
        u[axis] = 1.0
        if found == d or _strip(u, basis, found) < 0.1 / d:
            continue
        for a in range(d):
            basis[found, a] = u[a]
        found += 1
        for sign in (1.0, -1.0):
            away = 0.0
            for a in range(d):
                u[a] = sign * basis[found - 1, a]
                away -= u[a] * points[0, a]
            away += support(centers, axes, profile, total, u, shadow, points, spare)
            if away > best:
                best = away
                for a in range(d):
                    points[k + 1, a] = points[spare, a]
    return best


@njit(cache=True, error_model="numpy")
def _start(centers, axes, profile, total, tolerance, points, basis, u, shadow):  # type: ignore[no-untyped-def]
    """Fill d + 1 rows of `points`, each step towards the origin; a status."""
    d = u.shape[0]
    none = np.int64(0)  # a bare 0 would be compiled as a type of its own
    for a in range(d):
        u[a] = 0.0
        for i in range(centers.shape[0]):
            u[a] -= centers[i, a]
    if _strip(u, basis, none) <= tolerance:  # balanced contacts leave only rounding: any direction
        for a in range(d):
            u[a] = 1.0 if a == 0 else 0.0
    if support(centers, axes, profile, total, u, shadow, points, none) <= tolerance:
        return OPEN
    for k in range(d):
        for a in range(d):
            u[a] = -points[0, a]
        away = _strip(u, basis, k)
        if away > 1e-3:
            height = support(centers, axes, profile, total, u, shadow, points, k + 1)
            if height <= tolerance:
                return OPEN
            away += height
        if away <= 1e-3:
            away = _widest(centers, axes, profile, total, points, k, basis, u, shadow)
        if away <= tolerance:
            return FLAT
        for a in range(d):
            u[a] = points[k + 1, a] - points[0, a]
        _strip(u, basis, k)
        for a in range(d):
            basis[k, a] = u[a]
    return CONVERGED


@njit(cache=True, error_model="numpy")
def _measure(work, row, least, basis, edge, u):  # type: ignore[no-untyped-def]
    """Make `u` the unit normal of a facet by its vertices; returns the plane's distance.

    Edges that stick out of the others' span by less than the share `least` are left out.
    """
    d = u.shape[0]
    points, facets = work.points, work.facets
    corner, count = facets[row, 0], 0
    for j in range(1, d):
        length = 0.0
        for a in range(d):
            edge[a] = points[facets[row, j], a] - points[corner, a]
            length += edge[a] * edge[a]
        if _strip(edge, basis, count) > least * np.sqrt(length):
            for a in range(d):
                basis[count, a] = edge[a]
            count += 1
    _strip(u, basis, count)
    lowest = np.inf
    for j in range(d):
        height = 0.0
        for a in range(d):
            height += points[facets[row, j], a] * u[a]
        lowest = min(lowest, height)
    return lowest


@njit(cache=True, error_model="numpy")
def _first_facets(work, basis, edge, u):  # type: ignore[no-untyped-def]
    """The d + 1 facets of the start simplex; facet i leaves out vertex i."""
    d = u.shape[0]
    work.counts[2] = 0
    for i in range(d + 1):
        slot = 0
        for v in range(d + 1):
            if v != i:
                work.facets[i, slot] = work.facets[i, d + slot] = v
                slot += 1
        for a in range(d):
            u[a] = work.points[work.facets[i, 0], a] - work.points[i, a]
        work.planes[i, d] = _measure(work, i, 1e-13, basis, edge, u)
        for a in range(d):
            work.planes[i, a] = u[a]
        work.facets[i, 2 * d] = -1
        work.facets[i, 2 * d + 1] = i
        push(work.keys, work.heap, i, work.planes[i, d], i, i)
    work.counts[0] = work.counts[2] = work.counts[3] = d + 1
    work.counts[1] = 0


@njit(cache=True, error_model="numpy")
def _grow(  # type: ignore[no-untyped-def]
    centers,
    axes,
    profile,
    total,
    tolerance,
    gap,
    sight,
    closure_only,
    work,
    basis,
    edge,
    u,
    shadow,
    best,
):
    """Expand one grasp's polytope; a status, both bounds, and the points added."""
    d = len(work.axes)
    points, facets, planes, counts = work.points, work.facets, work.planes, work.counts
    status = _start(centers, axes, profile, total, tolerance, points, basis, u, shadow)
    if status != CONVERGED:
        for a in range(d):
            best[a] = u[a] if status == OPEN else 0.0
        return status, 0.0, 0.0, 0
    _first_facets(work, basis, edge, u)
    lower, upper = -np.inf, np.inf
    turn = 0
    while True:
        turn += 1
        row = nearest(work)
        if row < 0:
            return CONVERGED, upper, upper, turn - 1
        lower = planes[row, d]
        meet = gap if lower > tolerance else sight  # whether there is a ball is settled strictly
        if lower >= upper - meet:
            return CONVERGED, min(upper, lower), upper, turn - 1
        if closure_only and lower > tolerance:
            return CLOSED, lower, upper, turn - 1
        vertex = d + turn
        if vertex >= points.shape[0] - 1:
            return FULL, lower, upper, turn - 1
        for a in range(d):
            u[a] = planes[row, a]
        height = support(centers, axes, profile, total, u, shadow, points, vertex)
        if height - lower <= meet and height > tolerance:
            lower = _measure(work, row, 1e-6, basis, edge, u)
            height = support(centers, axes, profile, total, u, shadow, points, vertex)
        if height < upper:
            upper = height
            for a in range(d):
                best[a] = u[a]
        if upper <= tolerance:
            return OPEN, 0.0, 0.0, turn
        if height - lower <= meet:
            return CONVERGED, min(lower, upper), upper, turn
        seen, horizon = find_visible(work, row, vertex, turn, sight)
        if (
            counts[0] + max(0, horizon - counts[1]) > facets.shape[0]
            or counts[2] + horizon > work.keys.shape[0]
        ):
            return FULL, lower, upper, turn
        if not attach(work, seen, horizon, vertex, upper):
            return FAILED, lower, upper, turn


@njit(cache=True, error_model="numpy")
def _unit(centers, axes):  # type: ignore[no-untyped-def]
    """Length of the longest wrench or a little less: the root mean square over an ellipse's rim."""
    longest = 0.0
    for i in range(centers.shape[0]):
        square = 0.0
        for a in range(centers.shape[1]):
            square += centers[i, a] ** 2
            for j in range(axes.shape[1]):
                square += axes[i, j, a] ** 2 / axes.shape[1]
        longest = max(longest, square)
    return np.sqrt(longest)


@njit(cache=True, error_model="numpy")
def expand(centers, axes, profile, total, tolerance, gap, sight, closure_only, work, weakest):  # type: ignore[no-untyped-def]
    """Expand the polytope of one grasp: status, lower bound, upper bound, points added.

    `tolerance`, `gap` and `sight` (how far a point must lie beyond a facet to see it) count in
    units of the longest wrench. The direction of the upper bound is written into `weakest`.
    """
    d, k = centers.shape[1], axes.shape[1]
    if centers.shape[0] == 0:
        return FLAT, 0.0, 0.0, 0
    basis, edge, u, shadow = np.zeros((d, d)), np.empty(d), np.empty(d), np.empty(k)
    unit = _unit(centers, axes)
    return _grow(
        centers, axes, profile, total, tolerance * unit, gap * unit, sight * unit,
        closure_only, work, basis, edge, u, shadow, weakest,
    )  # fmt: skip
