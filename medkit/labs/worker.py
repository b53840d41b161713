"""One function of a submission, in a process of its own that answers call by call.

The process that grades draws the cases and judges; this one sees the arguments of a single call and
sends back what came out. So a submission can neither read the cases to come nor its own verdict.
"""

from __future__ import annotations

import ast
import json
import os
import sys
from typing import Any

import numpy as np

DRAWING = ("matplotlib", "medkit.viz", "ipywidgets", "IPython", "meshcat")
MEMORY = 4 << 30  # [bytes] of address space, where the platform can


def main() -> int:
    """Define what ``argv[1]``, a JSON list of cells, holds and answer calls of ``argv[2]``."""
    wanted, seconds = sys.argv[1], float(sys.argv[2])
    requests, replies = _own_pipes()
    cells = json.loads(requests.readline())
    _limit(seconds)
    answer: Any = None
    try:
        answer = definitions(cells, wanted).get(wanted)
        ready: dict[str, Any] = {"callable": callable(answer)}
    except BaseException as error:
        ready = _raised(error)
    _send(replies, ready)
    for line in requests:
        try:
            reply: dict[str, Any] = {"value": encoded(answer(*decoded(json.loads(line))))}
        except BaseException as error:
            # also SystemExit and KeyboardInterrupt of an answer: they are its result
            reply = _raised(error)
        _send(replies, reply)
    return 0


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
    """Definitions, constants, and imports that do not draw."""
    if isinstance(node, ast.Assign):
        return isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Import):
        return not any(alias.name.startswith(DRAWING) for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return not (node.module or "").startswith(DRAWING)
    return isinstance(node, ast.FunctionDef | ast.ClassDef)


def _own_pipes() -> tuple[Any, Any]:
    """Keep the pipes to ourselves: what a submission reads is empty, what it prints is dropped."""
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    return requests, replies


def _limit(seconds: float) -> None:
    """Bound processor time and memory in a way that a submission cannot undo."""
    try:
        import resource
    except ImportError:  # not a Unix; the grading process still waits no longer than it wants
        return
    import math
    import time

    used = math.ceil(time.process_time() + seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (used, used))
    if sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _raised(error: BaseException) -> dict[str, Any]:
    return {"error": type(error).__name__, "words": " ".join(str(error).split())[:200]}


def _send(replies: Any, reply: dict[str, Any]) -> None:
    replies.write(json.dumps(reply) + "\n")
    replies.flush()


if __name__ == "__main__":
    raise SystemExit(main())
