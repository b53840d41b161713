"""Compiled loops over all medial spheres: where a way leaves the object, and what is inside it."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def _chord(point, direction, center, radius):
    """Where a line enters and leaves a ball, as distances from `point`; (1, 0) when it misses."""
    along, square = 0.0, 0.0
    for axis in range(3):
        away = center[axis] - point[axis]
        along += away * direction[axis]
        square += away * away
    left = radius * radius - square + along * along
    if left <= 0.0:
        return 1.0, 0.0
    half = np.sqrt(left)
    return along - half, along + half


@njit(cache=True)
def ways_out(points, directions, centers, radii, gap, depth, room):
    """Depth of the object from each point on, and the free way after it (see `way_out`)."""
    enters, leaves = np.empty(len(radii)), np.empty(len(radii))
    for row in range(len(points)):
        count = 0
        for k in range(len(radii)):
            near, far = _chord(points[row], directions[row], centers[k], radii[k])
            if near <= far and far > 0.0:
                enters[count], leaves[count] = near, far
                count += 1
        end, grown = 0.0, True
        while grown:
            grown = False
            for k in range(count):
                if enters[k] <= end + gap and leaves[k] > end:
                    end, grown = leaves[k], True
        depth[row], room[row] = end, np.inf
        for k in range(count):
            if enters[k] > end + gap:
                room[row] = min(room[row], enters[k] - end)


@njit(cache=True)
def _square(point, other):
    """Squared distance of two points."""
    result = 0.0
    for axis in range(3):
        result += (point[axis] - other[axis]) ** 2
    return result


@njit(cache=True)
def any_inside(points, middle, reach, centers, radii, inside):
    """Whether any of the points (n, m, 3) of each row, within `reach` of a middle, is in a ball."""
    for row in range(len(points)):
        inside[row] = False
        for k in range(len(radii)):
            if _square(middle[row], centers[k]) > (reach[row] + radii[k]) ** 2:
                continue
            for place in range(points.shape[1]):
                if _square(points[row, place], centers[k]) < radii[k] * radii[k]:
                    inside[row] = True
                    break
            if inside[row]:
                break


@njit(cache=True)
def thickest(points, centers, radii, largest):
    """Radius of the largest ball that holds each point (n, 3); 0 where none does."""
    for row in range(len(points)):
        largest[row] = 0.0
        for k in range(len(radii)):
            if radii[k] <= largest[row]:
                continue
            if _square(points[row], centers[k]) <= radii[k] * radii[k]:
                largest[row] = radii[k]
