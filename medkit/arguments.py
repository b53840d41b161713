"""Checks of arguments that several rooms share, each with one sentence."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, expected

if TYPE_CHECKING:
    import pandas as pd


def whole(value: Any, name: str, least: int = 1) -> int:
    """Return a whole number of at least `least`, or raise `InputError`.

    Examples
    --------
    >>> whole(200, "draws")
    200
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or number < least or number != int(number):
        raise InputError(
            f"Expected {name} to be a whole number of at least {least}, but got {short(value)};"
            " give another one."
        )
    return int(number)


def one_of(value: Any, options: Iterable[str], what: str, remedy: str = "choose one") -> str:
    """Return one of the words `options`, or raise `InputError`.

    Examples
    --------
    >>> one_of("trial", ("subject", "trial"), "leave_out")
    'trial'
    """
    words = tuple(options)
    if not isinstance(value, str) or value not in words:
        raise InputError(
            f"Expected {what} among {', '.join(words)}, but got {short(value)}; {remedy}."
        )
    return value


def generator(rng: Any) -> np.random.Generator:
    """Return a random generator as it is; a seed or anything else raises `InputError`.

    Examples
    --------
    >>> isinstance(generator(np.random.default_rng(0)), np.random.Generator)
    True
    """
    remedy = "pass rng=numpy.random.default_rng(0)"
    return expected(rng, np.random.Generator, "a random generator as rng", remedy)


def file_path(path: Any, what: str) -> Path:
    """Return a path to `what`, which need not exist, or raise `InputError`.

    Examples
    --------
    >>> file_path("meshes", "a folder of meshes").name
    'meshes'
    """
    remedy = "pass a string or a pathlib.Path"
    expected(path, (str, os.PathLike), f"the path of {what}", remedy)
    return Path(path)


def numbers(values: ArrayLike, name: str) -> Floats:
    """Return one number or several as floats of shape (n,), or raise `InputError`.

    Examples
    --------
    >>> numbers(0.5, "friction")
    array([0.5])
    """
    remedy = "pass a list"
    array = np.atleast_1d(number_array(values, name, remedy))
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        raise InputError(f"Expected {name} as finite numbers, but got {short(values)}; {remedy}.")
    return array


def plane_point(value: ArrayLike, name: str) -> Floats:
    """Return a point of the plane, shape (2,), or raise `InputError`.

    Examples
    --------
    >>> plane_point([0, 1], "p1")
    array([0., 1.])
    """
    point = numbers(value, name)
    if len(point) != 2:
        raise InputError(f"Expected {name} as (x, y), but got {len(point)} numbers; pass two.")
    return point


def number_array(values: ArrayLike, what: str, remedy: str) -> Floats:
    """Return numbers as an array of any shape; words and ragged rows raise `InputError`.

    Examples
    --------
    >>> number_array([[0, 1]], "extents", "pass three").shape
    (1, 2)
    """
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Expected {what} as numbers in rows of one length, but got {short(values)}; {remedy}."
        ) from error


def table_with(table: Any, columns: Sequence[str], what: str, remedy: str) -> pd.DataFrame:
    """Return a table as it is; without one of its columns, or no table, raise `InputError`.

    Examples
    --------
    >>> import pandas as pd
    >>> len(table_with(pd.DataFrame({"t": [0.0]}), ["t"], "a table", "pass one"))
    1
    """
    import pandas as pd  # heavy, and needed here alone

    present = list(expected(table, pd.DataFrame, what, remedy).columns)
    absent = [name for name in columns if name not in present]
    if absent:
        raise InputError(
            f"Expected {what} with the columns {', '.join(map(str, columns))}, but"
            f" {str(absent[0])[:40]} is missing; {remedy}."
        )
    return table


def short(value: Any) -> str:
    """Return a value in one line of at most 40 characters, as it would be typed.

    Examples
    --------
    >>> short("claw")
    "'claw'"
    """
    text = " ".join(repr(value).split())
    return text if len(text) <= 40 else text[:36] + " ..."
