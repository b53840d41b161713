"""Wall time of a planner's stages."""

from __future__ import annotations

import time

from numba.core import event

#: Medial axis; candidates; loading compiled kernels, whatever stage asks for them; the object's
#: tree and the hand's tables; closing all candidates; judging them; the sum of these.
STAGES = ("medial", "symmetry", "kernels", "preparation", "closing", "quality", "total")

# numba holds this lock while it loads a kernel from its cache or compiles it
_LOADING = event.TimingListener()
event.register("numba:compiler_lock", _LOADING)


def _loading() -> float:
    """Time that this process has spent on loading or compiling kernels [s]."""
    return float(_LOADING.duration) if _LOADING.done else 0.0


class Stopwatch:
    """Wall time of named laps [s]; what loads compiled kernels is a lap of its own."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()
        self._loaded = _loading()

    def lap(self, name: str) -> None:
        """Book the time since the last lap under `name`, or under "kernels" where it went there."""
        now, loaded = time.perf_counter(), _loading()
        kernels = min(loaded - self._loaded, now - self._last)
        self.laps["kernels"] = self.laps.get("kernels", 0.0) + kernels
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last - kernels
        self._last, self._loaded = now, loaded

    def stages(self, *, quality: float, jobs: int = 1) -> dict[str, float]:
        """Time of each of `STAGES` up to the last lap [s]; the total is the sum of the others.

        Parameters
        ----------
        quality : float
            What judging took within the lap "closing", in all processes together [s].
        jobs : int
            Processes that closed and judged side by side. Their start, and the kernels that they
            load for themselves, are part of "closing".
        """
        laps = {stage: self.laps.get(stage, 0.0) for stage in STAGES}
        laps["quality"] = min(quality / jobs, laps["closing"])
        laps["closing"] -= laps["quality"]
        return {**laps, "total": sum(laps.values())}
