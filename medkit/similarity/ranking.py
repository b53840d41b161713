"""Planned grasps in the order of their likeness to people's, and how firm it is (P13 6.2.4)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.stats import kendalltau

from medkit.arguments import generator, one_of, table_with, whole
from medkit.errors import InputError
from medkit.geometry import Floats, expected
from medkit.similarity.grasps import HumanGrasps
from medkit.similarity.hands import correspondence, scaled_to_object
from medkit.similarity.measures import (
    d_eucl,
    d_symmetric,
    d_z,
    distance_table,
    fingertip_array,
    share_within,
)
from medkit.similarity.symmetry import SymmetryGroup

#: Columns by which a ranking can be sorted, all of them distances [m]: smaller is more alike.
MEASURES = ("d_eucl", "d_z", "d_symmetric", "nearest")


@dataclass(frozen=True)
class HumanReference:
    """Human grasps of one object, fitted to the robot's object and to its hand's fingers."""

    subject: np.ndarray  # (m,)
    trial: np.ndarray  # (m,)
    fingertips: Floats  # (m, k, 3) [m], origin at the centre of mass
    group: SymmetryGroup
    orders: tuple[tuple[int, ...], ...]
    simulated: bool

    def without(self, *, subject: str | None = None, trial: int | None = None) -> HumanReference:
        """Return the reference without a subject, a trial number, or one trial of a subject."""
        drop = np.ones(len(self.subject), dtype=bool)
        if subject is not None:
            drop &= self.subject == subject
        if trial is not None:
            drop &= self.trial == trial
        kept = ~drop if subject is not None or trial is not None else drop
        return HumanReference(
            self.subject[kept], self.trial[kept], self.fingertips[kept], self.group, self.orders,
            self.simulated,
        )  # fmt: skip


def human_reference(
    humans: HumanGrasps,
    *,
    recorded_extents: ArrayLike,
    extents: ArrayLike,
    group: SymmetryGroup,
    fingers: int = 5,
    interchangeable: bool = False,
) -> HumanReference:
    """Prepare human grasps of one object for comparison with a robot hand's (P13 6.2.4).

    Parameters
    ----------
    humans : HumanGrasps
        Grasps of one object; see `HumanGrasps.of`.
    recorded_extents, extents : array-like, shape (3,)
        Sizes of the recorded object and of the robot's [m].
    group : SymmetryGroup
        Rotations of the robot's object, centre in the frame of the comparison.
    fingers : int
        Number of the robot's fingers.
    interchangeable : bool
        Whether the jaws of a two-fingered gripper may be swapped.

    Returns
    -------
    HumanReference
        What `rank_grasps` compares with.

    Raises
    ------
    InputError
        If an argument is of another kind, the grasps are of several objects, or sizes or fingers
        do not fit.
    """
    remedy = "take them from grasps_from_recordings"
    expected(humans, HumanGrasps, "human grasps", remedy)
    remedy = "take one from symmetry_group_from_mesh"
    expected(group, SymmetryGroup, "a symmetry group", remedy)
    if len(set(humans.object.tolist())) != 1:
        raise InputError(
            f"Expected grasps of one object, but got {', '.join(sorted(set(humans.object)))};"
            " choose one with HumanGrasps.of(object=...)."
        )
    match = correspondence(fingers, interchangeable=interchangeable)
    tips = scaled_to_object(humans.fingertips, recorded_extents=recorded_extents, extents=extents)
    return HumanReference(
        humans.subject, humans.trial, match.human(tips), group, match.orders,
        bool(np.any(humans.simulated)),
    )  # fmt: skip


def rank_grasps(
    planned: ArrayLike,
    reference: HumanReference,
    *,
    subject: str | None = None,
    by: str = "d_symmetric",
    radius: float = 0.10,
) -> pd.DataFrame:
    """Rank planned grasps by their likeness to people's (P13 6.2.4).

    Parameters
    ----------
    planned : array-like, shape (n, k, 3)
        Fingertips of planned grasps [m], in the object's frame with its origin at the centre of
        mass.
    reference : HumanReference
        Human grasps, made comparable.
    subject : str, optional
        Whose average the first three measures use. Without it each grasp is held against every
        subject's own average and the nearest counts: P13 found averages over people meaningless.
    by : str
        Column to sort by, one of `MEASURES`.
    radius : float
        Distance [m] for `share_within`.

    Returns
    -------
    pandas.DataFrame
        Sorted, the most human-like first; columns grasp (row of `planned`), the `MEASURES` [m],
        share (of recordings within `radius`), subject (nearest by d_symmetric), rank (from 1).

    Raises
    ------
    InputError
        If no reference came, or shapes, subject or measure do not fit.
    """
    one_of(by, MEASURES, "a measure")
    grasps = fingertip_array(planned, "planned grasps")
    everyone = sorted(set(checked_reference(reference).subject.tolist()))
    names = everyone if subject is None else [one_of(subject, everyone, "a subject")]
    variants = [_measured(grasps[:, order], reference, names, radius) for order in reference.orders]
    table = variants[0]
    for other in variants[1:]:
        table = table.where(table["d_symmetric"] <= other["d_symmetric"], other)
    table = table.astype(dict.fromkeys((*MEASURES, "share"), float))
    table.insert(0, "grasp", np.arange(len(grasps)))
    table = table.sort_values(by, kind="stable").reset_index(drop=True)
    return table.assign(rank=np.arange(1, len(table) + 1))


def checked_reference(reference: HumanReference) -> HumanReference:
    """Return the reference as it is; `InputError` where something else came."""
    remedy = "make one with human_reference"
    return expected(reference, HumanReference, "a reference to human grasps", remedy)


def _measured(
    grasps: Floats, reference: HumanReference, names: list[str], radius: float
) -> pd.DataFrame:
    columns: dict[str, list[Floats]] = {"d_eucl": [], "d_z": [], "d_symmetric": []}
    for name in names:
        trials = reference.fingertips[reference.subject == name]
        columns["d_eucl"].append(d_eucl(grasps, trials))
        columns["d_z"].append(d_z(grasps, trials))
        columns["d_symmetric"].append(d_symmetric(grasps, trials, group=reference.group))
    group, people = reference.group, reference.fingertips
    nearest = distance_table(grasps, people, group=group).min(axis=1)
    table = pd.DataFrame({key: np.min(value, axis=0) for key, value in columns.items()})
    closest = np.argmin(np.stack(columns["d_symmetric"]), axis=0)
    return table.assign(
        nearest=nearest,
        share=share_within(grasps, people, radius=radius, group=group),
        subject=np.array(names)[closest],
    )


def rank_agreement(
    table: pd.DataFrame,
    *,
    rng: np.random.Generator,
    measures: tuple[str, ...] = MEASURES,
    draws: int = 400,
) -> pd.DataFrame:
    """Kendall's rank correlation between measures, with a bootstrap interval over grasps.

    Parameters
    ----------
    table : pandas.DataFrame
        From `rank_grasps`.
    rng : numpy.random.Generator
        Draws the bootstrap samples.
    measures : tuple of str
        Columns to compare.
    draws : int
        Number of bootstrap samples.

    Returns
    -------
    pandas.DataFrame
        first, second, tau, low, high (2.5 and 97.5 % quantiles).

    Raises
    ------
    InputError
        If there are fewer than five grasps or two measures, a measure is no column, or `rng` or
        `draws` do not fit.
    """
    expected(measures, (list, tuple), "measures as a tuple of columns", "pass two or more of them")
    table_with(table, measures, "a ranking", "pass a table from rank_grasps")
    draws = whole(draws, "draws")
    generator(rng)
    if len(table) < 5:
        raise InputError(
            f"Expected at least five grasps for a rank correlation, but got {len(table)};"
            " plan more."
        )
    rows = rng.integers(len(table), size=(draws, len(table)))
    result = []
    for first, second in combinations(measures, 2):
        a, b = table[first].to_numpy(), table[second].to_numpy()
        taus = [kendalltau(a[row], b[row]).statistic for row in rows]
        low, high = np.nanquantile(taus, [0.025, 0.975])
        result.append((first, second, kendalltau(a, b).statistic, low, high))
    return pd.DataFrame(result, columns=["first", "second", "tau", "low", "high"])


def ranking_stability(
    planned: ArrayLike, reference: HumanReference, *, leave_out: str = "subject"
) -> pd.DataFrame:
    """How each measure's ranking changes when one trial or one subject is left out.

    Parameters
    ----------
    planned : array-like, shape (n, k, 3)
        Fingertips of planned grasps [m].
    reference : HumanReference
        Human grasps, made comparable.
    leave_out : {"subject", "trial"}
        What is left out, one at a time; a trial is one trial of one subject.

    Returns
    -------
    pandas.DataFrame
        measure, left_out, tau (with the full ranking), same_best (whether the most human-like
        grasp stays so).

    Raises
    ------
    InputError
        If `leave_out` is something else, or fewer than two remain to be left out.
    """
    full = rank_grasps(planned, reference).sort_values("grasp")
    result = []
    for name, rest in _reduced(reference, leave_out):
        other = rank_grasps(planned, rest).sort_values("grasp")
        for measure in MEASURES:
            a, b = full[measure].to_numpy(), other[measure].to_numpy()
            same = bool(np.argmin(a) == np.argmin(b))
            result.append((measure, name, float(kendalltau(a, b).statistic), same))
    return pd.DataFrame(result, columns=["measure", "left_out", "tau", "same_best"])


def _reduced(reference: HumanReference, leave_out: str) -> list[tuple[str, HumanReference]]:
    subjects = sorted(set(reference.subject.tolist()))
    one_of(leave_out, ("subject", "trial"), "leave_out")
    if len(reference.subject) < 2:
        raise InputError("Expected two trials or more to leave one out, but got one; record more.")
    if leave_out == "subject":
        if len(subjects) < 2:
            raise InputError("Expected two subjects or more, but got one; leave out trials.")
        return [(name, reference.without(subject=name)) for name in subjects]
    pairs = zip(reference.subject.tolist(), reference.trial.tolist(), strict=True)
    return [(f"{name}/{trial}", reference.without(subject=name, trial=trial))
            for name, trial in pairs]  # fmt: skip
