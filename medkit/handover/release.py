"""From ratings to a release force: iso-score curves and their slope.

In one pose and mode a subject's log-odds of a better rating are modelled as
``a * sqrt(force) + c * weight``. Among force, its root, its cube root and its logarithm the root
fits these data best (``link_comparison``). Solved for the force at which the expected score falls
to a level, the root of the force is a straight line over weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from medkit.arguments import generator, number_array, one_of, short, whole
from medkit.errors import InputError
from medkit.handover.cells import RatingCells, design_columns, rating_cells, stratum_codes
from medkit.handover.estimands import subject_tables, subject_variation
from medkit.handover.ordinal import eta_at_score, fit_cumulative_logit
from medkit.handover.resampling import bootstrap_weights, subject_interval

Array = np.ndarray
Scope = Literal["people", "these"]


@dataclass(frozen=True)
class RootForceLines:
    """Iso-score lines ``sqrt(F*) = intercept + slope * weight`` of one pose and mode.

    Attributes
    ----------
    pose, mode : str
        The condition.
    intercept : (m, s) ndarray
        For each draw and subject [N^0.5].
    slope : (m, s) ndarray
        Likewise [N^0.5/kg].
    weights : (k,) ndarray
        Weights met in this pose and mode [kg].
    """

    pose: str
    mode: str
    intercept: Array
    slope: Array
    weights: Array

    def root_force(self, weight: Array) -> Array:
        """Return the root of F* at the given weights [N^0.5], (m, s, k); not below zero."""
        line = self.intercept[..., None] + self.slope[..., None] * np.asarray(weight)
        return np.asarray(np.maximum(line, 0.0))


def root_force_lines(
    trials: pd.DataFrame, level: float, *, multiplicity: Array | None = None
) -> list[RootForceLines]:
    """Fit every subject in every pose and mode and solve for the force at a score level.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    level : float
        Expected score between 0 and 1.
    multiplicity : (m, n) ndarray, optional
        How often each cell counts; once each when left out.

    Returns
    -------
    list of RootForceLines
        A subject whose ratings do not fall with the force has NaN.
    """
    cells = rating_cells(trials)
    weight = np.ones((1, len(cells))) if multiplicity is None else multiplicity
    lines = []
    for pose in range(len(cells.poses)):
        for mode in range(len(cells.modes)):
            keep = (cells.pose == pose) & (cells.mode == mode)
            if keep.any():
                lines.append(_lines(cells.where(keep), weight[:, keep], level))
    return lines


def iso_score(
    trials: pd.DataFrame, level: float = 0.75, *, weights: Sequence[float] | None = None,
    scope: Scope = "people", draws: int = 200, rng: np.random.Generator | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Return the release force at which the expected score falls to a level, over weight.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    level : float
        Expected score; 0.75 lies halfway between acceptable and good.
    weights : sequence of float, optional
        Masses [kg]; those met in the pose when left out.
    scope : {"people", "these"}
        Interval for people like these (t over subjects) or for these subjects (bootstrap over
        cells).
    draws : int
        Bootstrap draws of the latter.
    rng : numpy.random.Generator, optional
        Its source of randomness; ``default_rng(0)`` when left out.

    Returns
    -------
    pandas.DataFrame
        pose, mode, weight [kg], force, low, high [N], subjects (how many have such a force).
        Mean and interval are taken of the root of the force, in which the model is linear.

    Raises
    ------
    InputError
        If the level is not between 0 and 1 or a pose has fewer than two forces.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> curve = iso_score(load_trials(), 0.75, weights=[0.1, 0.6])
    >>> curve.loc[(curve.pose == "P1") & (curve["mode"] == "position"), "force"].round(1).tolist()
    [3.5, 5.4]
    """
    one_of(scope, ("people", "these"), "scope")
    lines = root_force_lines(trials, level)
    given = None if weights is None else _given_weights(weights)
    drawn = [None] * len(lines) if scope == "people" else _drawn(trials, level, draws, rng)
    parts = []
    for line, again in zip(lines, drawn, strict=True):
        at = line.weights if given is None else given
        root = line.root_force(at)[0]
        mean, low, high = subject_interval(root)
        if again is not None:
            reach = 1.959964 * np.nanstd(np.nanmean(again.root_force(at), axis=1), axis=0, ddof=1)
            low, high = mean - reach, mean + reach
        parts.append(
            pd.DataFrame(
                {
                    "pose": line.pose, "mode": line.mode, "weight": at, "force": mean**2,
                    "low": np.maximum(low, 0) ** 2, "high": high**2,
                    "subjects": np.isfinite(root).sum(axis=0),
                }
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


def iso_slope(
    trials: pd.DataFrame, level: float = 0.75, *, scope: Scope = "people", draws: int = 200,
    rng: np.random.Generator | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Return by how much the release force may grow per kilogram, and whether with the load.

    Parameters
    ----------
    trials, level, scope, draws, rng
        As in :func:`iso_score`.

    Returns
    -------
    pandas.DataFrame
        A row per pose and mode and one for their mean ("all"). ``slope``, ``low``, ``high``
        [N/kg]: rise of F* from the lightest to the heaviest object, per kilogram. ``exponent``,
        ``exponent_low``, ``exponent_high``: how steeply log F* rises over log weight; a force
        proportional to the load has 1, a constant force 0. ``proportional``: *supported*,
        *contradicted* or *not decided* by whether that interval holds 1 and leaves out 0.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> iso_slope(load_trials())["proportional"].unique().tolist()
    ['contradicted']
    """
    one_of(scope, ("people", "these"), "scope")
    lines = root_force_lines(trials, level)
    drawn = lines if scope == "people" else _drawn(trials, level, draws, rng)
    single = [rise_over_weight(line) for line in lines]
    repeated = [rise_over_weight(line) for line in drawn]
    single.append(tuple(np.mean([rise[k] for rise in single], axis=0) for k in (0, 1)))
    repeated.append(tuple(np.mean([rise[k] for rise in repeated], axis=0) for k in (0, 1)))
    names = [(line.pose, line.mode) for line in lines] + [("all", "all")]
    rows = []
    for (pose, mode), once, many in zip(names, single, repeated, strict=True):
        slope, low, high = _interval(once[0], many[0], scope)
        exponent, exponent_low, exponent_high = _interval(once[1], many[1], scope)
        rows.append(
            {
                "pose": pose, "mode": mode, "slope": slope, "low": low, "high": high,
                "exponent": exponent, "exponent_low": exponent_low, "exponent_high": exponent_high,
                "proportional": _proportional(exponent_low, exponent_high),
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def _given_weights(weights: Sequence[float]) -> Array:
    at = number_array(weights, "weights", "pass a list of masses [kg]")
    if at.ndim != 1 or not (np.isfinite(at) & (at >= 0)).all():
        raise InputError(
            f"Expected weights to be a list of masses of 0 kg or more, but got {short(weights)};"
            " pass such a list, or leave it out."
        )
    return at


def _lines(part: RatingCells, multiplicity: Array, level: float) -> RootForceLines:
    pose, mode = part.poses[part.pose[0]], part.modes[part.mode[0]]
    weights = np.unique(part.weight)
    if len(np.unique(part.force)) < 2:
        raise InputError(
            f"Expected at least two release forces in pose {pose}, mode {mode}, came one; a force"
            " at a score level cannot be told from it."
        )
    names = ["root_force", "weight"] if len(weights) > 1 else ["root_force"]
    first, counts = subject_tables(part, multiplicity)
    draws, subjects = counts.shape[:2]
    flat = counts.reshape(draws * subjects, len(first), 3)
    present = flat.sum(axis=(1, 2)) > 0
    design = design_columns(part, names)[first]
    fit = fit_cumulative_logit(design, flat[present])
    line = np.full((2, len(flat)), np.nan)
    steep = fit.coefficients[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        line[0, present] = np.where(steep < 0, eta_at_score(level, fit.thresholds) / steep, np.nan)
        grow = fit.coefficients[:, 1] if len(names) > 1 else 0.0
        line[1, present] = np.where(steep < 0, -grow / steep, np.nan)
    stacked: Array = line.reshape(2, draws, subjects)
    # who met one force or one weight alone has no line
    stacked[:, :, ~subject_variation(design, counts).all(axis=1)] = np.nan
    intercept, slope = stacked
    return RootForceLines(pose, mode, intercept, slope, weights)


def _drawn(
    trials: pd.DataFrame, level: float, draws: int, rng: np.random.Generator | None
) -> list[RootForceLines]:
    rng = np.random.default_rng(0) if rng is None else generator(rng)
    draws = whole(draws, "draws", 2)
    cells = rating_cells(trials)
    strata = stratum_codes(cells.subject, cells.pose, cells.mode, cells.force)
    return root_force_lines(trials, level, multiplicity=bootstrap_weights(strata, draws, rng))


def rise_over_weight(line: RootForceLines) -> tuple[Array, Array]:
    """Return slope [N/kg] and exponent of F* from the lightest to the heaviest object.

    Parameters
    ----------
    line : RootForceLines
        One pose and mode.

    Returns
    -------
    slope, exponent : (m, s) ndarray
        NaN where the pose was met with one weight only.
    """
    if len(line.weights) < 2:
        nothing = np.full(line.slope.shape, np.nan)
        return nothing, nothing
    ends = line.weights[[0, -1]]
    force = line.root_force(ends) ** 2
    slope = (force[..., 1] - force[..., 0]) / (ends[1] - ends[0])
    # a force of zero at the light end would give an infinite exponent
    logs = np.log(np.maximum(force, 1e-3))
    return slope, (logs[..., 1] - logs[..., 0]) / np.log(ends[1] / ends[0])


def _interval(once: Array, many: Array, scope: Scope) -> tuple[float, float, float]:
    mean, low, high = (float(value) for value in subject_interval(once[0]))
    if scope == "these":
        known = np.isfinite(many).any(axis=1)
        reach = 1.959964 * float(np.nanmean(many[known], axis=1).std(ddof=1))
        low, high = mean - reach, mean + reach
    return mean, low, high


def _proportional(low: float, high: float) -> str:
    if not np.isfinite(low + high):
        return "not decided"
    if low > 1 or high < 1:
        return "contradicted"
    return "supported" if low > 0 else "not decided"
