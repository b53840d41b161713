"""The compiled expansion, called with room that grows when a grasp needs more."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from medkit.contacts import WrenchCones
from medkit.geometry import Floats
from medkit.quality import kernels

#: A ball smaller than this, in units of the longest wrench, counts as none.
CLOSURE_TOLERANCE = 1e-10
#: Bounds of linearised cones meet this closely, in units of the longest wrench.
LINEAR_GAP = 1e-10
#: Room for facets: first try, and the tries after it; the last one ends with open bounds.
CAPACITIES = (2**13, 2**15, 2**18)
#: How far a point must lie beyond a facet to see it, in longest wrenches. Symmetric grasps give
#: facets in one plane exactly or not at all; those that nearly do so need a second opinion.
SIGHTS = (1e-10, 1e-12, 3e-10, 1e-13, 1e-9, 1e-14)

# Scratch memory is kept, one per thread: fresh pages would cost more than a small grasp does.
_kept = threading.local()


@dataclass(frozen=True)
class Expansion:
    """What the kernel found for each of g grasps.

    ``statuses`` (g,) as numbered in the kernel, ``points_added`` (g,), ``lower`` and ``upper``
    (g,) bounds of the radius, 0.0 without a ball, ``weakest`` (g, D) directions of the upper bound.
    """

    statuses: NDArray[np.int64]
    points_added: NDArray[np.int64]
    lower: Floats
    upper: Floats
    weakest: Floats

    @property
    def converged(self) -> NDArray[np.bool_]:
        """For which grasps the bounds met, shape (g,)."""
        return (self.statuses != kernels.FULL) & (self.statuses != kernels.FAILED)


def expand(
    cones: WrenchCones,
    starts: NDArray[np.int64],
    profile: Floats,
    *,
    total: bool,
    gap: float,
    closure_only: bool = False,
    tolerance: float = CLOSURE_TOLERANCE,
) -> Expansion:
    """Expand the polytope of each grasp, which owns contacts ``starts[g]`` to ``starts[g + 1]``."""
    count, dimension = len(starts) - 1, cones.centers.shape[1]
    statuses = np.full((count, 2), kernels.FULL, np.int64)
    signed, weakest = np.zeros((count, 2)), np.zeros((count, dimension))
    known: Floats | None = None
    for sight in SIGHTS:
        meet = max(gap, sight)  # a point that its own facet does not see is no progress
        for capacity in CAPACITIES:
            kernels.expand(
                cones.centers, cones.axes, starts, profile, total, tolerance, meet, sight,
                closure_only, _room(dimension, capacity), statuses, signed, weakest,
            )  # fmt: skip
            if not (statuses[:, 0] == kernels.FULL).any():
                break
        failed = statuses[:, 0] == kernels.FAILED
        if not failed.any():
            break
        known = _narrowed(known, signed, failed)
        # a unit normal force makes every longest wrench 1 or more, so this is the strict reading
        met = signed[:, 1] - signed[:, 0] <= SIGHTS[0]
        statuses[failed & met, 0] = kernels.CONVERGED
        statuses[failed & ~met, 0] = kernels.FULL
    np.maximum(signed, 0.0, out=signed)  # room that ran out may leave a negative lower bound
    return Expansion(statuses[:, 0], statuses[:, 1], signed[:, 0], signed[:, 1], weakest)


def _narrowed(known: Floats | None, signed: Floats, failed: NDArray[np.bool_]) -> Floats:
    """Both bounds of failed tries hold, so keep the better of each."""
    if known is None:
        known = np.tile([-np.inf, np.inf], (len(signed), 1))
    known[failed, 0] = np.maximum(known[failed, 0], signed[failed, 0])
    known[failed, 1] = np.minimum(known[failed, 1], signed[failed, 1])
    signed[failed] = known[failed]
    return known


def _room(dimension: int, capacity: int) -> kernels.Workspace:
    if capacity > CAPACITIES[0]:
        return kernels.workspace(dimension, capacity)
    name = f"room{dimension}"
    if not hasattr(_kept, name):
        setattr(_kept, name, kernels.workspace(dimension, capacity))
    room: kernels.Workspace = getattr(_kept, name)
    return room
