"""The functions of a submission, each in a process of its own that answers call by call.

The process that grades draws the cases and judges; this one sees the arguments of a single call and
sends back what came out. So a submission can neither read the cases to come nor its own verdict.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import resource
import signal
import sys
import time
from pathlib import Path
from typing import Any

from medkit.labs.exercise import line_of
from medkit.labs.messages import decoded, encoded, receive, send
from medkit.labs.reading import Cell, defines, definitions, needed_modules, read_cells, why_missing

#: Libraries that are loaded before the forks, so that each exercise need not load them again.
LIBRARIES = ("numpy", "scipy", "pandas", "statsmodels", "medkit")
IMPORTS = 60.0  # [s] of processor time that imports and definitions may take, besides the limit
MEMORY = 4 << 30  # [bytes] of address space, where the platform can
#: How the system ends a process that has used up its processor time.
SIGNALS_OF_TIME = (signal.SIGKILL, signal.SIGXCPU)

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
PROCESSES = ("os.fork", "os.exec", "os.posix_spawn", "os.spawn", "os.system", "os.kill")
REFUSED = (*PROCESSES, "os.killpg", "os.forkpty", "subprocess.Popen", "socket.connect", "os.link")
CHANGES = ("os.remove", "os.rename", "os.rmdir", "os.truncate", "os.symlink", "os.mkdir")
#: Where the answers to the labs lie in a checkout.
TESTS = os.path.realpath(Path(__file__).parents[2] / "tests")


def main() -> int:
    """Serve one exercise after the other, each in a fork with its own limits, until input ends."""
    pipe = _own_pipes()
    while (task := receive(pipe[0])) is not None:
        cells = read_cells(task["cells"])
        _warm(cells, task["function"])
        child = os.fork()
        if child == 0:
            _serve(pipe, task, cells)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        # the fork can no longer tell how it ended
        by_time = os.WIFSIGNALED(status) and os.WTERMSIG(status) in SIGNALS_OF_TIME
        send(pipe[1], {"ended": "time" if by_time else "gone"})
    return 0


def _serve(pipe: tuple[int, int], task: dict[str, Any], cells: list[Cell]) -> None:
    """Define what the cells hold, then answer calls of one function until ``None`` comes."""
    answer: Any = None
    try:
        _limit(IMPORTS)
        _lock(task["folder"])
        answer = _answer(cells, task["function"])
        _limit(float(task["seconds"]))
        why = why_missing(cells, task["function"], task["exercise"]) if answer is None else ""
        send(pipe[1], {"callable": callable(answer), "why": why})
    except BaseException as error:
        send(pipe[1], _raised(error, cells))
    while (arguments := receive(pipe[0])) is not None:
        try:
            send(pipe[1], {"value": encoded(answer(*decoded(arguments)))})
        except BaseException as error:
            # also SystemExit and KeyboardInterrupt of an answer: they are its result
            send(pipe[1], _raised(error, cells))


def _answer(cells: list[Cell], function: str) -> Any:
    return definitions(cells, function).get(function) if defines(cells, function) else None


def _warm(cells: list[Cell], function: str) -> None:
    """Load the well-known libraries that the function needs; a submission's own code is not run."""
    for name in needed_modules(cells, function):
        if name.split(".")[0] in LIBRARIES:
            with contextlib.suppress(Exception):
                importlib.import_module(name)


def _own_pipes() -> tuple[int, int]:
    """Keep the pipes to ourselves: what a submission reads is empty, what it prints is dropped."""
    pipe = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    return pipe


def _limit(seconds: float) -> None:
    """Bound processor time and memory in a way that a submission cannot undo."""
    used = math.ceil(time.process_time() + seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (used, used))
    if sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _lock(folder: str) -> None:
    """Work in `folder`; from now on start no process, change no file elsewhere, read no answers.

    This keeps honest mistakes and plain cheating out. It is no sandbox: compiled code goes around.
    """
    os.chdir(folder)
    caches = (os.path.realpath(folder), os.devnull, os.environ.get("NUMBA_CACHE_DIR", folder))

    def may_write(path: str) -> bool:
        return path.startswith(caches) or "__pycache__" in path

    def guard(event: str, arguments: tuple[Any, ...]) -> None:
        if event in REFUSED:
            raise PermissionError(f"{event} is refused while grading")
        if event not in CHANGES and event != "open":
            return
        for path in (_path(part) for part in arguments[: 2 if event == "os.rename" else 1]):
            changes = event in CHANGES or arguments[2] & WRITING
            if path is not None and changes and not may_write(path):
                raise PermissionError("writing files is refused while grading")
            if path is not None and (path.endswith(".ipynb") or path.startswith(TESTS + os.sep)):
                raise PermissionError("reading notebooks and solutions is refused while grading")

    sys.addaudithook(guard)


def _path(name: Any) -> str | None:
    return os.path.realpath(os.fsdecode(name)) if isinstance(name, str | bytes | Path) else None


def _raised(error: BaseException, cells: list[Cell]) -> dict[str, Any]:
    return {
        "error": type(error).__name__,
        "words": " ".join(str(error).split())[:200],
        "line": line_of(error, {cell.place for cell in cells}),
    }


if __name__ == "__main__":
    raise SystemExit(main())
