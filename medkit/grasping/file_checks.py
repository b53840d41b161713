"""What may stand in a grasp file: every check names the place in its sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from medkit.arguments import short
from medkit.errors import InputError
from medkit.geometry import Floats

#: How far a rotation or a direction in a file may be from one [1]; files may be rounded.
ROUNDING = 1e-4


def numbers(entry: Any, key: str, shape: tuple[int, ...], place: str) -> Floats:
    """Finite numbers of a shape under `key`, or `InputError`.

    Examples
    --------
    >>> numbers({"point": [1, 2, 3]}, "point", (3,), "a file")
    array([1., 2., 3.])
    """
    value = entry.get(key) if isinstance(entry, Mapping) else None
    try:
        array = np.array(np.nan if isinstance(value, str | bool) else value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = np.array(np.nan)
    if array.shape == shape and np.isfinite(array).all():
        return array
    wanted = f"finite numbers of shape {shape}" if shape else "a finite number"
    raise InputError(
        f"Expected {wanted} for {key!r} in {place}, but got {short(value)}; correct the entry."
    )


def number(entry: Any, key: str, place: str, *, least: float = -np.inf) -> float:
    """One finite number under `key`, at least `least`, or `InputError`."""
    value = float(numbers(entry, key, (), place))
    if value < least:
        raise InputError(
            f"Expected {key!r} in {place} to be at least {least:g}, but got {value:g}; correct the"
            " entry."
        )
    return value


def unit_vector(entry: Any, key: str, place: str) -> Floats:
    """Three numbers of length one under `key`, or `InputError`."""
    vector = numbers(entry, key, (3,), place)
    length = float(np.linalg.norm(vector))
    if abs(length - 1.0) > ROUNDING:
        raise InputError(
            f"Expected {key!r} in {place} to be of length one, but got length {length:.6g}; divide"
            " it by its length."
        )
    return vector


def rigid(entry: Any, key: str, place: str) -> Floats:
    """A rigid transform (4, 4) under `key`, or `InputError`."""
    pose = numbers(entry, key, (4, 4), place)
    if is_rigid(pose):
        return pose
    raise InputError(
        f"Expected {key!r} in {place} to be a rigid transform, rotation and translation above a"
        " row 0, 0, 0, 1, but it is none; correct the entry."
    )


def is_rigid(pose: Floats) -> bool:
    """Whether a matrix (4, 4) is a rotation and a translation, up to what files round off.

    Examples
    --------
    >>> is_rigid(np.eye(4)), is_rigid(2.0 * np.eye(4)), is_rigid(np.diag([-1.0, 1, 1, 1]))
    (True, False, False)
    """
    turn = pose[:3, :3]
    if np.abs(turn).max() > 2.0 or np.abs(pose[3] - [0.0, 0.0, 0.0, 1.0]).max() > ROUNDING:
        return False
    return bool(np.abs(turn.T @ turn - np.eye(3)).max() <= ROUNDING and np.linalg.det(turn) > 0.0)


def counted(entry: Any, key: str, place: str) -> dict[str, int]:
    """Whole numbers by name under `key`, none where it is left out, or `InputError`."""
    section = entry.get(key, {})
    if not isinstance(section, Mapping):
        raise InputError(
            f"Expected numbers by name for {key!r} in {place}, but got {short(section)}; correct"
            " the entry."
        )
    return {name: whole(section, name, f"{key} in {place}") for name in section}


def whole(entry: Any, key: str, place: str) -> int:
    """A whole number, zero or more, under `key`, or `InputError`."""
    value = number(entry, key, place, least=0.0)
    if value != int(value):
        raise InputError(
            f"Expected a whole number for {key!r} in {place}, but got {value:g}; correct the entry."
        )
    return int(value)


def texts(entry: Any, key: str, place: str) -> tuple[str, ...]:
    """A list of texts under `key`, or `InputError`."""
    value = entry.get(key)
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise InputError(
            f"Expected a list of texts for {key!r} in {place}, but got {short(value)}; correct the"
            " entry."
        )
    return tuple(value)
