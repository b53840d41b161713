"""What each claim is measured by: one number per subject (or block), for any weighting of cells.

Every measure takes the cells and multiplicities of shape (m, n), so that the estimate (all ones)
and its bootstrap draws come from the same lines.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from medkit.handover.cells import RatingCells, design_columns, force_steps, stratum_codes
from medkit.handover.ordinal import fit_cumulative_logit

Array = np.ndarray


def subject_tables(cells: RatingCells, multiplicity: Array) -> tuple[Array, Array]:
    """Spread the cells of all subjects over one common set of conditions.

    Parameters
    ----------
    cells : RatingCells
        The n cells.
    multiplicity : (m, n) ndarray
        How often each cell counts.

    Returns
    -------
    first : (d,) ndarray of int
        For each condition (pose, mode, force, weight) a cell that has it.
    counts : (m, s, d, 3) ndarray
        Counts per subject; zero where a subject lacks the condition.
    """
    condition = stratum_codes(cells.pose, cells.mode, cells.force, cells.weight)
    first = np.unique(condition, return_index=True)[1]
    counts = np.zeros((len(multiplicity), len(cells.subjects), len(first), 3))
    counts[:, cells.subject, condition] = multiplicity[:, :, None] * cells.counts
    return first, counts


def subject_coefficients(cells: RatingCells, design: Array, multiplicity: Array) -> Array:
    """Fit the cumulative logit to every subject by itself and return the coefficients.

    Parameters
    ----------
    cells : RatingCells
        The n cells.
    design : (n, p) ndarray
        Their design; columns must not be constant.
    multiplicity : (m, n) ndarray
        How often each cell counts.

    Returns
    -------
    (m, s, p) ndarray
        NaN for a subject without a rating or with one kind of rating only, and for a column that
        does not vary for a subject.
    """
    first, counts = subject_tables(cells, multiplicity)
    draws, subjects = counts.shape[:2]
    flat = counts.reshape(draws * subjects, len(first), 3)
    present = flat.sum(axis=(1, 2)) > 0
    result = np.full((len(flat), design.shape[1]), np.nan)
    pooled = fit_cumulative_logit(design[first], flat[present].sum(axis=0))
    start = np.r_[pooled.thresholds[0], pooled.coefficients[0]]
    result[present] = fit_cumulative_logit(design[first], flat[present], start=start).coefficients
    stacked: Array = result.reshape(draws, subjects, -1)
    stacked[:, ~subject_variation(design[first], counts)] = np.nan
    stacked[:, ~_mixed_ratings(cells)] = np.nan
    return stacked


def subject_variation(design: Array, counts: Array) -> Array:
    """Return which columns vary among the conditions a subject met, (s, p).

    Parameters
    ----------
    design : (d, p) ndarray
        One row per condition.
    counts : (m, s, d, 3) ndarray
        From :func:`subject_tables`.
    """
    met = counts.sum(axis=(0, 3)) > 0
    return np.array([np.ptp(design[own], axis=0) > 0 if own.any() else False * design[0] > 0
                     for own in met])  # fmt: skip


def _mixed_ratings(cells: RatingCells) -> Array:
    """Return which subjects gave more than one kind of rating; the others tell of no effect."""
    kinds = [cells.counts[cells.subject == who].sum(axis=0) for who in range(len(cells.subjects))]
    return np.array([np.count_nonzero(kind) > 1 for kind in kinds])


def force_effect(cells: RatingCells, multiplicity: Array) -> Array:
    """Return the log-odds of a better rating at 5 N against 10 N, per subject (m, s)."""
    if len(np.unique(cells.force)) < 2:
        return _missing(cells, multiplicity)
    design = _main_design(cells)
    slope = subject_coefficients(cells, design, multiplicity)[..., 0]
    return slope * (np.sqrt(5.0) - np.sqrt(10.0))


def weight_effect(cells: RatingCells, multiplicity: Array) -> Array:
    """Return the log-odds of a better rating per kilogram at the same force, per subject (m, s)."""
    if len(np.unique(cells.weight)) < 2:
        return _missing(cells, multiplicity)
    position = 1 if len(np.unique(cells.force)) > 1 else 0
    return subject_coefficients(cells, _main_design(cells), multiplicity)[..., position]


def contrast_cells(cells: RatingCells, column: str, better: str, worse: str) -> Array:
    """Return which cells take part in comparing two poses or modes: those met under both.

    Returns
    -------
    (n,) ndarray of bool
        All False when a name does not occur.
    """
    names = getattr(cells, f"{column}s")
    if better not in names or worse not in names:
        return np.zeros(len(cells), dtype=bool)
    code = getattr(cells, column)
    other = cells.mode if column == "pose" else cells.pose
    condition = stratum_codes(other, cells.force, cells.weight)
    first, second = (code == names.index(better)), (code == names.index(worse))
    shared = np.intersect1d(condition[first], condition[second])
    return (first | second) & np.isin(condition, shared)


def contrast_effect(
    cells: RatingCells, multiplicity: Array, column: str, better: str, worse: str
) -> Array:
    """Return the log-odds of a better rating in `better` against `worse`, per subject (m, s)."""
    keep = contrast_cells(cells, column, better, worse)
    if not keep.any():
        return _missing(cells, multiplicity)
    part = cells.where(keep)
    own = getattr(part, column) == getattr(cells, f"{column}s").index(better)
    other = design_columns(part, ["mode" if column == "pose" else "pose"])
    plain = np.column_stack([np.sqrt(part.force), part.weight, other])
    design = np.column_stack([own.astype(float), _varying(plain)])
    return subject_coefficients(part, design, multiplicity[:, keep])[..., 0]


def tolerated_force(cells: RatingCells, multiplicity: Array) -> Array:
    """Return the area under the score over force [N], (m, s, b) for the b pose-mode blocks.

    The force a subject puts up with, on average over weights, counting "acceptable" as half
    (a Spearman-Kaerber mean from the lowest to the highest force).
    """
    return force_area(cells, multiplicity, cells.points)


def force_area(cells: RatingCells, multiplicity: Array, values: Array) -> Array:
    """Return the area under a mean over force, per subject and block.

    Parameters
    ----------
    cells : RatingCells
        The n cells.
    multiplicity : (1, n) or (m, n) ndarray
        How often each cell counts.
    values : (n,) or (m, n) ndarray
        What is averaged over the weights at each force.

    Returns
    -------
    (m, s, b) ndarray
        In newtons times the values' unit; NaN where a force is missing altogether.
    """
    subjects, blocks = len(cells.subjects), len(cells.poses) * len(cells.modes)
    forces, widths = force_steps(cells.force)
    block = cells.subject * blocks + cells.pose * len(cells.modes) + cells.mode
    group = block * len(forces) + np.searchsorted(forces, cells.force)
    groups = subjects * blocks * len(forces)
    total = _group_sums(multiplicity * values, group, groups)
    weight = _group_sums(multiplicity, group, groups)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (total / weight).reshape(len(total), subjects, blocks, len(forces))
    return np.asarray((mean * widths).sum(axis=-1))


def least_sensitive_gap(cells: RatingCells, multiplicity: Array, subject: str) -> Array:
    """Return by how much a subject tolerates more force than the next, per block (m, b) [N]."""
    if subject not in cells.subjects or len(cells.subjects) < 2:
        return np.full((len(multiplicity), 1), np.nan)
    tolerated = tolerated_force(cells, multiplicity)
    own = cells.subjects.index(subject)
    others = np.delete(tolerated, own, axis=1)
    runner_up = np.argmax(np.nanmean(others, axis=2), axis=1)
    return tolerated[:, own] - others[np.arange(len(others)), runner_up]


def low_force_advantage(cells: RatingCells, multiplicity: Array, limit: float = 1.0) -> Array:
    """Return how much likelier than 1/2 a rating up to `limit` beats one at the next force (m, s).

    Ties count half. The next force is the strongest rival of the low ones.
    """
    low, rival = _low_and_rival(cells, limit)
    if not (low.any() and rival.any()):
        return _missing(cells, multiplicity)
    subjects, blocks = len(cells.subjects), len(cells.poses) * len(cells.modes)
    group = cells.subject * blocks + cells.pose * len(cells.modes) + cells.mode
    shares = []
    for side in (low, rival):
        weighted = [multiplicity * (cells.counts[:, k] * side) for k in range(3)]
        sums = [_group_sums(values, group, subjects * blocks) for values in weighted]
        total = np.stack(sums, axis=-1)
        with np.errstate(invalid="ignore"):
            shares.append(total / total.sum(axis=-1, keepdims=True))
    win = np.array([[0.5, 0, 0], [1, 0.5, 0], [1, 1, 0.5]])
    advantage = np.einsum("mgi,ij,mgj->mg", shares[0], win, shares[1]) - 0.5
    return _mean_over(advantage.reshape(len(multiplicity), subjects, blocks))


def good_force_slope(cells: RatingCells, multiplicity: Array) -> Array:
    """Return how much longer "good" lasts per kilogram [N/kg], per subject (m, s).

    The area under the share of "good" over force is the mean force at which "good" goes; its
    slope over weight is the sum over forces of the slope of that share, times the force step.
    """
    if len(np.unique(cells.weight)) < 2 or len(np.unique(cells.force)) < 2:
        return _missing(cells, multiplicity)
    subjects, blocks = len(cells.subjects), len(cells.poses) * len(cells.modes)
    forces, widths = force_steps(cells.force)
    block = cells.subject * blocks + cells.pose * len(cells.modes) + cells.mode
    group = block * len(forces) + np.searchsorted(forces, cells.force)
    slope = _weighted_slope(
        cells.weight, cells.shares[:, 2], multiplicity, group, subjects * blocks * len(forces)
    )
    slope = slope.reshape(len(multiplicity), subjects, blocks, len(forces))
    total = np.where(np.isfinite(slope).any(axis=-1), np.nansum(slope * widths, axis=-1), np.nan)
    met = [len(np.unique(cells.weight[cells.subject == who])) > 1 for who in range(subjects)]
    total[:, ~np.array(met)] = np.nan
    return _mean_over(total)


def low_force_coefficients(cells: RatingCells, limit: float = 1.0) -> Array:
    """Return +1 for low forces, -1 for the next, 0 elsewhere: the permutation statistic's form."""
    low, rival = _low_and_rival(cells, limit)
    return low.astype(float) - rival.astype(float)


def _low_and_rival(cells: RatingCells, limit: float) -> tuple[Array, Array]:
    low = cells.force <= limit
    above = cells.force[~low]
    return low, (cells.force == above.min() if len(above) else np.zeros(len(cells), dtype=bool))


def _main_design(cells: RatingCells) -> Array:
    return _varying(design_columns(cells, ["root_force", "weight", "pose", "mode"]))


def _varying(columns: Array) -> Array:
    """Leave out columns that are constant or repeat one before: they carry nothing."""
    kept: list[int] = []
    for index in range(columns.shape[1]):
        trial = np.column_stack([np.ones(len(columns)), columns[:, [*kept, index]]])
        if np.linalg.matrix_rank(trial) == trial.shape[1]:
            kept.append(index)
    return columns[:, kept]


def _missing(cells: RatingCells, multiplicity: Array) -> Array:
    return np.full((len(multiplicity), len(cells.subjects)), np.nan)


def _mean_over(values: Array) -> Array:
    """Average over the last axis, leaving out NaN, without the warning of an empty mean."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=-1)
    return np.where(known.any(axis=-1), total / np.maximum(known.sum(axis=-1), 1), np.nan)


def _weighted_slope(x: Array, y: Array, multiplicity: Array, group: Array, groups: int) -> Array:
    """Return the least-squares slope of y over x in every group, (m, groups)."""

    def sums(values: Array) -> Array:
        return _group_sums(multiplicity * values, group, groups)

    n, sx, sy = sums(np.ones(len(x))), sums(x), sums(y)
    spread = n * sums(x * x) - sx**2
    usable = spread > 1e-12 * np.maximum(n, 1) ** 2
    covariance = n * sums(x * y) - sx * sy
    # a draw that holds one weight only says nothing of a slope
    return np.where(
        usable, covariance / np.where(usable, spread, 1.0), np.where(n > 0, 0.0, np.nan)
    )


def block_names(cells: RatingCells) -> Sequence[str]:
    """Return the names of the pose-mode blocks in the order of the last axis above."""
    return [f"{pose}, {mode}" for pose in cells.poses for mode in cells.modes]


def _group_sums(values: Array, group: Array, groups: int) -> Array:
    """Add up the columns of `values` (m, n) that share a group, (m, groups)."""
    return np.array([np.bincount(group, row, minlength=groups) for row in values])
