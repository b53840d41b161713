"""Cumulative logit on counts of bad, acceptable, good: many data sets at once, by Newton's method.

The probability of a rating at or below level k is ``logistic(threshold_k - eta)`` with
``eta = x . coefficients``, so a larger coefficient means better ratings. statsmodels' OrderedModel
fits the same model to one row per rating in a tenth of a second; the claims need thousands of fits,
hence this one, which takes counts and a stack of data sets that share their design.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from medkit.arguments import number_array
from medkit.errors import InputError
from medkit.geometry import nonnegative, positive

Array = np.ndarray


@dataclass(frozen=True)
class CumulativeLogit:
    """Fits of one design to a stack of m data sets.

    Attributes
    ----------
    thresholds : (m, 2) ndarray
        Between bad and acceptable, and between acceptable and good [log-odds].
    coefficients : (m, p) ndarray
        Change of the log-odds of a better rating per unit of each column.
    covariance : (m, p + 2, p + 2) ndarray
        Inverse information, thresholds first. Trusts every rating as independent news.
    log_likelihood : (m,) ndarray
        At the estimate.
    converged : (m,) ndarray of bool
        Whether the last Newton step was negligible.
    """

    thresholds: Array
    coefficients: Array
    covariance: Array
    log_likelihood: Array
    converged: Array


def fit_cumulative_logit(
    design: Array, counts: Array, *, ridge: float = 1e-3, tolerance: float = 1e-8,
    start: Array | None = None,
) -> CumulativeLogit:  # fmt: skip
    """Fit the cumulative logit to one or many tables of counts.

    Parameters
    ----------
    design : (n, p) ndarray
        One row per cell, no constant column (the thresholds are the constants).
    counts : (n, 3) or (m, n, 3) ndarray
        Ratings bad, acceptable, good of each cell; a row of zeros is a missing cell.
    ridge : float
        Weight of the squared parameters taken from the log-likelihood. The default (a prior of
        standard deviation 30) moves no estimate visibly and keeps one finite when a data set
        holds one kind of rating only.
    tolerance : float
        Largest change of a parameter at which the iteration ends.
    start : (p + 2,) ndarray, optional
        Thresholds and coefficients to start from.

    Returns
    -------
    CumulativeLogit
        With m = 1 for a single table.

    Raises
    ------
    InputError
        If the shapes do not match, a number is not one that can be, or no cell has a rating.

    Examples
    --------
    >>> force = np.array([[1.0], [2.0], [3.0]])
    >>> counts = np.array([[1, 3, 16], [5, 10, 5], [16, 3, 1]])
    >>> fit = fit_cumulative_logit(force, counts)
    >>> bool(fit.coefficients[0, 0] < 0), bool(fit.converged[0])
    (True, True)
    """
    design = number_array(design, "a design", "pass one row per cell")
    counts = number_array(counts, "counts", "pass bad, acceptable, good of every cell")
    counts = counts[None] if counts.ndim == 2 else counts
    _check(design, counts)
    ridge, tolerance = nonnegative(ridge, "ridge"), positive(tolerance, "tolerance")
    point = _start(design, counts) if start is None else _given_start(start, design, counts)
    value = _objective(design, counts, point, ridge)
    done = np.zeros(len(counts), dtype=bool)
    for _ in range(60):
        live = np.flatnonzero(~done)
        gradient, hessian = _derivatives(design, counts[live], point[live], ridge)
        step = np.linalg.solve(hessian, gradient[..., None])[..., 0]
        point[live], value[live] = _line_search(
            design, counts[live], point[live], -step, value[live], ridge
        )
        done[live] = np.abs(step).max(axis=1) < tolerance * (1 + np.abs(point[live]).max(axis=1))
        if done.all():
            break
    hessian = _derivatives(design, counts, point, ridge)[1]
    likelihood = _log_likelihood(design, counts, point)
    return CumulativeLogit(point[:, :2], point[:, 2:], np.linalg.inv(-hessian), likelihood, done)


def rating_probabilities(eta: Array, thresholds: Array) -> Array:
    """Return the probabilities of bad, acceptable, good for linear predictors `eta`.

    Parameters
    ----------
    eta : (...) ndarray
        Linear predictor [log-odds].
    thresholds : (2,) or broadcastable (..., 2) ndarray
        Ascending thresholds.

    Returns
    -------
    (..., 3) ndarray
        Adding up to one.

    Examples
    --------
    >>> rating_probabilities(np.array(0.0), np.array([-1.0, 1.0])).round(3).tolist()
    [0.269, 0.462, 0.269]
    """
    eta = number_array(eta, "linear predictors", "pass one number per cell")
    thresholds = number_array(thresholds, "thresholds", "pass two that ascend")
    if thresholds.shape[-1:] != (2,) or np.any(np.isnan(thresholds)):
        raise InputError(
            f"Expected two thresholds, but got shape {thresholds.shape} or NaN; pass two that"
            " ascend, between bad and acceptable and between acceptable and good."
        )
    below = _logistic(thresholds - eta[..., None])
    first, second = below[..., 0], below[..., 1]
    return np.stack([first, second - first, 1.0 - second], axis=-1)


def expected_score(eta: Array, thresholds: Array) -> Array:
    """Return the expected score (bad 0, acceptable 0.5, good 1) for linear predictors `eta`."""
    return rating_probabilities(eta, thresholds) @ np.array([0.0, 0.5, 1.0])


def eta_at_score(level: float, thresholds: Array) -> Array:
    """Return the linear predictor at which the expected score equals `level`.

    Parameters
    ----------
    level : float
        Between 0 and 1.
    thresholds : (..., 2) ndarray
        Ascending thresholds [log-odds].

    Returns
    -------
    (...) ndarray
        Linear predictor [log-odds]; the positive root of a quadratic in its exponential.

    Examples
    --------
    >>> thresholds = np.array([-1.0, 2.0])
    >>> round(float(expected_score(eta_at_score(0.7, thresholds), thresholds)), 12)
    0.7
    """
    if not isinstance(level, int | float | np.number) or not 0 < level < 1:
        raise InputError(
            f"Expected a score level between 0 and 1, came {str(level)[:40]}; 0.75 lies halfway"
            " between acceptable and good."
        )
    # shifted by the mean threshold, so that the exponentials stay near one
    middle = thresholds.mean(axis=-1)
    half = np.exp((thresholds[..., 1] - thresholds[..., 0]) / 2)
    linear = (half + 1 / half) * (1 - 2 * level)
    root = np.sqrt(linear**2 + 16 * level * (1 - level))
    # the form without cancellation on either side of level 1/2
    positive = np.where(
        linear > 0, 4 * level / (linear + root), (root - linear) / (4 * (1 - level))
    )
    return middle + np.log(positive)


def _check(design: Array, counts: Array) -> None:
    if design.ndim != 2 or counts.ndim != 3 or counts.shape[1:] != (len(design), 3):
        raise InputError(
            f"Expected counts of shape (cells, 3) or (sets, cells, 3) for a design of shape"
            f" {design.shape}, came {counts.shape}; pass one row of counts per cell."
        )
    if not np.isfinite(design).all() or not (counts >= 0).all():
        raise InputError(
            "Expected finite numbers in the design and counts of 0 or more, but at least one is"
            " not; leave such cells out."
        )
    if not (counts.sum(axis=(1, 2)) > 0).all():
        raise InputError("Expected ratings in every data set, but one has none; leave it out.")


def _given_start(start: Array, design: Array, counts: Array) -> Array:
    """Return the point to start from for every data set, (m, p + 2), checked."""
    point = number_array(start, "a start", "pass thresholds and coefficients")
    if point.shape != (design.shape[1] + 2,) or not np.isfinite(point).all():
        raise InputError(
            f"Expected a start of {design.shape[1] + 2} finite numbers, but got shape"
            f" {point.shape} or NaN; pass two thresholds, then one coefficient a column."
        )
    if not point[0] < point[1]:
        raise InputError("Expected a start with ascending thresholds, but they do not; swap them.")
    return np.tile(point, (len(counts), 1))


def _logistic(x: Array) -> Array:
    return 0.5 * (1.0 + np.tanh(0.5 * x))


def _start(design: Array, counts: Array) -> Array:
    """Start at the marginal thresholds and no effect."""
    total = counts.sum(axis=1) + 0.5
    share = np.cumsum(total, axis=1)[:, :2] / total.sum(axis=1, keepdims=True)
    return np.hstack([np.log(share / (1 - share)), np.zeros((len(counts), design.shape[1]))])


def _parts(design: Array, point: Array) -> tuple[Array, Array, Array, Array]:
    """Return G1, G2, p1 and both tails with the middle probability free of cancellation."""
    eta = point[:, 2:] @ design.T
    low, high = point[:, :1] - eta, point[:, 1:2] - eta
    first, second = _logistic(low), _logistic(high)
    middle = second * _logistic(-low) * -np.expm1(point[:, :1] - point[:, 1:2])
    return first, second, np.maximum(middle, 1e-100), eta


def _log_likelihood(design: Array, counts: Array, point: Array) -> Array:
    _, _, middle, eta = _parts(design, point)
    low, high = point[:, :1] - eta, point[:, 1:2] - eta
    terms = -counts[..., 0] * np.logaddexp(0, -low) - counts[..., 2] * np.logaddexp(0, high)
    return np.asarray((terms + counts[..., 1] * np.log(middle)).sum(axis=1))


def _objective(design: Array, counts: Array, point: Array, ridge: float) -> Array:
    """Log-likelihood less the ridge; a faint barrier keeps the thresholds apart."""
    gap = point[:, 1] - point[:, 0]
    allowed = gap > 0
    safe = np.where(allowed[:, None], point, np.r_[-1.0, 1.0, np.zeros(point.shape[1] - 2)])
    value = _log_likelihood(design, counts, safe) - 0.5 * ridge * (point**2).sum(axis=1)
    value += ridge * np.log(np.where(allowed, gap, 1.0))
    return np.where(allowed, value, -np.inf)


def _derivatives(design: Array, counts: Array, point: Array, ridge: float) -> tuple[Array, Array]:
    """Return gradient (m, p + 2) and Hessian (m, p + 2, p + 2) of the objective."""
    first, second, middle, _ = _parts(design, point)
    n0, n1, n2 = counts[..., 0], counts[..., 1], counts[..., 2]
    g1, g2 = first * (1 - first), second * (1 - second)
    s1 = n0 * (1 - first) - n1 * g1 / middle
    s2 = n1 * g2 / middle - n2 * second
    h11 = -n0 * g1 - n1 * (g1 * (1 - 2 * first) / middle + (g1 / middle) ** 2)
    h22 = -n2 * g2 + n1 * (g2 * (1 - 2 * second) / middle - (g2 / middle) ** 2)
    h12 = n1 * (g1 / middle) * (g2 / middle)
    gradient = np.hstack([s1.sum(1, keepdims=True), s2.sum(1, keepdims=True), -(s1 + s2) @ design])
    gap = point[:, 1] - point[:, 0]
    gradient -= ridge * point
    gradient[:, 0] -= ridge / gap
    gradient[:, 1] += ridge / gap
    return gradient, _hessian(design, h11, h22, h12, gap, ridge)


def _hessian(design: Array, h11: Array, h22: Array, h12: Array, gap: Array, ridge: float) -> Array:
    size = design.shape[1] + 2
    products = (design[:, :, None] * design[:, None, :]).reshape(len(design), -1)
    hessian = np.empty((len(h11), size, size))
    both = h11 + h22 + 2 * h12
    hessian[:, 2:, 2:] = (both @ products).reshape(-1, size - 2, size - 2)
    for row, own in ((0, h11), (1, h22)):
        hessian[:, row, 2:] = hessian[:, 2:, row] = -(own + h12) @ design
        hessian[:, row, row] = own.sum(axis=1) - ridge / gap**2
    hessian[:, 0, 1] = hessian[:, 1, 0] = h12.sum(axis=1) + ridge / gap**2
    hessian -= ridge * np.eye(size)
    return hessian


def _line_search(
    design: Array, counts: Array, point: Array, step: Array, value: Array, ridge: float
) -> tuple[Array, Array]:
    """Halve the step of every data set until its objective does not fall (it is concave)."""
    scale = np.ones(len(point))
    best, best_value = point.copy(), value.copy()
    open_sets = np.ones(len(point), dtype=bool)
    for _ in range(30):
        trial = point[open_sets] + scale[open_sets, None] * step[open_sets]
        trial_value = _objective(design, counts[open_sets], trial, ridge)
        good = trial_value >= value[open_sets] - 1e-10 * np.abs(value[open_sets])
        index = np.flatnonzero(open_sets)
        best[index[good]], best_value[index[good]] = trial[good], trial_value[good]
        open_sets[index[good]] = False
        if not open_sets.any():
            break
        scale[open_sets] /= 2
    return best, best_value
