"""From tidy recordings to human grasps: five fingertips and a wrist at the end of the reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from medkit.arguments import table_with
from medkit.datasets.human_grasps import COLUMNS, FINGERS, SENSORS
from medkit.errors import InputError
from medkit.geometry import Floats, nonnegative, positive
from medkit.similarity.movements import THRESHOLD, find_movements, settled_sample
from medkit.similarity.recordings import CUTOFF, Recording, lowpassed, resampled, speeds


@dataclass(frozen=True)
class HumanGrasps:
    """Human grasps, struct of arrays, in the object's frame, fingers thumb to little."""

    subject: np.ndarray  # (n,) str
    object: np.ndarray  # (n,) str
    trial: np.ndarray  # (n,) int
    fingertips: Floats  # (n, 5, 3) [m]
    wrist: Floats  # (n, 3) [m]
    duration: Floats  # (n,) [s] of the reach
    simulated: np.ndarray  # (n,) bool

    def __len__(self) -> int:
        return len(self.subject)

    def of(self, *, subject: str | None = None, object: str | None = None) -> HumanGrasps:  # noqa: A002
        """Return the grasps of one subject, one object, or both.

        Raises
        ------
        InputError
            If none is left.
        """
        kept = np.ones(len(self), dtype=bool)
        if subject is not None:
            kept &= self.subject == subject
        if object is not None:
            kept &= self.object == object
        if not kept.any():
            raise InputError(
                f"Expected grasps of subject {subject or 'any'} on object {object or 'any'}, but"
                f" there are none; subjects are {', '.join(sorted(set(self.subject)))}, objects"
                f" {', '.join(sorted(set(self.object)))}."
            )
        return self.rows(np.flatnonzero(kept))

    def rows(self, index: np.ndarray) -> HumanGrasps:
        """Return the grasps at the given rows."""
        return HumanGrasps(
            self.subject[index], self.object[index], self.trial[index], self.fingertips[index],
            self.wrist[index], self.duration[index], self.simulated[index],
        )  # fmt: skip

    def subjects(self) -> list[str]:
        """Names of the subjects, sorted."""
        return sorted(set(self.subject.tolist()))


def recording_from_rows(rows: pd.DataFrame) -> Recording:
    """Turn the tidy rows of one trial into a recording of the six trackers.

    Raises
    ------
    InputError
        If a tracker is missing or an instant occurs twice.
    """
    absent = [name for name in SENSORS if name not in set(rows["sensor"])]
    if absent:
        raise InputError(
            f"Expected the trackers {', '.join(SENSORS)} in a trial, but {', '.join(absent)} is"
            " missing; run medkit.similarity.validate on the table."
        )
    if bool(rows.duplicated(["t", "sensor"]).any()):
        raise InputError(
            "Expected one row per instant and tracker, but some occur twice; run"
            " medkit.similarity.validate on the table."
        )
    wide = rows.pivot(index="t", columns="sensor", values=["x", "y", "z"])
    positions = np.stack(
        [wide[axis][list(SENSORS)].to_numpy(dtype=float) for axis in "xyz"], axis=2
    )
    return Recording(SENSORS, wide.index.to_numpy(dtype=float), positions)


def grasps_from_recordings(
    table: pd.DataFrame,
    *,
    cutoff: float = CUTOFF,
    threshold: float = THRESHOLD,
    rate: float = 100.0,
    settle: float = 0.0,
) -> tuple[HumanGrasps, pd.DataFrame]:
    """Find the grasp of every trial: filter, wrist speed, end of the first reach (P13 6.2.2).

    Parameters
    ----------
    table : pandas.DataFrame
        Tidy recordings in the object's frame, as `medkit.datasets.load_human_grasps` returns.
    cutoff : float
        Cut-off of the low-pass [Hz].
    threshold : float
        Wrist speed [m/s] at start and end.
    rate : float
        Clock [Hz] on which trials are put.
    settle : float
        Look for the stillest instant up to so long after the end [s]; 0 takes the end itself,
        as P13 does.

    Returns
    -------
    HumanGrasps
        The trials in which a grasp was found.
    pandas.DataFrame
        The others: subject, object, trial and why.

    Raises
    ------
    InputError
        If no table came, a setting does not fit, no trial gives a grasp, or a trial cannot be
        read as a recording.

    Examples
    --------
    >>> from medkit.datasets import load_human_grasps
    >>> table = load_human_grasps()
    >>> grasps, failed = grasps_from_recordings(table[table["trial"] == 1])
    >>> grasps.fingertips.shape, len(failed)
    ((10, 5, 3), 0)
    """
    remedy = "pass one from medkit.datasets.load_human_grasps"
    table_with(table, tuple(COLUMNS), "a table of recordings", remedy)
    positive(threshold, "threshold", " m/s")
    settle = nonnegative(settle, "settle", " s")
    found, failed = [], []
    for (subject, name, trial), rows in table.groupby(["subject", "object", "trial"], sort=True):
        smooth = lowpassed(resampled(recording_from_rows(rows), rate=rate), cutoff=cutoff)
        outcome = _end_of_reach(smooth, threshold, settle)
        if isinstance(outcome, str):
            failed.append((subject, name, trial, outcome))
            continue
        at_end, duration = outcome
        labels = (str(subject), str(name), int(str(trial)))
        found.append((*labels, at_end, duration, bool(rows["simulated"].iloc[0])))
    if not found:
        raise InputError(
            f"Expected at least one trial with a grasp, but none of {len(failed)} has one"
            f" ({failed[0][3] if failed else 'the table is empty'}); run"
            " medkit.similarity.validate on the table."
        )
    columns = ["subject", "object", "trial", "why"]
    return _stacked(found), pd.DataFrame(failed, columns=columns)


def _end_of_reach(smooth: Recording, threshold: float, settle: float) -> tuple[Floats, float] | str:
    """Positions (6, 3) at the end of the first reach and its duration, or why there is none."""
    speed = speeds(smooth)[:, SENSORS.index("wrist")]
    movements = find_movements(smooth.times, speed, threshold=threshold)
    if not movements:
        return "the wrist never moved faster than the threshold"
    reach = movements[0]
    if not reach.end_seen:
        return "the recording ends before the reach does"
    sample = settled_sample(reach, speed, smooth.times, within=settle) if settle else reach.end
    at_end = smooth.positions[sample]
    if not np.all(np.isfinite(at_end)):
        unseen = [SENSORS[i] for i in np.flatnonzero(~np.isfinite(at_end).all(axis=1))]
        return f"{', '.join(unseen)} not seen at the end of the reach"
    return at_end, float(smooth.times[reach.end] - smooth.times[reach.start])


def _stacked(found: list[tuple[str, str, int, Floats, float, bool]]) -> HumanGrasps:
    subject, name, trial, ends, duration, simulated = zip(*found, strict=True)
    places = np.stack(ends)
    fingers = len(FINGERS)
    return HumanGrasps(
        np.array(subject), np.array(name), np.array(trial), places[:, :fingers],
        places[:, fingers], np.array(duration), np.array(simulated),
    )  # fmt: skip
