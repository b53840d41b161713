"""Three ways to tell the disks that matter from those that noise made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import nonnegative, positive
from medkit.planar.disks import MedialAxis, checked_axis


def filter_object_angle(axis: MedialAxis, min_angle: float) -> MedialAxis:
    """Keep disks whose object angle is at least `min_angle`.

    Parameters
    ----------
    axis : MedialAxis
        Disks to choose from.
    min_angle : float
        Smallest object angle that stays [rad]; a rounding of 1e-9 is forgiven, so that 120 deg
        keeps the whole axis of an equilateral triangle.

    Returns
    -------
    MedialAxis
        The disks that stay.

    Raises
    ------
    InputError
        If `min_angle` is negative.

    Notes
    -----
    Source: P13 3.2.2 and 4.2.3.
    """
    axis = checked_axis(axis)
    return axis.keep(axis.object_angles >= nonnegative(min_angle, "min_angle", " rad") - 1e-9)


def filter_lambda(axis: MedialAxis, min_span: float) -> MedialAxis:
    """Keep disks whose touch points need a circle of at least `min_span` [m] around them.

    Notes
    -----
    The lambda medial axis of Chazal and Lieutier 2005. Source: P13 3.2.2.
    """
    axis = checked_axis(axis)
    return axis.keep(axis.spans >= nonnegative(min_span, "min_span", " m"))


def filter_scale(axis: MedialAxis, scale: float) -> MedialAxis:
    """Keep disks that still show at the rim when all disks grow by a factor.

    Every disk is scaled about its own centre. A disk whose grown rim is covered by the other
    grown disks carries only detail, and goes; the others keep their original size.

    Parameters
    ----------
    axis : MedialAxis
        Disks to choose from.
    scale : float
        Factor, 1 or more.

    Returns
    -------
    MedialAxis
        The disks that stay.

    Raises
    ------
    InputError
        If `scale` is below one.

    Notes
    -----
    The finite form of the scale axis transform of Giesen and others 2009: it chooses among the
    given disks instead of building the axis of the grown union. Source: P13 3.2.2.
    """
    axis, scale = checked_axis(axis), positive(scale, "scale")
    if not scale >= 1.0:
        raise InputError(f"Expected a scale of 1 or more, but got {scale:g}; give a larger one.")
    radii = axis.radii * scale
    shown = [_shows(axis.centers, radii, i) for i in range(len(axis))]
    return axis.keep(np.array(shown, dtype=bool))


def _shows(centers: NDArray[np.float64], radii: NDArray[np.float64], i: int) -> bool:
    """Whether some of the rim of disk i lies outside all other disks."""
    gap = centers - centers[i]
    distance = np.hypot(gap[:, 0], gap[:, 1])
    slack = 1e-12 * radii.max()
    same = (distance <= slack) & (np.abs(radii - radii[i]) <= slack)
    if np.any(~same & (distance + radii[i] <= radii + slack)):
        return False
    near = ~same & (distance < radii + radii[i]) & (distance + radii > radii[i])
    facing = np.arctan2(gap[near, 1], gap[near, 0])
    cosine = (radii[i] ** 2 + distance[near] ** 2 - radii[near] ** 2) / (
        2.0 * radii[i] * distance[near]
    )
    half = np.arccos(np.clip(cosine, -1.0, 1.0))
    start = np.mod(facing - half, 2 * np.pi)
    order = np.argsort(start)
    start, stop = start[order], start[order] + 2 * half[order]
    if not len(start):
        return True
    # go once around; covered arcs that run past the end cover the beginning as well
    reach = np.maximum.accumulate(np.concatenate([[stop.max() - 2 * np.pi], stop]))
    return bool(np.any(start > reach[:-1] + 1e-9) or reach[-1] < 2 * np.pi - 1e-9)
