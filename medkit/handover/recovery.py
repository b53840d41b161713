"""Does the mixed model find what was put in: simulated ratings with known parameters, refitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from medkit.arguments import generator, number_array, one_of, whole
from medkit.errors import InputError
from medkit.geometry import expected
from medkit.handover.mixed import fit_mixed_logit
from medkit.handover.ordinal import rating_probabilities

Array = np.ndarray


def simulate_counts(
    design: Array, subject: Array, *, thresholds: Sequence[float] | Array,
    coefficients: Sequence[float] | Array, spread: Sequence[Sequence[float]] | Array,
    slopes: Sequence[int], ratings: int, rng: np.random.Generator,
) -> Array:  # fmt: skip
    """Draw a table of simulated ratings from known parameters.

    Parameters
    ----------
    design : (n, p) ndarray
        Fixed effects.
    subject : (n,) ndarray of int
        Who rates.
    thresholds, coefficients, spread : array-like
        As in :class:`medkit.handover.mixed.MixedLogit`.
    slopes : sequence of int
        Columns with a random slope, in the order of `spread` after the intercept.
    ratings : int
        Ratings per cell.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    (n, 3) ndarray of int
        Counts bad, acceptable, good.

    Examples
    --------
    >>> simulate_counts(np.zeros((2, 1)), np.array([0, 1]), thresholds=[-1, 1], coefficients=[0],
    ...                 spread=[[0.1]], slopes=[], ratings=4,
    ...                 rng=np.random.default_rng(0)).sum(axis=1).tolist()
    [4, 4]
    """
    size = int(np.max(subject)) + 1
    effects = rng.multivariate_normal(np.zeros(len(spread)), np.asarray(spread, float), size=size)
    carriers = np.column_stack([np.ones(len(design)), design[:, list(slopes)]])
    eta = design @ np.asarray(coefficients, float) + (carriers * effects[subject]).sum(axis=1)
    chances = rating_probabilities(eta, np.asarray(thresholds, float))
    return np.array([rng.multinomial(ratings, row) for row in chances / chances.sum(1)[:, None]])


def recovery_study(
    *, studies: int, subjects: int, rng: np.random.Generator, slopes: Sequence[str] = (),
    spread: Sequence[Sequence[float]] = ((0.6,),),
) -> pd.DataFrame:  # fmt: skip
    """Fit simulated experiments with known parameters; report bias and coverage.

    Parameters
    ----------
    studies, subjects : int
        Number of simulated experiments and of subjects in each.
    rng : numpy.random.Generator
        Source of randomness.
    slopes : sequence of str
        ``root_force`` and ``weight``, or neither.
    spread : nested sequence
        Covariance of intercept and slopes.

    Returns
    -------
    pandas.DataFrame
        Per coefficient the truth, the mean estimate, the bias, its Monte Carlo error, and the
        share of 95 % Wald intervals that hold the truth.
    """
    studies, subjects = whole(studies, "studies"), whole(subjects, "subjects")
    generator(rng)
    _check_effects(slopes, spread)
    truth = np.array([-3.0, 2.5])
    force, weight = (grid.ravel() for grid in np.meshgrid([0.5, 2, 5, 7, 10, 15], [0.1, 0.4, 0.8]))
    one = np.column_stack([np.sqrt(force), weight])
    design, subject = np.tile(one, (subjects, 1)), np.repeat(np.arange(subjects), len(one))
    names = ("root_force", "weight")
    estimates, errors = [], []
    for _ in range(studies):
        counts = simulate_counts(
            design, subject, thresholds=[-8.0, -5.0], coefficients=truth, spread=spread,
            slopes=[names.index(name) for name in slopes], ratings=4, rng=rng,
        )  # fmt: skip
        fit = fit_mixed_logit(design, counts, subject, names=names, slopes=slopes)
        estimates.append(fit.coefficients)
        errors.append(fit.errors)
    found, error = np.array(estimates), np.array(errors)
    return pd.DataFrame(
        {
            "truth": truth, "mean": found.mean(axis=0), "bias": found.mean(axis=0) - truth,
            "monte_carlo_error": found.std(axis=0, ddof=1) / np.sqrt(studies),
            "coverage": (np.abs(found - truth) < 1.959964 * error).mean(axis=0),
        },
        index=pd.Index(names, name="coefficient"),
    )  # fmt: skip


def _check_effects(slopes: Sequence[str], spread: Sequence[Sequence[float]]) -> None:
    """Refuse slopes that are no columns, and a covariance that is none or of another size."""
    remedy = 'pass (), ("root_force",) or the like'
    for name in expected(slopes, (list, tuple), "slopes as a tuple of columns", remedy):
        one_of(name, ("root_force", "weight"), "slopes", remedy)
    size = 1 + len(slopes)
    matrix = number_array(spread, "spread", "pass a nested tuple such as ((0.6,),)")
    if matrix.shape != (size, size) or not np.isfinite(matrix).all():
        raise InputError(
            f"Expected spread to be finite numbers of shape {(size, size)}, but got shape"
            f" {matrix.shape} or NaN; pass the covariance of the intercept and every slope."
        )
