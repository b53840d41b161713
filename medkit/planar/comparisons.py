"""One axis held against another, against the region, and against what a simulation says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import Voronoi

from medkit.errors import InputError
from medkit.geometry import Floats, points_array
from medkit.planar.bounds import min_friction, min_object_angle
from medkit.planar.disks import MedialAxis, angle_between
from medkit.planar.outlines import Outline, SmoothOutline
from medkit.planar.settings import SqueezeSettings
from medkit.planar.studies import simulated_critical_friction


def stray_and_hole(axis: MedialAxis, reference: MedialAxis) -> tuple[float, float]:
    """Farthest centre from the reference's centres, and the other way round.

    Parameters
    ----------
    axis, reference : MedialAxis
        What is judged, and what it should be; at least one disk each.

    Returns
    -------
    stray : float
        How far a disk of `axis` lies from the nearest of the reference [m], at worst.
    hole : float
        How far a disk of the reference lies from the nearest of `axis` [m], at worst.

    Raises
    ------
    InputError
        If one of the two has no disk left.

    Examples
    --------
    >>> from medkit.planar import medial_axis, rectangle
    >>> axis = medial_axis(rectangle())
    >>> stray_and_hole(axis, axis)
    (0.0, 0.0)
    """
    if not len(axis) or not len(reference):
        raise InputError(
            "Expected at least one disk on both axes, but one has none; filter less strictly."
        )
    gap = np.linalg.norm(axis.centers[:, None] - reference.centers[None], axis=2)
    return float(gap.min(axis=1).max()), float(gap.min(axis=0).max())


def living_branches(axis: MedialAxis, *, disks: int = 3) -> int:
    """Number of branches of which at least so many disks are left after filtering.

    Examples
    --------
    >>> from medkit.planar import medial_axis, rectangle
    >>> living_branches(medial_axis(rectangle()))
    5
    """
    return int((np.bincount(axis.branch[axis.branch >= 0], minlength=1) >= disks).sum())


def graspable_share(axis: MedialAxis, *, friction: float) -> float:
    """Share of the axis, by length, whose object angle lies above the bound.

    Parameters
    ----------
    axis : MedialAxis
        The whole axis, unfiltered.
    friction : float
        Coefficient of static friction [1].

    Returns
    -------
    float
        Between 0 and 1.

    Examples
    --------
    >>> from medkit.planar import medial_axis, rectangle
    >>> round(graspable_share(medial_axis(rectangle()), friction=0.5), 2)
    0.26
    """
    held = axis.object_angles > min_object_angle(friction)
    return float(axis.lengths[held].sum() / axis.lengths.sum())


def covered_share(axis: MedialAxis, points: ArrayLike) -> float:
    """Share of points inside the outline that lie in one of the disks (P13 3.2).

    Parameters
    ----------
    axis : MedialAxis
        Disks.
    points : array-like, shape (n, 2)
        Points [m]; those outside the outline do not count.

    Returns
    -------
    float
        One where the disks rebuild the shape.

    Examples
    --------
    >>> from medkit.planar import medial_axis, rectangle
    >>> covered_share(medial_axis(rectangle()), [[0.0, 0.0], [0.01, 0.01]])
    1.0
    """
    inside = points_array(points, 2)
    inside = inside[axis.outline.contains(inside)]
    gap = np.linalg.norm(inside[:, None] - axis.centers[None], axis=2)
    return float((gap <= axis.radii).any(axis=1).mean())


def voronoi_centers(outline: Outline, samples: int) -> Floats:
    """Voronoi vertices inside an outline that was sampled: the approximate medial axis.

    Parameters
    ----------
    outline : Outline
        The region.
    samples : int
        Number of points on it, evenly spread.

    Returns
    -------
    ndarray, shape (n, 2)
        Centres [m]; they include a hair for every reflex corner and for most samples of a curve.

    Notes
    -----
    Source: P13 3.2.2 and figure 3.4, after Attali and Brandt.

    Examples
    --------
    >>> from medkit.planar import rectangle
    >>> bool(np.abs(voronoi_centers(rectangle(0.08, 0.04), 96)[:, 1]).max() < 0.02)
    True
    """
    ends = np.concatenate([[0.0], np.cumsum(outline.lengths)])
    at = (np.arange(samples) + 0.5) / samples * ends[-1]
    edge = np.searchsorted(ends, at, side="right") - 1
    spots = outline.starts[edge] + (at - ends[edge])[:, None] * outline.tangents[edge]
    vertices = Voronoi(spots).vertices
    return np.asarray(vertices[outline.contains(vertices)])


def notch_distance(outline: Outline, points: ArrayLike) -> Floats:
    """Distance of points of shape (n, 2) from the nearest corner that points inwards, (n,) [m].

    Infinite on outlines without such a corner.

    Examples
    --------
    >>> from medkit.planar import l_shape
    >>> notch_distance(l_shape(0.08, 0.03), [[0.03, 0.03], [0.03, 0.04]]).round(3).tolist()
    [0.0, 0.01]
    """
    spots, corners = points_array(points, 2), []
    for loop in () if isinstance(outline, SmoothOutline) else outline.loops:
        arriving, leaving = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
        turn = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
        corners.append(loop[turn < 0.0])
    every = np.vstack([np.full((1, 2), np.inf), *corners])
    return np.asarray(np.linalg.norm(spots[:, None] - every[None], axis=2).min(axis=1))


def friction_deviation(
    outline: Outline, touch: ArrayLike, center: ArrayLike, *, tolerance: float = 2e-3,
    **settings: Any,
) -> float:  # fmt: skip
    """Simulated critical friction over the bound, minus one, for one disk.

    Parameters
    ----------
    outline : Outline
        The object.
    touch : array-like, shape (2, 2)
        Touch points of the disk [m].
    center : array-like, shape (2,)
        Its centre [m].
    tolerance : float
        Relative width at which the bisection stops [1].
    **settings
        What is changed in :class:`medkit.planar.SqueezeSettings`.

    Returns
    -------
    float
        Zero where simulation and statics agree [1].
    """
    spots = points_array(touch, 2)
    spokes = spots - np.asarray(center, dtype=float)
    limit = min_friction(float(angle_between(spokes[0], spokes[1])))
    found = simulated_critical_friction(
        outline, *spots, low=0.5 * limit, high=2.0 * limit, tolerance=tolerance,
        settings=SqueezeSettings(**settings),
    )  # fmt: skip
    return found / limit - 1.0


def numerics_study(
    outline: Outline, touch: ArrayLike, center: ArrayLike, changes: Mapping[str, Mapping[str, Any]]
) -> dict[str, float]:
    """Repeat :func:`friction_deviation` under changed settings of the engine.

    Parameters
    ----------
    outline, touch, center
        As there.
    changes : mapping of str to mapping
        Name of each variant and the settings it changes.

    Returns
    -------
    dict of str to float
        Deviation per variant [1].
    """
    return {
        name: friction_deviation(outline, touch, center, **change)
        for name, change in changes.items()
    }
