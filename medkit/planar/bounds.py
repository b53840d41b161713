"""The statics of two contacts: friction cone, chord, object angle, and the bound that ties them."""

from __future__ import annotations

import math

from medkit.errors import InputError
from medkit.geometry import nonnegative


def cone_half_angle(friction: float) -> float:
    """Half-angle of the Coulomb friction cone.

    Parameters
    ----------
    friction : float
        Coefficient of static friction [1], zero or more.

    Returns
    -------
    float
        Angle beta between the contact normal and the cone's edge [rad], tan(beta) = friction.

    Raises
    ------
    InputError
        If `friction` is negative or not finite.

    Notes
    -----
    Source: P13 4.2.1, equation 4.1.

    Examples
    --------
    >>> round(math.degrees(cone_half_angle(1.0)), 9)
    45.0
    """
    return math.atan(nonnegative(friction, "friction"))


def min_object_angle(friction: float) -> float:
    """Object angle that a two-finger grasp has to exceed to be force-closure.

    Two fingers at the touch points of a medial disk with object angle alpha push along the chord
    between them. The chord makes the angle (pi - alpha) / 2 with both contact normals, and the
    grasp is force-closure when it lies strictly inside both friction cones.

    Parameters
    ----------
    friction : float
        Coefficient of static friction between finger and object [1], zero or more.

    Returns
    -------
    float
        pi - 2 atan(friction) [rad]. At equality the grasp is not force-closure.

    Raises
    ------
    InputError
        If `friction` is negative or not finite.

    Notes
    -----
    Source: P13 4.2.1, equation 4.4, after Nguyen 1988.

    Examples
    --------
    >>> round(math.degrees(min_object_angle(1.0)), 9)
    90.0
    """
    return math.pi - 2.0 * cone_half_angle(friction)


def min_friction(object_angle: float) -> float:
    """Friction that a grasp at an object angle has to exceed: the bound, read the other way.

    Parameters
    ----------
    object_angle : float
        Object angle alpha of the medial disk [rad], in (0, pi].

    Returns
    -------
    float
        tan((pi - alpha) / 2) [1].

    Raises
    ------
    InputError
        If `object_angle` is not within (0, pi].

    Examples
    --------
    >>> round(min_friction(math.radians(120.0)), 6)
    0.57735
    """
    angle = nonnegative(object_angle, "object_angle", " rad")
    if not 0.0 < angle <= math.pi:
        raise InputError(
            f"Expected an object angle above 0 and up to pi rad, but got {angle:g} rad;"
            " pass radians, not degrees."
        )
    return math.tan((math.pi - angle) / 2.0)


def is_antipodal(object_angle: float, *, friction: float) -> bool:
    """Decide by the bound whether two fingers on a medial disk can hold the object.

    Parameters
    ----------
    object_angle : float
        Object angle of the disk [rad], in (0, pi].
    friction : float
        Coefficient of static friction [1].

    Returns
    -------
    bool
        True when `object_angle` is strictly above the bound.

    Raises
    ------
    InputError
        If `friction` or the angle is negative or not finite.

    Examples
    --------
    >>> is_antipodal(math.radians(100.0), friction=1.0)
    True
    """
    angle = nonnegative(object_angle, "object_angle", " rad")
    return bool(angle > min_object_angle(friction))
