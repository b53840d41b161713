"""The next experiment: simulated subjects from the fitted population, and how many are needed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats

from medkit.arguments import generator, number_array, short, table_with, whole
from medkit.errors import InputError
from medkit.geometry import expected, positive
from medkit.handover.cells import RatingCells, design_columns, rating_cells
from medkit.handover.estimands import subject_tables
from medkit.handover.ordinal import fit_cumulative_logit, rating_probabilities
from medkit.handover.release import rise_over_weight, root_force_lines
from medkit.handover.resampling import subject_interval

Array = np.ndarray
TERMS = ("root_force", "weight", "pose", "mode")
SUBJECTS = (4, 6, 8, 12, 16, 24, 32, 48, 64)


def simulate_population(
    trials: pd.DataFrame, *, subjects: int, rng: np.random.Generator, repetitions: int = 4
) -> pd.DataFrame:
    """Return a table of simulated subjects who differ as the real ones do.

    Thresholds and effects are fitted to every subject; new subjects are drawn from the normal
    distribution with their mean and their covariance less the mean estimation error.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`; at least two subjects.
    subjects : int
        How many to simulate.
    rng : numpy.random.Generator
        Source of randomness.
    repetitions : int
        Ratings per cell.

    Returns
    -------
    pandas.DataFrame
        In the schema of the trials; ``attrs["simulated"]`` is True.

    Raises
    ------
    InputError
        If the trials hold one subject only, or another argument is of another kind.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> drawn = simulate_population(load_trials(), subjects=3, rng=np.random.default_rng(0))
    >>> len(drawn), drawn.attrs["simulated"]
    (648, True)
    """
    cells, repetitions = rating_cells(trials), whole(repetitions, "repetitions")
    subjects = whole(subjects, "subjects")
    generator(rng)
    if len(cells.subjects) < 2:
        raise InputError(
            "Expected at least two subjects to draw more like them, came one; add some."
        )
    first, counts = subject_tables(cells, np.ones((1, len(cells))))
    design = design_columns(cells, TERMS)[first]
    fit = fit_cumulative_logit(design, counts[0])
    point = np.column_stack(
        [fit.thresholds[:, 0], np.log(np.diff(fit.thresholds)[:, 0]), fit.coefficients]
    )
    spread = _between(point, _gap_covariance(fit.covariance, np.diff(fit.thresholds)[:, 0]))
    drawn = rng.multivariate_normal(point.mean(axis=0), spread, size=subjects, method="eigh")
    return _rated(cells.where(first), design, drawn, repetitions, rng)


def slope_estimates(trials: pd.DataFrame, level: float = 0.75) -> Array:
    """Return the slope of F* [N/kg], averaged over poses and modes, of every subject, (s,)."""
    lines = root_force_lines(trials, level)
    return np.asarray(np.mean([rise_over_weight(line)[0][0] for line in lines], axis=0))


def slope_power(
    estimates: Array, *, subjects: Sequence[int] = SUBJECTS, draws: int = 2000,
    observed: int = 4, rng: np.random.Generator,
) -> pd.DataFrame:  # fmt: skip
    """Return how the interval of the slope narrows with the number of subjects.

    Parameters
    ----------
    estimates : (m,) ndarray
        Slopes of many simulated subjects, from :func:`slope_estimates`.
    subjects : sequence of int
        Sizes of the next experiment.
    draws : int
        Simulated experiments per size.
    observed : int
        Subjects the spread was learned from; it sets how wrong that spread may be.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    pandas.DataFrame
        ``spread`` ("as estimated", or "larger": the upper 80 % bound for the standard deviation
        from so few subjects), ``subjects``, mean ``half_width`` of the 95 % t interval [N/kg], and
        the chance ``power`` that it excludes zero.
    """
    estimates = number_array(estimates, "slopes", "pass those of slope_estimates")
    known = estimates[np.isfinite(estimates)]
    if not len(known):
        raise InputError(
            "Expected finite slopes, but there is none; pass those of slope_estimates."
        )
    sizes, draws, observed = _sizes(subjects), whole(draws, "draws"), whole(observed, "observed", 2)
    generator(rng)
    factor = float(np.sqrt((observed - 1) / stats.chi2.ppf(0.2, observed - 1)))
    rows = []
    for name, scale in (("as estimated", 1.0), ("larger", factor)):
        pool = known.mean() + scale * (known - known.mean())
        for size in sizes:
            _, low, high = subject_interval(rng.choice(pool, size=(size, draws)))
            rows.append((name, size, float(np.mean(high - low) / 2), float(np.mean(low > 0))))
    return pd.DataFrame(rows, columns=["spread", "subjects", "half_width", "power"])


def claim_power(
    estimates: pd.DataFrame, *, subjects: Sequence[int] = SUBJECTS, draws: int = 2000,
    rng: np.random.Generator,
) -> pd.DataFrame:  # fmt: skip
    """Return the chance that an experiment's interval decides each claim.

    Claim 5 is about one person and has no answer in more people; it is left out.

    Parameters
    ----------
    estimates : pandas.DataFrame
        A row per claim number, a column per subject of a large population: from
        ``subject_estimates`` of a simulated table, or from :func:`normal_population`.
    subjects, draws, rng
        As in :func:`slope_power`.

    Returns
    -------
    pandas.DataFrame
        ``number`` of the claim, ``subjects``, ``power``: chance that the 95 % t interval over
        subjects excludes zero.
    """
    _checked_estimates(estimates)
    sizes, draws = _sizes(subjects), whole(draws, "draws")
    generator(rng)
    rows = []
    for number, row in estimates.drop(index=5, errors="ignore").iterrows():
        pool = row.to_numpy(float)
        pool = pool[np.isfinite(pool)]
        for size in sizes if len(pool) else ():
            _, low, high = subject_interval(rng.choice(pool, size=(size, draws)))
            rows.append((number, size, float(np.mean((low > 0) | (high < 0)))))
    return pd.DataFrame(rows, columns=["number", "subjects", "power"])


def normal_population(
    estimates: pd.DataFrame, *, size: int = 2000, rng: np.random.Generator
) -> pd.DataFrame:
    """Return a population that varies in every claim as the observed subjects do.

    The plain alternative to simulated ratings: it takes over the observed spread whole, with all
    that the model leaves out, and takes it to be normal.

    Parameters
    ----------
    estimates : pandas.DataFrame
        From :func:`medkit.handover.subject_estimates`.
    size : int
        Subjects to draw.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    pandas.DataFrame
        A row per claim number, `size` columns.
    """
    size = whole(size, "size")
    generator(rng)
    plain = _checked_estimates(estimates).drop(index=5, errors="ignore")
    mean = plain.mean(axis=1).to_numpy()
    spread = plain.std(axis=1, ddof=1).to_numpy()
    drawn = mean[:, None] + spread[:, None] * rng.standard_normal((len(plain), size))
    return pd.DataFrame(drawn, index=plain.index)


def subjects_needed(power: pd.DataFrame, *, chance: float = 0.8) -> pd.Series:
    """Return the smallest number of subjects tried that decides each claim with that chance.

    Returns
    -------
    pandas.Series
        Indexed by claim number; NaN when none of the sizes tried is enough.

    Examples
    --------
    >>> table = pd.DataFrame({"number": 1, "subjects": [4, 8], "power": [0.5, 0.9]})
    >>> subjects_needed(table).tolist()
    [8.0]
    """
    remedy = "pass one from claim_power"
    table_with(power, ("number", "subjects", "power"), "a table of powers", remedy)
    if not positive(chance, "chance") <= 1.0:
        raise InputError(f"Expected a chance of at most 1, but got {chance:g}; pass 0.8, say.")
    enough = power["subjects"].where(power["power"] >= chance)
    return enough.groupby(power["number"]).min().rename("subjects")


def _sizes(subjects: Sequence[int]) -> list[int]:
    """Return the sizes of experiments, each a whole number of people."""
    remedy = "pass a tuple such as (4, 8, 16)"
    sizes = number_array(subjects, "subjects", remedy)
    if sizes.ndim != 1:
        raise InputError(
            f"Expected several numbers of subjects, but got {short(subjects)}; {remedy}."
        )
    return [whole(size, "subjects") for size in sizes]


def _checked_estimates(estimates: pd.DataFrame) -> pd.DataFrame:
    remedy = "pass one from subject_estimates"
    return expected(estimates, pd.DataFrame, "a table of estimates", remedy)


def _gap_covariance(covariance: Array, gap: Array) -> Array:
    """Carry the covariance of both thresholds over to the first and the log of the gap."""
    change = np.tile(np.eye(covariance.shape[1]), (len(gap), 1, 1))
    change[:, 1, 0], change[:, 1, 1] = -1 / gap, 1 / gap
    return np.asarray(change @ covariance @ np.swapaxes(change, 1, 2))


def _between(point: Array, errors: Array) -> Array:
    """Return the covariance between subjects: that of the estimates less their own error."""
    raw = np.cov(point, rowvar=False) - errors.mean(axis=0)
    value, vector = np.linalg.eigh((raw + raw.T) / 2)
    return np.asarray((vector * np.maximum(value, 0.0)) @ vector.T)


def _rated(
    conditions: RatingCells, design: Array, drawn: Array, repetitions: int,
    rng: np.random.Generator,
) -> pd.DataFrame:  # fmt: skip
    parts = []
    for index, point in enumerate(drawn):
        thresholds = point[0] + np.array([0.0, np.exp(point[1])])
        chances = rating_probabilities(design @ point[2:], thresholds)
        counts = rng.multinomial(repetitions, chances / chances.sum(axis=1, keepdims=True))
        parts.append((np.full(len(design), f"S{index:03d}"), counts))
    times = len(drawn)
    counts = np.vstack([part[1] for part in parts])
    table = pd.DataFrame(
        {
            "pose": np.tile(np.array(conditions.poses)[conditions.pose], times),
            "mode": np.tile(np.array(conditions.modes)[conditions.mode], times),
            "force_N": np.tile(conditions.force, times),
            "weight_g": np.tile(np.rint(1000 * conditions.weight).astype(int), times),
            "subject": np.concatenate([part[0] for part in parts]),
            "good": counts[:, 2], "acceptable": counts[:, 1], "bad": counts[:, 0], "sum_ok": True,
        }
    )  # fmt: skip
    table.attrs["simulated"] = True
    return table
