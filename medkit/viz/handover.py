"""The published views of the handover ratings (L14 figures 4.9 to 4.29), each by one call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from medkit.errors import InputError
from medkit.handover.trials import cells_of, mean_scores, rating_shares, score
from medkit.viz.style import BLACK, CYCLE, MARKERS, SEQUENTIAL, axes_or_new

#: Good, acceptable, bad: dark to light in grey, and told apart by hatching when stacked.
RATING_STYLE = {
    "good": {"color": "#00664B", "hatch": ""},
    "acceptable": {"color": "#E9B84A", "hatch": "//"},
    "bad": {"color": "#F3D9CE", "hatch": ".."},
}
FORCE_LABEL = "release force [N]"
WEIGHT_LABEL = "object weight [kg]"
SCORE_LABEL = "score [1]"


def plot_rating_shares(trials: pd.DataFrame, *, by: str = "weight_g", ax: Any = None) -> Any:
    """Draw good, acceptable and bad as stacked shares of all ratings (after L14 4.12 to 4.15).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`, already narrowed to what belongs together.
    by : str
        Column along the axis: ``weight_g``, ``force_N`` or ``subject``.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The bars, bad at the bottom.
    """
    ax = axes_or_new(ax)
    shares = rating_shares(trials, [by])
    place = np.arange(len(shares))
    floor = np.zeros(len(shares))
    for level in ("good", "acceptable", "bad"):
        ax.bar(place, shares[level], 0.86, bottom=floor, label=level, edgecolor="white",
               linewidth=0.5, **RATING_STYLE[level])  # fmt: skip
        floor += shares[level].to_numpy()
    crowded = by == "weight_g" and len(shares) > 5
    names = [_tick(value, by) for value in shares.index]
    ax.set_xticks(place, names, rotation=90 if crowded else 0)
    ax.set(ylim=(0, 1), xlabel=axis_label(by), ylabel="share of ratings [1]")
    ax.grid(False)
    return ax


def plot_rating_counts(
    trials: pd.DataFrame, *, level: str, subject: str, pose: str, mode: str, ax: Any = None
) -> Any:
    """Draw how often one subject gave one rating, over weight and force (L14 4.9 to 4.11).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    level : {"good", "acceptable", "bad"}
        The rating counted.
    subject, pose, mode : str
        The part of the table shown.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        A field of counts; cells without data stay blank.
    """
    ax = axes_or_new(ax)
    part = cells_of(trials, pose, mode)
    grid = part[part["subject"] == subject].pivot(index="force_N", columns="weight_g", values=level)
    _field(ax, grid, vmax=float(part[["good", "acceptable", "bad"]].sum(axis=1).max()), digits=0)
    ax.set(title=f"{subject}, {level}", xlabel=WEIGHT_LABEL, ylabel=FORCE_LABEL)
    return ax


def plot_rating_lines(
    trials: pd.DataFrame, *, level: str, by: str, ax: Any = None, compare: str = "pose"
) -> Any:
    """Draw the share of one rating over force or weight, one line per pose or mode (L14 4.16 ff.).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    level : {"good", "acceptable", "bad"}
        The rating.
    by : {"force_N", "weight_g"}
        Column along the axis.
    ax : matplotlib.axes.Axes, optional
        Where to draw.
    compare : {"pose", "mode", "subject"}
        One line per value of this column.

    Returns
    -------
    matplotlib.axes.Axes
        The lines.
    """
    ax = axes_or_new(ax)
    shares = rating_shares(trials, [compare, by])[level].unstack(compare)
    scale = 1e-3 if by == "weight_g" else 1.0
    for index, (name, values) in enumerate(shares.items()):
        ax.plot(values.index * scale, values, color=CYCLE[index % len(CYCLE)],
                marker=MARKERS[index % len(MARKERS)],
                linestyle=("-", "--", ":", "-.")[index % 4], label=str(name))  # fmt: skip
    ax.set(ylim=(-0.03, 1.03), xlabel=axis_label(by), ylabel=f"share {level} [1]")
    return ax


def plot_score_boxes(trials: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw box plots of the cell scores at every force (L14 4.20 to 4.24).

    The cells are drawn as dots too: with four weights a box alone hides how few they are.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`, narrowed to what belongs together.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        One box per force (equal steps along the axis), whiskers to the most extreme cells, and
        the means as diamonds.
    """
    ax = axes_or_new(ax)
    groups = [
        (force, part["score"].to_numpy())
        for force, part in trials.assign(score=score(trials)).groupby("force_N")
    ]
    place = np.arange(len(groups))
    ax.boxplot([values for _, values in groups], positions=place, widths=0.6, whis=(0, 100),
               patch_artist=True, boxprops={"facecolor": "#E8EEF4", "edgecolor": "#555555"},
               medianprops={"color": BLACK}, showfliers=False)  # fmt: skip
    for x, (_, values) in zip(place, groups, strict=True):
        spread = np.linspace(-0.2, 0.2, len(values)) if len(values) > 1 else np.zeros(1)
        ax.plot(x + spread, values, linestyle="", marker=".", color=CYCLE[0], markersize=3)
    ax.plot(place, [values.mean() for _, values in groups], linestyle="", marker="D",
            color=CYCLE[3], markersize=5, label="mean")  # fmt: skip
    ax.set_xticks(place, [f"{force:g}" for force, _ in groups])
    ax.set(ylim=(-0.04, 1.04), xlabel=FORCE_LABEL, ylabel=SCORE_LABEL)
    return ax


def plot_score_map(trials: pd.DataFrame, *, kind: str = "heat", ax: Any = None) -> Any:
    """Draw the mean score over weight and force (L14 4.25 to 4.29).

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`, narrowed to one pose and mode.
    kind : {"heat", "contour", "3d"}
        A field with the scores written in, contour lines on true axes, or the thesis's
        three-dimensional view.
    ax : matplotlib.axes.Axes, optional
        Where to draw; three-dimensional axes for ``"3d"``.

    Returns
    -------
    matplotlib.axes.Axes
        With the score's colour running from 0 to 1.

    Raises
    ------
    InputError
        If `kind` is unknown.
    """
    draw: dict[str, Callable[..., Any]] = {"heat": _heat, "contour": _contour, "3d": _surface}
    if kind not in draw:
        raise InputError(f"Expected kind heat, contour or 3d, came {kind!r}; pick one.")
    ax = axes_or_new(ax, **({"projection": "3d"} if kind == "3d" else {}))
    grid = mean_scores(trials, ["force_N", "weight_g"]).unstack("weight_g")
    draw[kind](ax, grid)
    ax.set(xlabel=WEIGHT_LABEL, ylabel=FORCE_LABEL)
    return ax


def axis_label(column: str) -> str:
    """Return the label, with its unit, of a column of the trial table."""
    return {"weight_g": WEIGHT_LABEL, "force_N": FORCE_LABEL}.get(column, column)


def _tick(value: Any, column: str) -> str:
    if column == "weight_g":
        return f"{value / 1000:g}"
    return f"{value:g}" if column == "force_N" else str(value)


def _field(ax: Any, grid: pd.DataFrame, *, vmax: float, digits: int) -> Any:
    """Draw a table as a field of colours with its numbers, the lowest force at the bottom."""
    values = grid.to_numpy(dtype=float)
    image = ax.imshow(values, origin="lower", aspect="auto", cmap=SEQUENTIAL, vmin=0, vmax=vmax)
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            text = f"{value:.{digits}f}"
            text = text.replace("0.", ".") if digits else text
            color = "white" if value < 0.55 * vmax else "black"
            ax.text(column, row, text, fontsize=7, ha="center", va="center", color=color)
    names = [_tick(weight, "weight_g") for weight in grid.columns]
    ax.set_xticks(range(len(names)), names, rotation=90 if len(names) > 5 else 0)
    ax.set_yticks(range(grid.shape[0]), [f"{force:g}" for force in grid.index])
    ax.grid(False)
    return image


def _heat(ax: Any, grid: pd.DataFrame) -> None:
    _field(ax, grid, vmax=1.0, digits=2)


def _contour(ax: Any, grid: pd.DataFrame) -> None:
    weight, force = np.meshgrid(grid.columns.to_numpy() / 1000, grid.index.to_numpy())
    levels = np.linspace(0, 1, 11)
    ax.contourf(weight, force, grid.to_numpy(), levels=levels, cmap=SEQUENTIAL)
    lines = ax.contour(weight, force, grid.to_numpy(), levels=[0.25, 0.5, 0.75], colors="white",
                       linestyles=[":", "--", "-"])  # fmt: skip
    ax.clabel(lines, fmt="%.2f", fontsize=8, manual=_label_places(grid, lines.levels))
    ax.plot(weight.ravel(), force.ravel(), linestyle="", marker=".", color="white", markersize=2)
    ax.grid(False)


def _label_places(grid: pd.DataFrame, levels: Any) -> list[tuple[float, float]]:
    """Where contour labels stand clear of the data: halfway between two middle columns."""
    column = max(1, grid.shape[1] // 2)
    place = float(np.mean(grid.columns[column - 1 : column + 1])) / 1000
    score = grid.iloc[:, column - 1 : column + 1].mean(axis=1).to_numpy()[::-1]
    return [
        (place, float(np.interp(level, score, grid.index.to_numpy()[::-1]))) for level in levels
    ]


def _surface(ax: Any, grid: pd.DataFrame) -> None:
    weight, force = np.meshgrid(grid.columns.to_numpy() / 1000, grid.index.to_numpy())
    ax.plot_surface(weight, force, grid.to_numpy(), cmap=SEQUENTIAL, vmin=0, vmax=1,
                    edgecolor="#444444", linewidth=0.3)  # fmt: skip
    ax.set(zlim=(0, 1), zlabel=SCORE_LABEL)
    ax.view_init(elev=28, azim=-130)
