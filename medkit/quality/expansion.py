"""The compiled expansion, called with room that grows when a grasp needs more."""

from __future__ import annotations

import threading
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.quality import kernels
from medkit.quality.space import WrenchSpace

#: A ball smaller than this, in units of the longest wrench, counts as none.
CLOSURE_TOLERANCE = 1e-10
#: Room for facets: first try, and the tries after it; the last one ends with open bounds.
CAPACITIES = (2**13, 2**15, 2**18)
#: How far a point must lie beyond a facet to see it, in longest wrenches. Symmetric grasps give
#: facets in one plane exactly or not at all; those that nearly do so need a second opinion.
SIGHTS = (1e-10, 1e-12, 3e-10, 1e-13, 1e-9, 1e-14)


class _Kept(threading.local):
    """Scratch memory, one per thread: fresh pages would cost more than a small grasp does."""

    def __init__(self) -> None:
        self.rooms: dict[int, kernels.Workspace] = {}


_kept = _Kept()


class Expansion(NamedTuple):
    """What the kernel found for a grasp: bounds of the radius, 0.0 without a ball."""

    lower: float
    upper: float
    weakest: Floats
    points_added: int
    converged: bool


def expand(space: WrenchSpace, *, closure_only: bool = False) -> Expansion:
    """Expand the polytope of one grasp until its bounds meet, or until it holds the origin."""
    weakest = np.zeros(space.centers.shape[1])
    lower, upper, added, converged = -np.inf, np.inf, 0, False
    for sight in SIGHTS:
        meet = max(space.gap, sight)  # a point that its own facet does not see is no progress
        for capacity in CAPACITIES:
            status, low, high, added = kernels.expand(
                space.centers, space.axes, space.profile, space.total, CLOSURE_TOLERANCE, meet,
                sight, closure_only, _room(len(weakest), capacity), weakest,
            )  # fmt: skip
            if status != kernels.FULL:
                break
        if status != kernels.FAILED:
            lower, upper, converged = low, high, status != kernels.FULL
            break
        # both bounds of a failed try hold, so keep the better of each; a unit normal force makes
        # every longest wrench 1 or more, so this is the strict reading of having met
        lower, upper = max(lower, low), min(upper, high)
        if upper - lower <= SIGHTS[0]:
            converged = True
            break
    # room that ran out may leave a negative lower bound
    return Expansion(max(lower, 0.0), max(upper, 0.0), weakest, added, converged)


def expand_many(space: WrenchSpace, starts: NDArray[np.int64]) -> Floats:
    """Bounds (g, 2) of each grasp, which owns contacts ``starts[g]`` to ``starts[g + 1]``."""
    bounds = np.empty((len(starts) - 1, 2))
    for g, (first, last) in enumerate(pairwise(starts.tolist())):
        own = space._replace(centers=space.centers[first:last], axes=space.axes[first:last])
        bounds[g] = expand(own)[:2]
    return bounds


def _room(dimension: int, capacity: int) -> kernels.Workspace:
    if capacity > CAPACITIES[0]:
        return kernels.workspace(dimension, capacity)
    room = _kept.rooms.get(dimension)
    if room is None:
        room = _kept.rooms[dimension] = kernels.workspace(dimension, capacity)
    return room
