"""Compiled questions to the object's lattice: clearance of a point, bodies that lie inside.

`field` is an `ObjectField`, `hand` a `ClosingHand`; poses are (4, 4) maps from a link's frame
into the object's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import moved
from medkit.grasping.closing.kernel_options import inner, leaf

#: Lattice values are off by at most this many spacings between nodes (half a cell's diagonal).
SLACK = float(np.sqrt(3.0) / 2.0) * (1.0 + 1e-6)


@leaf
def node_at(field: Any, x: float, y: float, z: float) -> tuple[int, int, int, bool]:
    """The lattice node nearest to a point, and whether there is one."""
    shape = field.distances.shape
    i = round((x - field.origin[0]) / field.spacing)
    j = round((y - field.origin[1]) / field.spacing)
    k = round((z - field.origin[2]) / field.spacing)
    return i, j, k, 0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2]


@inner
def depth_at(field: Any, x: float, y: float, z: float) -> float:
    """Depth [m] that a point surely has inside the object; 0 if it is not surely inside."""
    i, j, k, within = node_at(field, x, y, z)
    if not within or not field.inside[i, j, k]:
        return 0.0
    return max(field.distances[i, j, k] - SLACK * field.spacing, 0.0)


@inner
def way_out_of_inside(
    field: Any, hand: Any, body: int, pose: np.ndarray, approach: np.ndarray, way: float
) -> float:
    """Retreat [m] of at least `way` after which no sample of a body is well inside the object.

    A sample inside stays inside until it leaves, so no free pose is passed over.
    """
    surface = hand.surface
    for s in range(surface.start[body], surface.start[body + 1]):
        x, y, z = moved(pose, surface.samples, s)
        depth = 1.0
        while depth > 0.0:
            depth = depth_at(
                field, x - way * approach[0], y - way * approach[1], z - way * approach[2]
            )
            way += depth
    return way


@inner
def is_inside(field: Any, hand: Any, body: int, pose: np.ndarray) -> bool:
    """Whether a body that meets no face lies within the object.

    All of it is on one side then: the first sample that is well away from the surface tells,
    and a body without any is outside.
    """
    surface = hand.surface
    for s in range(surface.start[body], surface.start[body + 1]):
        x, y, z = moved(pose, surface.samples, s)
        i, j, k, within = node_at(field, x, y, z)
        if not within:
            return False
        if field.distances[i, j, k] > 2.0 * SLACK * field.spacing:
            return bool(field.inside[i, j, k])
    return False
