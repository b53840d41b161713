"""Whole figures of the handover chapter: the numbers of the thesis, each rebuilt by one call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from medkit.errors import InputError
from medkit.handover.trials import cells_of
from medkit.viz.handover import (
    FORCE_LABEL,
    plot_rating_counts,
    plot_rating_lines,
    plot_rating_shares,
    plot_score_boxes,
    plot_score_map,
)

RATING_ORDER = ("good", "acceptable", "bad")


def figure_counts(trials: pd.DataFrame, *, level: str, pose: str, mode: str) -> Any:
    """Return how often each subject gave one rating: small multiples (L14 4.9 to 4.11)."""
    subjects = sorted(trials["subject"].unique())
    figure, axes = _grid(len(subjects), columns=4, size=(2.7, 3.4))
    for ax, subject in zip(axes, subjects, strict=False):
        plot_rating_counts(trials, level=level, subject=subject, pose=pose, mode=mode, ax=ax)
        ax.label_outer()
    figure.suptitle(f'ratings "{level}" in {pose}, {mode} mode [count in a cell]')
    return figure


def figure_shares(trials: pd.DataFrame, *, pose: str, mode: str) -> Any:
    """Return the shares of the three ratings by weight, a panel per force (L14 4.12 to 4.15)."""
    part = cells_of(trials, pose, mode)
    forces = sorted(part["force_N"].unique())
    figure, axes = _grid(len(forces), columns=3, size=(2.9, 2.1))
    for ax, force in zip(axes, forces, strict=False):
        plot_rating_shares(part[part["force_N"] == force], ax=ax)
        ax.set_title(f"{force:g} N")
        ax.label_outer()
    _shared_legend(figure, axes[0])
    figure.suptitle(f"{pose}, {mode} mode, all subjects", x=0.01, ha="left")
    return figure


def figure_compared(trials: pd.DataFrame, *, compare: str, where: str, value: str) -> Any:
    """Return the shares over force, poses or modes against each other (L14 4.16 to 4.19).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    compare : {"pose", "mode"}
        What the lines of a panel tell apart.
    where, value : str
        The other column and the value it is held at.

    Returns
    -------
    matplotlib.figure.Figure
        Ratings in rows, weights in columns; only weights met by every line.
    """
    part = trials[trials[where] == value]
    met = part.groupby("weight_g")[compare].nunique()
    weights = met.index[met == part[compare].nunique()].tolist()
    figure, axes = plt.subplots(
        3, len(weights), figsize=(1.5 + 1.75 * len(weights), 5.6), sharex=True, sharey=True,
        squeeze=False,
    )  # fmt: skip
    for row, level in zip(axes, RATING_ORDER, strict=True):
        for ax, weight in zip(row, weights, strict=True):
            chosen = part[part["weight_g"] == weight]
            plot_rating_lines(chosen, level=level, by="force_N", compare=compare, ax=ax)
            ax.set_title(f"{weight / 1000:g} kg" if level == "good" else "")
            ax.label_outer()
    _shared_legend(figure, axes[0][0])
    figure.suptitle(f"{compare}s compared, {where} {value}", x=0.01, ha="left")
    return figure


def figure_boxes(trials: pd.DataFrame, *, pose: str, mode: str) -> Any:
    """Return box plots of the scores over force, a panel per subject (L14 4.20 to 4.23)."""
    part = cells_of(trials, pose, mode)
    return _panels(part, "subject", plot_score_boxes, f"{pose}, {mode} mode", columns=2)


def figure_boxes_of_all(trials: pd.DataFrame) -> Any:
    """Return box plots of the scores over force, a panel per pose and mode (L14 4.24)."""
    return _panels(
        _with_condition(trials), "condition", plot_score_boxes, "all subjects", columns=2
    )


def figure_maps(trials: pd.DataFrame, *, pose: str, mode: str, kind: str = "heat") -> Any:
    """Return the score over weight and force, a panel per subject (L14 4.25 to 4.28)."""
    part = cells_of(trials, pose, mode)
    title = f"mean score [1] in {pose}, {mode} mode"
    return _panels(part, "subject", partial(plot_score_map, kind=kind), title, columns=2, kind=kind)


def figure_maps_of_all(trials: pd.DataFrame, *, kind: str = "heat") -> Any:
    """Return the score over weight and force, a panel per pose and mode (L14 4.29)."""
    draw = partial(plot_score_map, kind=kind)
    title = "mean score [1] of all subjects"
    return _panels(_with_condition(trials), "condition", draw, title, columns=2, kind=kind)


def figure_tables(trials: pd.DataFrame, *, pose: str, mode: str) -> Any:
    """Return the printed table of one pose and mode as three fields of counts (L14 4.5 to 4.8)."""
    part = cells_of(trials, pose, mode)
    subjects = sorted(part["subject"].unique())
    figure, axes = plt.subplots(
        len(subjects), 3, figsize=(9.5, 2.5 * len(subjects)), squeeze=False, sharex=True
    )
    for row, subject in zip(axes, subjects, strict=True):
        for ax, level in zip(row, RATING_ORDER, strict=True):
            plot_rating_counts(part, level=level, subject=subject, pose=pose, mode=mode, ax=ax)
            ax.label_outer()
    figure.suptitle(f"{pose}, {mode} mode: counts as printed", x=0.01, ha="left")
    return figure


_POSITION, _IMPEDANCE = "position", "impedance"
FIGURES: dict[str, Callable[[pd.DataFrame], Any]] = {
    "4.5": partial(figure_tables, pose="P1", mode=_POSITION),
    "4.6": partial(figure_tables, pose="P2", mode=_POSITION),
    "4.7": partial(figure_tables, pose="P1", mode=_IMPEDANCE),
    "4.8": partial(figure_tables, pose="P2", mode=_IMPEDANCE),
    "4.9": partial(figure_counts, level="good", pose="P1", mode=_POSITION),
    "4.10": partial(figure_counts, level="acceptable", pose="P1", mode=_POSITION),
    "4.11": partial(figure_counts, level="bad", pose="P1", mode=_POSITION),
    "4.12": partial(figure_shares, pose="P1", mode=_POSITION),
    "4.13": partial(figure_shares, pose="P1", mode=_IMPEDANCE),
    "4.14": partial(figure_shares, pose="P2", mode=_POSITION),
    "4.15": partial(figure_shares, pose="P2", mode=_IMPEDANCE),
    "4.16": partial(figure_compared, compare="pose", where="mode", value=_POSITION),
    "4.17": partial(figure_compared, compare="pose", where="mode", value=_IMPEDANCE),
    "4.18": partial(figure_compared, compare="mode", where="pose", value="P1"),
    "4.19": partial(figure_compared, compare="mode", where="pose", value="P2"),
    "4.20": partial(figure_boxes, pose="P1", mode=_POSITION),
    "4.21": partial(figure_boxes, pose="P2", mode=_POSITION),
    "4.22": partial(figure_boxes, pose="P1", mode=_IMPEDANCE),
    "4.23": partial(figure_boxes, pose="P2", mode=_IMPEDANCE),
    "4.24": figure_boxes_of_all,
    "4.25": partial(figure_maps, pose="P1", mode=_POSITION),
    "4.26": partial(figure_maps, pose="P1", mode=_IMPEDANCE),
    "4.27": partial(figure_maps, pose="P2", mode=_POSITION),
    "4.28": partial(figure_maps, pose="P2", mode=_IMPEDANCE),
    "4.29": figure_maps_of_all,
}


def thesis_figure(trials: pd.DataFrame, number: str) -> Any:
    """Rebuild one figure of the thesis by its number, from 4.5 to 4.29.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    number : str
        For example ``"4.12"``.

    Returns
    -------
    matplotlib.figure.Figure
        The same data as the printed figure, in a form that survives grey.

    Raises
    ------
    InputError
        If the thesis has no such view.
    """
    if number not in FIGURES:
        raise InputError(f"Expected a figure from 4.5 to 4.29, came {number!r}; pass one of them.")
    return FIGURES[number](trials)


def _with_condition(trials: pd.DataFrame) -> pd.DataFrame:
    return trials.assign(condition=trials["pose"] + ", " + trials["mode"])


def _panels(
    trials: pd.DataFrame, by: str, draw: Callable[..., Any], title: str, *, columns: int,
    kind: str = "heat",
) -> Any:  # fmt: skip
    groups = list(trials.groupby(by))
    flat = kind != "3d"
    figure, axes = _grid(
        len(groups), columns=columns, size=(4.2, 2.8), projection=None if flat else "3d"
    )
    for ax, (name, part) in zip(axes, groups, strict=False):
        draw(part, ax=ax)
        ax.set_title(str(name))
        # fields of poses with other weights have axes of their own
        if flat and trials.groupby(by)["weight_g"].nunique().nunique() == 1:
            ax.label_outer()
    figure.suptitle(title, x=0.01, ha="left")
    return figure


def _grid(
    count: int, *, columns: int, size: Sequence[float], projection: str | None = None
) -> tuple[Any, Sequence[Any]]:
    """Return a figure with `count` axes in rows of `columns`, the surplus axes removed."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(size[0] * columns, size[1] * rows + 0.4), squeeze=False,
        subplot_kw={"projection": projection} if projection else None,
    )  # fmt: skip
    flat = list(np.ravel(axes))
    for ax in flat[count:]:
        ax.remove()
    return figure, flat[:count]


def _shared_legend(figure: Any, ax: Any) -> None:
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))


__all__ = [
    "FIGURES", "FORCE_LABEL", "figure_boxes", "figure_boxes_of_all", "figure_compared",
    "figure_counts", "figure_maps", "figure_maps_of_all", "figure_shares", "figure_tables",
    "thesis_figure",
]  # fmt: skip
