"""Pictures of the grasping experiments: yields beside the printed ones, reasons, robustness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pandas as pd

from medkit.geometry import Floats
from medkit.grasping.grasp_set import OUTCOMES
from medkit.grasping.yields import interval_pct
from medkit.viz.style import (
    BLACK,
    BLUE,
    CYCLE,
    GREEN,
    MARKERS,
    ORANGE,
    PURPLE,
    VERMILION,
    axes_or_new,
)

#: Colours of outcomes, and hatches that keep them apart in grey.
OUTCOME_LOOKS = dict(
    zip(
        OUTCOMES,
        [(GREEN, ""), (ORANGE, "//"), (VERMILION, "xx"), (PURPLE, "..")],
        strict=True,
    )
)


#: Label of an axis of yields.
YIELD = "force-closure candidates [%]"


def plot_yields(
    ours: Mapping[str, pd.DataFrame],
    printed: Mapping[str, Mapping[str, float]],
    *,
    ax: Any = None,
) -> Any:
    """Draw yields by object: ours with intervals, printed ones as open marks.

    Parameters
    ----------
    ours : mapping of str to DataFrame
        By label, rows of `medkit.grasping.experiments.yield_table`.
    printed : mapping of str to mapping
        By the same labels, printed yields [%] by object.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = axes_or_new(ax)
    names = list(next(iter(ours.values())).object)
    width = 0.7 / max(len(ours), 1)
    for k, (label, table) in enumerate(ours.items()):
        at = np.arange(len(names)) + (k - (len(ours) - 1) / 2.0) * width
        rows = table.set_index("object").loc[names]
        # Rounding may put an interval that ends at 0 or 100 % a hair inside its yield.
        error = np.maximum([rows.yield_pct - rows.low_pct, rows.high_pct - rows.yield_pct], 0.0)
        ax.errorbar(
            at, rows.yield_pct, yerr=np.nan_to_num(error), fmt=MARKERS[k], color=CYCLE[k],
            markersize=6, capsize=2, linewidth=1.2, label=f"{label}, rebuilt (95 %)",
        )  # fmt: skip
        if label in printed:
            shown = [printed[label].get(name, np.nan) for name in names]
            ax.plot(
                at, shown, linestyle="", marker=MARKERS[k], markersize=8, markerfacecolor="none",
                markeredgecolor=CYCLE[k], label=f"{label}, printed",
            )  # fmt: skip
    ax.set_xticks(np.arange(len(names)), [name.replace("_", " ") for name in names], rotation=35)
    ax.set_ylabel(YIELD)
    ax.set_ylim(-3, 103)
    _legend_above(ax, columns=2)
    return ax


def plot_means(
    means: pd.DataFrame, printed: Mapping[float, Mapping[float, float]], *, ax: Any = None
) -> Any:
    """Draw mean yields over the radius ratio, a line for each planner and search radius.

    Parameters
    ----------
    means : pandas.DataFrame
        Rows of `medkit.grasping.yields.mean_yields` whose planner has a radius ratio.
    printed : mapping of float to mapping
        By search radius [m] and ratio [1], printed mean yields of the medial planner [%].
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Full lines are rebuilt, with 95 % intervals over objects; dashed ones are printed.
    """
    ax = axes_or_new(ax)
    keys = means[["planner", "search_radius"]].drop_duplicates().itertuples(index=False)
    for k, (planner, radius) in enumerate(keys):
        part = means[(means.planner == planner) & (means.search_radius == radius)]
        around = [part.yield_pct - part.low_pct, part.high_pct - part.yield_pct]
        ax.errorbar(
            part.min_radius_ratio + 0.008 * k, part.yield_pct, yerr=np.maximum(around, 0.0),
            color=CYCLE[k], marker=MARKERS[k], markersize=6, capsize=3,
            label=f"{planner}, {100 * radius:.0f} cm",
        )  # fmt: skip
        if planner == "medial" and radius in printed:
            known = printed[radius]
            ax.plot(
                list(known), list(known.values()), linestyle="--", color=CYCLE[k],
                marker=MARKERS[k], markersize=7, markerfacecolor="none",
                label=f"{planner}, {100 * radius:.0f} cm, printed",
            )  # fmt: skip
    ax.set(xlabel="smallest sphere over largest [1]", ylabel=YIELD, ylim=(0, 103))
    _legend_above(ax, columns=2)
    return ax


def plot_friction(
    tables: Mapping[str, pd.DataFrame], *, friction: float | None = None, ax: Any = None
) -> Any:
    """Draw yields over friction, one line a planner, with 95 % bands.

    Parameters
    ----------
    tables : mapping of str to DataFrame
        By label, from `medkit.grasping.robustness.yields_over_friction`.
    friction : float, optional
        Coefficient to mark [1].
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = axes_or_new(ax)
    for k, (label, table) in enumerate(tables.items()):
        share, low, high = interval_pct(table.held, table.tested)
        ax.plot(table.friction, share, color=CYCLE[k], marker=MARKERS[k], label=label)
        ax.fill_between(table.friction, low, high, color=CYCLE[k], alpha=0.15, linewidth=0)
    if friction is not None:
        ax.axvline(friction, color=BLACK, linestyle=":")
    ax.set(xlabel="friction coefficient [1]", ylabel=YIELD, ylim=(-3, 103))
    ax.legend(fontsize=8)
    return ax


def setting_labels(keys: Sequence[tuple]) -> list[str]:
    """Short names of settings (planner, grasp, search radius [m], radius ratio [1]).

    Examples
    --------
    >>> setting_labels([("medial", "power", 0.03, 0.5), ("normals", "power", 0.03, 0.0)])
    ['medial, 3 cm, from 0.5', 'normals']
    """
    return [
        f"{planner}, {100 * radius:g} cm, from {ratio:g}"
        if planner.startswith("medial")
        else planner
        for planner, _, radius, ratio in keys
    ]


def plot_reasons(reasons: pd.DataFrame, labels: Sequence[str], *, ax: Any = None) -> Any:
    """Draw shares of outcomes as stacked bars, one bar a row of `reasons`.

    Parameters
    ----------
    reasons : pandas.DataFrame
        Columns are outcomes [%], as from `medkit.grasping.experiments.failure_reasons`.
    labels : sequence of str
        Names of the rows.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = axes_or_new(ax)
    left = np.zeros(len(reasons))
    for outcome, (color, hatch) in OUTCOME_LOOKS.items():
        share = reasons[outcome].to_numpy()
        ax.barh(
            np.arange(len(reasons)), share, left=left, color=color, hatch=hatch,
            edgecolor="white", linewidth=0.5, label=outcome.replace("_", " "),
        )  # fmt: skip
        left += share
    ax.set_yticks(np.arange(len(reasons)), labels)
    ax.invert_yaxis()
    ax.set_xlim(0, 100)
    ax.set_xlabel("share of tested candidates [%]")
    _legend_above(ax, columns=4)
    return ax


def plot_robustness(table: pd.DataFrame, *, error: Literal["shift", "turn"], ax: Any = None) -> Any:
    """Draw the share of grasps that still hold over the size of an error, with 95 % intervals.

    Parameters
    ----------
    table : pandas.DataFrame
        From `medkit.grasping.robustness.yields_under_errors`, one or more planners.
    error : {"shift", "turn"}
        Which error to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = axes_or_new(ax)
    other = {"shift": "turn", "turn": "shift"}[error]
    scale = 1000.0 if error == "shift" else 180.0 / np.pi
    for k, (planner, part) in enumerate(table[table[other] == 0.0].groupby("planner", sort=False)):
        summed = part.groupby(error)[["kept", "held_before"]].sum()
        share, low, high = interval_pct(summed.kept, summed.held_before)
        at = scale * summed.index.to_numpy() + 0.08 * (k - 1)
        ax.errorbar(
            at, share, yerr=[share - low, high - share], marker=MARKERS[k], color=CYCLE[k],
            capsize=2, elinewidth=0.9, label=str(planner),
        )  # fmt: skip
    ax.set_xlabel("displacement of the hand [mm]" if error == "shift" else "turn of the hand [deg]")
    ax.set_ylabel("grasps that still hold [%]")
    ax.set_ylim(0, 103)
    ax.legend(fontsize=8)
    return ax


def plot_grip(openings: Floats, offsets: Floats, widths: Floats, *, ax: Any = None) -> Any:
    """Draw how far pads miss each other over their opening [m], with openings that are asked for.

    Parameters
    ----------
    openings, offsets : ndarray, shape (m,)
        Of a `medkit.grasping.precision_grip.PrecisionGrip` [m].
    widths : ndarray, shape (k,)
        Openings to mark [m].
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.
    """
    ax = axes_or_new(ax)
    ax.plot(1000.0 * openings, 1000.0 * offsets, color=BLUE, marker="")
    for width in np.minimum(widths, openings[0]):
        ax.axvline(1000.0 * float(width), color="0.6", linestyle=":")
    ax.set_xlabel("opening between the pads [mm]")
    ax.set_ylabel("depth by which they miss [mm]")
    return ax


def _legend_above(ax: Any, *, columns: int) -> None:
    """A legend over the axes, however high they are."""
    ax.legend(
        ncol=columns, fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), handlelength=1.6,
        columnspacing=1.2,
    )  # fmt: skip
