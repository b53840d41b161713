"""Grading a folder of submissions: the notebook's own checks with hidden cases and a time limit.

The cases and the verdict stay in this process; a submission answers call by call in another one,
with limits of processor time and memory. It still runs with your rights: grade where you would open
the notebook.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import numpy as np

from medkit.errors import InputError
from medkit.labs.exercise import HIDDEN_CASES, Exercise, Verdict
from medkit.labs.registry import LABS, exercises_of
from medkit.labs.worker import decoded, definitions, encoded

TIME_LIMIT = 20.0  # [s] of computing an exercise may take
START = 120.0  # [s] by the clock for a slow machine to start and to import
#: How the system ends a process that has used up its processor time.
SIGNALS_OF_TIME = (-getattr(signal, "SIGKILL", 9), -getattr(signal, "SIGXCPU", 24))


def submissions(folder: Path) -> list[Path]:
    """Return the notebooks of a folder and of its subfolders, sorted by name."""
    if not folder.is_dir():
        raise InputError(
            f"Expected a folder of submissions, but {folder} is not one; check the path."
        )
    found = sorted(p for p in folder.rglob("*.ipynb") if ".ipynb_checkpoints" not in p.parts)
    if not found:
        raise InputError(
            f"Expected notebooks (*.ipynb) in {folder}, but found none; check the path."
        )
    return found


def grade(path: Path, *, seed: int, time_limit: float = TIME_LIMIT) -> list[Verdict]:
    """Check every exercise of one submission with hidden cases.

    Parameters
    ----------
    path : Path
        A notebook. Its lab is recognised by the exercises it names.
    seed : int
        Seed of the hidden cases; the same seed gives the same cases.
    time_limit : float
        Processor time an exercise may take [s]; more is a miss with that reason.

    Returns
    -------
    list of Verdict
        One per exercise of the lab.

    Raises
    ------
    InputError
        If the file is no notebook, or not one of a lab.
    """
    cells = code_cells(path)
    return [
        _graded(cells, exercise, seed, time_limit)
        for exercise in exercises_of(_lab_of(cells, path))
    ]


def verdict_of(path: Path, exercise: Exercise, seed: int) -> Verdict:
    """Check one exercise of a notebook that can be trusted, in this process, without limits."""
    answer = definitions(code_cells(path), exercise.function).get(exercise.function)
    return exercise.verdict(answer, np.random.default_rng(seed), HIDDEN_CASES)


def _graded(cells: list[str], exercise: Exercise, seed: int, time_limit: float) -> Verdict:
    """Judge here, with the cases that the submission never sees; let it answer over there."""
    with _Worker(cells, exercise.function, time_limit) as worker:
        try:
            answer = worker.call if worker.defined() else None
            return exercise.verdict(answer, np.random.default_rng(seed), HIDDEN_CASES)
        except _OutOfTime:
            hint = f"stopped after the limit of {time_limit:g} s"
        except _Gone:
            hint = "the process of the answer ended without a result"
        except _Failed as error:
            # what its own cell raised while it was executed
            hint = f"the cell of {exercise.function} stopped with {error}"
    return Verdict(exercise.name, False, hint)


class _OutOfTime(BaseException):
    """Not an Exception, so that it is never taken for the answer's own."""


class _Gone(BaseException):
    """The worker ended, by itself or by the system."""


class _Failed(BaseException):
    """The submission's own cell raised."""


class _Worker:
    """A process that holds one answer, and the pipes to it."""

    def __init__(self, cells: list[str], function: str, time_limit: float) -> None:
        self._cells, self._function, self._limit = cells, function, time_limit

    def __enter__(self) -> _Worker:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "medkit.labs.worker", self._function, str(self._limit)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            start_new_session=True,
        )  # fmt: skip
        self._replies: Queue[bytes] = Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()

    def defined(self) -> bool:
        """Whether the submission defines the function."""
        ready = self._ask(self._cells, START)
        # by the clock from here on, for what waits without computing
        self._end = time.monotonic() + 3.0 * self._limit + 5.0
        if "error" in ready:
            raise _Failed(f"{ready['error']}: {ready['words']}")
        return bool(ready["callable"])

    def call(self, *arguments: Any) -> Any:
        """Call the function over there; what it raises is raised here under the same name."""
        reply = self._ask(encoded(arguments), self._end - time.monotonic())
        if "error" in reply:
            raise type(str(reply["error"]), (Exception,), {})(reply["words"])
        return decoded(reply["value"])

    def _ask(self, request: Any, patience: float) -> dict[str, Any]:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
            line = self._replies.get(timeout=max(patience, 0.01))
        except Empty:
            raise _OutOfTime from None
        except OSError:
            line = b""
        try:
            reply = json.loads(line)
        except ValueError:
            raise (_OutOfTime if self._ran_out() else _Gone) from None
        if not isinstance(reply, dict):
            raise _Gone
        return reply

    def _ran_out(self) -> bool:
        """Whether the system ended the process for its processor time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._process.wait(timeout=5.0) in SIGNALS_OF_TIME
        return False

    def _listen(self) -> None:
        assert self._process.stdout is not None
        with contextlib.suppress(ValueError, OSError):
            for line in self._process.stdout:
                self._replies.put(line)
        self._replies.put(b"")


def table(
    folder: Path, *, seed: int, time_limit: float, progress: Callable[[list[Path]], Any] = iter
) -> Iterator[dict[str, Any]]:
    """Grade every submission of a folder and yield a row for each exercise."""
    for path in progress(submissions(folder)):
        try:
            verdicts = grade(path, seed=seed, time_limit=time_limit)
        except InputError as error:
            verdicts = [Verdict("-", False, str(error))]
        for verdict in verdicts:
            yield {
                "submission": str(path.relative_to(folder)),
                "exercise": verdict.exercise,
                "passed": verdict.passed,
                "hint": verdict.hint,
            }


def code_cells(path: Path) -> list[str]:
    """Return the code of a notebook, cell by cell, or an `InputError` that names the file."""
    import nbformat

    try:
        notebook = nbformat.read(path, as_version=4)
        return [str(cell.source) for cell in notebook.cells if cell.cell_type == "code"]
    except Exception as error:
        # nbformat raises a dozen kinds for broken files; they all mean that it cannot be read
        raise InputError(
            f"Expected a notebook in {path.name}, but it cannot be read"
            f" ({type(error).__name__}); ask for the file again."
        ) from error


def _lab_of(cells: list[str], path: Path) -> str:
    text = "\n".join(cells)
    for lab in LABS:
        if f"{lab}-1" in text:
            return lab
    raise InputError(
        f"Expected a lab notebook, but {path.name} names none of the exercises of"
        f" {', '.join(LABS)}; hand in the lab's own notebook."
    )
