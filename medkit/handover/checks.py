"""Is the model fit to be used: proportional odds, calibration, draws, left-out subjects."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from medkit.arguments import generator, whole
from medkit.errors import InputError
from medkit.geometry import expected
from medkit.handover.cells import RatingCells, design_columns, rating_cells
from medkit.handover.claims import claims, subject_estimates, thesis_claims
from medkit.handover.ordinal import fit_cumulative_logit, rating_probabilities
from medkit.handover.release import iso_slope
from medkit.handover.resampling import subject_interval
from medkit.handover.trials import load_trials, trial_table, with_light_object

Array = np.ndarray
TERMS = ("root_force", "weight", "pose", "mode")


def proportional_odds_check(trials: pd.DataFrame) -> pd.DataFrame:
    """Compare the coefficients at the two thresholds, which the model takes to be equal.

    Two plain logits are fitted to every subject: at least acceptable against bad, and good against
    the rest.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.

    Returns
    -------
    pandas.DataFrame
        Per term the mean coefficient ``not_bad`` and ``good`` over subjects, their ``difference``
        with its 95 % t interval ``low``, ``high``.

    Examples
    --------
    >>> proportional_odds_check(load_trials()).loc["root_force", "good"] < 0
    np.True_
    """
    cells = rating_cells(trials)
    design = design_columns(cells, TERMS)
    both = np.array(
        [
            [_binary_fit(design[own], cells.counts[own], split) for split in (0, 1)]
            for own in (cells.subject == person for person in range(len(cells.subjects)))
        ]
    )
    mean, low, high = subject_interval(both[:, 1] - both[:, 0])
    names = _names(cells)
    average = both.mean(axis=0)
    columns = {"not_bad": average[0], "good": average[1], "difference": mean}
    return pd.DataFrame(columns | {"low": low, "high": high}, index=pd.Index(names, name="term"))


def calibration(
    trials: pd.DataFrame, *, bins: int = 8, leave_subject_out: bool = False
) -> pd.DataFrame:
    """Compare predicted probabilities with observed shares.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    bins : int
        Groups of cells of about equal number, by predicted probability.
    leave_subject_out : bool
        Predict each subject from the others' pooled model, as one would a stranger, instead of
        from the subject's own fit.

    Returns
    -------
    pandas.DataFrame
        ``event`` ("at least acceptable", "good"), ``predicted``, ``observed``, ``error``
        (standard error over cells), ``cells``.

    Examples
    --------
    >>> table = calibration(load_trials())
    >>> bool((table["predicted"] - table["observed"]).abs().max() < 0.15)
    True
    """
    cells, bins = rating_cells(trials), whole(bins, "bins")
    remedy = "say whether each subject is predicted from the others"
    expected(leave_subject_out, (bool, np.bool_), "leave_subject_out as True or False", remedy)
    chances = predicted_probabilities(cells, leave_subject_out=leave_subject_out)
    parts = []
    for event, levels in (("at least acceptable", [1, 2]), ("good", [2])):
        predicted, observed = chances[:, levels].sum(axis=1), cells.shares[:, levels].sum(axis=1)
        groups = np.array_split(np.argsort(predicted, kind="stable"), bins)
        parts += [
            {
                "event": event, "predicted": predicted[group].mean(),
                "observed": observed[group].mean(), "cells": len(group),
                "error": (observed - predicted)[group].std(ddof=1) / np.sqrt(len(group)),
            }
            for group in groups if len(group) > 1
        ]  # fmt: skip
    return pd.DataFrame(parts)


def predicted_probabilities(cells: RatingCells, *, leave_subject_out: bool = False) -> Array:
    """Return the probabilities of bad, acceptable, good of every cell, (n, 3)."""
    design = design_columns(cells, TERMS)
    chances = np.empty((len(cells), 3))
    for person in range(len(cells.subjects)):
        own = cells.subject == person
        source = ~own if leave_subject_out else own
        if not source.any():
            raise InputError("Expected at least two subjects to leave one out, came one; add some.")
        fit = fit_cumulative_logit(design[source], cells.counts[source])
        chances[own] = rating_probabilities(design[own] @ fit.coefficients[0], fit.thresholds[0])
    return chances


def predictive_check(
    trials: pd.DataFrame, *, draws: int = 200, rng: np.random.Generator
) -> pd.DataFrame:
    """Draw tables from the fitted model and ask whether the real one would stand out among them.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    draws : int
        Simulated tables.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    pandas.DataFrame
        Per statistic the ``observed`` value and the 2.5 %, 50 % and 97.5 % points of the
        simulated ones: the shares of good and of bad, the share of unanimous cells (four equal
        ratings), the share of cells holding both good and bad.
    """
    cells, draws = rating_cells(trials), whole(draws, "draws")
    generator(rng)
    chances = predicted_probabilities(cells)
    sizes = cells.counts.sum(axis=1).astype(int)
    drawn = np.array([_statistics(rng.multinomial(sizes, chances)) for _ in range(draws)])
    low, middle, high = np.quantile(drawn, [0.025, 0.5, 0.975], axis=0)
    return pd.DataFrame(
        {"observed": _statistics(cells.counts), "low": low, "median": middle, "high": high},
        index=pd.Index(["share good", "share bad", "unanimous cells", "cells with good and bad"],
                       name="statistic"),
    )  # fmt: skip


def leave_one_subject_out(trials: pd.DataFrame, *, level: float = 0.75) -> pd.DataFrame:
    """Return every claim's estimate, and the slope of the release force, without each subject.

    Returns
    -------
    pandas.DataFrame
        A row per claim number and one ``"slope"`` [N/kg]; a column per left-out subject. Claim 5
        is missing without its own subject.
    """
    columns = {}
    for name in sorted(trial_table(trials)["subject"].unique()):
        rest = trials[trials["subject"] != name]
        estimates = subject_estimates(rest).mean(axis=1)
        estimates.loc["slope"] = iso_slope(rest, level)["slope"].iloc[-1]
        columns[f"without {name}"] = estimates
    return pd.DataFrame(columns)


def readings() -> dict[str, pd.DataFrame]:
    """Return the thesis's table under every reading of its oddities.

    Returns
    -------
    dict
        Name of the reading to trials: nine irregular cells dropped, kept, completed with the best
        or the worst rating; the lightest object at 24 g or 20 g; six odd-looking cells left out.
    """
    plain = load_trials()
    odd = pd.DataFrame(_ODD_CELLS, columns=["pose", "mode", "force_N", "weight_g", "subject"])
    key = list(odd.columns)
    marked = plain.merge(odd, on=key, how="left", indicator=True)["_merge"].to_numpy()
    return {
        "dropped": plain,
        "kept": load_trials(irregular="keep"),
        "best": load_trials(irregular="best"),
        "worst": load_trials(irregular="worst"),
        "20 g": with_light_object(plain),
        "odd cells out": plain[marked == "left_only"].reset_index(drop=True),
    }


def sensitivity(
    tables: Mapping[str, pd.DataFrame] | None = None, *, draws: int = 100, shuffles: int = 499
) -> pd.DataFrame:
    """Return estimates and verdicts of all claims under every reading of the table.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame, optional
        Readings; those of :func:`readings` when left out.
    draws, shuffles : int
        As in :func:`medkit.handover.claims`.

    Returns
    -------
    pandas.DataFrame
        Columns (reading, "estimate"), (reading, "verdict"); a row per claim.
    """
    remedy = "pass a dictionary of tables, or leave it out"
    expected(tables, (Mapping, type(None)), "readings of the table by name", remedy)
    parts = {}
    for name, trials in (readings() if tables is None else tables).items():
        table = claims(trials, draws=draws, shuffles=shuffles)
        parts[name] = table[["estimate", "verdict", "verdict_these"]]
    return pd.concat(parts, axis=1)


#: Cells that add up but look odd beside their neighbours (data/handover_trials/README.md).
_ODD_CELLS = (
    ("P1", "position", 7.0, 400, "T3"), ("P1", "position", 12.0, 100, "T4"),
    ("P1", "impedance", 10.0, 800, "T4"), ("P2", "position", 7.0, 100, "T4"),
    ("P2", "position", 10.0, 100, "T4"), ("P2", "impedance", 12.0, 100, "T1"),
)  # fmt: skip


def _names(cells: RatingCells) -> list[str]:
    names = ["root_force", "weight"]
    names += [f"pose {name}" for name in cells.poses[1:]]
    return names + [f"mode {name}" for name in cells.modes[1:]]


def _binary_fit(design: Array, counts: Array, split: int) -> Array:
    """Return the coefficients of a plain logit for a rating above the split."""
    from statsmodels.genmod.families import Binomial
    from statsmodels.genmod.generalized_linear_model import GLM

    above = counts[:, split + 1 :].sum(axis=1)
    table = np.column_stack([above, counts.sum(axis=1) - above])
    constant = np.column_stack([np.ones(len(design)), design])
    return np.asarray(GLM(table, constant, family=Binomial()).fit().params[1:])


def _statistics(counts: Array) -> Array:
    total = counts.sum()
    unanimous = (counts.max(axis=1) == counts.sum(axis=1)).mean()
    torn = ((counts[:, 0] > 0) & (counts[:, 2] > 0)).mean()
    return np.array([counts[:, 2].sum() / total, counts[:, 0].sum() / total, unanimous, torn])


def method_agreement(trials: pd.DataFrame) -> pd.DataFrame:
    """Return intervals of the first four claims by methods from naive to careful.

    Returns
    -------
    pandas.DataFrame
        Per claim (1 to 4) and method: estimate, low, high. *Ratings independent*: statsmodels'
        OrderedModel with subject effects. *Random intercepts* and *random force slopes*: mixed
        models, Wald interval. *Subjects, t*: one estimate a subject, as in ``claims``.
    """
    from medkit.handover.mixed import fit_population

    cells = rating_cells(trials)
    if len(cells.poses) != 2 or len(cells.modes) != 2:
        raise InputError(
            f"Expected trials in two poses and two modes, came {len(cells.poses)} and"
            f" {len(cells.modes)}; pass a table that holds both of each."
        )
    rows = _ordered_model_rows(cells)
    for method, slopes in (("random intercepts", ()), ("random force slopes", ("root_force",))):
        fit = fit_population(trials, terms=TERMS, slopes=slopes)
        rows += _wald_rows(method, fit.coefficients[:4], fit.errors[:4])
    once = np.ones((1, len(cells)))
    for claim in thesis_claims()[:4]:
        mean, low, high = subject_interval(claim.measure(cells, once)[0])
        rows.append((claim.number, "subjects, t", float(mean), float(low), float(high)))
    table = pd.DataFrame(rows, columns=["number", "method", "estimate", "low", "high"])
    return table.sort_values(["number"], kind="stable").reset_index(drop=True)


def _ordered_model_rows(cells: RatingCells) -> list[tuple[int, str, float, float, float]]:
    from statsmodels.miscmodels.ordinal_model import OrderedModel

    design = design_columns(cells, [*TERMS, "subject"])
    counts = cells.counts.astype(int)
    levels = np.repeat(np.tile(np.arange(3), len(counts)), counts.ravel())
    long = np.repeat(np.repeat(design, 3, axis=0), counts.ravel(), axis=0)
    fit = OrderedModel(levels, long, distr="logit").fit(method="bfgs", disp=0)
    return _wald_rows("ratings independent", fit.params[:4], fit.bse[:4])


def _wald_rows(
    method: str, coefficients: Array, errors: Array
) -> list[tuple[int, str, float, float, float]]:
    """Turn the coefficients of force, weight, P2 and position into the measures of the claims."""
    factor = np.array([np.sqrt(5.0) - np.sqrt(10.0), 1.0, -1.0, 1.0])
    centre, reach = factor * coefficients, 1.959964 * np.abs(factor) * errors
    return [
        (k + 1, method, float(centre[k]), float(centre[k] - reach[k]), float(centre[k] + reach[k]))
        for k in range(4)
    ]


__all__ = [
    "calibration", "leave_one_subject_out", "method_agreement", "predictive_check",
    "proportional_odds_check", "readings", "sensitivity",
]  # fmt: skip
