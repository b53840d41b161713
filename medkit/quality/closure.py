"""Force closure and form closure, and the friction at which closure begins."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog

from medkit.contacts import Contacts
from medkit.geometry import Floats, positive
from medkit.quality.expansion import expand
from medkit.quality.space import LINEAR_GAP, SpaceOptions, wrench_rows, wrench_space
from medkit.wrench_cones import PATCH_RADIUS, ContactModel, checked_origin


def is_force_closure(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    friction: ArrayLike,
    torque_origin: ArrayLike | None = None,
    torque_scale: float | None = None,
    edges: int | None = 8,
    contact: ContactModel = "point",
    patch_radius: float = PATCH_RADIUS,
) -> bool:
    """Whether the contacts can resist every wrench, however small.

    The origin must lie strictly inside the wrench space: a ball of 1e-10 of the longest wrench
    has to fit, so a grasp on the very edge (cones that just touch) is not force-closure.

    Parameters
    ----------
    points : array-like, shape (n, 3) or (n, 2)
        Contact points [m].
    normals : array-like, same shape
        Inward unit normals [1].
    friction : float or array-like, shape (n,)
        Coulomb coefficients [1].
    torque_origin : array-like, optional
        Point the cone edges are turned by, see `medkit.contacts` [m]; the mean of the points by
        default. In the plane and for exact cones the answer does not depend on it.
    torque_scale : float, optional
        Length torques are divided by [m], only for conditioning; the largest distance of a point
        from the torque origin by default.
    edges : int or None
        Edges of a linearised cone; None for the exact cone.
    contact : {"point", "frictionless", "soft"}
        Contact model.
    patch_radius : float
        Radius of a soft finger's patch [m].

    Returns
    -------
    bool
        False also for too few contacts and for none.

    Raises
    ------
    InputError
        For arguments out of their range; see `Contacts`.

    Notes
    -----
    Decided by the expanding polytope of `epsilon`, which stops as soon as it holds the origin or
    a plane keeps the origin out. Sources: P13 4.2.1 and 4.6.2.

    Examples
    --------
    >>> points, normals = [[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]]
    >>> is_force_closure(points, normals, friction=0.1)
    True
    >>> is_force_closure(points, normals, friction=0.0)
    False
    """
    contacts = Contacts(points, normals, friction)
    origin, scale = torque_frame(contacts, torque_origin, torque_scale)
    options = SpaceOptions(
        edges=edges, contact=contact, patch_radius=patch_radius, tolerance=LINEAR_GAP
    )
    space = wrench_space(contacts, origin, scale, options)
    return expand(space, closure_only=True).lower > 0.0


def is_form_closure(points: ArrayLike, normals: ArrayLike) -> bool:
    """Whether the contacts hold the object without any friction (first-order form closure).

    Needs at least four contacts in the plane and seven in space.

    Parameters
    ----------
    points, normals : array-like, shape (n, 3) or (n, 2)
        As in `is_force_closure` [m], [1]; the tolerance is the same, too.

    Returns
    -------
    bool
        False also for too few contacts.

    Raises
    ------
    InputError
        See `Contacts`.

    Examples
    --------
    >>> normals = [[1, 0], [-1, 0], [0, -1], [0, 1]]
    >>> is_form_closure([[-1, 0.5], [1, -0.5], [-0.5, 1], [0.5, -1]], normals)
    True
    >>> is_form_closure([[-1, 0.0], [1, 0.0], [0.0, 1], [0.0, -1]], normals)
    False
    """
    return is_force_closure(points, normals, friction=0.0, contact="frictionless")


def torque_frame(
    contacts: Contacts, torque_origin: ArrayLike | None, torque_scale: float | None
) -> tuple[Floats, float]:
    """The torque origin and scale, or the mean of the points and the largest distance from it."""
    if torque_origin is None:
        torque_origin = (
            contacts.points.mean(axis=0) if len(contacts) else np.zeros(contacts.dimension)
        )
    origin = checked_origin(torque_origin, contacts.dimension)
    if torque_scale is None:
        reach = np.linalg.norm(contacts.points - origin, axis=1).max(initial=0.0)
        return origin, float(reach) if reach > 0.0 else 1.0
    return origin, positive(torque_scale, "torque_scale", " m")


def closure_margin(wrenches: ArrayLike) -> float:
    """Decide closure by linear programming: the margin is above zero for force closure.

    The largest t for which convex weights, each at least t, balance the wrenches; 0.0 if the
    wrenches do not span the space or do not balance at all. An independent road to the answer of
    `is_force_closure`, through HiGHS.

    Parameters
    ----------
    wrenches : array-like, shape (n, m, D) or (n, D)
        Primitive wrenches, for example from `Contacts.wrenches`.

    Returns
    -------
    float
        Margin [1], at most 1 / number of wrenches.

    Raises
    ------
    InputError
        If the wrenches are not finite numbers of one of these shapes.

    Examples
    --------
    >>> corners = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])
    >>> round(closure_margin(corners), 3), closure_margin(corners + [2.0, 0.0])
    (0.333, 0.0)
    """
    rows = wrench_rows(wrenches)
    if len(rows) == 0 or np.linalg.matrix_rank(rows, tol=1e-9) < rows.shape[1]:
        return 0.0
    count = len(rows)
    # weights are t + slack: sum (t + s_i) w_i = 0, count t + sum s_i = 1
    balance = np.column_stack([rows.T, rows.sum(axis=0)])
    equality = np.vstack([balance, np.append(np.ones(count), count)])
    answer = linprog(
        np.append(np.zeros(count), -1.0),
        A_eq=equality,
        b_eq=np.append(np.zeros(rows.shape[1]), 1.0),
        bounds=(0.0, None),
        method="highs",
    )
    return float(answer.x[-1]) if answer.status == 0 else 0.0


class CriticalFriction(float):
    """The smallest friction coefficient that closes a grasp, with how it was come by.

    A float (the upper end of the bracket, at which the grasp is force-closure; nan when no
    friction helps) that also knows:

    ``outcome``: "found"; "frictionless" when the grasp needs no friction (value 0.0); "none"
    when even `largest` does not close it. ``lower``: largest coefficient tried that does not
    close it (equal to `largest` for "none").
    """

    outcome: Literal["found", "frictionless", "none"]
    lower: float

    def __new__(
        cls, value: float, outcome: Literal["found", "frictionless", "none"], lower: float
    ) -> CriticalFriction:
        """Make the number and hang the account of it on."""
        number = super().__new__(cls, value)
        number.outcome, number.lower = outcome, lower
        return number


def critical_friction(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    torque_origin: ArrayLike | None = None,
    edges: int | None = None,
    contact: ContactModel = "point",
    patch_radius: float = PATCH_RADIUS,
    largest: float = 1000.0,
    tolerance: float = 1e-9,
) -> CriticalFriction:
    """Smallest friction coefficient, the same at every contact, that gives force closure.

    Bisection over the half-angle of the cone, as closure never ends when friction grows.

    Parameters
    ----------
    points, normals, torque_origin, edges, contact, patch_radius
        As in `is_force_closure`, but with exact cones by default.
    largest : float
        Coefficient beyond which friction is no longer believed in [1].
    tolerance : float
        Width of the bracket in the cone's half-angle [rad].

    Returns
    -------
    CriticalFriction
        A float, see there for its outcome.

    Raises
    ------
    InputError
        For arguments out of their range; see `Contacts`.

    Examples
    --------
    >>> wedge = np.deg2rad(30.0)  # flanks that meet at 60 deg
    >>> normals = [[np.cos(wedge), np.sin(wedge)], [-np.cos(wedge), np.sin(wedge)]]
    >>> round(critical_friction([[-1.0, 0.0], [1.0, 0.0]], normals), 6)
    0.57735
    """
    contacts = Contacts(points, normals, 0.0)

    def closed(half_angle: float) -> bool:
        return is_force_closure(
            contacts.points, contacts.normals, friction=float(np.tan(half_angle)),
            torque_origin=torque_origin, edges=edges, contact=contact, patch_radius=patch_radius,
        )  # fmt: skip

    low, high = 0.0, float(np.arctan(positive(largest, "largest")))
    width = positive(tolerance, "tolerance", " rad")
    if closed(low):
        return CriticalFriction(0.0, "frictionless", 0.0)
    if not closed(high):
        return CriticalFriction(np.nan, "none", largest)
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if closed(middle) else (middle, high)
    return CriticalFriction(np.tan(high), "found", float(np.tan(low)))
