"""Tables of an experiment's counts: yields with their intervals, means over objects, reasons."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from statsmodels.stats.proportion import proportion_confint

from medkit.geometry import Floats
from medkit.grasping.grasp_set import FORCE_CLOSURE, OUTCOMES

#: What identifies a setting in a table of counts.
COLUMNS = ["planner", "grasp", "search_radius", "min_radius_ratio"]


def interval_pct(held: ArrayLike, tested: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Shares [%] with Wilson's 95 % interval; a share of nothing is 0 with the whole range.

    Parameters
    ----------
    held, tested : array-like of int, shape (n,)
        Counts.

    Returns
    -------
    share, low, high : ndarray, shape (n,)
        In percent.

    Examples
    --------
    >>> [round(float(value[0]), 1) for value in interval_pct([8], [10])]
    [80.0, 49.0, 94.3]
    """
    count, of = np.asarray(held, dtype=float), np.maximum(np.asarray(tested, dtype=float), 1e-12)
    share = 100.0 * count / of
    low, high = (100.0 * bound for bound in proportion_confint(count, of, method="wilson"))
    # rounding may put an interval that ends at 0 or 100 % a hair inside its share
    return share, np.minimum(low, share), np.maximum(high, share)


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

    Examples
    --------
    >>> from medkit.grasping.study import load_study
    >>> row = yield_table(load_study(1)).iloc[0]
    >>> row.object, bool(row.low_pct < row.yield_pct < row.high_pct)
    ('glasses', True)
    """
    share, low, high = interval_pct(results[FORCE_CLOSURE], results.tested)
    table = results[["object", *COLUMNS, "tested"]].copy()
    table["yield_pct"] = np.where(results.tested > 0, share, np.nan)
    table["low_pct"], table["high_pct"] = low, high
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

    Examples
    --------
    >>> from medkit.grasping.study import load_study
    >>> means = mean_yields(load_study(1), rng=np.random.default_rng(0))
    >>> means.planner.tolist(), set(means.objects.tolist())
    (['medial', 'medial-plus', 'normals', 'boxes'], {10})
    """
    rows = []
    for key, part in yield_table(results).dropna(subset="yield_pct").groupby(COLUMNS, sort=False):
        values = part.yield_pct.to_numpy()
        means = values[rng.integers(0, len(values), (resamples, len(values)))].mean(axis=1)
        low, high = np.percentile(means, [2.5, 97.5])
        rows.append([*key, values.mean(), low, high, len(values)])
    return pd.DataFrame(rows, columns=[*COLUMNS, "yield_pct", "low_pct", "high_pct", "objects"])


def ratio_of_means(
    above: pd.DataFrame, below: pd.DataFrame, *, rng: np.random.Generator, resamples: int = 2000
) -> tuple[float, float, float]:
    """How many times the mean yield of one setting is that of another, on the same objects.

    Parameters
    ----------
    above, below : pandas.DataFrame
        Rows of one setting each, from `run_experiment`, one row an object.
    rng : numpy.random.Generator
        Draws the resamples of objects; both settings keep the same ones.
    resamples : int
        How many.

    Returns
    -------
    ratio, low, high : float
        With a 95 % bootstrap interval over objects; infinite where the lower mean is zero.

    Examples
    --------
    >>> from medkit.grasping.study import load_study
    >>> parts = dict(iter(load_study(1).groupby("planner")))
    >>> pair = parts["medial"], parts["normals"]
    >>> ratio, low, high = ratio_of_means(*pair, rng=np.random.default_rng(0))
    >>> 1.0 < low < ratio < high
    True
    """
    share = [
        yield_table(part).set_index("object").yield_pct.loc[list(above.object)].to_numpy()
        for part in (above, below)
    ]
    drawn = rng.integers(0, len(share[0]), (resamples, len(share[0])))
    with np.errstate(divide="ignore"):
        ratios = share[0][drawn].mean(axis=1) / share[1][drawn].mean(axis=1)
        ratio = share[0].mean() / share[1].mean()
    low, high = np.percentile(ratios, [2.5, 97.5])
    return float(ratio), float(min(low, ratio)), float(max(high, ratio))


def failure_reasons(results: pd.DataFrame) -> pd.DataFrame:
    """Share of each outcome among the tested candidates of each setting.

    Parameters
    ----------
    results : pandas.DataFrame
        From `run_experiment`.

    Returns
    -------
    pandas.DataFrame
        One row a setting, one column an outcome [%]; rows add to 100.

    Examples
    --------
    >>> from medkit.grasping.study import load_study
    >>> bool(np.allclose(failure_reasons(load_study(1)).sum(axis=1), 100.0))
    True
    """
    counts = results.groupby(COLUMNS, sort=False)[list(OUTCOMES)].sum()
    return 100.0 * counts.div(counts.sum(axis=1), axis=0)
