"""Wall time of a planner's stages."""

from __future__ import annotations

import time

STAGES = ("medial", "symmetry", "closing", "quality", "total")


class Stopwatch:
    """Wall time of named laps [s]."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._begin = self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """Book the time since the last lap under `name`."""
        now = time.perf_counter()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last
        self._last = now

    def total(self) -> float:
        """Time since the start [s]."""
        return time.perf_counter() - self._begin

    def stages(self, *, quality: float) -> dict[str, float]:
        """Time of each of `STAGES` [s]; with several processes quality counts what all spent."""
        laps = {stage: self.laps.get(stage, 0.0) for stage in STAGES}
        laps["quality"] = quality
        laps["closing"] = max(laps["closing"] - quality, 0.0)
        laps["total"] = self.total()
        return laps
