"""Pictures of the grasping experiments: yields beside the printed ones, reasons, robustness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from medkit.geometry import Floats
from medkit.grasping.grasp_set import OUTCOMES
from medkit.viz.style import BLUE, CYCLE, GREEN, MARKERS, ORANGE, PURPLE, VERMILION, axes_or_new

#: Colours of outcomes, and hatches that keep them apart in grey.
OUTCOME_LOOKS = dict(
    zip(
        OUTCOMES,
        [(GREEN, ""), (ORANGE, "//"), (VERMILION, "xx"), (PURPLE, "..")],
        strict=True,
    )
)


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
    ax.set_ylabel("force-closure candidates [%]")
    ax.set_ylim(-3, 103)
    ax.legend(ncol=2, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.22))
    return ax


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
    ax.legend(ncol=2, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.28))
    return ax


def plot_robustness(table: pd.DataFrame, *, error: str, ax: Any = None) -> Any:
    """Draw the share of grasps that still hold over the size of an error, one line a planner.

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
        ax.plot(
            scale * summed.index.to_numpy(), 100.0 * summed.kept / summed.held_before,
            marker=MARKERS[k], color=CYCLE[k], label=str(planner),
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
