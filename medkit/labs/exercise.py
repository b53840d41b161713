"""What an exercise is, what a verdict says, and how a check asks for a property."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

#: Cases a student sees, and cases a grader draws besides them.
OPEN_CASES, HIDDEN_CASES = 20, 200

NOTHING = "nothing comes back yet: replace the ... by your answer"
NO_RETURN = "nothing comes back: end the function with return; what it prints is not its answer"


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
            code = getattr(answer, "__code__", None)
            line = getattr(error, "line", None) or line_of(
                error, {getattr(code, "co_filename", "")}
            )
            where = f" in line {line}" if line else ""
            hint = f"{self.function} stopped{where} with {type(error).__name__}: {words}"
            return Verdict(self.name, False, hint.rstrip(": "))
        return Verdict(self.name, True)


def require(condition: Any, hint: str) -> None:
    """Raise `Miss(hint)` unless the property holds."""
    if not bool(np.all(condition)):
        raise Miss(hint)


def line_of(error: BaseException, files: Collection[str]) -> int | None:
    """Return the last line of one of the `files` that the error passed through."""
    steps = traceback.walk_tb(error.__traceback__)
    lines = [line for frame, line in steps if frame.f_code.co_filename in files]
    return lines[-1] if lines else None


def something(value: Any) -> Any:
    """Return an answer as it is, or raise `Miss` where nothing came back."""
    require(value is not Ellipsis, NOTHING)
    require(value is not None, NO_RETURN)
    return value


def array(value: Any, shape: tuple[int, ...], name: str) -> Any:
    """Return an answer as a float array of `shape`, or raise `Miss`."""
    wanted = f"an array of shape {shape}" if shape else "a single number"
    something(value)
    try:
        if np.iscomplexobj(value) and near(np.imag(value), 0.0, 0.0):
            value = np.real(value)
        result = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        came = repr(value) if len(repr(value)) < 40 else f"a {type(value).__name__}"
        raise Miss(f"expected {wanted} for {name}, but {came} came back") from None
    came = f"an array of shape {result.shape}" if result.ndim else "a single number"
    require(result.shape == shape, f"expected {wanted} for {name}, but {came} came back")
    require(np.isfinite(result), f"expected finite numbers in {name}, but one is not")
    return result


def number(value: Any, name: str) -> float:
    """Return an answer as a float, or raise `Miss`."""
    return float(array(value, (), name))


def near(value: Any, target: Any, tolerance: float = 1e-6) -> bool:
    """Whether all numbers agree within an absolute `tolerance`."""
    return bool(np.all(np.abs(np.asarray(value, dtype=float) - np.asarray(target)) <= tolerance))
