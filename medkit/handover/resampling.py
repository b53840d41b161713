"""Intervals and tests that respect who gave a rating: t over subjects, bootstrap, permutation."""

from __future__ import annotations

import itertools

import numpy as np
from scipy import stats

from medkit.errors import InputError

Array = np.ndarray


def subject_interval(estimates: Array, *, confidence: float = 0.95) -> tuple[Array, Array, Array]:
    """Return mean and t interval over one estimate per subject.

    With few clusters this is the interval that keeps its promise: each subject is boiled down to
    one number, and the spread of these numbers carries all the uncertainty about people.

    Parameters
    ----------
    estimates : (s, ...) ndarray
        One estimate per subject; missing ones are NaN.
    confidence : float
        Coverage aimed at.

    Returns
    -------
    mean, low, high : ndarray
        The interval is NaN with fewer than two subjects.

    Examples
    --------
    >>> mean, low, high = subject_interval(np.array([1.0, 2.0, 3.0, 4.0]))
    >>> float(mean), float(low.round(2)), float(high.round(2))
    (2.5, 0.45, 4.55)
    """
    estimates = np.asarray(estimates, dtype=float)
    known = np.isfinite(estimates).sum(axis=0)
    filled = np.where(np.isfinite(estimates), estimates, 0.0)
    mean = np.where(known > 0, filled.sum(axis=0) / np.maximum(known, 1), np.nan)
    squares = np.where(np.isfinite(estimates), (estimates - mean) ** 2, 0.0).sum(axis=0)
    error = np.sqrt(squares / np.maximum(known - 1, 1) / np.maximum(known, 1))
    reach = stats.t.ppf((1 + confidence) / 2, np.maximum(known - 1, 1)) * error
    reach = np.where(known > 1, reach, np.nan)
    return mean, mean - reach, mean + reach


def sign_flip_p(estimates: Array) -> float:
    """Return the two-sided p value of flipping the signs of the subjects' estimates.

    The wild cluster bootstrap of a mean with all its 2^s sign patterns. With four subjects it
    cannot fall below 1/8, whatever the data: that is what four people can say about people.

    Parameters
    ----------
    estimates : (s,) ndarray
        One estimate per subject.

    Returns
    -------
    float
        Between 2 / 2^s and 1.

    Examples
    --------
    >>> sign_flip_p(np.array([5.0, 6.0, 7.0, 8.0]))
    0.125
    """
    values = np.asarray(estimates, dtype=float)
    values = values[np.isfinite(values)]
    if len(values) > 16:
        raise InputError(
            f"Expected at most 16 subjects for all sign patterns, came {len(values)}; use the"
            " t interval, which needs no patterns."
        )
    signs = np.array(list(itertools.product((-1, 1), repeat=len(values))))
    flipped = np.abs(signs @ values)
    return float((flipped >= abs(values.sum()) - 1e-12).mean())


def bootstrap_weights(strata: Array, draws: int, rng: np.random.Generator) -> Array:
    """Return how often each cell is drawn when the cells of every stratum are drawn anew.

    Parameters
    ----------
    strata : (n,) ndarray of int
        Cells are exchanged within a stratum only.
    draws : int
        Number of resamples.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    (draws, n) ndarray
        Whole numbers; within a stratum each row adds up to the stratum's size.

    Examples
    --------
    >>> weights = bootstrap_weights(np.array([0, 0, 1]), 5, np.random.default_rng(0))
    >>> weights.sum(axis=1).tolist()
    [3.0, 3.0, 3.0, 3.0, 3.0]
    """
    weights = np.zeros((draws, len(strata)))
    for stratum in np.unique(strata):
        members = np.flatnonzero(strata == stratum)
        share = np.full(len(members), 1 / len(members))
        weights[:, members] = rng.multinomial(len(members), share, size=draws)
    return weights


def permutation_p(
    coefficients: Array, values: Array, strata: Array, *, draws: int, rng: np.random.Generator
) -> float:
    """Return the two-sided p value of a linear statistic when values are shuffled within strata.

    Parameters
    ----------
    coefficients, values : (n,) ndarray
        The statistic is their product's sum.
    strata : (n,) ndarray of int
        Only values of one stratum are exchanged.
    draws : int
        Number of shuffles.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    float
        Never below ``1 / (draws + 1)``, since the data are one of the shuffles.

    Examples
    --------
    >>> x = np.arange(8.0)
    >>> permutation_p(x - 3.5, x, np.zeros(8, int), draws=99, rng=np.random.default_rng(0))
    0.01
    """
    order = np.argsort(strata, kind="stable")
    strata, values = strata[order].astype(float), values[order]
    coefficients = _centred(coefficients[order], strata)
    seen = abs(float(coefficients @ values))
    rounding = 1e-12 * float(np.abs(coefficients) @ np.abs(values))
    reached = 0
    for start in range(0, draws, 200):
        keys = strata + rng.random((min(200, draws - start), len(values)))
        shuffled = values[np.argsort(keys, axis=1)]
        reached += int((np.abs(shuffled @ coefficients) >= seen - rounding).sum())
    return (reached + 1) / (draws + 1)


def holm(p_values: Array) -> Array:
    """Return p values corrected for their number by Holm's step-down rule; NaN stays NaN.

    Examples
    --------
    >>> holm(np.array([0.01, 0.04, 0.03])).round(3).tolist()
    [0.03, 0.06, 0.06]
    """
    p_values = np.asarray(p_values, dtype=float)
    order = np.argsort(p_values)
    count = int(np.isfinite(p_values).sum())
    result = np.full(len(p_values), np.nan)
    result[order[:count]] = np.minimum(
        1, np.maximum.accumulate(p_values[order[:count]] * np.arange(count, 0, -1))
    )
    return result


def _centred(values: Array, strata: Array) -> Array:
    """Subtract the mean of each stratum, so that the statistic's mean under shuffling is zero."""
    index = np.unique(strata, return_inverse=True)[1]
    mean = np.bincount(index, values) / np.bincount(index)
    return np.asarray(values - mean[index])
