"""Compiled bookkeeping of a simplicial polytope: heap of facets, visible cap, new facets.

A new facet's plane is the positive combination of the two planes that meet in its ridge, so that
no linear system is solved and slivers do no harm. New facets find their neighbours by the sum of
their ridges' vertex hashes. Plain loops and few arrays keep the compilation short.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit


class Workspace(NamedTuple):
    """Room for facets, their heap and the table in which new ridges meet.

    With d the dimension, a row of `facets` holds d vertices, d neighbours, the mark of the last
    point it was held against (2 t visible, 2 t + 1 hidden) and a serial number; then, unrelated
    to the row's facet, an entry of the stack of free rows and one of the list of visible rows.
    A row of `planes` holds the unit normal, the distance from the origin and the depth of the
    present point. `counts` holds the rows in use, the free rows, the heap's size, the serial
    and how often ridges were joined.
    """

    facets: np.ndarray  # (F, 2 d + 4) int64
    planes: np.ndarray  # (F, d + 2) float64
    heap: np.ndarray  # (H, 2) int64: row, serial
    keys: np.ndarray  # (H,) float64
    ridges: np.ndarray  # (T, 4) int64: key, row, slot, mark; T a power of two
    points: np.ndarray  # (P, d) float64
    counts: np.ndarray  # (5,) int64


def workspace(dimension: int, capacity: int) -> Workspace:
    """Room for `capacity` facets, a power of two, and a sixteenth as many points."""
    return Workspace(
        np.empty((capacity, 2 * dimension + 4), np.int64),
        np.empty((capacity, dimension + 2)),
        np.empty((2 * capacity, 2), np.int64),
        np.empty(2 * capacity),
        np.zeros((4 * capacity, 4), np.int64),
        np.empty((capacity // 16, dimension)),
        np.zeros(5, np.int64),
    )


@njit(cache=True, error_model="numpy")
def push(keys, heap, size, key, row, serial):  # type: ignore[no-untyped-def]
    """Put a facet on the heap of `size` entries."""
    hole = size
    while hole > 0:
        parent = (hole - 1) >> 1
        if keys[parent] <= key:
            break
        keys[hole] = keys[parent]
        heap[hole, 0], heap[hole, 1] = heap[parent, 0], heap[parent, 1]
        hole = parent
    keys[hole] = key
    heap[hole, 0], heap[hole, 1] = row, serial


@njit(cache=True, error_model="numpy")
def _drop_first(keys, heap, size):  # type: ignore[no-untyped-def]
    """Remove the first of `size` + 1 entries."""
    key, row, serial = keys[size], heap[size, 0], heap[size, 1]
    hole = 0
    while 2 * hole + 1 < size:
        child = 2 * hole + 1
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[hole] = keys[child]
        heap[hole, 0], heap[hole, 1] = heap[child, 0], heap[child, 1]
        hole = child
    keys[hole] = key
    heap[hole, 0], heap[hole, 1] = row, serial


@njit(cache=True, error_model="numpy")
def nearest(work):  # type: ignore[no-untyped-def]
    """Take the living facet nearest to the origin from the heap; -1 when there is none."""
    serial_column = 2 * work.points.shape[1] + 1
    while work.counts[2] > 0:
        row, serial = work.heap[0, 0], work.heap[0, 1]
        work.counts[2] -= 1
        _drop_first(work.keys, work.heap, work.counts[2])
        if work.facets[row, serial_column] == serial:
            return row
    return -1


@njit(cache=True, error_model="numpy")
def _depth(planes, row, points, vertex):  # type: ignore[no-untyped-def]
    """How far a point lies beyond a facet's plane."""
    d = points.shape[1]
    value = -planes[row, d]
    for a in range(d):
        value += planes[row, a] * points[vertex, a]
    planes[row, d + 1] = value
    return value


@njit(cache=True, error_model="numpy")
def find_visible(work, start, vertex, turn, tolerance):  # type: ignore[no-untyped-def]
    """List the facets that a point lies beyond, spreading from `start`; how many there are."""
    d = work.points.shape[1]
    facets, planes = work.facets, work.planes
    mark, listed = 2 * d, 2 * d + 3
    facets[0, listed] = start
    facets[start, mark] = 2 * turn
    _depth(planes, start, work.points, vertex)
    seen, done = 1, 0
    while done < seen:
        row = facets[done, listed]
        done += 1
        for j in range(d, 2 * d):
            other = facets[row, j]
            if facets[other, mark] >= 2 * turn:
                continue
            if _depth(planes, other, work.points, vertex) > tolerance:
                facets[other, mark] = 2 * turn
                facets[seen, listed] = other
                seen += 1
            else:
                facets[other, mark] = 2 * turn + 1
    return seen


@njit(cache=True, error_model="numpy")
def _mixed(vertex):  # type: ignore[no-untyped-def]
    """Spread a vertex number over 63 bits, so that sums of them name sets of vertices."""
    x = (vertex + 1) * 6364136223846793005
    x = (x ^ (x >> 31)) * 3935559000370003845
    return x ^ (x >> 29)


@njit(cache=True, error_model="numpy")
def _meet(facets, ridges, row, slot, key, stamp):  # type: ignore[no-untyped-def]
    """Join the new facet that waits at this ridge, or wait; -1 joined, 1 waiting, 0 broken."""
    d = (facets.shape[1] - 4) >> 1
    mask = ridges.shape[0] - 1
    place = key & mask
    while ridges[place, 3] == stamp:
        if ridges[place, 0] == key:
            other, across = ridges[place, 1], ridges[place, 2]
            if across < 0:
                return 0
            facets[row, d + slot] = other
            facets[other, d + across] = row
            ridges[place, 2] = -1
            return -1
        place = (place + 1) & mask
    ridges[place, 0], ridges[place, 1], ridges[place, 2], ridges[place, 3] = key, row, slot, stamp
    return 1


@njit(cache=True, error_model="numpy")
def _cap(facets, planes, row, below, slot, beyond, vertex):  # type: ignore[no-untyped-def]
    """Write the facet over the ridge between visible `below` and hidden `beyond`; its hash."""
    d = planes.shape[1] - 2
    rise, fall = planes[below, d + 1], max(-planes[beyond, d + 1], 0.0)
    square = 0.0
    for a in range(d + 1):
        planes[row, a] = rise * planes[beyond, a] + fall * planes[below, a]
        if a < d:
            square += planes[row, a] * planes[row, a]
    length = np.sqrt(square)
    for a in range(d + 1):
        planes[row, a] /= length
    total = 0
    for a in range(d):
        facets[row, a] = vertex if a == slot else facets[below, a]
        total += _mixed(facets[row, a])
        if facets[beyond, d + a] == below:
            facets[beyond, d + a] = row
    facets[row, d + slot] = beyond
    return total


@njit(cache=True, error_model="numpy")
def attach(work, seen, vertex, turn, bound):  # type: ignore[no-untyped-def]
    """Replace the visible facets by the cone over their horizon; False when it does not close."""
    d = work.points.shape[1]
    facets, planes, counts = work.facets, work.planes, work.counts
    counts[4] += 1  # never starts again, as the table outlives a grasp
    waiting = 0
    for index in range(seen):
        below = facets[index, 2 * d + 3]
        for slot in range(d):
            beyond = facets[below, d + slot]
            if facets[beyond, 2 * d] != 2 * turn + 1:
                continue
            if counts[1] > 0:
                counts[1] -= 1
                row = facets[counts[1], 2 * d + 2]
            else:
                row = counts[0]
                counts[0] += 1
            total = _cap(facets, planes, row, below, slot, beyond, vertex)
            facets[row, 2 * d] = -1
            facets[row, 2 * d + 1] = counts[3]
            if planes[row, d] < bound:
                push(work.keys, work.heap, counts[2], planes[row, d], row, counts[3])
                counts[2] += 1
            counts[3] += 1
            for a in range(d):
                if a != slot:
                    key = total - _mixed(facets[row, a])
                    joined = _meet(facets, work.ridges, row, a, key, counts[4])
                    if joined == 0:
                        return False
                    waiting += joined
    for index in range(seen):
        row = facets[index, 2 * d + 3]
        facets[row, 2 * d + 1] = -1
        facets[counts[1], 2 * d + 2] = row
        counts[1] += 1
    return waiting == 0
