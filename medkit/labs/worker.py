"""The functions of a submission, each in a process of its own that answers call by call.

The process that grades draws the cases and judges; this one sees the arguments of a single call and
sends back what came out. So a submission can neither read the cases to come nor its own verdict.
"""

from __future__ import annotations

import ast
import contextlib
import importlib
import json
import math
import os
import re
import resource
import signal
import struct
import sys
import time
from typing import Any

import numpy as np

DRAWING = ("matplotlib", "medkit.viz", "ipywidgets", "IPython", "meshcat")
ARITHMETIC = ("np", "numpy", "math")
#: Libraries that are loaded before the forks, so that each exercise need not load them again.
LIBRARIES = ("numpy", "scipy", "pandas", "statsmodels", "medkit")
IMPORTS = 60.0  # [s] of processor time that imports and definitions may take, besides the limit
MEMORY = 4 << 30  # [bytes] of address space, where the platform can
#: How the system ends a process that has used up its processor time.
SIGNALS_OF_TIME = (signal.SIGKILL, signal.SIGXCPU)


def main() -> int:
    """Serve one exercise after the other, each in a fork with its own limits, until input ends."""
    pipe = _own_pipes()
    while (task := receive(pipe[0])) is not None:
        _warm(task["cells"])
        child = os.fork()
        if child == 0:
            _serve(pipe, task)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        # the fork can no longer tell how it ended
        by_time = os.WIFSIGNALED(status) and os.WTERMSIG(status) in SIGNALS_OF_TIME
        send(pipe[1], {"ended": "time" if by_time else "gone"})
    return 0


def _serve(pipe: tuple[int, int], task: dict[str, Any]) -> None:
    """Define what the cells hold, then answer calls of one function until ``None`` comes."""
    answer: Any = None
    try:
        _limit(IMPORTS)
        answer = definitions(task["cells"], task["function"]).get(task["function"])
        _limit(float(task["seconds"]))
        send(pipe[1], {"callable": callable(answer)})
    except BaseException as error:
        send(pipe[1], _raised(error))
    while (arguments := receive(pipe[0])) is not None:
        try:
            reply: dict[str, Any] = {"value": encoded(answer(*decoded(arguments)))}
        except BaseException as error:
            # also SystemExit and KeyboardInterrupt of an answer: they are its result
            reply = _raised(error)
        send(pipe[1], reply)


def _warm(cells: list[str]) -> None:
    """Load the well-known libraries that the cells import; a submission's own code is not run."""
    for name in re.findall(r"^\s*(?:from|import)\s+([\w.]+)", "\n".join(cells), re.M):
        if name.split(".")[0] in LIBRARIES and not name.startswith(DRAWING):
            with contextlib.suppress(Exception):
                importlib.import_module(name)


def send(stream: int, message: Any) -> None:
    """Write one message, its length before it, to a file descriptor."""
    content = json.dumps(message).encode()
    content = struct.pack("!Q", len(content)) + content
    while content:
        content = content[os.write(stream, content) :]


def receive(stream: int) -> Any:
    """Read one message; None where the stream ends. Never reads ahead: a fork reads on."""
    length = struct.unpack("!Q", _exactly(stream, 8) or b"\0" * 8)[0]
    return json.loads(_exactly(stream, length)) if length else None


def _exactly(stream: int, count: int) -> bytes:
    parts = []
    while count > 0:
        part = os.read(stream, min(count, 1 << 20))
        if not part:
            return b""
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def definitions(cells: list[str], wanted: str) -> dict[str, Any]:
    """Execute imports and definitions only: no picture, no check, no input of a submission."""
    namespace: dict[str, Any] = {"__name__": "submission"}
    for source in cells:
        try:
            tree = ast.parse(source)
        except (SyntaxError, ValueError):
            continue
        tree.body = [node for node in tree.body if _is_kept(node)]
        try:
            exec(compile(tree, "<submission>", "exec"), namespace)
        except Exception:
            # a broken neighbour must not cost the exercise that is asked for
            if any(getattr(node, "name", None) == wanted for node in tree.body):
                raise
    return namespace


def encoded(value: Any) -> Any:
    """Turn numbers, arrays, texts, and lists and tuples of them into JSON; refuse the rest."""
    if value is Ellipsis:
        return ["..."]
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return ["value", value]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return ["array", value.dtype.str, list(value.shape), value.ravel().tolist()]
    if isinstance(value, list | tuple):
        return [type(value).__name__, [encoded(item) for item in value]]
    raise TypeError(f"expected numbers or an array, but it returned {type(value).__name__}")


def decoded(value: Any) -> Any:
    """Undo `encoded`.

    Examples
    --------
    >>> decoded(encoded((1.5, [True, None], np.eye(2)[0])))
    (1.5, [True, None], array([1., 0.]))
    """
    kind = value[0]
    if kind == "...":
        return ...
    if kind == "array":
        return np.array(value[3], dtype=value[1]).reshape(value[2])
    if kind in ("list", "tuple"):
        items = [decoded(item) for item in value[1]]
        return items if kind == "list" else tuple(items)
    return value[1]


def _is_kept(node: ast.stmt) -> bool:
    """Definitions, values that need no more than arithmetic, and imports that do not draw."""
    if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign):
        return node.value is not None and _is_plain(node.value)
    if isinstance(node, ast.Import):
        return not any(alias.name.startswith(DRAWING) for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return not (node.module or "").startswith(DRAWING)
    return isinstance(node, ast.FunctionDef | ast.ClassDef)


def _is_plain(value: ast.expr) -> bool:
    """Whether an expression calls nothing but numpy and math; a lambda waits until it is called."""
    if isinstance(value, ast.Lambda):
        return True
    if isinstance(value, ast.Call):
        module = value.func.value if isinstance(value.func, ast.Attribute) else None
        if not (isinstance(module, ast.Name) and module.id in ARITHMETIC):
            return False
    return all(
        _is_plain(part) for part in ast.iter_child_nodes(value) if isinstance(part, ast.expr)
    )


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


def _raised(error: BaseException) -> dict[str, Any]:
    return {"error": type(error).__name__, "words": " ".join(str(error).split())[:200]}


if __name__ == "__main__":
    raise SystemExit(main())
