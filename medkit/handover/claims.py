"""The seven claims of L14 section 4.2, each with estimate, interval, test and a plain verdict.

The rule, fixed before the data are looked at (docs/decisions/0061-verdict-rule.md): every claim is
a number that is positive when the claim is true. *Supported*: the 95 % interval lies above zero and
the permutation p value, corrected for seven claims (Holm), is below 0.05. *Contradicted*: the
interval lies below zero and p likewise. Else *not decided by these data*.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from medkit.arguments import whole
from medkit.errors import InputError
from medkit.geometry import expected
from medkit.handover import estimands
from medkit.handover.cells import RatingCells, force_steps, rating_cells, stratum_codes
from medkit.handover.resampling import (
    bootstrap_weights,
    holm,
    permutation_p,
    sign_flip_p,
    subject_interval,
)
from medkit.handover.trials import trial_table

Array = np.ndarray
SUPPORTED, CONTRADICTED, NOT_DECIDED = "supported", "contradicted", "not decided"
ALPHA = 0.05


@dataclass(frozen=True)
class Claim:
    """A claim: its words, its measure (positive when true) and its permutation test."""

    number: int
    text: str
    unit: str
    measure: Callable[[RatingCells, Array], Array]
    permutation: Callable[[RatingCells, int, np.random.Generator], float]
    replicate: str = "subject"


def thesis_claims(subject: str = "T4") -> tuple[Claim, ...]:
    """Return the seven claims of L14 section 4.2; `subject` is the one called least sensitive."""
    expected(subject, str, "the name of a subject", 'pass one such as "T4"')
    ratio, shift = "log-odds", "N"
    pose = partial(estimands.contrast_effect, column="pose", better="P1", worse="P2")
    mode = partial(estimands.contrast_effect, column="mode", better="position", worse="impedance")
    gap = partial(estimands.least_sensitive_gap, subject=subject)
    return (
        Claim(1, "a lower release force is rated better", f"{ratio}, 5 N against 10 N",
              estimands.force_effect, _permute_force),
        Claim(2, "at the same force a heavier object is rated better", f"{ratio} per kg",
              estimands.weight_effect, _permute_weight),
        Claim(3, "P2 is rated more severely than P1", f"{ratio}, P1 against P2", pose,
              partial(_permute_pairs, column="pose", better="P1", worse="P2")),
        Claim(4, "impedance mode is rated more severely than position mode",
              f"{ratio}, position against impedance", mode,
              partial(_permute_pairs, column="mode", better="position", worse="impedance")),
        Claim(5, f"subject {subject} is the least sensitive", f"{shift}, against the next", gap,
              partial(_permute_subjects, subject=subject), replicate="block"),
        Claim(6, "0.5 N to 1 N gets the highest scores", "probability of winning - 1/2",
              estimands.low_force_advantage, _permute_low),
        Claim(7, '"good" goes first for light objects as the force grows', f"{shift}/kg",
              estimands.good_force_slope, _permute_good),
    )  # fmt: skip


def claims(
    trials: pd.DataFrame, *, rng: np.random.Generator | None = None, draws: int = 200,
    shuffles: int = 1999, subject: str = "T4",
) -> pd.DataFrame:  # fmt: skip
    """Hold the seven claims of L14 section 4.2 against a table of trials.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`; at least two subjects.
    rng : numpy.random.Generator, optional
        Source of randomness; ``numpy.random.default_rng(0)`` when left out, so that one table
        has one answer.
    draws, shuffles : int
        Bootstrap draws and permutations; fewer than 140 of these cannot support a claim.
    subject : str
        Whom claim 5 is about.

    Returns
    -------
    pandas.DataFrame
        One row per claim. ``claim``; ``estimate``, ``low``, ``high`` in ``unit``: mean over the
        subjects and its 95 % t interval with (subjects - 1) degrees of freedom, for *people like
        these* (claim 5: over pose-mode blocks); ``p_permutation`` (cells shuffled within a
        subject), ``p_holm`` (corrected for all claims), ``p_sign`` (signs of the subjects flipped);
        ``verdict``; ``low_these``, ``high_these``, ``verdict_these``: bootstrap over cells, for
        *these subjects* only; ``agree``: subjects (blocks) on the claim's side. A claim the table
        cannot speak to has NaN and the verdict *not decided*.

    Raises
    ------
    InputError
        If no table came, it has fewer than two subjects or one kind of rating only, or another
        argument is of another kind.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> table = claims(load_trials(), draws=20, shuffles=199)
    >>> table["verdict"].iloc[0]
    'supported'
    """
    rng = np.random.default_rng(0) if rng is None else rng
    remedy = "pass rng=numpy.random.default_rng(0), or leave it out"
    expected(rng, np.random.Generator, "a random generator as rng", remedy)
    draws, shuffles = whole(draws, "draws", 0), whole(shuffles, "shuffles", 0)
    cells = rating_cells(trial_table(trials))
    if len(cells.subjects) < 2:
        raise InputError(
            f"Expected trials of at least two subjects, came {len(cells.subjects)}; an interval"
            " for people needs more than one person."
        )
    given = cells.counts.sum(axis=0)
    if np.count_nonzero(given) < 2:
        kind = ("bad", "acceptable", "good")[int(given.argmax())]
        raise InputError(
            f"Expected ratings of at least two kinds, came {int(given.sum())} that are all {kind};"
            " nothing can be told apart in such a table."
        )
    strata = stratum_codes(cells.subject, cells.pose, cells.mode, cells.force)
    weights = bootstrap_weights(strata, draws, rng)
    rows = [_row(claim, cells, weights, shuffles, rng) for claim in thesis_claims(subject)]
    table = pd.DataFrame(rows)
    table["p_holm"] = holm(table["p_permutation"].to_numpy())
    for suffix in ("", "_these"):
        table[f"verdict{suffix}"] = [
            verdict(low, high, p)
            for low, high, p in zip(
                table[f"low{suffix}"], table[f"high{suffix}"], table["p_holm"], strict=True
            )
        ]
    order = ["claim", "estimate", "low", "high", "p_permutation", "verdict", "unit", "p_holm",
             "p_sign", "agree", "low_these", "high_these", "verdict_these"]  # fmt: skip
    table.index = pd.Index([claim.number for claim in thesis_claims(subject)], name="number")
    return table[order]


def verdict(low: float, high: float, p_value: float) -> str:
    """Apply the rule stated at the top of this module.

    Examples
    --------
    >>> verdict(0.2, 1.0, 0.01), verdict(-1.0, -0.2, 0.01), verdict(-0.1, 1.0, 0.01)
    ('supported', 'contradicted', 'not decided')
    """
    if p_value < ALPHA and low > 0:
        return SUPPORTED
    return CONTRADICTED if p_value < ALPHA and high < 0 else NOT_DECIDED


def subject_estimates(trials: pd.DataFrame, *, subject: str = "T4") -> pd.DataFrame:
    """Return the estimate of every claim for every subject (claim 5: for every block).

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> subject_estimates(load_trials()).loc[1, ["T1", "T2", "T3", "T4"]].gt(0).all()
    np.True_
    """
    cells = rating_cells(trial_table(trials))
    once = np.ones((1, len(cells)))
    rows = {}
    for claim in thesis_claims(subject):
        names = cells.subjects if claim.replicate == "subject" else estimands.block_names(cells)
        values = claim.measure(cells, once)[0]
        rows[claim.number] = dict(zip(names, values, strict=False))
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("number")


def _row(
    claim: Claim, cells: RatingCells, weights: Array, shuffles: int, rng: np.random.Generator
) -> dict[str, object]:
    single = claim.measure(cells, np.ones((1, len(cells))))[0]
    mean, low, high = subject_interval(single)
    row: dict[str, object] = {"claim": claim.text, "unit": claim.unit, "estimate": float(mean)}
    row |= {"low": float(low), "high": float(high)}
    known = single[np.isfinite(single)]
    if not len(known):
        missing = dict.fromkeys(("low_these", "high_these", "p_permutation", "p_sign"), np.nan)
        return row | missing | {"agree": "no data"}
    drawn = np.nanmean(claim.measure(cells, weights), axis=1)
    row["low_these"], row["high_these"] = _bootstrap_interval(drawn, float(mean))
    row["p_permutation"] = claim.permutation(cells, shuffles, rng)
    row["p_sign"] = sign_flip_p(known) if 1 < len(known) <= 16 else np.nan
    kind = "" if claim.replicate == "subject" else " blocks"
    row["agree"] = f"{int((known > 0).sum())} of {len(known)}{kind}"
    return row


def _bootstrap_interval(drawn: Array, estimate: float) -> tuple[float, float]:
    """Return estimate -+ 1.96 bootstrap standard errors: steadier than tails of few draws."""
    reach = 1.959964 * float(np.nanstd(drawn, ddof=1)) if len(drawn) > 1 else np.nan
    return estimate - reach, estimate + reach


def _permute_force(cells: RatingCells, draws: int, rng: np.random.Generator) -> float:
    strata = stratum_codes(cells.subject, cells.pose, cells.mode, cells.weight)
    return permutation_p(np.sqrt(cells.force), cells.ridits, strata, draws=draws, rng=rng)


def _permute_weight(cells: RatingCells, draws: int, rng: np.random.Generator) -> float:
    strata = stratum_codes(cells.subject, cells.pose, cells.mode, cells.force)
    return permutation_p(cells.weight, cells.ridits, strata, draws=draws, rng=rng)


def _permute_good(cells: RatingCells, draws: int, rng: np.random.Generator) -> float:
    """Shuffle weights; the statistic is the slope of claim 7, linear in the shares of good."""
    forces, widths = force_steps(cells.force)
    strata = stratum_codes(cells.subject, cells.pose, cells.mode, cells.force)
    mean = np.bincount(strata, cells.weight) / np.bincount(strata)
    centred = cells.weight - mean[strata]
    spread = np.maximum(np.bincount(strata, centred**2), 1e-12)[strata]
    step = widths[np.searchsorted(forces, cells.force)]
    return permutation_p(step * centred / spread, cells.shares[:, 2], strata, draws=draws, rng=rng)


def _permute_low(cells: RatingCells, draws: int, rng: np.random.Generator) -> float:
    coefficients = estimands.low_force_coefficients(cells)
    part, kept = cells.where(coefficients != 0), coefficients[coefficients != 0]
    strata = stratum_codes(part.subject, part.pose, part.mode, part.weight)
    return permutation_p(kept, part.ridits, strata, draws=draws, rng=rng)


def _permute_pairs(
    cells: RatingCells,
    draws: int,
    rng: np.random.Generator,
    *,
    column: str,
    better: str,
    worse: str,
) -> float:
    """Swap the two poses (or modes) of a pair of cells that are alike in all else."""
    part = cells.where(estimands.contrast_cells(cells, column, better, worse))
    other = part.mode if column == "pose" else part.pose
    strata = stratum_codes(part.subject, other, part.force, part.weight)
    side = (getattr(part, column) == getattr(cells, f"{column}s").index(better)).astype(float)
    return permutation_p(side, part.ridits, strata, draws=draws, rng=rng)


def _permute_subjects(
    cells: RatingCells, draws: int, rng: np.random.Generator, *, subject: str
) -> float:
    """Shuffle who gave a cell; T4 was singled out after looking, so chance may favour anyone."""
    strata = stratum_codes(cells.pose, cells.mode, cells.force, cells.weight)
    order = np.argsort(strata, kind="stable")
    cells, strata = cells.where(order), strata[order].astype(float)
    once = np.ones((1, len(cells)))
    seen = float(np.nanmean(estimands.least_sensitive_gap(cells, once, subject)))
    reached = 0
    for start in range(0, draws, 200):
        keys = strata + rng.random((min(200, draws - start), len(strata)))
        shuffled = cells.points[np.argsort(keys, axis=1)]
        tolerated = np.sort(np.nanmean(estimands.force_area(cells, once, shuffled), axis=2), axis=1)
        # the gap of whoever comes first, or of the last to the first when T4 is not in front
        rival = -2 if seen > 0 else 0
        extreme = tolerated[:, -1] - tolerated[:, rival]
        reached += int((extreme >= abs(seen) - 1e-12).sum())
    return (reached + 1) / (draws + 1)
