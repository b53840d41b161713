"""Frames, unit vectors, rigid transforms, and the checks that arguments pass through.

``T_a_b`` maps coordinates of frame b into frame a. Everything is in metres and radians.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.errors import InputError

Floats = NDArray[np.float64]
Kind = TypeVar("Kind")


def expected(value: Any, kind: type[Kind] | tuple[type[Kind], ...], what: str, remedy: str) -> Kind:
    """Check that an argument is of a type, and return it as it is.

    Parameters
    ----------
    value : object
        What was passed.
    kind : type or tuple of types
        The type that it should have.
    what : str
        What was expected, for the sentence: "a hand".
    remedy : str
        What to do, without a full stop.

    Returns
    -------
    object
        `value` itself.

    Raises
    ------
    InputError
        If it is of another type.

    Examples
    --------
    >>> expected([1, 2], list, "a list", "put it into brackets")
    [1, 2]
    """
    if isinstance(value, kind):
        return value
    raise InputError(f"Expected {what}, but got {_in_words(value)}; {remedy}.")


def _in_words(value: Any) -> str:
    """Name a value by its type and, where that is short, by what it holds."""
    if value is None:
        return "None"
    kind = type(value)
    rooms = kind.__module__.split(".")
    home = ".".join(rooms[: 2 if rooms[0] == "medkit" else 1])
    name = kind.__name__ if home in ("builtins", "__main__") else f"{home}.{kind.__name__}"
    if isinstance(value, str | int | float):
        text = repr(value)
        return f"the {name} {text if len(text) <= 40 else text[:36] + '...'}"
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        return f"a {name} of {len(value)}"
    return f"a {name}"


def unit(vectors: ArrayLike) -> Floats:
    """Scale vectors to length one.

    Parameters
    ----------
    vectors : array-like, shape (..., d)
        Vectors of non-zero length [any unit].

    Returns
    -------
    ndarray, shape (..., d)
        Unit vectors [1].

    Raises
    ------
    InputError
        If a vector has zero or non-finite length.

    Examples
    --------
    >>> unit([3.0, 0.0, 4.0])
    array([0.6, 0. , 0.8])
    """
    array = np.asarray(vectors, dtype=float)
    length = np.linalg.norm(array, axis=-1, keepdims=True)
    if not np.all(np.isfinite(length)) or np.any(length == 0.0):
        raise InputError(
            "Expected vectors of finite, non-zero length, but got at least one of length"
            f" {float(length[~(np.isfinite(length) & (length > 0))][0])}; remove it."
        )
    return np.asarray(array / length)


def points_array(points: ArrayLike, dimension: int, name: str = "points") -> Floats:
    """Check an array of points and return it as floats.

    Parameters
    ----------
    points : array-like, shape (n, dimension)
        Coordinates [m].
    dimension : int
        Number of columns that is expected.
    name : str
        What the array is called in the error message.

    Returns
    -------
    ndarray, shape (n, dimension)
        The same numbers as float64.

    Raises
    ------
    InputError
        If it does not hold numbers, the shape differs or a number is not finite.
    """
    try:
        array = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Expected {name} to be rows of {dimension} numbers, but got {_in_words(points)} that"
            f" cannot be read so; pass one row of {dimension} coordinates per point."
        ) from error
    if array.ndim != 2 or array.shape[1] != dimension:
        raise InputError(
            f"Expected {name} of shape (n, {dimension}), but got shape {array.shape};"
            f" pass one row of {dimension} coordinates per point."
        )
    if not np.all(np.isfinite(array)):
        raise InputError(
            f"Expected finite numbers in {name}, but row"
            f" {int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])} is not; remove it."
        )
    return array


def nonnegative(value: Any, name: str, unit_text: str = "") -> float:
    """Check that a number is finite and not below zero, and return it as a float.

    Raises
    ------
    InputError
        If it is not.

    Examples
    --------
    >>> nonnegative(0.5, "friction")
    0.5
    """
    number = _number(value, name)
    if not number >= 0.0:
        raise InputError(
            f"Expected {name} to be zero or more, but got {number:g}{unit_text};"
            " give a number that is not negative."
        )
    return number


def positive(value: Any, name: str, unit_text: str = "") -> float:
    """Check that a number is finite and above zero, and return it as a float.

    Raises
    ------
    InputError
        If it is not.
    """
    number = _number(value, name)
    if not number > 0.0:
        raise InputError(
            f"Expected {name} to be above zero, but got {number:g}{unit_text};"
            " give a positive number."
        )
    return number


def _number(value: Any, name: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Expected {name} to be a number, but got {value!r}; give a single number."
        ) from error
    if not np.isfinite(number):
        raise InputError(f"Expected {name} to be finite, but got {number}; give a finite number.")
    return number


def transform(rotation: ArrayLike, translation: ArrayLike) -> Floats:
    """Assemble homogeneous transforms from rotations and translations.

    Parameters
    ----------
    rotation : array-like, shape (..., 3, 3)
        Rotation matrices [1].
    translation : array-like, shape (..., 3)
        Translations [m].

    Returns
    -------
    ndarray, shape (..., 4, 4)
        ``T_a_b`` with ``x_a = T_a_b @ [x_b, 1]``.
    """
    rotations = np.asarray(rotation, dtype=float)
    result = np.zeros((*rotations.shape[:-2], 4, 4))
    result[..., :3, :3] = rotations
    result[..., :3, 3] = translation
    result[..., 3, 3] = 1.0
    return result


def inverse(T_a_b: ArrayLike) -> Floats:
    """Invert rigid transforms: ``T_b_a`` from ``T_a_b``, shape (..., 4, 4)."""
    pose = np.asarray(T_a_b, dtype=float)
    turned = np.swapaxes(pose[..., :3, :3], -1, -2)
    return transform(turned, -np.einsum("...ij,...j->...i", turned, pose[..., :3, 3]))


def apply(T_a_b: ArrayLike, points_b: ArrayLike) -> Floats:
    """Map points of shape (n, 3) [m] from frame b into frame a by one transform (4, 4)."""
    pose = np.asarray(T_a_b, dtype=float)
    return np.asarray(np.asarray(points_b, dtype=float) @ pose[:3, :3].T + pose[:3, 3])


def rotation_about(axis: ArrayLike, angle: float) -> Floats:
    """Rotation matrix (3, 3) about a unit `axis` (3,) by `angle` [rad], after Rodrigues.

    Examples
    --------
    >>> rotation_about([0, 0, 1], np.pi / 2).round(12) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    x, y, z = unit(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def random_rotation(rng: np.random.Generator) -> Floats:
    """Rotation matrix (3, 3), uniform over all rotations, from `rng`."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0.0:
        q[:, 0] = -q[:, 0]
    return np.asarray(q)


def perpendicular(vectors: ArrayLike) -> Floats:
    """For each unit vector of shape (..., 3) one unit vector at right angles to it."""
    array = np.asarray(vectors, dtype=float)
    smallest = np.argmin(np.abs(array), axis=-1)
    helper = np.eye(3)[smallest]
    return unit(np.cross(array, helper))
