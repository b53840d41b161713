"""Force closure in the plane: the measures of `medkit.quality`, with an outline's own defaults."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from medkit import quality
from medkit.arguments import one_of, plane_point
from medkit.contacts import Contacts
from medkit.geometry import Floats, points_array
from medkit.planar.outlines import Outline, checked_outline


def is_force_closure(
    points: ArrayLike, normals: ArrayLike, *, friction: ArrayLike, outline: Outline | None = None
) -> bool:
    """Whether planar contacts can resist every push and twist, however small.

    Parameters
    ----------
    points : array-like, shape (n, 2)
        Contact points [m].
    normals : array-like, shape (n, 2)
        Unit normals into the object [1].
    friction : float or array-like, shape (n,)
        Coulomb coefficients [1].
    outline : Outline, optional
        The object; it sets origin and length of the torques, which condition the test but do
        not change its answer.

    Returns
    -------
    bool
        True when the origin lies strictly inside the hull of the primitive wrenches; the
        tolerance is that of :func:`medkit.quality.is_force_closure`.

    Raises
    ------
    InputError
        For shapes, normals or friction out of their range.

    Notes
    -----
    Source: P13 4.2.1 and 4.6.2; with two contacts it agrees with Nguyen's antipodal theorem.

    Examples
    --------
    >>> is_force_closure([[-1, 0], [1, 0]], [[1, 0], [-1, 0]], friction=0.1)
    True
    """
    place, normal = points_array(points, 2), points_array(normals, 2, "normals")
    origin, scale = _torques(place, outline, None, None)
    return bool(
        quality.is_force_closure(
            place, normal, friction=friction, torque_origin=origin, torque_scale=scale
        )
    )


def is_form_closure(points: ArrayLike, normals: ArrayLike) -> bool:
    """Whether contacts hold without any friction; in the plane that takes four or more.

    Parameters
    ----------
    points, normals : array-like, shape (n, 2)
        Contact points [m] and unit normals into the object [1].

    Returns
    -------
    bool
        Force closure of the frictionless contacts.
    """
    return bool(
        quality.is_form_closure(points_array(points, 2), points_array(normals, 2, "normals"))
    )


def epsilon(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    friction: ArrayLike,
    outline: Outline | None = None,
    torque_origin: ArrayLike | None = None,
    torque_scale: float | None = None,
    norm: Literal["l1", "linf"] = "l1",
) -> quality.Epsilon:
    """Radius of the largest ball of wrenches that the contacts resist.

    Parameters
    ----------
    points, normals : array-like, shape (n, 2)
        Contact points [m] and unit normals into the object [1].
    friction : float or array-like, shape (n,)
        Coulomb coefficients [1].
    outline : Outline, optional
        The object: torques are taken about its centre of mass and divided by its largest
        distance from there, unless the two arguments below say otherwise.
    torque_origin : array-like, shape (2,), optional
        Point the torques are taken about [m]; without an outline the mean of the points.
    torque_scale : float, optional
        Characteristic length [m]; without an outline the largest distance of a contact point
        from the origin.
    norm : {"l1", "linf"}
        Sum of the normal forces at most 1 N, or each of them.

    Returns
    -------
    medkit.quality.Epsilon
        With ``.lower`` and ``.upper``, both 0.0 without force closure.

    Raises
    ------
    InputError
        For shapes, normals, friction or lengths out of their range.

    Examples
    --------
    >>> round(epsilon([[-1, 0], [1, 0]], [[1, 0], [-1, 0]], friction=1.0).lower, 6)
    0.57735
    """
    place, normal = points_array(points, 2), points_array(normals, 2, "normals")
    one_of(norm, ("l1", "linf"), "norm")
    origin, scale = _torques(place, outline, torque_origin, torque_scale)
    return quality.epsilon(
        place, normal, friction=friction, torque_origin=origin, torque_scale=scale, norm=norm
    )


def volume(
    points: ArrayLike, normals: ArrayLike, *, friction: ArrayLike, outline: Outline
) -> float:
    """Volume of the planar wrench space (l1) about the outline's centre of mass [N^3].

    Torques are divided by the outline's characteristic length.
    """
    outline = checked_outline(outline)
    return float(
        quality.volume(
            points_array(points, 2), points_array(normals, 2, "normals"), friction=friction,
            torque_origin=outline.center_mass, torque_scale=outline.characteristic_length,
        )
    )  # fmt: skip


def critical_friction(points: ArrayLike, normals: ArrayLike) -> quality.CriticalFriction:
    """Friction above which planar contacts are force-closure.

    Parameters
    ----------
    points, normals : array-like, shape (n, 2)
        Contact points [m] and unit normals into the object [1].

    Returns
    -------
    medkit.quality.CriticalFriction
        A float [1], nan when no friction helps, that also says how it was found.

    Examples
    --------
    >>> from medkit.planar.shapes import wedge
    >>> touch = wedge(np.radians(120.0), radius=0.02)[1]
    >>> round(float(critical_friction(touch, -touch / 0.02)), 6)
    0.57735
    """
    return quality.critical_friction(
        points_array(points, 2), points_array(normals, 2, "normals"), torque_origin=None
    )


def primitive_wrenches(
    points: ArrayLike, normals: ArrayLike, *, friction: float, outline: Outline
) -> Floats:
    """Wrenches [fx, fy, torque] of both cone edges of each contact, normal force one.

    Parameters
    ----------
    points, normals : array-like, shape (n, 2)
        Contact points [m] and unit normals into the object [1].
    friction : float
        Coulomb coefficient [1].
    outline : Outline
        Torques are about its centre of mass and divided by its characteristic length.

    Returns
    -------
    ndarray, shape (2 n, 3)
        Forces [N] and torque over length [N].

    Raises
    ------
    InputError
        For shapes, normals or friction out of their range.
    """
    outline = checked_outline(outline)
    contacts = Contacts(
        points_array(points, 2), points_array(normals, 2, "normals"), friction=friction
    )
    wrenches = contacts.wrenches(
        torque_origin=outline.center_mass, torque_scale=outline.characteristic_length
    )
    return wrenches.reshape(-1, 3)


def _torques(
    points: Floats, outline: Outline | None, origin: ArrayLike | None, scale: float | None
) -> tuple[Floats, float]:
    outline = checked_outline(outline) if outline is not None else None
    if origin is not None:
        about = plane_point(origin, "torque_origin")
    else:
        about = outline.center_mass if outline is not None else points.mean(axis=0)
    if scale is not None:
        return about, scale
    if outline is not None:
        return about, outline.characteristic_length
    reach = float(np.linalg.norm(points - about, axis=1).max()) if len(points) else 0.0
    return about, reach if reach > 0.0 else 1.0
