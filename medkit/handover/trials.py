"""Trial tables for analysis: irregular cells treated in the open, ratings turned into scores."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Literal

import numpy as np
import pandas as pd

from medkit.arguments import one_of, table_with
from medkit.datasets.handover_schema import KEY, RATINGS
from medkit.datasets.handover_trials import load_handover_table
from medkit.errors import InputError
from medkit.geometry import expected, positive

Irregular = Literal["drop", "keep", "best", "worst"]

#: Points of a rating (source: L14 section 4.2).
POINTS = {"good": 1.0, "acceptable": 0.5, "bad": 0.0}


def load_trials(
    path: str | os.PathLike[str] | None = None,
    *,
    irregular: Irregular = "drop",
    ratings: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Return a table of handover trials, one row per cell (source: L14 figures 4.5 to 4.8).

    Parameters
    ----------
    path : path-like, optional
        A lab's own table in the same schema; the thesis's table when left out.
    irregular : {"drop", "keep", "best", "worst"}
        What becomes of cells whose ratings do not add up to the repetitions of the table:
        left out, kept as printed, or completed with ratings "good" or "bad". The last two
        bracket whatever was lost. Cells with too many ratings are kept as they are by them.
    ratings : mapping, optional
        From another rating scale to good, acceptable, bad; see
        :func:`medkit.datasets.handover_trials.load_handover_table`.

    Returns
    -------
    pandas.DataFrame
        Columns pose, mode, force_N [N], weight_g [g], subject, good, acceptable, bad
        [ratings], sum_ok. ``attrs`` holds the cells read, the irregular ones among them, the
        treatment and the repetitions; :func:`describe_trials` says it in a sentence.

    Raises
    ------
    InputError
        If the table cannot be used; names the first bad line and how many there are.

    Examples
    --------
    >>> trials = load_trials()
    >>> len(trials), trials.attrs["irregular"], trials.attrs["treatment"]
    (855, 9, 'drop')
    """
    one_of(irregular, ("drop", "keep", "best", "worst"), "irregular")
    table = load_handover_table(path, ratings=ratings)
    repetitions = int(table.loc[table["sum_ok"], list(RATINGS)].iloc[0].sum())
    treated = _treated(table, irregular, repetitions)
    treated.attrs = {
        "cells": len(table),
        "irregular": int((~table["sum_ok"]).sum()),
        "treatment": irregular,
        "repetitions": repetitions,
    }
    return treated


def _treated(table: pd.DataFrame, irregular: Irregular, repetitions: int) -> pd.DataFrame:
    if irregular == "drop":
        return table[table["sum_ok"]].reset_index(drop=True)
    table = table.copy()
    if irregular in ("best", "worst"):
        lost = (repetitions - table[list(RATINGS)].sum(axis=1)).clip(lower=0)
        table["good" if irregular == "best" else "bad"] += lost
    return table


def describe_trials(trials: pd.DataFrame) -> str:
    """Say in one sentence what a table holds and what became of its irregular cells.

    Examples
    --------
    >>> print(describe_trials(load_trials()))
    3420 ratings by 4 subjects in 855 cells; 9 of 864 cells do not add up to 4 and were dropped.
    """
    total = int(trial_table(trials)[list(RATINGS)].to_numpy().sum())
    text = f"{total} ratings by {trials['subject'].nunique()} subjects in {len(trials)} cells"
    if "irregular" not in trials.attrs:
        return text + "."
    fate = {
        "drop": "were dropped",
        "keep": "were kept as printed",
        "best": "were completed with good",
        "worst": "were completed with bad",
    }[trials.attrs["treatment"]]
    if not trials.attrs["irregular"]:
        return text + "; every cell adds up."
    return (
        f"{text}; {trials.attrs['irregular']} of {trials.attrs['cells']} cells do not add up to"
        f" {trials.attrs['repetitions']} and {fate}."
    )


def with_light_object(
    trials: pd.DataFrame, *, weight_g: int = 20, printed_g: int = 24
) -> pd.DataFrame:
    """Return the trials with the lightest object read as another weight.

    The table's heading says ``24g*``, the running text 20 g (L14 section 4.2).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`load_trials`.
    weight_g, printed_g : int
        The weight to put in, and the one to replace [g].

    Returns
    -------
    pandas.DataFrame
        A copy.

    Examples
    --------
    >>> int(with_light_object(load_trials())["weight_g"].min())
    20
    """
    for name, value in (("weight_g", weight_g), ("printed_g", printed_g)):
        positive(value, name, " g")
    changed = trial_table(trials).copy()
    changed["weight_g"] = changed["weight_g"].replace({printed_g: weight_g})
    return changed


def trial_table(trials: pd.DataFrame) -> pd.DataFrame:
    """Return the table as it is; `InputError` where something else came."""
    remedy = "pass a table from load_trials"
    return expected(trials, pd.DataFrame, "a table of trials", remedy)


def score(trials: pd.DataFrame) -> pd.Series:
    """Return the score of every cell: good 1, acceptable 0.5, bad 0, averaged (L14 section 4.2).

    Parameters
    ----------
    trials : pandas.DataFrame
        With count columns good, acceptable and bad, at least one rating in a row.

    Returns
    -------
    pandas.Series
        One score in [0, 1] per row, with the rows' index, named ``score``.

    Raises
    ------
    InputError
        If no table came, a count column is missing or a row holds no rating.

    Examples
    --------
    >>> score(pd.DataFrame({"good": [4, 1], "acceptable": [0, 2], "bad": [0, 1]})).tolist()
    [1.0, 0.5]
    """
    counts = rating_counts(trials)
    points = np.array([POINTS[level] for level in RATINGS])
    return pd.Series(counts @ points / counts.sum(axis=1), index=trials.index, name="score")


def rating_counts(trials: pd.DataFrame) -> np.ndarray:
    """Return the counts good, acceptable, bad of every row as an (n, 3) array, checked."""
    absent = [level for level in RATINGS if level not in trial_table(trials).columns]
    if absent:
        raise InputError(
            f"Expected count columns good, acceptable and bad, but {absent[0]} is missing;"
            " pass a table from load_trials."
        )
    counts = trials[list(RATINGS)].to_numpy(dtype=float)
    empty = np.flatnonzero(~(counts.sum(axis=1) > 0) | (counts < 0).any(axis=1))
    if len(empty):
        raise InputError(
            f"Expected at least one rating in every row, but row {empty[0]} holds"
            f" {counts[empty[0]].tolist()}; drop the {len(empty)} rows without ratings."
        )
    return counts


def rating_shares(trials: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """Return the share of each rating for every combination of the columns `by`.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`load_trials`.
    by : list of str
        Columns that stay apart; the rest is pooled.

    Returns
    -------
    pandas.DataFrame
        Index `by`; columns good, acceptable, bad (adding up to one) and ratings [count].

    Examples
    --------
    >>> rating_shares(load_trials(), ["pose"])["good"].round(3).tolist()
    [0.368, 0.287]
    """
    table_with(trial_table(trials), RATINGS, "a table of trials", "pass one from load_trials")
    counts = trials.groupby(kept_apart(trials, by))[list(RATINGS)].sum()
    total = counts.sum(axis=1)
    return counts.div(total, axis=0).assign(ratings=total)


def mean_scores(trials: pd.DataFrame, by: list[str]) -> pd.Series:
    """Return the mean of the cell scores for every combination of the columns `by`.

    Examples
    --------
    >>> mean_scores(load_trials(), ["force_N"]).round(2).iloc[[0, -1]].tolist()
    [0.96, 0.02]
    """
    scored = trial_table(trials).assign(score=score(trials))
    return scored.groupby(kept_apart(trials, by))["score"].mean()


def kept_apart(trials: pd.DataFrame, by: list[str]) -> list[str]:
    """Return the columns `by` as they are; `InputError` where one is no column of the trials."""
    remedy = 'pass a list such as ["pose", "mode"]'
    names = [by] if isinstance(by, str) else expected(by, (list, tuple), "columns as by", remedy)
    if not names:
        raise InputError(f"Expected columns as by, but the list is empty; {remedy}.")
    for name in names:
        one_of(name, map(str, trials.columns), "columns as by", remedy)
    return by


def cells_of(
    trials: pd.DataFrame, pose: str | None = None, mode: str | None = None
) -> pd.DataFrame:
    """Return the rows of one pose and one mode, or of all where None is passed.

    Raises
    ------
    InputError
        If nothing is left.
    """
    keep = np.ones(len(trial_table(trials)), dtype=bool)
    for column, value in (("pose", pose), ("mode", mode)):
        if value is not None:
            keep &= (trials[column] == value).to_numpy()
    if not keep.any():
        raise InputError(
            f"Expected trials in pose {pose} and mode {mode}, but the table has"
            f" poses {sorted(trials['pose'].unique())} and modes {sorted(trials['mode'].unique())};"
            " pick among them."
        )
    return trials[keep]


def missing_cells(trials: pd.DataFrame) -> int:
    """Return how many cells of the full crossing (per pose) the table lacks."""
    full = 0
    for _, part in trial_table(trials).groupby("pose"):
        full += int(np.prod([part[name].nunique() for name in KEY[1:]]))
    return full - len(trials)
