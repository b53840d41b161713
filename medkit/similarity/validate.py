"""What is wrong with a table of recordings, said row group by row group; nothing is mended."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from medkit.arguments import table_with
from medkit.datasets.human_grasps import COLUMNS, OBJECT_COLUMNS, SENSORS
from medkit.geometry import expected

#: Wrist and fingertips further than this [m] from the object's centre cannot be metres.
FAR = 5.0
#: At the still instant of a grasp the fingers are within this distance [m] of the object.
NEAR_OBJECT = 0.15
#: A hand's own size [m]: greatest distance of two trackers of one hand.
HAND = 0.40
#: Faster than people reach [m/s]: a jump.
FASTEST = 8.0


def validate(table: pd.DataFrame, objects: pd.DataFrame | None = None) -> pd.DataFrame:
    """Check recordings and say per group of rows what is wrong with them.

    Parameters
    ----------
    table : pandas.DataFrame
        Tidy recordings, as `medkit.datasets.load_human_grasps` returns them.
    objects : pandas.DataFrame, optional
        Sizes, as `medkit.datasets.load_human_objects` returns them; lets the frame be checked.

    Returns
    -------
    pandas.DataFrame
        One row per finding: severity ("error", "warning"), rows (where), problem, advice. Empty
        when nothing was found.

    Raises
    ------
    InputError
        If something else than a table came; a table that lacks columns is a finding.

    Examples
    --------
    >>> from medkit.datasets import load_human_grasps, load_human_objects
    >>> table = load_human_grasps()
    >>> len(validate(table[table["trial"] < 3], load_human_objects()))
    0
    """
    remedy = "pass one from medkit.datasets.load_human_grasps"
    expected(table, pd.DataFrame, "a table of recordings", remedy)
    if objects is not None:
        remedy = "pass one from medkit.datasets.load_human_objects"
        table_with(objects, OBJECT_COLUMNS[2:], "a table of objects", remedy)
    missing = [column for column in COLUMNS if column not in table.columns]
    if missing:
        findings = [("error", "whole table", f"the columns {', '.join(missing)} are missing",
                     "add them; docs/adding_recordings.md says what they mean")]  # fmt: skip
        return _report(findings)
    findings = list(_duplicate_trials(table))
    for (subject, name, trial), rows in table.groupby(["subject", "object", "trial"], sort=True):
        where = f"subject {subject}, object {name}, trial {trial}"
        findings += _trial_findings(rows, where)
        if objects is not None:
            findings += _frame_findings(rows, str(name), objects, where)
    return _report(findings)


Finding = tuple[str, str, str, str]


def _report(findings: list[Finding]) -> pd.DataFrame:
    return pd.DataFrame(findings, columns=["severity", "rows", "problem", "advice"])


def _trial_findings(rows: pd.DataFrame, where: str) -> Iterator[Finding]:
    yield from _sensor_findings(rows, where)
    yield from _time_findings(rows, where)
    size = _hand_size(rows)
    yield from _unit_findings(rows, where, size)
    yield from _gap_findings(rows, where)
    if size < 10.0 * HAND:
        yield from _jump_findings(rows, where)
    if rows["simulated"].nunique() > 1:
        yield ("error", where, "simulated and recorded rows are mixed in one trial",
               "give every row of a trial the same mark")  # fmt: skip


def _sensor_findings(rows: pd.DataFrame, where: str) -> Iterator[Finding]:
    present = set(rows["sensor"])
    absent = [name for name in SENSORS if name not in present]
    strange = sorted(present - set(SENSORS))
    if absent:
        yield ("error", where, f"no rows of {', '.join(absent)}",
               "record all six trackers, or compare fewer fingers")  # fmt: skip
    if strange:
        yield ("error", where, f"unknown sensor {', '.join(strange)}",
               f"use the names {', '.join(SENSORS)}")  # fmt: skip


def _time_findings(rows: pd.DataFrame, where: str) -> Iterator[Finding]:
    if not np.all(np.isfinite(rows["t"])):
        yield ("error", where, "time stamps are missing", "every row needs a time [s]")
    for sensor, track in rows.groupby("sensor", sort=False):
        steps = np.diff(track["t"].to_numpy())
        back = np.flatnonzero(steps < 0.0)
        if back.size:
            yield ("error", f"{where}, {sensor}",
                   f"time runs backwards at {back.size} places, first after t ="
                   f" {track['t'].iloc[back[0]]:.3f} s",
                   "mend the export, or drop the samples with only_forward_in_time")  # fmt: skip
        if np.any(steps == 0.0):
            yield ("error", f"{where}, {sensor}",
                   f"{int(np.sum(steps == 0.0))} instants occur twice",
                   "remove the copies")  # fmt: skip
    span = float(rows["t"].max() - rows["t"].min())
    if span > 120.0:
        yield ("error", where, f"the trial lasts {span:.0f} s: milliseconds?", "give seconds")


def _unit_findings(rows: pd.DataFrame, where: str, size: float) -> Iterator[Finding]:
    far = float(np.nanmax(np.abs(rows[["x", "y", "z"]].to_numpy()), initial=0.0))
    if far > FAR or size > 10.0 * HAND:
        yield ("error", where,
               f"positions reach {far:.3g} and the hand spans {size:.3g}: millimetres?",
               "give metres; nothing is converted here")  # fmt: skip
    elif size > HAND:
        yield (
            "warning",
            where,
            f"the hand spans {size:.2f} m",
            "check that sensors are not swapped",
        )
    elif 0.0 < size < 0.03:
        yield ("error", where, f"the hand spans only {size:.3g} m", "check the unit: metres")


def _hand_size(rows: pd.DataFrame) -> float:
    """Median over time of the largest distance [file's unit] of two trackers of the hand."""
    wide = rows.pivot_table(index="t", columns="sensor", values=["x", "y", "z"], aggfunc="first")
    places = np.stack([wide[axis].to_numpy(dtype=float) for axis in "xyz"], axis=2)
    spans = np.nanmax(places, axis=1, initial=-np.inf) - np.nanmin(places, axis=1, initial=np.inf)
    spans = np.linalg.norm(np.where(np.isfinite(spans), spans, np.nan), axis=1)
    return float(np.nanmedian(spans)) if np.any(np.isfinite(spans)) else 0.0


def _gap_findings(rows: pd.DataFrame, where: str) -> Iterator[Finding]:
    for sensor, track in rows.groupby("sensor", sort=False):
        unseen = track[["x", "y", "z"]].isna().any(axis=1).to_numpy()
        if unseen.mean() > 0.3:
            yield ("error" if unseen.all() else "warning", f"{where}, {sensor}",
                   f"not seen in {100.0 * unseen.mean():.0f} % of the samples",
                   "leave the trial out, or record it again")  # fmt: skip


def _jump_findings(rows: pd.DataFrame, where: str) -> Iterator[Finding]:
    for sensor, track in rows.groupby("sensor", sort=False):
        seen = track.dropna(subset=["x", "y", "z"])
        steps = np.diff(seen["t"].to_numpy())
        moves = np.linalg.norm(np.diff(seen[["x", "y", "z"]].to_numpy(), axis=0), axis=1)
        jumps = np.flatnonzero(moves > FASTEST * np.maximum(steps, 1e-9) + 0.01)
        if jumps.size:
            at = int(jumps[0])
            yield ("warning", f"{where}, {sensor}",
                   f"jumps by {moves[at]:.3f} m at t = {seen['t'].iloc[at]:.3f} s",
                   "check for swapped or re-found trackers")  # fmt: skip


def _frame_findings(
    rows: pd.DataFrame, name: str, objects: pd.DataFrame, where: str
) -> Iterator[Finding]:
    if name not in objects.index:
        yield ("error", where, f"object {name} is not in objects.csv", "add a row with its size")
        return
    extents = objects.loc[name, ["extent_x", "extent_y", "extent_z"]].to_numpy(dtype=float)
    reach = 0.5 * float(np.linalg.norm(extents))
    tips = rows[rows["sensor"] != "wrist"].groupby("t")[["x", "y", "z"]].mean().to_numpy()
    distance = np.linalg.norm(tips, axis=1)
    nearest = float(np.nanmin(distance, initial=np.inf))
    if FAR > nearest > reach + NEAR_OBJECT:
        yield ("error", where,
               f"the fingers never come nearer to the origin than {nearest:.2f} m",
               "give positions in the object's frame, origin at its centre of mass")  # fmt: skip
    lowest = float(np.nanmin(rows["z"], initial=np.inf))
    height = float(np.asarray(objects.loc[name, "extent_z"], dtype=float))
    if -FAR < lowest < -0.5 * height - 0.10:
        yield ("error", where, f"trackers at z = {lowest:.2f} m lie below the table",
               "turn the frame so that z points up from the table")  # fmt: skip


def _duplicate_trials(table: pd.DataFrame) -> Iterator[Finding]:
    """Trials whose positions equal those of another to the last digit."""
    first: dict[int, str] = {}
    for key, rows in table.groupby(["subject", "object", "trial"], sort=True):
        where = "subject {}, object {}, trial {}".format(*key)
        mark = int(
            pd.util.hash_pandas_object(rows[["sensor", "t", "x", "y", "z"]], index=False).sum()
        )
        if mark in first:
            yield ("error", where, f"the same numbers as {first[mark]}", "remove one of the two")
        first.setdefault(mark, where)
