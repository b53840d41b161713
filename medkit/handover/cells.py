"""A trial table as arrays: one row per cell, columns of a design, counts in ascending order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from medkit.errors import InputError
from medkit.handover.trials import rating_counts, trial_table

Array = np.ndarray


@dataclass(frozen=True)
class RatingCells:
    """The cells of a trial table as arrays of equal length n.

    Attributes
    ----------
    force : (n,) ndarray
        Release force [N].
    weight : (n,) ndarray
        Mass of the object [kg].
    pose, mode, subject : (n,) ndarray of int
        Indices into the names below.
    counts : (n, 3) ndarray
        Ratings bad, acceptable, good.
    poses, modes, subjects : tuple of str
        Sorted names.
    """

    force: Array
    weight: Array
    pose: Array
    mode: Array
    subject: Array
    counts: Array
    poses: tuple[str, ...]
    modes: tuple[str, ...]
    subjects: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.force)

    def where(self, keep: Array) -> RatingCells:
        """Return the cells chosen by a boolean or integer index, names unchanged."""
        return RatingCells(
            self.force[keep], self.weight[keep], self.pose[keep], self.mode[keep],
            self.subject[keep], self.counts[keep], self.poses, self.modes, self.subjects,
        )  # fmt: skip

    @property
    def points(self) -> Array:
        """Score of every cell, in [0, 1]."""
        return self.shares @ np.array([0.0, 0.5, 1.0])

    @property
    def shares(self) -> Array:
        """Share of bad, acceptable and good in every cell, (n, 3)."""
        return np.asarray(self.counts / self.counts.sum(axis=1, keepdims=True))

    @property
    def ridits(self) -> Array:
        """Mean rank of a cell's ratings among all ratings, in [0, 1]: uses their order alone."""
        total = self.counts.sum(axis=0)
        rank = (np.cumsum(total) - total / 2) / total.sum()
        return np.asarray(self.shares @ rank)


def rating_cells(trials: pd.DataFrame) -> RatingCells:
    """Turn a trial table into arrays.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.

    Returns
    -------
    RatingCells
        In the order of the rows.

    Raises
    ------
    InputError
        If the table is empty or lacks a column.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> cells = rating_cells(load_trials())
    >>> len(cells), cells.subjects
    (855, ('T1', 'T2', 'T3', 'T4'))
    """
    needed = ("pose", "mode", "force_N", "weight_g", "subject")
    absent = [name for name in needed if name not in trial_table(trials).columns]
    if absent or trials.empty:
        raise InputError(
            f"Expected a table with columns {', '.join(needed)} and at least one row, but"
            f" {f'{absent[0]} is missing' if absent else 'it is empty'}; pass one from load_trials."
        )
    codes = {name: np.unique(trials[name].astype(str), return_inverse=True) for name in needed[:2]}
    codes["subject"] = np.unique(trials["subject"].astype(str), return_inverse=True)
    names = {name: tuple(str(value) for value in codes[name][0]) for name in codes}
    return RatingCells(
        trials["force_N"].to_numpy(float), trials["weight_g"].to_numpy(float) / 1000,
        codes["pose"][1], codes["mode"][1], codes["subject"][1], rating_counts(trials)[:, ::-1],
        names["pose"], names["mode"], names["subject"],
    )  # fmt: skip


def design_columns(cells: RatingCells, names: Sequence[str]) -> Array:
    """Return the design matrix of the named terms.

    Parameters
    ----------
    cells : RatingCells
        The cells.
    names : sequence of str
        Among ``root_force`` [N^0.5], ``weight`` [kg], ``pose`` and ``mode`` (one column for each
        name after the first), ``subject`` (likewise).

    Returns
    -------
    (n, p) ndarray
        Columns in that order.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> design_columns(rating_cells(load_trials()), ["root_force", "subject"]).shape
    (855, 4)
    """
    columns: list[Array] = []
    for name in names:
        if name == "root_force":
            columns.append(np.sqrt(cells.force))
        elif name == "weight":
            columns.append(cells.weight)
        else:
            levels = len(getattr(cells, {"pose": "poses", "mode": "modes"}.get(name, "subjects")))
            codes = cells.subject if name == "subject" else getattr(cells, name)
            columns += [(codes == level).astype(float) for level in range(1, levels)]
    return np.column_stack(columns) if columns else np.zeros((len(cells), 0))


def stratum_codes(*columns: Array) -> Array:
    """Return one integer per row: equal where all columns are equal.

    Examples
    --------
    >>> stratum_codes(np.array([1.5, 1.5, 2.0]), np.array([0, 1, 0])).tolist()
    [0, 1, 2]
    """
    stacked = np.column_stack([np.asarray(column, dtype=float) for column in columns])
    return np.unique(stacked, axis=0, return_inverse=True)[1].ravel()


def force_steps(force: Array) -> tuple[Array, Array]:
    """Return the distinct forces and the trapezoid width of each [N].

    Examples
    --------
    >>> forces, widths = force_steps(np.array([1.0, 2.0, 4.0]))
    >>> widths.tolist()
    [0.5, 1.5, 1.0]
    """
    forces = np.unique(force)
    gap = np.diff(forces)
    return forces, np.r_[0.0, gap] / 2 + np.r_[gap, 0.0] / 2
