"""All labs by name, and the check that a notebook calls."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from medkit.errors import InputError
from medkit.labs.exercise import OPEN_CASES, Exercise, Verdict

LABS = ("planar", "medial", "planner", "statistics")


def lab_names() -> tuple[str, ...]:
    """Return the names of all labs."""
    return LABS


def exercises_of(lab: str) -> tuple[Exercise, ...]:
    """Return the exercises of one lab, in their order."""
    if lab not in LABS:
        raise InputError(
            f"Expected one of the labs {', '.join(LABS)}, but got {lab!r}; check the spelling."
        )
    exercises: tuple[Exercise, ...] = importlib.import_module(f"medkit.labs.{lab}").EXERCISES
    return exercises


def check(name: str, answer: Any) -> Verdict:
    """Check an answer to one exercise, with open cases that are the same at every call.

    Parameters
    ----------
    name : str
        Lab and number, for example ``"planar-2"``.
    answer : callable
        The student's function.

    Returns
    -------
    Verdict
        Shown by a notebook as ``planar-2 passed`` or as a hint.
    """
    for exercise in exercises_of(name.rpartition("-")[0]):
        if exercise.name == name:
            return exercise.verdict(answer, np.random.default_rng(0), OPEN_CASES)
    raise InputError(
        f"Expected an exercise such as 'planar-1', but got {name!r}; check the number."
    )
