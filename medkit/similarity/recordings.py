"""A continuous recording of trackers, from raw samples to filtered speeds (P13 6.2.2).

Every step returns a new recording and is called by name; none happens by itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from medkit.errors import InputError
from medkit.geometry import Floats, inverse, nonnegative, positive

#: Order of the low-pass, P13 6.2.2.
FILTER_ORDER = 2
#: Cut-off [Hz]; P13 gives none. Reaching lies below 5 Hz, tracker noise is spread over all.
CUTOFF = 8.0


@dataclass(frozen=True)
class Recording:
    """Positions of several trackers over time; NaN where one was not seen."""

    sensors: tuple[str, ...]
    times: Floats  # (n,) [s]
    positions: Floats  # (n, m, 3) [m]
    source: str = ""

    def __post_init__(self) -> None:
        expected = (len(self.times), len(self.sensors), 3)
        if self.positions.shape != expected or len(self.times) < 2:
            raise InputError(
                f"Expected positions of shape {expected} and at least two samples, but got shape"
                f" {self.positions.shape}; pass one row per instant."
            )

    @property
    def rate(self) -> float:
        """Sampling rate [Hz], from the median step."""
        return float(1.0 / np.median(np.diff(self.times)))

    def of(self, *sensors: str) -> Floats:
        """Positions (n, len(sensors), 3) [m] of the named trackers.

        Raises
        ------
        InputError
            If a name is unknown.
        """
        missing = [name for name in sensors if name not in self.sensors]
        if missing:
            raise InputError(
                f"Expected trackers among {', '.join(self.sensors)}, but got"
                f" {', '.join(missing)}; name them as in the recording."
            )
        return self.positions[:, [self.sensors.index(name) for name in sensors]]

    def renamed(self, names: dict[str, str]) -> Recording:
        """Return the trackers in ``names`` (new name -> name in the recording), in that order."""
        chosen = self.of(*names.values())
        return replace(self, sensors=tuple(names), positions=chosen)


def only_forward_in_time(recording: Recording) -> tuple[Recording, int]:
    """Drop samples that are not later than all before them; return how many were dropped.

    Some acquisition programs write buffered samples at the start of a trial, whose stamps run
    backwards.
    """
    latest = np.maximum.accumulate(np.concatenate([[-np.inf], recording.times[:-1]]))
    kept = recording.times > latest
    return _rows(recording, kept), int(np.sum(~kept))


def held_to_missing(recording: Recording) -> tuple[Recording, int]:
    """Mark samples that repeat the one before to the last digit as not seen; return their number.

    Noise makes exact repetition impossible, so it means that the device held its last value.
    """
    repeated = np.zeros(recording.positions.shape[:2], dtype=bool)
    repeated[1:] = np.all(recording.positions[1:] == recording.positions[:-1], axis=2)
    positions = np.where(repeated[..., None], np.nan, recording.positions)
    return replace(recording, positions=positions), int(repeated.sum())


def resampled(recording: Recording, *, rate: float, longest_gap: float = 0.2) -> Recording:
    """Put a recording on an even clock and bridge drop-outs by straight lines.

    Parameters
    ----------
    recording : Recording
        Times strictly increasing.
    rate : float
        Samples per second [Hz].
    longest_gap : float
        Longer drop-outs [s] stay NaN, as do those at either end.

    Returns
    -------
    Recording
        Evenly spaced.

    Raises
    ------
    InputError
        If time does not run forward or the rate is not above zero.
    """
    step = 1.0 / positive(rate, "rate", " Hz")
    gap = nonnegative(longest_gap, "longest_gap", " s")
    if np.any(np.diff(recording.times) <= 0.0):
        first = int(np.argmax(np.diff(recording.times) <= 0.0)) + 1
        raise InputError(
            f"Expected times that run forward, but sample {first} is not later than the one"
            " before; drop such samples with only_forward_in_time, or mend the file."
        )
    count = int(np.floor((recording.times[-1] - recording.times[0]) / step + 1e-6)) + 1
    clock = recording.times[0] + step * np.arange(count)
    columns = [_bridged(recording.times, track, clock, gap)
               for track in recording.positions.transpose(1, 0, 2)]  # fmt: skip
    return replace(recording, times=clock, positions=np.stack(columns, axis=1))


def _bridged(times: Floats, track: Floats, clock: Floats, longest_gap: float) -> Floats:
    seen = np.flatnonzero(np.isfinite(track).all(axis=1))
    result = np.full((len(clock), 3), np.nan)
    if seen.size == 0:
        return result
    for axis in range(3):
        result[:, axis] = np.interp(clock, times[seen], track[seen, axis], np.nan, np.nan)
    after = np.searchsorted(times[seen], clock, side="left").clip(1, max(seen.size - 1, 1))
    if seen.size > 1:
        width = times[seen][after] - times[seen][after - 1]
        skipped = seen[after] - seen[after - 1] > 1
        result[skipped & (width > longest_gap)] = np.nan
    return result


def lowpassed(recording: Recording, *, cutoff: float = CUTOFF) -> Recording:
    """Filter every coordinate by a second-order Butterworth low-pass without delay (P13 6.2.2).

    Parameters
    ----------
    recording : Recording
        Evenly spaced; stretches of NaN are left as they are and split the track.
    cutoff : float
        Frequency [Hz] at which the single pass has halved the power. The filter runs forward and
        backward, so its phase is zero and its power there is a quarter.

    Returns
    -------
    Recording
        Filtered positions.

    Raises
    ------
    InputError
        If the clock is uneven or the cut-off is not below half the rate.
    """
    steps = np.diff(recording.times)
    if np.ptp(steps) > 1e-3 * np.median(steps):
        raise InputError(
            f"Expected an even clock, but steps vary from {steps.min():.4g} to {steps.max():.4g} s;"
            " call resampled first."
        )
    limit = positive(cutoff, "cutoff", " Hz")
    if limit >= 0.5 * recording.rate:
        raise InputError(
            f"Expected a cut-off below half the sampling rate ({0.5 * recording.rate:g} Hz), but"
            f" got {limit:g} Hz; lower it."
        )
    sections = butter(FILTER_ORDER, limit, fs=recording.rate, output="sos")
    positions = recording.positions.copy()
    for sensor in range(positions.shape[1]):
        for piece in _seen_pieces(positions[:, sensor]):
            positions[piece, sensor] = sosfiltfilt(sections, positions[piece, sensor], axis=0)
    return replace(recording, positions=positions)


def _seen_pieces(track: Floats) -> list[slice]:
    """Stretches without NaN that are long enough to be filtered."""
    seen = np.concatenate([[False], np.isfinite(track).all(axis=1), [False]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(seen) == 1), np.flatnonzero(np.diff(seen) == -1)
    return [
        slice(a, b) for a, b in zip(starts, ends, strict=True) if b - a > 3 * (FILTER_ORDER + 4)
    ]


def speeds(recording: Recording) -> Floats:
    """Speed (n, m) [m/s] of every tracker by central differences of its positions."""
    velocity = np.gradient(recording.positions, recording.times, axis=0)
    return np.asarray(np.linalg.norm(velocity, axis=2))


def in_frame(recording: Recording, T_world_object: Floats) -> Recording:
    """Express positions in the object's frame, given its pose (4, 4) in the tracker's frame."""
    pose = inverse(T_world_object)
    turned = recording.positions @ pose[:3, :3].T + pose[:3, 3]
    return replace(recording, positions=turned)


def frame_from_markers(origin: Floats, along_x: Floats, in_xy: Floats) -> Floats:
    """Pose (4, 4) of a frame from three markers (3,) [m]: its origin, a point on x, one in x-y.

    Raises
    ------
    InputError
        If the markers lie on one line.
    """
    from medkit.geometry import transform, unit

    x, other = unit(along_x - origin), in_xy - origin
    if np.linalg.norm(np.cross(x, other)) < 1e-6:
        raise InputError(
            "Expected three markers that are not on one line, but they are; choose another."
        )
    z = unit(np.cross(x, other))
    return transform(np.stack([x, np.cross(z, x), z], axis=1), origin)


def _rows(recording: Recording, kept: np.ndarray) -> Recording:
    return replace(recording, times=recording.times[kept], positions=recording.positions[kept])
