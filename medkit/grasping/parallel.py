"""Testing candidates, here or in several processes: arrays are sent, the rest is built anew."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from multiprocessing import resource_tracker
from typing import Any

from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.grasp_set import Grasp
from medkit.grasping.testers import GraspTester, warm_quality

Progress = Callable[[Iterable[Any], int], Iterable[Any]]

#: Candidates that one process takes at a time.
CHUNK = 8

_tester: Any = None


def _start(tester_type: Any, parts: dict) -> None:
    global _tester
    _tester = tester_type.from_parts(parts)
    warm_quality()  # else the first candidate's time would count it


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Hold an interrupt back until the block ends; processes that start in it never see one.

    One that struck while a pool starts would leave processes that nobody knows any more.
    """
    if threading.current_thread() is not threading.main_thread():  # the others get no interrupt
        yield
        return
    # started on demand, the tracker would unblock the signal again
    resource_tracker.ensure_running()
    came: list[int] = []
    handler = signal.signal(signal.SIGINT, lambda number, _frame: came.append(number))
    # blocked for the children, who inherit it; other threads of ours may still take the signal
    masks = hasattr(signal, "pthread_sigmask")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        signal.signal(signal.SIGINT, signal.SIG_DFL if handler is None else handler)
    if came:
        signal.raise_signal(signal.SIGINT)


def _test(row: tuple) -> Any:
    return _tester.test(*row)


def processes_for(count: int, jobs: int) -> int:
    """Number of processes that test `count` candidates when there may be `jobs`."""
    return jobs if jobs > 1 and count >= 2 * jobs else 1


def run_candidates(
    tester: GraspTester,
    candidates: CandidateGrasps,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Iterator[tuple[Grasp, float]]:
    """Test candidates one after the other, in this process or in several; same order, same result.

    Parameters
    ----------
    tester : GraspTester
        Closes and judges one candidate after the other.
    candidates : CandidateGrasps
        The candidates.
    jobs : int
        Number of processes.
    progress : callable, optional
        Wraps the iterable of results.
    """
    rows: list[tuple] = [*candidates.rows()]
    if processes_for(len(rows), jobs) == 1:
        results: Iterable[tuple[Grasp, float]] = (tester.test(*row) for row in rows)
        yield from progress(results, len(rows)) if progress else results
        return
    results = tested_in_processes(tester, rows, jobs)
    yield from progress(results, len(rows)) if progress else results


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
    yield from in_processes(_test, rows, jobs, chunk=CHUNK, start=(type(tester), tester.parts()))


def in_processes(
    function: Callable[[Any], Any],
    tasks: Sequence[Any],
    jobs: int,
    *,
    chunk: int = 1,
    start: tuple[Any, dict] | None = None,
) -> Iterator[Any]:
    """Results of a function of a module for every task, in order, from new processes.

    Parameters
    ----------
    function : callable
        What a process runs for each task; both travel by name or by pickle.
    tasks : sequence
        Its arguments.
    jobs : int
        Number of processes.
    chunk : int
        Tasks that a process takes at a time.
    start : tuple of class and dict, optional
        Tester that each process builds at its start, for `tested_in_processes`.

    Yields
    ------
    object
        One result per task. When the walk ends early, by an interrupt or an error, the
        processes end too.
    """
    context = multiprocessing.get_context("spawn")
    with ExitStack() as stack:
        with _interrupts_wait():
            pool = context.Pool(jobs, _start if start else None, start or ())
            stack.callback(_end, pool)
        yield from pool.imap(function, tasks, chunksize=chunk)


def _end(pool: Any) -> None:
    with _interrupts_wait():  # a second interrupt would leave processes behind, too
        pool.terminate()
