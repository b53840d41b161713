"""Grading a folder of submissions: the notebook's own checks with hidden cases and a time limit.

A submission runs in a process of its own, but it runs: grade what you would also open.
"""

from __future__ import annotations

import ast
import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from medkit.errors import InputError
from medkit.labs.exercise import HIDDEN_CASES, Exercise, Verdict
from medkit.labs.registry import LABS, exercises_of

TIME_LIMIT = 20.0  # [s] of computing an exercise may take
PATIENCE = 120.0  # [s] by the clock on top, for a slow machine to start and to import
DRAWING = ("matplotlib", "medkit.viz", "ipywidgets", "IPython")


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
        A notebook. Its lab is recognised by the functions it defines and the checks it calls.
    seed : int
        Seed of the hidden cases; the same seed gives the same cases.
    time_limit : float
        Processor time an exercise may take [s]; more is a miss with that reason.

    Returns
    -------
    list of Verdict
        One per exercise of the lab. A notebook that cannot be read misses all of them.
    """
    cells = _code_cells(path)
    lab = _lab_of(cells, path)
    told = _in_a_process(path, lab, seed, time_limit)
    silent = "the process ended, or was stopped, without a verdict"
    return [
        told.get(exercise.name, Verdict(exercise.name, False, silent))
        for exercise in exercises_of(lab)
    ]


def verdict_of(
    path: Path, exercise: Exercise, seed: int, time_limit: float | None = None
) -> Verdict:
    """Run a submission's definitions in this process and check one exercise."""
    namespace = _definitions(_code_cells(path), exercise.function)
    answer = namespace.get(exercise.function)
    try:
        with _at_most(time_limit):
            return exercise.verdict(answer, np.random.default_rng(seed), HIDDEN_CASES)
    except _OutOfTime:
        return _too_slow(exercise, time_limit or 0.0)


class _OutOfTime(BaseException):
    """Not an Exception, so that no answer's own handler swallows it."""


@contextmanager
def _at_most(seconds: float | None) -> Iterator[None]:
    """Stop the block after so much processor time [s], where the platform can."""
    if seconds is None or not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_: Any) -> None:
        raise _OutOfTime

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def _too_slow(exercise: Exercise, time_limit: float) -> Verdict:
    return Verdict(exercise.name, False, f"stopped after the limit of {time_limit:g} s")


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


def _in_a_process(path: Path, lab: str, seed: int, time_limit: float) -> dict[str, Verdict]:
    """Check all exercises of a submission in one child process, which prints a line for each."""
    command = [
        sys.executable, "-m", "medkit.labs", "submission", str(path), lab, str(seed),
        "--time-limit", str(time_limit),
    ]  # fmt: skip
    patience = PATIENCE + time_limit * len(exercises_of(lab))
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=patience, check=False
        )
        output = done.stdout
    except subprocess.TimeoutExpired as error:
        raw = error.stdout or b""
        output = raw if isinstance(raw, str) else raw.decode("utf-8", "replace")
    lines = (line for line in output.splitlines() if line.startswith('{"exercise"'))
    verdicts = (Verdict(**json.loads(line)) for line in lines)
    return {verdict.exercise: verdict for verdict in verdicts}


def _code_cells(path: Path) -> list[str]:
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


def _definitions(cells: list[str], wanted: str) -> dict[str, Any]:
    """Execute imports and definitions only: no picture, no check, no input of a submission."""
    namespace: dict[str, Any] = {"__name__": "submission"}
    for source in cells:
        try:
            tree = ast.parse(source)
        except SyntaxError:
            continue
        tree.body = [node for node in tree.body if _is_kept(node)]
        try:
            exec(compile(tree, "<submission>", "exec"), namespace)
        except Exception:
            # a broken neighbour must not cost the exercise that is asked for
            if any(getattr(node, "name", None) == wanted for node in tree.body):
                raise
    return namespace


def _is_kept(node: ast.stmt) -> bool:
    """Definitions, constants, and imports that do not draw."""
    if isinstance(node, ast.Assign):
        return isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Import):
        return not any(alias.name.startswith(DRAWING) for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return not (node.module or "").startswith(DRAWING)
    return isinstance(node, ast.FunctionDef | ast.ClassDef)
