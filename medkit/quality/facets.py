"""Compiled bookkeeping of a simplicial polytope: heap of facets, visible cap, new facets.

A new facet's plane is the positive combination of the two planes that meet in its ridge, so that
no linear system is solved and slivers do no harm. New facets find their neighbours by walking
around the face they share, through the visible facets. The dimension is the length of a tuple,
which the compiler knows, so that it can unroll the short loops.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit


class Workspace(NamedTuple):
    """Room for facets, their heap and the lists of one expansion.

    With d the dimension, a row of `facets` holds d vertices, d neighbours, the mark of the last
    point it was held against (2 t visible, 2 t + 1 hidden) and a serial number. A row of `planes`
    holds the unit normal, the distance from the origin and the depth of the present point.
    `lists` holds the stack of free rows, the visible rows, and the horizon: visible row and slot
    of every ridge with a hidden neighbour. `counts` holds the rows in use, the free rows, the
    heap's size and the serial.
    """

    axes: tuple[int, ...]  # 0 to d - 1
    facets: np.ndarray  # (F, 2 d + 2) int32
    planes: np.ndarray  # (F, d + 2) float64
    lists: np.ndarray  # (4, F) int32
    heap: np.ndarray  # (H, 2) int32: row, serial
    keys: np.ndarray  # (H,) float64
    points: np.ndarray  # (P, d) float64
    counts: np.ndarray  # (4,) int64


FREE, SEEN, BELOW, SLOT = 0, 1, 2, 3


def workspace(dimension: int, capacity: int) -> Workspace:
    """Room for `capacity` facets, a power of two, and a sixteenth as many points."""
    return Workspace(
        tuple(range(dimension)),
        np.empty((capacity, 2 * dimension + 2), np.int32),
        np.empty((capacity, dimension + 2)),
        np.empty((4, capacity), np.int32),
        np.empty((2 * capacity, 2), np.int32),
        np.empty(2 * capacity),
        np.empty((capacity // 16, dimension)),
        np.zeros(4, np.int64),
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
    serial_column = 2 * len(work.axes) + 1
    while work.counts[2] > 0:
        row, serial = np.int64(work.heap[0, 0]), work.heap[0, 1]
        work.counts[2] -= 1
        _drop_first(work.keys, work.heap, work.counts[2])
        if work.facets[row, serial_column] == serial:
            return row
    return -1


@njit(cache=True, error_model="numpy")
def _depth(axes, planes, row, points, vertex):  # type: ignore[no-untyped-def]
    """How far a point lies beyond a facet's plane."""
    d = len(axes)
    value = -planes[row, d]
    for a in range(d):
        value += planes[row, a] * points[vertex, a]
    planes[row, d + 1] = value
    return value


@njit(cache=True, error_model="numpy")
def find_visible(work, start, vertex, turn, tolerance):  # type: ignore[no-untyped-def]
    """List the facets that a point lies beyond, spreading from `start`, and their horizon.

    Returns how many facets and how many ridges.
    """
    d = len(work.axes)
    facets, planes, lists = work.facets, work.planes, work.lists
    lists[SEEN, 0] = start
    facets[start, 2 * d] = 2 * turn
    _depth(work.axes, planes, start, work.points, vertex)
    seen, done, ridges = 1, 0, 0
    while done < seen:
        row = lists[SEEN, done]
        done += 1
        for j in range(d):
            other = facets[row, d + j]
            mark = facets[other, 2 * d]
            if mark == 2 * turn:
                continue
            if mark < 2 * turn:
                if _depth(work.axes, planes, other, work.points, vertex) > tolerance:
                    facets[other, 2 * d] = 2 * turn
                    lists[SEEN, seen] = other
                    seen += 1
                    continue
                facets[other, 2 * d] = 2 * turn + 1
            if ridges < lists.shape[1]:
                lists[BELOW, ridges], lists[SLOT, ridges] = row, j
            ridges += 1
    return seen, ridges


@njit(cache=True, error_model="numpy")
def _slot_of(facets, row, first, count, value):  # type: ignore[no-untyped-def]
    """Which of a row's `count` entries from `first` on is `value`."""
    found = 0
    for a in range(count):
        if facets[row, first + a] == value:
            found = a
    return found


@njit(cache=True, error_model="numpy")
def _join(axes, facets, row, below, slot, across, limit):  # type: ignore[no-untyped-def]
    """Join a new facet to the one across from its vertex in slot `across`; False when lost.

    Both stand on the horizon, and both hold the d - 2 vertices that `below` has besides those
    in its slots `slot` and `across`: turn about these, from visible facet to visible facet,
    until the horizon is met again.
    """
    d = len(axes)
    here, out, kept = below, across, slot
    for _ in range(limit):
        there = np.int64(facets[here, d + out])
        if there < 0:
            facets[row, d + across] = -1 - there
            facets[-1 - there, d + kept] = row
            return True
        out = _slot_of(facets, there, 0, d, facets[here, kept])
        kept = _slot_of(facets, there, d, d, here)
        here = there
    return False


@njit(cache=True, error_model="numpy")
def _cap(axes, facets, planes, row, below, slot, beyond, vertex):  # type: ignore[no-untyped-def]
    """Write the facet over the ridge between visible `below` and hidden `beyond`."""
    d = len(axes)
    rise, fall = planes[below, d + 1], max(-planes[beyond, d + 1], 0.0)
    square = 0.0
    for a in range(d + 1):
        planes[row, a] = rise * planes[beyond, a] + fall * planes[below, a]
        if a < d:
            square += planes[row, a] * planes[row, a]
    shrink = 1.0 / np.sqrt(square)
    for a in range(d + 1):
        planes[row, a] *= shrink
    for a in range(d):
        facets[row, a] = facets[below, a]
        facets[row, d + a] = -1  # nobody yet
        if facets[beyond, d + a] == below:
            facets[beyond, d + a] = row
    facets[row, slot] = vertex
    facets[row, d + slot] = beyond
    facets[row, 2 * d] = -1


@njit(cache=True, error_model="numpy")
def _take_row(counts, lists):  # type: ignore[no-untyped-def]
    """A row that is free."""
    if counts[1] > 0:
        counts[1] -= 1
        return np.int64(lists[FREE, counts[1]])
    counts[0] += 1
    return counts[0] - 1


@njit(cache=True, error_model="numpy")
def attach(work, seen, horizon, vertex, bound):  # type: ignore[no-untyped-def]
    """Replace the visible facets by the cone over their horizon; False when it does not close."""
    d = len(work.axes)
    facets, planes, counts, lists = work.facets, work.planes, work.counts, work.lists
    for index in range(horizon):
        below, slot = np.int64(lists[BELOW, index]), np.int64(lists[SLOT, index])
        row, beyond = _take_row(counts, lists), np.int64(facets[below, d + slot])
        _cap(work.axes, facets, planes, row, below, slot, beyond, vertex)
        facets[row, 2 * d + 1] = counts[3]
        facets[below, d + slot] = -1 - row  # the sign by which `_join` knows the horizon
        if planes[row, d] < bound:
            push(work.keys, work.heap, counts[2], planes[row, d], row, counts[3])
            counts[2] += 1
        counts[3] += 1
    for index in range(horizon):
        below, slot = np.int64(lists[BELOW, index]), np.int64(lists[SLOT, index])
        row = -1 - np.int64(facets[below, d + slot])
        for a in range(d):
            if facets[row, d + a] < 0 and not _join(
                work.axes, facets, row, below, slot, a, seen + 1
            ):
                return False
    for index in range(seen):
        row = np.int64(lists[SEEN, index])
        facets[row, 2 * d + 1] = -1
        lists[FREE, counts[1]] = row
        counts[1] += 1
    return True
