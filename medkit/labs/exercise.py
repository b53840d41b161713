"""What an exercise is, what a verdict says, and how a check asks for a property."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

#: Cases a student sees, and cases a grader draws besides them.
OPEN_CASES, HIDDEN_CASES = 20, 200

NOTHING = "nothing comes back yet: replace the ... by your answer"


class Miss(Exception):
    """A property that an answer misses; the message is the hint."""


@dataclass(frozen=True)
class Verdict:
    """Whether an answer passed, and the hint if it did not."""

    exercise: str
    passed: bool
    hint: str = ""

    def __repr__(self) -> str:
        return f"{self.exercise} passed" if self.passed else f"{self.exercise} not yet: {self.hint}"


@dataclass(frozen=True)
class Exercise:
    """One exercise: its name, the function the student writes, and the check of its properties.

    `check(answer, rng, cases)` raises `Miss` with a hint, or returns when all is well.
    """

    name: str
    function: str
    check: Callable[[Callable[..., Any], np.random.Generator, int], None]

    def verdict(self, answer: Any, rng: np.random.Generator, cases: int) -> Verdict:
        """Check one answer; whatever it raises becomes a hint, never a traceback."""
        if not callable(answer):
            return Verdict(self.name, False, f"expected the function {self.function}; define it")
        try:
            self.check(answer, rng, cases)
        except Miss as miss:
            return Verdict(self.name, False, str(miss))
        except Exception as error:
            # a student's function may raise anything; the kind and the words are the best hint
            words = " ".join(str(error).split())[:120]
            return Verdict(
                self.name, False, f"{self.function} stopped with {type(error).__name__}: {words}"
            )
        return Verdict(self.name, True)


def require(condition: Any, hint: str) -> None:
    """Raise `Miss(hint)` unless the property holds."""
    if not bool(np.all(condition)):
        raise Miss(hint)


def array(value: Any, shape: tuple[int, ...], name: str) -> Any:
    """Return an answer as a float array of `shape`, or raise `Miss`."""
    if value is None or value is Ellipsis:
        raise Miss(NOTHING)
    result = np.asarray(value, dtype=float)
    require(
        result.shape == shape, f"expected {name} of shape {shape}, but it has shape {result.shape}"
    )
    require(np.isfinite(result), f"expected finite numbers in {name}, but one is not")
    return result


def number(value: Any, name: str) -> float:
    """Return an answer as a float, or raise `Miss`."""
    return float(array(value, (), name))


def near(value: Any, target: Any, tolerance: float = 1e-6) -> bool:
    """Whether all numbers agree within an absolute `tolerance`."""
    return bool(np.all(np.abs(np.asarray(value, dtype=float) - np.asarray(target)) <= tolerance))
