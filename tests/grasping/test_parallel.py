"""Processes that test candidates: in order, and gone when the walk ends, however it ends."""

import math
import os
import signal
import threading
from multiprocessing import popen_spawn_posix

import pytest

from medkit.grasping.parallel import in_processes


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_results_come_in_the_order_of_the_tasks():
    assert list(in_processes(math.sqrt, [9.0, 4.0, 1.0], 2)) == [3.0, 2.0, 1.0]


@pytest.fixture
def heard():
    """Hear interrupts as at a terminal: shells start jobs in the background deaf to them."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_while_processes_start_leaves_none_behind(monkeypatch, heard):
    started, over = [], threading.Event()
    # the kernel hands an interrupt to any thread, and the main one then acts on it
    other = threading.Thread(target=over.wait, daemon=True)
    other.start()
    launch = popen_spawn_posix.Popen._launch

    def interrupted(self, process):
        launch(self, process)
        started.append(self.pid)
        signal.pthread_kill(other.ident, signal.SIGINT)
        over.wait(0.1)  # until it has arrived

    monkeypatch.setattr(popen_spawn_posix.Popen, "_launch", interrupted)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        list(in_processes(math.sqrt, [9.0, 4.0, 1.0], 2))
    over.set()
    assert started
    assert not [pid for pid in started if is_alive(pid)]
    assert signal.getsignal(signal.SIGINT) is before


def test_a_walk_that_ends_early_ends_its_processes(monkeypatch):
    started = []
    launch = popen_spawn_posix.Popen._launch

    def noted(self, process):
        launch(self, process)
        started.append(self.pid)

    monkeypatch.setattr(popen_spawn_posix.Popen, "_launch", noted)
    walk = in_processes(math.sqrt, [9.0, 4.0, 1.0], 2)
    assert next(walk) == 3.0
    walk.close()
    assert len(started) >= 2
    assert not [pid for pid in started if is_alive(pid)]
