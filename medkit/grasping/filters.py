"""Which medial spheres are kept: object angle, radius, lambda and scale axis (P13 3.2.2, 4.2)."""

from __future__ import annotations

import numpy as np

from medkit.geometry import nonnegative
from medkit.grasping.medial import MedialAxis

#: P13 4.2.3: spheres below this describe corners and edges rather than thickness [rad].
MIN_OBJECT_ANGLE = np.radians(120.0)


def filter_object_angle(axis: MedialAxis, min_angle: float = MIN_OBJECT_ANGLE) -> MedialAxis:
    """Keep the spheres whose object angle is at least `min_angle` [rad] (P13 4.2.3)."""
    # a hair below: 120 deg computed in two ways must not differ
    return axis.select(axis.object_angles >= nonnegative(min_angle, "min_angle", " rad") - 1e-9)


def filter_radius_ratio(axis: MedialAxis, ratio: float) -> MedialAxis:
    """Keep the spheres whose radius is at least `ratio` times the largest one (P13 4.2.4)."""
    largest = float(axis.radii.max(initial=0.0))
    return axis.select(axis.radii >= nonnegative(ratio, "ratio") * largest)
