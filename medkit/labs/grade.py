"""Grading a folder of submissions: the notebook's own checks with hidden cases and a time limit.

The cases and the verdict stay in this process; a submission answers call by call in another one,
with limits of processor time and memory. It still runs with your rights: grade where you would open
the notebook.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from medkit.errors import InputError
from medkit.labs.exercise import HIDDEN_CASES, Exercise, Verdict
from medkit.labs.messages import decoded, encoded, receive, send
from medkit.labs.reading import definitions, read_cells
from medkit.labs.registry import LABS, exercises_of

TIME_LIMIT = 20.0  # [s] of computing an exercise may take
QUIET = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
PATIENCE = 120.0  # [s] by the clock on top, for a slow machine and for an answer that sleeps


def submissions(folder: Path) -> list[Path]:
    """Return the notebooks of a folder and of its subfolders, sorted by name."""
    if not folder.is_dir():
        raise InputError(
            f"Expected a folder of submissions, but {folder} is not one; check the path."
        )
    found = sorted(
        path
        for path in folder.rglob("*.ipynb")
        # a Mac adds "._lab.ipynb" to an archive, Jupyter its checkpoints
        if ".ipynb_checkpoints" not in path.parts and not path.name.startswith("._")
    )
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
    exercises = exercises_of(_lab_of(cells, path))
    with _Worker(cells, time_limit) as worker:
        return [_graded(worker, exercise, seed) for exercise in exercises]


def verdict_of(path: Path, exercise: Exercise, seed: int) -> Verdict:
    """Check one exercise of a notebook that can be trusted, in this process, without limits."""
    cells = read_cells(code_cells(path))
    answer = definitions(cells, exercise.function).get(exercise.function)
    return exercise.verdict(answer, np.random.default_rng(seed), HIDDEN_CASES)


def _graded(worker: _Worker, exercise: Exercise, seed: int) -> Verdict:
    """Judge here, with the cases that the submission never sees; let it answer over there."""
    try:
        why = worker.turn_to(exercise)
        rng = np.random.default_rng(seed)
        verdict = (
            Verdict(exercise.name, False, why)
            if why
            else exercise.verdict(worker.call, rng, HIDDEN_CASES)
        )
    except _OutOfTime:
        hint = f"stopped after the limit of {worker.limit:g} s"
        verdict = Verdict(exercise.name, False, hint)
    except _Gone:
        hint = "the process of the answer ended without a result"
        verdict = Verdict(exercise.name, False, hint)
    except _Failed as error:
        hint = f"the cell of {exercise.function} stopped{error}"
        verdict = Verdict(exercise.name, False, hint)
    worker.done()
    return verdict


class _OutOfTime(BaseException):
    """Not an Exception, so that it is never taken for the answer's own."""


class _Gone(BaseException):
    """The answer's process ended, by itself or by the system."""


class _Failed(BaseException):
    """The submission's own cell raised."""


class _Worker:
    """A process that holds one submission, and the pipes to it."""

    def __init__(self, cells: list[str], limit: float) -> None:
        self._cells, self.limit = cells, limit
        self._process: subprocess.Popen[bytes] | None = None
        self._serving = False
        # what an answer writes to a file by mistake goes with it
        self._folder = tempfile.TemporaryDirectory(prefix="medkit_lab_")

    def __enter__(self) -> _Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()
        self._folder.cleanup()

    def turn_to(self, exercise: Exercise) -> str:
        """Turn to one function, and say why the submission does not define it, if so."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "medkit.labs.worker"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                env={**os.environ, **QUIET},
                start_new_session=True,
            )  # fmt: skip
        self._end = time.monotonic() + PATIENCE + 3.0 * self.limit
        self._serving = True
        ready = self._ask(
            {
                "cells": self._cells,
                "exercise": exercise.name,
                "function": exercise.function,
                "seconds": self.limit,
                "folder": self._folder.name,
            }
        )
        if "error" in ready:
            where = f" in line {ready['line']}" if ready.get("line") else ""
            raise _Failed(f"{where} with {ready['error']}: {ready.get('words')}")
        if ready.get("callable"):
            return ""
        return (
            str(ready.get("why", "")) or f"{exercise.function} is no function: define it with def"
        )

    def call(self, *arguments: Any) -> Any:
        """Call the function over there; what it raises is raised here under the same name."""
        reply = self._ask(encoded(arguments))
        if "error" in reply:
            raise type(str(reply["error"]), (Exception,), {"line": reply.get("line")})(
                reply.get("words")
            )
        return decoded(reply["value"])

    def done(self) -> None:
        """Leave the function; its fork ends."""
        if self._serving:
            with contextlib.suppress(_OutOfTime, _Gone):
                self._ask(None)

    def _ask(self, request: Any) -> dict[str, Any]:
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        reply = None
        try:
            send(self._process.stdin.fileno(), request)
            reply = receive(self._process.stdout.fileno(), self._end)
        except TimeoutError:
            self._stop()
            raise _OutOfTime from None
        except (OSError, ValueError):
            pass  # it closed the pipe, or wrote into it what is no message
        if not isinstance(reply, dict):
            self._stop()
            raise _Gone
        if "ended" in reply:
            self._serving = False
            raise _OutOfTime if reply["ended"] == "time" else _Gone
        return reply

    def _stop(self) -> None:
        """End the process and whatever it started; the next function gets a new one."""
        self._serving = False
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()
        self._process = None


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
    """Return the lab that the marks and checks of a notebook name most often."""
    text = "\n".join(cells)
    named = Counter({lab: len(re.findall(rf"\b{lab}-\d", text)) for lab in LABS})
    lab, count = named.most_common(1)[0]
    if not count:
        raise InputError(
            f"Expected a lab notebook, but {path.name} names none of the exercises of"
            f" {', '.join(LABS)}; hand in the lab's own notebook."
        )
    return lab
