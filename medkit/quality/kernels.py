"""Compiled core: a polytope that grows inside the wrench space where it is nearest to the origin.

The polytope is simplicial. A facet keeps its vertices, its neighbours (slot j lies across from
vertex j), its outward unit normal and its signed distance from the origin. The facet with the
smallest signed distance is asked for the support point in its own direction; the point is added,
the facets that see it are replaced by the cone over their horizon. While the origin is still
outside, that distance is negative and the same step searches for a separating plane, so neither
phase needs a starting simplex around the origin.

A new facet's plane is the positive combination of the two planes that meet in its ridge, so that
no linear system is solved and slivers do no harm; the last facet is measured anew from its
vertices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

CONVERGED, OPEN, FLAT, BUDGET, FAILED, CLOSED = 0, 1, 2, 3, 4, 5
_MIX = np.uint64(0x9E3779B97F4A7C15)


class Facets(NamedTuple):
    """Struct of arrays for facets, with a stack of free rows and a heap of candidates."""

    vertices: np.ndarray  # (F, d) int32
    neighbours: np.ndarray  # (F, d) int32
    normals: np.ndarray  # (F, d)
    offsets: np.ndarray  # (F,) signed distance from the origin
    depths: np.ndarray  # (F,) how far the present point lies beyond
    marks: np.ndarray  # (F,) 2 t visible, 2 t + 1 hidden from point t
    serials: np.ndarray  # (F,) which use of the row this is
    free: np.ndarray  # (F,) stack of rows to use again
    visible: np.ndarray  # (F,) list of facets that see the present point
    heap_keys: np.ndarray  # (H,)
    heap_rows: np.ndarray  # (H,)
    heap_serials: np.ndarray  # (H,)
    table_keys: np.ndarray  # (T,) hash of a ridge
    table_rows: np.ndarray  # (T,)
    table_slots: np.ndarray  # (T,)
    table_marks: np.ndarray  # (T,)
    counts: np.ndarray  # used rows, free rows, heap size, serial


@njit(cache=True)
def new_facets(capacity, d):  # type: ignore[no-untyped-def]
    """Room for `capacity` facets in `d` dimensions."""
    table = 8 * capacity
    return Facets(
        np.empty((capacity, d), np.int32), np.empty((capacity, d), np.int32),
        np.empty((capacity, d)), np.empty(capacity), np.empty(capacity),
        np.zeros(capacity, np.int32), np.zeros(capacity, np.int32),
        np.empty(capacity, np.int32), np.empty(capacity, np.int32),
        np.empty(4 * capacity), np.empty(4 * capacity, np.int32),
        np.empty(4 * capacity, np.int32),
        np.empty(table, np.uint64), np.empty(table, np.int32), np.empty(table, np.int32),
        np.zeros(table, np.int32),
        np.zeros(4, np.int64),
    )  # fmt: skip


@njit(cache=True)
def grown(old, d):  # type: ignore[no-untyped-def]
    """The same facets with twice the room."""
    rows = old.offsets.shape[0]
    new = new_facets(2 * rows, d)
    new.vertices[:rows] = old.vertices
    new.neighbours[:rows] = old.neighbours
    new.normals[:rows] = old.normals
    new.offsets[:rows] = old.offsets
    new.depths[:rows] = old.depths
    new.marks[:rows] = old.marks
    new.serials[:rows] = old.serials
    new.free[:rows] = old.free
    new.visible[:rows] = old.visible
    new.heap_keys[: 4 * rows] = old.heap_keys
    new.heap_rows[: 4 * rows] = old.heap_rows
    new.heap_serials[: 4 * rows] = old.heap_serials
    new.counts[:] = old.counts
    return new


@njit(cache=True)
def _push(facets, row):  # type: ignore[no-untyped-def]
    keys, rows, serials = facets.heap_keys, facets.heap_rows, facets.heap_serials
    key = facets.offsets[row]
    hole = facets.counts[2]
    facets.counts[2] += 1
    while hole > 0:
        parent = (hole - 1) >> 1
        if keys[parent] <= key:
            break
        keys[hole], rows[hole], serials[hole] = keys[parent], rows[parent], serials[parent]
        hole = parent
    keys[hole], rows[hole], serials[hole] = key, row, facets.serials[row]


@njit(cache=True)
def _pop(facets):  # type: ignore[no-untyped-def]
    """Row of the living facet nearest to the origin, or -1 when the heap is empty."""
    keys, rows, serials = facets.heap_keys, facets.heap_rows, facets.heap_serials
    while facets.counts[2] > 0:
        row, serial = rows[0], serials[0]
        facets.counts[2] -= 1
        size = facets.counts[2]
        key, last, mark = keys[size], rows[size], serials[size]
        hole = 0
        while 2 * hole + 1 < size:
            child = 2 * hole + 1
            if child + 1 < size and keys[child + 1] < keys[child]:
                child += 1
            if keys[child] >= key:
                break
            keys[hole], rows[hole], serials[hole] = keys[child], rows[child], serials[child]
            hole = child
        keys[hole], rows[hole], serials[hole] = key, last, mark
        if facets.serials[row] == serial:
            return row
    return -1


@njit(cache=True)
def _add_contact(centers, axes, profile, i, along, shadow, out):  # type: ignore[no-untyped-def]
    """Add contact i's wrench of largest component to `out`, from its shadow on the direction."""
    d, k = centers.shape[1], axes.shape[1]
    for a in range(d):
        out[a] += centers[i, a]
    if profile.shape[0] == 0:
        length = 0.0
        for j in range(k):
            length += shadow[j] * shadow[j]
        length = np.sqrt(length)
        for j in range(k):
            weight = shadow[j] / length if length > 0.0 else 0.0
            for a in range(d):
                out[a] += weight * axes[i, j, a]
        return
    best, chosen = -np.inf, 0
    for z in range(profile.shape[0]):
        value = 0.0
        for j in range(k):
            value += profile[z, j] * shadow[j]
        if value > best:
            best, chosen = value, z
    for j in range(k):
        for a in range(d):
            out[a] += profile[chosen, j] * axes[i, j, a]


@njit(cache=True)
def _shadow(centers, axes, i, u, shadow):  # type: ignore[no-untyped-def]
    """Contact i along `u`: the centre's component, and its axes' components into `shadow`."""
    d = centers.shape[1]
    along = 0.0
    for a in range(d):
        along += centers[i, a] * u[a]
    for j in range(axes.shape[1]):
        value = 0.0
        for a in range(d):
            value += axes[i, j, a] * u[a]
        shadow[j] = value
    return along


@njit(cache=True)
def _reach(profile, along, shadow, least):  # type: ignore[no-untyped-def]
    """Largest component of a contact, or less than `least` when it cannot exceed `least`."""
    k = shadow.shape[0]
    square = 0.0
    for j in range(k):
        square += shadow[j] * shadow[j]
    gap = least - along
    if gap > 0.0 and square < gap * gap:
        return -np.inf
    if profile.shape[0] == 0:
        return along + np.sqrt(square)
    best = -np.inf
    for z in range(profile.shape[0]):
        value = 0.0
        for j in range(k):
            value += profile[z, j] * shadow[j]
        best = max(best, value)
    return along + best


@njit(cache=True)
def support(centers, axes, profile, total, u, shadow, out):  # type: ignore[no-untyped-def]
    """Furthest point of the wrench space along `u` into `out`; returns its component.

    The union of contacts (``total`` False) takes the best contact; the sum takes every contact
    that helps at all, each at full normal force.
    """
    d = centers.shape[1]
    out[:] = 0.0
    best, chosen = -np.inf, 0
    for i in range(centers.shape[0]):
        along = _shadow(centers, axes, i, u, shadow)
        value = _reach(profile, along, shadow, 0.0 if total else best)
        if total and value > 0.0:
            _add_contact(centers, axes, profile, i, along, shadow, out)
        elif value > best:
            best, chosen = value, i
    if not total:
        along = _shadow(centers, axes, chosen, u, shadow)
        _add_contact(centers, axes, profile, chosen, along, shadow, out)
    height = 0.0
    for a in range(d):
        height += u[a] * out[a]
    return height


@njit(cache=True)
def _orthogonal(vector, basis, count):  # type: ignore[no-untyped-def]
    """Take from `vector` its parts along `count` unit rows, twice for safety; return its length."""
    for _ in range(2):
        for row in range(count):
            part = np.dot(vector, basis[row])
            vector -= part * basis[row]
    return np.sqrt(np.dot(vector, vector))


@njit(cache=True)
def _widest(centers, axes, profile, total, basis, count, start, u, shadow, out):  # type: ignore[no-untyped-def]
    """Search the directions not yet spanned for the furthest point; returns its distance."""
    d = centers.shape[1]
    rest = basis.copy()
    trial = np.empty(d)
    best, found = 0.0, count
    for axis in range(d):
        u[:] = 0.0
        u[axis] = 1.0
        length = _orthogonal(u, rest, found)
        if length < 0.1 / d or found == d:
            continue
        u /= length
        rest[found] = u
        found += 1
        for sign in (1.0, -1.0):
            u *= sign
            away = support(centers, axes, profile, total, u, shadow, trial) - np.dot(u, start)
            if away > best:
                best = away
                out[:] = trial
    return best


@njit(cache=True)
def start_simplex(centers, axes, profile, total, tolerance, points, shadow):  # type: ignore[no-untyped-def]
    """Fill the first d + 1 rows of `points`, each step towards the origin; a status."""
    d = centers.shape[1]
    basis = np.zeros((d, d))
    u, edge = np.empty(d), np.empty(d)
    for a in range(d):
        u[a] = -np.mean(centers[:, a])
    length = np.sqrt(np.dot(u, u))
    if length <= tolerance:
        u[:] = 0.0
        u[0] = length = 1.0
    u /= length
    if support(centers, axes, profile, total, u, shadow, points[0]) <= tolerance:
        return OPEN
    for k in range(d):
        u[:] = -points[0]
        length = _orthogonal(u, basis, k)
        away = 0.0
        if length > 1e-3:
            u /= length
            height = support(centers, axes, profile, total, u, shadow, points[k + 1])
            if height <= tolerance:
                return OPEN
            away = height + length
        if away <= 1e-3:
            away = _widest(
                centers, axes, profile, total, basis, k, points[0], u, shadow, points[k + 1]
            )
        if away <= tolerance:
            return FLAT
        edge[:] = points[k + 1] - points[0]
        basis[k] = edge / _orthogonal(edge, basis, k)
    return CONVERGED


@njit(cache=True)
def first_facets(facets, points):  # type: ignore[no-untyped-def]
    """The d + 1 facets of the start simplex; facet i leaves out vertex i."""
    d = points.shape[1]
    system = np.ones((d + 1, d + 1))
    system[:, :d] = points[: d + 1]
    weights = np.linalg.inv(system)  # column i: the barycentric coordinate of vertex i
    for i in range(d + 1):
        gradient = weights[:d, i]
        length = np.sqrt(np.sum(gradient * gradient))
        facets.normals[i] = -gradient / length
        facets.offsets[i] = weights[d, i] / length
        slot = 0
        for v in range(d + 1):
            if v != i:
                facets.vertices[i, slot] = v
                facets.neighbours[i, slot] = v
                slot += 1
        facets.marks[i] = 0
        facets.serials[i] = i
        _push(facets, i)
    facets.counts[0] = d + 1
    facets.counts[3] = d + 1


@njit(cache=True)
def _depth(facets, row, point):  # type: ignore[no-untyped-def]
    value = -facets.offsets[row]
    for a in range(point.shape[0]):
        value += facets.normals[row, a] * point[a]
    facets.depths[row] = value
    return value


@njit(cache=True)
def find_visible(facets, start, point, turn, tolerance):  # type: ignore[no-untyped-def]
    """List the facets that `point` lies beyond, spreading from `start`; how many there are."""
    facets.visible[0] = start
    facets.marks[start] = 2 * turn
    _depth(facets, start, point)
    seen, done = 1, 0
    while done < seen:
        row = facets.visible[done]
        done += 1
        for j in range(point.shape[0]):
            other = facets.neighbours[row, j]
            if facets.marks[other] >= 2 * turn:
                continue
            if _depth(facets, other, point) > tolerance:
                facets.marks[other] = 2 * turn
                facets.visible[seen] = other
                seen += 1
            else:
                facets.marks[other] = 2 * turn + 1
    return seen


@njit(cache=True)
def _mixed(vertex):  # type: ignore[no-untyped-def]
    x = (np.uint64(vertex) + np.uint64(1)) * _MIX
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True)
def _link(facets, row, slot, key, turn):  # type: ignore[no-untyped-def]
    """Meet the other new facet with this ridge, or wait for it; +1 waiting, -1 met, 0 broken."""
    mask = facets.table_marks.shape[0] - 1
    place = np.int64(key & np.uint64(mask))
    while facets.table_marks[place] == turn:
        if facets.table_keys[place] == key:
            other, across = facets.table_rows[place], facets.table_slots[place]
            if across < 0:
                return 0
            facets.neighbours[row, slot] = other
            facets.neighbours[other, across] = row
            facets.table_slots[place] = -1
            return -1
        place = (place + 1) & mask
    facets.table_marks[place] = turn
    facets.table_keys[place] = key
    facets.table_rows[place] = row
    facets.table_slots[place] = slot
    return 1


@njit(cache=True)
def _new_row(facets):  # type: ignore[no-untyped-def]
    counts = facets.counts
    if counts[1] > 0:
        counts[1] -= 1
        row = facets.free[counts[1]]
    else:
        row = counts[0]
        counts[0] += 1
    facets.marks[row] = 0
    facets.serials[row] = counts[3]
    counts[3] += 1
    return np.int64(row)


@njit(cache=True)
def _cap(facets, below, slot, beyond, vertex):  # type: ignore[no-untyped-def]
    """New facet over the ridge between visible `below` and hidden `beyond`; its row."""
    d = facets.vertices.shape[1]
    row = _new_row(facets)
    rise = facets.depths[below]
    fall = max(-facets.depths[beyond], 0.0)
    length = 0.0
    for a in range(d):
        facets.vertices[row, a] = facets.vertices[below, a]
        value = rise * facets.normals[beyond, a] + fall * facets.normals[below, a]
        facets.normals[row, a] = value
        length += value * value
        if facets.neighbours[beyond, a] == below:
            facets.neighbours[beyond, a] = row
    length = np.sqrt(length)
    for a in range(d):
        facets.normals[row, a] /= length
    facets.offsets[row] = (rise * facets.offsets[beyond] + fall * facets.offsets[below]) / length
    facets.vertices[row, slot] = vertex
    facets.neighbours[row, slot] = beyond
    return row


@njit(cache=True)
def attach(facets, seen, vertex, turn, bound):  # type: ignore[no-untyped-def]
    """Replace the visible facets by the cone over their horizon; False when it does not close."""
    d = facets.vertices.shape[1]
    waiting = 0
    for index in range(seen):
        below = facets.visible[index]
        for slot in range(d):
            beyond = facets.neighbours[below, slot]
            if facets.marks[beyond] != 2 * turn + 1:
                continue
            row = _cap(facets, below, slot, beyond, vertex)
            if facets.offsets[row] < bound:
                _push(facets, row)
            whole = np.uint64(0)
            for a in range(d):
                whole += _mixed(facets.vertices[row, a])
            for a in range(d):
                if a != slot:
                    change = _link(facets, row, a, whole - _mixed(facets.vertices[row, a]), turn)
                    if change == 0:
                        return False
                    waiting += change
    for index in range(seen):
        row = facets.visible[index]
        facets.serials[row] = -1
        facets.free[facets.counts[1]] = row
        facets.counts[1] += 1
    return waiting == 0


@njit(cache=True)
def _measured(facets, row, points, u):  # type: ignore[no-untyped-def]
    """Plane of a facet anew from its vertices: unit normal into `u`, returns the distance."""
    d = points.shape[1]
    basis = np.zeros((d, d))
    edge = np.empty(d)
    corner = points[facets.vertices[row, 0]]
    count = 0
    for j in range(1, d):
        edge[:] = points[facets.vertices[row, j]] - corner
        before = np.sqrt(np.dot(edge, edge))
        length = _orthogonal(edge, basis, count)
        if length > 1e-6 * before:
            basis[count] = edge / length
            count += 1
    u[:] = facets.normals[row]
    u /= _orthogonal(u, basis, count)
    lowest = np.inf
    for j in range(d):
        lowest = min(lowest, np.dot(points[facets.vertices[row, j]], u))
    return lowest


@njit(cache=True)
def expand(centers, axes, profile, total, tolerance, gap, closure_only, budget, weakest):  # type: ignore[no-untyped-def]
    """Grow the polytope until the nearest facet is one of the wrench space.

    Returns a status, the lower and the upper bound of the signed distance, and the number of
    points added; the direction of the upper bound goes into `weakest`.
    """
    d = centers.shape[1]
    points = np.empty((64, d))
    shadow, u = np.empty(axes.shape[1]), np.empty(d)
    status = start_simplex(centers, axes, profile, total, tolerance, points, shadow)
    if status != CONVERGED:
        return status, 0.0, 0.0, 0
    facets = new_facets(512, d)
    first_facets(facets, points)
    upper = np.inf
    for turn in range(1, budget + 1):
        row = _pop(facets)
        if row < 0 or facets.offsets[row] >= upper - gap:
            return CONVERGED, upper if row < 0 else min(upper, facets.offsets[row]), upper, turn
        lower = facets.offsets[row]
        if closure_only and lower > tolerance:
            return CLOSED, lower, upper, turn
        vertex = d + turn
        if vertex == points.shape[0]:
            points = np.concatenate((points, np.empty_like(points)))
        height = support(centers, axes, profile, total, facets.normals[row], shadow, points[vertex])
        if height < upper:
            upper = height
            weakest[:] = facets.normals[row]
        if upper <= tolerance:
            return OPEN, lower, upper, turn
        if height - lower <= gap:
            lower = _measured(facets, row, points, u)
            upper = min(upper, support(centers, axes, profile, total, u, shadow, points[vertex]))
            return CONVERGED, min(lower, upper), upper, turn
        seen = find_visible(facets, row, points[vertex], turn, tolerance)
        room = facets.offsets.shape[0]
        while facets.counts[0] + seen * d > room or facets.counts[2] + seen * d > 4 * room:
            facets = grown(facets, d)
            room = facets.offsets.shape[0]
        if not attach(facets, seen, vertex, turn, upper):
            return FAILED, lower, upper, turn
    return BUDGET, lower, upper, budget
