"""Testing candidates in several processes: arrays are sent, everything else is built anew."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from typing import Any

#: Candidates that one process takes at a time.
CHUNK = 8

_tester: Any = None


def _start(tester_type: Any, parts: dict) -> None:
    global _tester
    import signal

    # The parent alone reacts to an interrupt; it ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _tester = tester_type.from_parts(parts)


def _test(row: tuple) -> Any:
    return _tester.test(*row)


def tested_in_processes(tester: Any, rows: list[tuple], jobs: int) -> Iterator[Any]:
    """Results of ``tester.test(*row)`` for every row, in order.

    Parameters
    ----------
    tester : object
        With ``parts()``, a dictionary that travels between processes, and a class method
        ``from_parts``.
    rows : list of tuple
        Arguments of each test.
    jobs : int
        Number of processes.

    Yields
    ------
    object
        One result per row. When the walk ends early, by an interrupt or an error, the
        processes end too.
    """
    context = multiprocessing.get_context("spawn")
    with context.Pool(jobs, _start, (type(tester), tester.parts())) as pool:
        yield from pool.imap(_test, rows, chunksize=CHUNK)
