"""Numbers, arrays and texts between the process that grades and the one that answers."""

from __future__ import annotations

import json
import os
import select
import struct
import time
from typing import Any

import numpy as np

#: Most numbers an answer may return, and most bytes of one message.
MOST, LARGEST = 1_000_000, 64 << 20


def send(stream: int, message: Any) -> None:
    """Write one message, its length before it, to a file descriptor."""
    content = json.dumps(message).encode()
    if len(content) > LARGEST:
        raise ValueError("expected a few numbers, but the message is longer than 64 MB")
    content = struct.pack("!Q", len(content)) + content
    while content:
        content = content[os.write(stream, content) :]


def receive(stream: int, until: float = float("inf")) -> Any:
    """Read one message, before the monotonic time `until` [s]; None where the stream ends.

    Never reads ahead, because a fork reads on. Raises `TimeoutError`, and `ValueError` for what is
    no message.
    """
    length = struct.unpack("!Q", _exactly(stream, 8, until) or b"\0" * 8)[0]
    if length > LARGEST:
        raise ValueError("expected a message of at most 64 MB")
    return json.loads(_exactly(stream, length, until)) if length else None


def _exactly(stream: int, count: int, until: float) -> bytes:
    parts = []
    while count > 0:
        if until < float("inf"):
            patience = max(until - time.monotonic(), 0.01)
            if not select.select([stream], [], [], patience)[0]:
                raise TimeoutError
        part = os.read(stream, min(count, 1 << 20))
        if not part:
            return b""
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def encoded(value: Any) -> Any:
    """Turn numbers, arrays, texts, and lists and tuples of them into JSON; refuse the rest."""
    if value is Ellipsis:
        return ["..."]
    if isinstance(value, np.generic):
        return ["scalar", encoded(np.asarray(value))]
    if value is None or isinstance(value, bool | int | float):
        return ["value", value]
    if isinstance(value, str | list | tuple | range | np.ndarray) and _size(value) > MOST:
        raise TypeError("expected a few numbers, but it returned more than a million")
    if isinstance(value, str):
        return ["value", value[:1000]]
    if isinstance(value, complex):
        return encoded(np.asarray(value))
    if isinstance(value, np.ndarray) and value.dtype.kind == "c":
        return ["complex", encoded(value.real), encoded(value.imag)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return ["array", value.dtype.str, list(value.shape), value.ravel().tolist()]
    if isinstance(value, list | tuple | range):
        # a named tuple, such as scipy's confidence interval, is a tuple to whoever checks it
        kind = "tuple" if isinstance(value, tuple) else "list"
        return [kind, [encoded(item) for item in value]]
    if hasattr(value, "__array__"):
        return encoded(np.asarray(value, dtype=float))
    if hasattr(value, "__float__"):
        return ["value", float(value)]
    raise TypeError(f"expected numbers or an array, but it returned {type(value).__name__}")


def _size(value: Any) -> int:
    return int(value.size) if isinstance(value, np.ndarray) else len(value)


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
    if kind == "scalar":
        return decoded(value[1])[()]
    if kind == "complex":
        return decoded(value[1]) + 1j * decoded(value[2])
    if kind in ("list", "tuple"):
        items = [decoded(item) for item in value[1]]
        return items if kind == "list" else tuple(items)
    return value[1]
