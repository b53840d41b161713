"""Contacts: points, inward normals and friction, checked once, and the wrenches they can give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, points_array
from medkit.wrench_cones import PATCH_RADIUS as PATCH_RADIUS
from medkit.wrench_cones import ContactModel as ContactModel
from medkit.wrench_cones import linear_profile, wrench_cones

#: How far a normal's length may be from one [1].
UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Contacts:
    """Where fingers touch, in which direction they push, and how rough it is there.

    Parameters
    ----------
    points : array-like, shape (n, 3) or (n, 2)
        Contact points, object frame [m].
    normals : array-like, same shape
        Inward unit normals: the directions in which the fingers push [1].
    friction : float or array-like, shape (n,)
        Coulomb coefficient, one for all or one per contact [1].

    Raises
    ------
    InputError
        For shapes that do not fit, numbers that are not finite, normals that are not of length
        one (within 1e-6), and friction below zero.

    Examples
    --------
    >>> pinch = Contacts([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]], friction=0.5)
    >>> pinch.cone_edges(torque_origin=[0.0, 0.0])[0]
    array([[ 1. ,  0.5],
           [ 1. , -0.5]])
    >>> pinch.wrenches(torque_origin=[0.0, 0.0], torque_scale=1.0)[0]
    array([[ 1. ,  0.5, -0.5],
           [ 1. , -0.5,  0.5]])
    """

    points: Floats
    normals: Floats
    friction: Floats

    def __init__(self, points: ArrayLike, normals: ArrayLike, friction: ArrayLike) -> None:
        try:
            places = np.array(points, dtype=float, order="C")
            inward = np.array(normals, dtype=float, order="C")
            roughness = np.asarray(friction, dtype=float)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"Expected numbers for points, normals and friction, but got something else"
                f" ({error}); pass arrays of shape (n, 3) or (n, 2) and a coefficient."
            ) from None
        fits = places.ndim == 2 and inward.shape == places.shape and roughness.ndim == 0
        spread = np.empty(len(places) if fits else 0)
        spread[:] = roughness if fits else 0.0
        # one compiled look at all numbers; only what fails it pays for the checks that explain
        if not (fits and len(places) and _sound(places, inward, spread)):
            _refuse_points(places)
            _refuse_normals(inward, places)
            spread = _spread_friction(roughness, len(places))
        object.__setattr__(self, "points", places)
        object.__setattr__(self, "normals", inward)
        object.__setattr__(self, "friction", spread)

    def __len__(self) -> int:
        return len(self.points)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return int(self.points.shape[1])

    def cone_edges(self, *, torque_origin: ArrayLike, edges: int = 8) -> Floats:
        """Forces along the edges of the friction cones, each with a normal part of one.

        Parameters
        ----------
        torque_origin : array-like, shape (3,) or (2,)
            The point the lever arms start at [m]; it sets where the first edge lies.
        edges : int
            Edges of a spatial cone, three or more; a round cone (None) has none to list and is
            refused. A planar cone has two whatever is asked.

        Returns
        -------
        ndarray, shape (n, edges, 3) or (n, 2, 2)
            Forces [N] for a normal force of 1 N.
        """
        cones = wrench_cones(self, torque_origin=torque_origin, torque_scale=1.0)
        profile = linear_profile(self.dimension, "point", edges)
        wrenches = cones.centers[:, None, :] + profile @ cones.axes
        return np.ascontiguousarray(wrenches[:, :, : self.dimension])

    def wrenches(
        self,
        *,
        torque_origin: ArrayLike,
        torque_scale: float,
        edges: int = 8,
        contact: ContactModel = "point",
        patch_radius: float = PATCH_RADIUS,
    ) -> Floats:
        """Primitive wrenches ``[force, torque / torque_scale]`` of every contact.

        Parameters
        ----------
        torque_origin : array-like, shape (3,) or (2,)
            The point torques are taken about [m].
        torque_scale : float
            Length that torques are divided by [m].
        edges : int
            Edges of a spatial cone.
        contact : {"point", "frictionless", "soft"}
            Hard finger, finger without friction, or finger that also resists torsion.
        patch_radius : float
            Radius of a soft finger's patch [m].

        Returns
        -------
        ndarray, shape (n, m, 6) or (n, 2, 3)
            ``m`` wrenches per contact [N]: `edges` for a point, 1 without friction, and
            ``2 + edges (edges // 2 - 1)`` for a soft finger.
        """
        cones = wrench_cones(
            self,
            torque_origin=torque_origin,
            torque_scale=torque_scale,
            contact=contact,
            patch_radius=patch_radius,
        )
        return np.asarray(
            cones.centers[:, None, :] + linear_profile(self.dimension, contact, edges) @ cones.axes
        )


@njit(cache=True, error_model="numpy")
def _sound(points, normals, friction):  # type: ignore[no-untyped-def]
    """Whether all numbers are finite, normals of length one, friction zero or more."""
    if points.shape[1] != 2 and points.shape[1] != 3:
        return False
    for i in range(points.shape[0]):
        square = 0.0
        for a in range(points.shape[1]):
            if not np.isfinite(points[i, a]):
                return False
            square += normals[i, a] * normals[i, a]
        if not (abs(square - 1.0) <= 2.0 * UNIT_TOLERANCE and 0.0 <= friction[i] < np.inf):
            return False
    return True


def _refuse_points(points: Floats) -> None:
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(
            f"Expected points of shape (n, 2) or (n, 3), but got shape {points.shape};"
            " pass one row of coordinates per contact."
        )
    points_array(points, points.shape[1])


def _refuse_normals(normals: Floats, points: Floats) -> None:
    points_array(normals, points.shape[1], "normals")
    if len(normals) != len(points):
        raise InputError(
            f"Expected one normal per point, but got {len(normals)} normals for"
            f" {len(points)} points; pass as many as points."
        )
    off = np.abs((normals * normals).sum(axis=1) - 1.0)
    if len(off) and off.max() > 2.0 * UNIT_TOLERANCE:
        worst = int(off.argmax())
        raise InputError(
            f"Expected normals of length one, but row {worst} has length"
            f" {np.linalg.norm(normals[worst]):.6g}; divide each normal by its length."
        )


def _spread_friction(array: Floats, n: int) -> Floats:
    if array.ndim > 1 or (array.ndim == 1 and len(array) != n):
        raise InputError(
            f"Expected one friction coefficient or one for each of {n} contacts, but got shape"
            f" {array.shape}; pass a number or an array of length {n}."
        )
    if not np.all(np.isfinite(array)) or np.any(array < 0.0):
        bad = array[~(np.isfinite(array) & (array >= 0.0))] if array.ndim else array
        raise InputError(
            "Expected friction to be finite and zero or more, but got"
            f" {float(np.ravel(bad)[0]):g}; give a coefficient that is not negative."
        )
    return np.full(n, array)
