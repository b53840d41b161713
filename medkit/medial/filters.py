"""Which medial spheres are kept: object angle, radius, lambda and scale axis (P13 3.2.2, 4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, expected, nonnegative
from medkit.medial.axis import MedialAxis

#: P13 4.2.3: spheres below this describe corners and edges rather than thickness [rad].
MIN_OBJECT_ANGLE = float(np.radians(120.0))


def filter_object_angle(axis: MedialAxis, min_angle: float = MIN_OBJECT_ANGLE) -> MedialAxis:
    """Keep the spheres whose object angle is at least `min_angle` [rad] (P13 4.2.3).

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import medial_axis
    >>> axis = medial_axis(trimesh.creation.box((0.2, 0.1, 0.04)))
    >>> 0 < len(filter_object_angle(axis)) < len(axis)
    True
    """
    _checked(axis)
    # a hair below: 120 deg computed in two ways must not differ
    return axis.select(axis.object_angles >= nonnegative(min_angle, "min_angle", " rad") - 1e-9)


def filter_radius_ratio(axis: MedialAxis, ratio: float) -> MedialAxis:
    """Keep the spheres whose radius is at least `ratio` times the largest one (P13 4.2.4)."""
    largest = float(_checked(axis).radii.max(initial=0.0))
    return axis.select(axis.radii >= nonnegative(ratio, "ratio") * largest)


def touch_circumradii(axis: MedialAxis) -> Floats:
    """Radius of the smallest ball around each sphere's two touch points, shape (n,) [m].

    This is the lambda of the lambda medial axis (P13 3.2.2), ``r sin(alpha / 2)``: half the
    distance of the touch points that are farthest apart.
    """
    return np.asarray(axis.radii * np.sin(0.5 * axis.object_angles))


def filter_lambda(axis: MedialAxis, min_lambda: float) -> MedialAxis:
    """Keep the spheres whose touch points do not fit into a ball smaller than `min_lambda` [m].

    Unlike the object angle, lambda measures lengths: small details go, whatever their shape.
    """
    _checked(axis)
    return axis.select(touch_circumradii(axis) >= nonnegative(min_lambda, "min_lambda", " m"))


def filter_scale_axis(axis: MedialAxis, scale: float) -> MedialAxis:
    """Keep the spheres that survive when all are grown by `scale` (P13 3.2.2).

    A sphere goes when, grown, it lies inside another grown sphere: a small sphere beside a large
    one adds nothing to the shape at that scale. This is the first step of the scale axis
    transform, which then computes the medial axis of the grown union anew; that second step is
    left out, so a kept sphere is always one of the object's own.

    Parameters
    ----------
    axis : MedialAxis
        All spheres of an object.
    scale : float
        Growth, at least 1; 1 removes duplicates only.

    Returns
    -------
    MedialAxis
        The largest sphere is always kept.

    Raises
    ------
    InputError
        If the scale is below 1.
    """
    _checked(axis)
    if not nonnegative(scale, "scale") >= 1.0:
        raise InputError(f"Expected a scale of at least 1, but got {scale:g}; spheres only grow.")
    keep = uncovered(axis.centers, axis.radii * scale)
    return axis.select(keep)


def _checked(axis: MedialAxis) -> MedialAxis:
    return expected(axis, MedialAxis, "a medial axis", "pass medkit.grasping.medial_axis(mesh)")


def uncovered(centers: Floats, radii: Floats) -> NDArray[np.int64]:
    """Indices, ascending, of the balls that lie in no larger ball of the set (n, 3), (n,) [m]."""
    from scipy.spatial import cKDTree

    order = np.argsort(-radii, kind="stable")
    tree = cKDTree(centers)
    alive = np.ones(len(radii), bool)
    for i in order:
        if not alive[i]:
            continue
        # only centres nearer than this ball's radius can belong to balls inside it
        near = np.array(tree.query_ball_point(centers[i], radii[i]))
        distance = np.linalg.norm(centers[near] - centers[i], axis=1)
        inside = near[distance + radii[near] <= radii[i] * (1.0 + 1e-12)]
        alive[inside[inside != i]] = False
    return np.flatnonzero(alive)
