"""Friction cones as sets of wrenches: from contacts to centres and axes, round or with edges.

One contact with a unit normal force can push with every force of its friction cone. Written as a
wrench divided into force and scaled torque, that set is an ellipse (a segment in the plane, an
ellipsoid for a soft finger) around a centre::

    w(z) = centre + axes^T z,   |z| <= 1

The convention for linearised cones, which every quality number rests on, is the decision
``docs/decisions/0020-cone-edges.md``: edge k of m is ``n + mu (cos(a) t1 + sin(a) t2)`` with
``a = 2 pi k / m``, where ``t1`` is the part of the lever arm ``p - torque_origin`` at right angles
to the normal, made a unit vector, and ``t2 = n x t1``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any, Literal, Protocol

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, positive

ContactModel = Literal["point", "frictionless", "soft"]

#: A lever arm closer than this to the normal's line gives no tangent direction [rad].
TANGENT_TOLERANCE = 1e-6
#: Radius of the patch with which a soft finger touches, unless the caller knows better [m].
PATCH_RADIUS = 0.005


class CheckedContacts(Protocol):
    """What `medkit.contacts.Contacts` guarantees, as far as cones need it."""

    @property
    def points(self) -> Floats:
        """Shape (n, 3) or (n, 2) [m]."""

    @property
    def normals(self) -> Floats:
        """Inward unit normals, of the same shape."""

    @property
    def friction(self) -> Floats:
        """Shape (n,) [1]."""

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""


@dataclass(frozen=True)
class WrenchCones:
    """Per contact the ellipse of wrenches for a unit normal force: ``centers + axes^T z``.

    ``centers`` (n, D) and ``axes`` (n, k, D) with D = 3 in the plane, 6 in space.
    """

    centers: Floats
    axes: Floats


def wrench_cones(
    contacts: CheckedContacts,
    *,
    torque_origin: ArrayLike,
    torque_scale: float,
    contact: ContactModel = "point",
    patch_radius: float = PATCH_RADIUS,
) -> WrenchCones:
    """Turn contacts into ellipses of wrenches.

    A soft finger presses with even pressure on a disk of `patch_radius` a; sliding of the patch
    starts on the ellipsoid ``|f_t|^2 / mu^2 + torsion^2 / (2/3 mu a)^2 = f_n^2``. In the plane
    torsion has no part, so a soft finger equals a point.
    """
    check_model(contact)
    origin = checked_origin(torque_origin, contacts.dimension)
    scale = positive(torque_scale, "torque_scale", " m")
    patch = positive(patch_radius, "patch_radius", " m") if contact == "soft" else 0.0
    n, d = contacts.points.shape
    centers = np.empty((n, 3 * (d - 1)))
    axes = np.empty((n, axis_count(d, contact), 3 * (d - 1)))
    friction = np.zeros(n) if contact == "frictionless" else contacts.friction
    fill_cones(contacts.points, contacts.normals, friction, patch, origin, scale, centers, axes)
    return WrenchCones(centers, axes)


def axis_count(dimension: int, contact: ContactModel) -> int:
    """How many axes a contact's ellipse has: 1 in the plane, 2 in space, 3 for a soft finger."""
    return 1 if dimension == 2 else 3 if contact == "soft" else 2


def linear_profile(dimension: int, contact: ContactModel, edges: int | None) -> Floats:
    """`cone_profile` of cones that have edges; `InputError` for round ones, which have none."""
    profile = cone_profile(dimension, contact, edges)
    if len(profile):
        return profile
    raise InputError(
        "Expected edges to be a whole number of three or more, but got None; a round cone has no"
        " edges to list, pass for example 32."
    )


def cone_profile(dimension: int, contact: ContactModel, edges: int | None) -> Floats:
    """Points ``z`` on the unit sphere that stand for a contact's ellipse.

    Parameters
    ----------
    dimension : int
        2 or 3.
    contact : {"point", "frictionless", "soft"}
        Contact model.
    edges : int or None
        Edges of a cone; None stands for the exact cone and gives no points in space.

    Returns
    -------
    ndarray, shape (m, k)
        In the plane the two ends of the segment, which is exact. A soft finger gets `edges`
        meridians on ``edges // 2 - 1`` circles of latitude, and the two poles.
    """
    k = axis_count(dimension, contact)
    if contact == "frictionless":
        return np.zeros((1, k))
    if dimension == 2:
        return np.array([[1.0], [-1.0]])
    if edges is None:
        return np.zeros((0, k))
    if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
        raise InputError(
            f"Expected edges to be a whole number of three or more, but got {edges!r};"
            " pass for example 8, or None for the exact cone."
        )
    return _round_profile(int(edges), contact == "soft").copy()


@lru_cache(maxsize=32)
def _round_profile(edges: int, soft: bool) -> Floats:
    turn = 2.0 * np.pi * np.arange(edges) / edges
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if not soft:
        return circle
    steps = max(2, edges // 2)
    rings = [
        np.column_stack([np.cos(angle) * circle, np.full(edges, np.sin(angle))])
        for angle in np.pi * np.arange(1, steps) / steps - np.pi / 2.0
    ]
    return np.vstack([[[0.0, 0.0, -1.0]], *rings, [[0.0, 0.0, 1.0]]])


@njit(cache=True, error_model="numpy")
def tangent_pair(normal, arm, t1, t2):  # type: ignore[no-untyped-def]
    """First tangent along the lever arm's tangential part, or along a world axis without one."""
    along = normal[0] * arm[0] + normal[1] * arm[1] + normal[2] * arm[2]
    length = 0.0
    reach = 0.0
    for a in range(3):
        t1[a] = arm[a] - along * normal[a]
        length += t1[a] * t1[a]
        reach += arm[a] * arm[a]
    if length <= TANGENT_TOLERANCE**2 * reach:
        # no direction is distinguished by this contact alone: take n x e of the smallest |n|
        axis = 0
        for a in range(1, 3):
            if abs(normal[a]) < abs(normal[axis]):
                axis = a
        b, c = (axis + 1) % 3, (axis + 2) % 3
        t1[axis] = 0.0
        t1[b] = normal[c]
        t1[c] = -normal[b]
        length = t1[b] * t1[b] + t1[c] * t1[c]
    for a in range(3):
        t1[a] /= np.sqrt(length)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        t2[a] = normal[b] * t1[c] - normal[c] * t1[b]


@njit(cache=True, error_model="numpy")
def _fill_wrench(force, arm, gain, scale, out):  # type: ignore[no-untyped-def]
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        out[a] = gain * force[a]
        out[3 + a] = gain * (arm[b] * force[c] - arm[c] * force[b]) / scale


@njit(cache=True, error_model="numpy")
def fill_cones(points, normals, friction, patch, origin, scale, centers, axes):  # type: ignore[no-untyped-def]
    """Write the ellipses of one grasp into `centers` (n, D) and `axes` (n, k, D)."""
    t1, t2 = np.empty(3), np.empty(3)
    arm = np.empty(points.shape[1])
    for i in range(points.shape[0]):
        normal, mu = normals[i], friction[i]
        for a in range(arm.shape[0]):
            arm[a] = points[i, a] - origin[a]
        if points.shape[1] == 2:
            centers[i, 0], centers[i, 1] = normal[0], normal[1]
            centers[i, 2] = (arm[0] * normal[1] - arm[1] * normal[0]) / scale
            axes[i, 0, 0], axes[i, 0, 1] = -mu * normal[1], mu * normal[0]
            axes[i, 0, 2] = mu * (arm[0] * normal[0] + arm[1] * normal[1]) / scale
            continue
        tangent_pair(normal, arm, t1, t2)
        _fill_wrench(normal, arm, 1.0, scale, centers[i])
        _fill_wrench(t1, arm, mu, scale, axes[i, 0])
        _fill_wrench(t2, arm, mu, scale, axes[i, 1])
        if axes.shape[1] == 3:
            for a in range(3):
                axes[i, 2, a] = 0.0
                axes[i, 2, 3 + a] = 2.0 / 3.0 * mu * patch * normal[a] / scale


def check_model(contact: Any) -> None:
    """Refuse a contact model that is none of the three."""
    if not isinstance(contact, str) or contact not in ("point", "frictionless", "soft"):
        raise InputError(
            f"Expected contact to be 'point', 'frictionless' or 'soft', but got {contact!r};"
            " use one of the three."
        )


def checked_origin(torque_origin: ArrayLike, dimension: int) -> Floats:
    """Check the point torques are taken about and return it as floats, shape (dimension,)."""
    try:
        origin = np.array(torque_origin, dtype=float)
    except (TypeError, ValueError):
        origin = np.array(np.nan)
    if origin.shape == (dimension,) and isfinite(origin.sum()):
        return origin
    raise InputError(
        f"Expected torque_origin to be {dimension} finite numbers, but got"
        f" {' '.join(str(torque_origin).split())[:60]}; pass one point [m]."
    )
