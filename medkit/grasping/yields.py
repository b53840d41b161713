"""Tables of an experiment's counts: yields with their intervals, means over objects, reasons."""

from __future__ import annotations

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from medkit.grasping.grasp_set import FORCE_CLOSURE, OUTCOMES

#: What identifies a setting in a table of counts.
COLUMNS = ["planner", "grasp", "search_radius", "min_radius_ratio"]


def yield_table(results: pd.DataFrame) -> pd.DataFrame:
    """Yield of every object and setting with its Wilson interval.

    Parameters
    ----------
    results : pandas.DataFrame
        From `run_experiment`.

    Returns
    -------
    pandas.DataFrame
        ``yield_pct``, ``low_pct``, ``high_pct`` [%] (95 %) and ``tested``.
    """
    low, high = proportion_confint(
        results[FORCE_CLOSURE].to_numpy(), np.maximum(results.tested.to_numpy(), 1), method="wilson"
    )
    table = results[["object", *COLUMNS, "tested"]].copy()
    table["yield_pct"] = 100.0 * results[FORCE_CLOSURE] / results.tested.where(results.tested > 0)
    table["low_pct"], table["high_pct"] = 100.0 * low, 100.0 * high
    return table


def mean_yields(
    results: pd.DataFrame, *, rng: np.random.Generator, resamples: int = 2000
) -> pd.DataFrame:
    """Mean over objects of the yield of each setting, with a bootstrap interval over objects.

    Parameters
    ----------
    results : pandas.DataFrame
        From `run_experiment`.
    rng : numpy.random.Generator
        Draws the resamples.
    resamples : int
        How many.

    Returns
    -------
    pandas.DataFrame
        One row a setting: ``yield_pct``, ``low_pct``, ``high_pct`` [%] (95 %), ``objects``.
    """
    rows = []
    for key, part in yield_table(results).dropna(subset="yield_pct").groupby(COLUMNS, sort=False):
        values = part.yield_pct.to_numpy()
        means = values[rng.integers(0, len(values), (resamples, len(values)))].mean(axis=1)
        low, high = np.percentile(means, [2.5, 97.5])
        rows.append([*key, values.mean(), low, high, len(values)])
    return pd.DataFrame(rows, columns=[*COLUMNS, "yield_pct", "low_pct", "high_pct", "objects"])


def failure_reasons(results: pd.DataFrame) -> pd.DataFrame:
    """Share of each outcome among the tested candidates of each setting [%], rows adding to 100."""
    counts = results.groupby(COLUMNS, sort=False)[list(OUTCOMES)].sum()
    return 100.0 * counts.div(counts.sum(axis=1), axis=0)
