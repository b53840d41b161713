"""Where a reach begins and ends: the wrist's speed against a threshold (P13 6.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, positive

#: Speed [m/s] at which a movement starts and ends, P13 6.2.2.
THRESHOLD = 0.1


@dataclass(frozen=True)
class Movement:
    """One stretch above the threshold; `start` and `end` are samples, `end` the first below."""

    start: int
    end: int
    start_seen: bool  # False: the hand already moved at the first sample
    end_seen: bool  # False: it still moved at the last one
    peak_speed: float  # [m/s]


def find_movements(
    times: ArrayLike,
    speed: ArrayLike,
    *,
    threshold: float = THRESHOLD,
    shortest: float = 0.2,
    shortest_pause: float = 0.05,
) -> list[Movement]:
    """Split a recording into movements, where the speed is above a threshold (P13 6.2.2).

    Parameters
    ----------
    times : array-like, shape (n,)
        Instants [s].
    speed : array-like, shape (n,)
        Speed of the wrist [m/s]; NaN where it was not seen, which ends a movement.
    threshold : float
        Speed [m/s] of start and end.
    shortest : float
        Briefer movements [s] are dropped: twitches, and jumps where a tracker is found again.
    shortest_pause : float
        Briefer pauses [s] do not end a movement.

    Returns
    -------
    list of Movement
        In the order of time; empty when nothing moved.

    Raises
    ------
    InputError
        If the arrays differ in length or the threshold is not above zero.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> [(m.start, m.end) for m in find_movements(t, np.sin(np.pi * t))]
    [(4, 97)]
    """
    clock, values = np.asarray(times, dtype=float), np.asarray(speed, dtype=float)
    limit = positive(threshold, "threshold", " m/s")
    if clock.shape != values.shape or clock.ndim != 1 or len(clock) < 2:
        raise InputError(
            f"Expected times and speeds of one length, but got shapes {clock.shape} and"
            f" {values.shape}; pass one speed per instant."
        )
    runs = _runs(np.nan_to_num(values, nan=0.0) > limit)
    merged: list[list[int]] = []
    for start, end in runs:
        if merged and clock[start] - clock[merged[-1][1]] < shortest_pause:
            merged[-1][1] = end
        else:
            merged.append([start, end])
    last = len(clock) - 1
    return [
        Movement(start, min(end, last), start > 0, end <= last,
                 float(np.nanmax(values[start : end + 1])))
        for start, end in merged
        if clock[min(end, last)] - clock[start] >= shortest
    ]  # fmt: skip


def settled_sample(movement: Movement, speed: Floats, times: Floats, *, within: float = 0.3) -> int:
    """Sample of least speed up to `within` [s] after a movement's end, when the hand has settled.

    P13 takes the end itself; a hand that still moves at 0.1 m/s is some millimetres short.
    """
    stop = int(np.searchsorted(times, times[movement.end] + within, side="right"))
    window = speed[movement.end : max(stop, movement.end + 1)]
    if not np.any(np.isfinite(window)):
        return movement.end
    return movement.end + int(np.nanargmin(window))


def _runs(above: np.ndarray) -> list[tuple[int, int]]:
    """Stretches of True as (first, one past the last)."""
    edges = np.diff(np.concatenate([[0], above.astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(),
                    strict=True))  # fmt: skip
