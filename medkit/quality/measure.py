"""Epsilon: the radius of the largest ball around the origin inside the grasp wrench space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.quality.expansion import expand, expand_many
from medkit.quality.space import Norm, SpaceOptions, wrench_space
from medkit.wrench_cones import PATCH_RADIUS, ContactModel


@dataclass(frozen=True)
class Epsilon:
    """Bounds on the radius of the largest origin-centred ball inside the wrench space.

    Attributes
    ----------
    lower, upper : float
        The radius lies between them [N for contacts that press with at most 1 N]; both are 0.0
        for a grasp that is not force-closure.
    weakest_direction : ndarray, shape (6,) or (3,)
        Unit wrench ``[force, torque / torque_scale]`` in which the wrench space reaches least
        far; a disturbance of the opposite direction is the hardest to resist. For a grasp that
        is not force-closure, a direction in which it can give no positive wrench; zeros when
        the wrenches do not span the space.
    points_added : int
        Support points the polytope took in after its start simplex.
    converged : bool
        False when the room for facets ran out first; the bounds hold all the same. That happens
        to exact cones on contacts of rotational symmetry, whose weakest directions form a whole
        family, at tolerances below about 1e-3, and now and then to the "linf" space of more than
        a hundred contacts, with bounds 0.5 % apart at most in trials with 200.
    """

    lower: float
    upper: float
    weakest_direction: Floats
    points_added: int
    converged: bool

    @property
    def force_closure(self) -> bool:
        """Whether the ball has a radius at all."""
        return self.lower > 0.0


@dataclass(frozen=True)
class EpsilonBatch:
    """Epsilon of many grasps: ``lower`` and ``upper`` (g,), 0.0 where not force-closure."""

    lower: Floats
    upper: Floats

    @property
    def force_closure(self) -> NDArray[np.bool_]:
        """Which grasps are force-closure, shape (g,)."""
        return np.asarray(self.lower > 0.0)


def epsilon(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    friction: ArrayLike,
    torque_origin: ArrayLike,
    torque_scale: float,
    edges: int | None = 8,
    norm: Norm = "l1",
    contact: ContactModel = "point",
    patch_radius: float = PATCH_RADIUS,
    tolerance: float = 1e-4,
) -> Epsilon:
    """Largest wrench, in its weakest direction, that the contacts resist.

    Parameters
    ----------
    points : array-like, shape (n, 3) or (n, 2)
        Contact points, object frame [m].
    normals : array-like, same shape
        Inward unit normals [1].
    friction : float or array-like, shape (n,)
        Coulomb coefficients [1].
    torque_origin : array-like, shape (3,) or (2,)
        Point torques are taken about, usually the centre of mass [m].
    torque_scale : float
        Length torques are divided by, usually the object's largest distance from its centre of
        mass [m].
    edges : int or None
        Edges of a linearised cone in space, see `medkit.contacts`; None for the exact cone. A
        planar cone has two edges and is exact.
    norm : {"l1", "linf"}
        "l1": the normal forces sum to at most 1 N (hull of the union of the contacts' wrenches);
        "linf": each normal force is at most 1 N (their Minkowski sum).
    contact : {"point", "frictionless", "soft"}
        Contact model.
    patch_radius : float
        Radius of a soft finger's patch [m].
    tolerance : float
        How closely the bounds of exact cones meet, in units of the longest wrench [1]. Bounds of
        linearised cones meet within 1e-10 whatever is given (1e-9 in the worst case, where
        facets lie in one plane almost but not quite) as long as the expansion converges; as a
        rule they agree to rounding.

    Returns
    -------
    Epsilon
        Bounds, the weakest direction, and how much work it was. Grasps that are not
        force-closure (also too few contacts, coplanar wrenches) give 0.0.

    Raises
    ------
    InputError
        For arguments out of their range; see `Contacts`.

    Notes
    -----
    After Ferrari and Canny (1992); the expansion after Zheng (2012). P13 4.6.2, 5.1.3. A grasp
    whose ball is smaller than 1e-10 of its longest wrench counts as not force-closure.

    Examples
    --------
    >>> pinch = epsilon([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]],
    ...                 friction=1.0, torque_origin=[0.0, 0.0], torque_scale=1.0)
    >>> round(pinch.lower, 6)
    0.57735
    """
    contacts = Contacts(points, normals, friction)
    options = SpaceOptions(edges, norm, contact, patch_radius, tolerance)
    space = wrench_space(contacts, torque_origin, torque_scale, options)
    return Epsilon(*expand(space))


def _stacked(
    points: Sequence[ArrayLike], normals: Sequence[ArrayLike], friction: float
) -> tuple[Contacts, NDArray[np.int64]]:
    """All contacts one after the other, and where each grasp starts."""
    try:
        rows = [np.asarray(row, dtype=float) for row in points]
        sides = [np.asarray(row, dtype=float) for row in normals]
        counts = [len(row) for row in rows]
    except (TypeError, ValueError):
        raise InputError(
            "Expected the contacts of several grasps, but got something else; pass one list of"
            " points and one of normals per grasp."
        ) from None
    if [np.size(row) for row in sides] != [np.size(row) for row in rows]:
        raise InputError(
            "Expected as many normals as points in every grasp, but the numbers differ between"
            f" {len(rows)} lists of points and {len(sides)} of normals; pass them in pairs."
        )
    filled = [i for i, count in enumerate(counts) if count]
    if not filled:
        flat, inward = np.zeros((0, 3)), np.zeros((0, 3))
    else:
        flat = np.concatenate([rows[i] for i in filled])
        inward = np.concatenate([sides[i] for i in filled])
    starts = np.zeros(len(counts) + 1, np.int64)
    starts[1:] = np.cumsum(counts)
    return Contacts(flat, inward, friction), starts


def epsilon_many(
    points: Sequence[ArrayLike],
    normals: Sequence[ArrayLike],
    *,
    friction: float,
    torque_origin: ArrayLike,
    torque_scale: float,
    **options: Any,
) -> EpsilonBatch:
    """Epsilon of many grasps of one object.

    Parameters
    ----------
    points, normals : sequence of array-like, each of shape (n_i, 3) or (n_i, 2)
        Contacts of each grasp [m], [1].
    friction : float
        Coulomb coefficient of all contacts [1].
    torque_origin, torque_scale
        As in `epsilon`, one for all grasps.
    **options
        `edges`, `norm`, `contact`, `patch_radius` and `tolerance` as in `epsilon`.

    Returns
    -------
    EpsilonBatch
        Bounds per grasp.

    Raises
    ------
    InputError
        For arguments out of their range, and lists of points and normals that do not pair up.

    Examples
    --------
    >>> pinch = [[-1.0, 0.0], [1.0, 0.0]]
    >>> epsilon_many([pinch], [[[1.0, 0.0], [-1.0, 0.0]]], friction=1.0,
    ...              torque_origin=[0.0, 0.0], torque_scale=1.0).lower.round(6)
    array([0.57735])
    """
    contacts, starts = _stacked(points, normals, friction)
    space = wrench_space(contacts, torque_origin, torque_scale, SpaceOptions(**options))
    return EpsilonBatch(*expand_many(space, starts).T)
