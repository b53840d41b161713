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
LINEAR_GAP = 1e-12
#: Room for facets: first try, and the tries after it; the last one ends with open bounds.
CAPACITIES = (2**12, 2**16, 2**20)

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
    statuses = np.zeros((count, 2), np.int64)
    statuses[:, 0] = kernels.FULL
    signed, weakest = np.zeros((count, 2)), np.zeros((count, dimension))
    for capacity in CAPACITIES:
        kernels.expand(
            cones.centers, cones.axes, starts, profile, total, tolerance, gap, closure_only,
            _room(dimension, capacity), statuses, signed, weakest,
        )  # fmt: skip
        if not (statuses[:, 0] == kernels.FULL).any():
            break
    np.maximum(signed, 0.0, out=signed)  # a budget that ran out may leave a negative lower bound
    return Expansion(statuses[:, 0], statuses[:, 1], signed[:, 0], signed[:, 1], weakest)


def _room(dimension: int, capacity: int) -> kernels.Workspace:
    if capacity > CAPACITIES[0]:
        return kernels.workspace(dimension, capacity)
    name = f"room{dimension}"
    if not hasattr(_kept, name):
        setattr(_kept, name, kernels.workspace(dimension, capacity))
    room: kernels.Workspace = getattr(_kept, name)
    return room
