"""Compiled bookkeeping of a simplicial polytope: heap of facets, visible cap, new facets.

A new facet's plane is the positive combination of the two planes that meet in its ridge, so that
no linear system is solved and slivers do no harm. New facets find their neighbours by the sum of
their ridges' vertex codes. The dimension is the length of a tuple, which the compiler knows: it
then unrolls the short loops, and the whole takes half the time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit


class Workspace(NamedTuple):
    """Room for facets, their heap and the table in which new ridges meet.

    With d the dimension, a row of `facets` holds d vertices, d neighbours, the mark of the last
    point it was held against (2 t visible, 2 t + 1 hidden) and a serial number. A row of `planes`
    holds the unit normal, the distance from the origin and the depth of the present point.
    `lists` holds the stack of free rows, the visible rows, and the horizon: visible row and slot
    of every ridge with a hidden neighbour. `counts` holds the rows in use, the free rows, the
    heap's size, the serial and how often ridges were joined.
    """

    axes: tuple[int, ...]  # 0 to d - 1
    facets: np.ndarray  # (F, 2 d + 2) int32
    planes: np.ndarray  # (F, d + 2) float64
    lists: np.ndarray  # (4, F) int32
    heap: np.ndarray  # (H, 2) int32: row, serial
    keys: np.ndarray  # (H,) float64
    ridges: np.ndarray  # (T, 4) int64: key, row, slot, mark; T a power of two
    codes: np.ndarray  # (P,) int64: random, so that their sums name sets of vertices
    points: np.ndarray  # (P, d) float64
    counts: np.ndarray  # (5,) int64


FREE, SEEN, BELOW, SLOT = 0, 1, 2, 3


def workspace(dimension: int, capacity: int) -> Workspace:
    """Room for `capacity` facets, a power of two, and a sixteenth as many points."""
    limits = np.iinfo(np.int64)
    codes = np.random.default_rng(6).integers(limits.min, limits.max, capacity // 16)
    return Workspace(
        tuple(range(dimension)),
        np.empty((capacity, 2 * dimension + 2), np.int32),
        np.empty((capacity, dimension + 2)),
        np.empty((4, capacity), np.int32),
        np.empty((2 * capacity, 2), np.int32),
        np.empty(2 * capacity),
        np.zeros((8 * capacity, 4), np.int64),
        codes,
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
def _meet(axes, facets, ridges, mask, row, slot, key, stamp):  # type: ignore[no-untyped-def]
    """Join the new facet that waits at this ridge, or wait; -1 joined, 1 waiting, 0 broken."""
    d = len(axes)
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
        if facets[beyond, d + a] == below:
            facets[beyond, d + a] = row
    facets[row, slot] = vertex
    facets[row, d + slot] = beyond
    facets[row, 2 * d] = -1


@njit(cache=True, error_model="numpy")
def _mask(ridges, count):  # type: ignore[no-untyped-def]
    """Use no more of the table of ridges than `count` entries need, so that it stays at hand."""
    size = 64
    while size < 2 * count and size < ridges.shape[0]:
        size *= 2
    return size - 1


@njit(cache=True, error_model="numpy")
def attach(work, seen, horizon, vertex, turn, bound):  # type: ignore[no-untyped-def]
    """Replace the visible facets by the cone over their horizon; False when it does not close."""
    d = len(work.axes)
    facets, planes, counts, lists, codes = (
        work.facets,
        work.planes,
        work.counts,
        work.lists,
        work.codes,
    )
    counts[4] += 1  # never starts again, as the table outlives a grasp
    mask = _mask(work.ridges, horizon * (d - 1))
    waiting = 0
    for index in range(horizon):
        below, slot = lists[BELOW, index], lists[SLOT, index]
        if counts[1] > 0:
            counts[1] -= 1
            row = np.int64(lists[FREE, counts[1]])
        else:
            row = counts[0]
            counts[0] += 1
        _cap(work.axes, facets, planes, row, below, slot, facets[below, d + slot], vertex)
        facets[row, 2 * d + 1] = counts[3]
        if planes[row, d] < bound:
            push(work.keys, work.heap, counts[2], planes[row, d], row, counts[3])
            counts[2] += 1
        counts[3] += 1
        total = np.int64(0)
        for a in range(d):
            total += codes[facets[row, a]]
        for a in range(d):
            if a != slot:
                key = total - codes[facets[row, a]]
                joined = _meet(work.axes, facets, work.ridges, mask, row, a, key, counts[4])
                if joined == 0:
                    return False
                waiting += joined
    for index in range(seen):
        row = np.int64(lists[SEEN, index])
        facets[row, 2 * d + 1] = -1
        lists[FREE, counts[1]] = row
        counts[1] += 1
    return waiting == 0
