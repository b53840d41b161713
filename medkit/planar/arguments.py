"""Checks of arguments that several files of the plane need, each with one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats


def whole(value: Any, name: str, least: int = 1) -> int:
    """Return a whole number of at least `least`, or raise `InputError`.

    Examples
    --------
    >>> whole(5.0, "corners", 3)
    5
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not number >= least or number != int(min(number, 2.0**53)):
        raise InputError(
            f"Expected {name} to be a whole number of at least {least}, but got {str(value)[:40]};"
            " give another one."
        )
    return int(number)


def numbers(values: ArrayLike, name: str) -> Floats:
    """Return one number or several as floats of shape (n,), or raise `InputError`."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        array = np.array([np.nan])
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        raise InputError(
            f"Expected {name} to be finite numbers, but got {str(values)[:40]}; pass a list."
        )
    return array


def place(value: ArrayLike, name: str) -> Floats:
    """Return a point of the plane, shape (2,), or raise `InputError`."""
    point = numbers(value, name)
    if len(point) != 2:
        raise InputError(f"Expected {name} to be (x, y), but got {len(point)} numbers; pass two.")
    return point


def choice(value: Any, options: Sequence[str], name: str) -> str:
    """Return one of the words `options`, or raise `InputError`."""
    if not isinstance(value, str) or value not in options:
        raise InputError(
            f"Expected {name} to be one of {', '.join(options)}, but got {str(value)[:40]};"
            " choose one."
        )
    return value
