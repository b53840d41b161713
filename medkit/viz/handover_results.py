"""Figures of the handover results: claims, iso-score curves, recommendation, checks, power."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from medkit.handover.ordinal import rating_probabilities
from medkit.viz.handover import FORCE_LABEL, SCORE_LABEL, WEIGHT_LABEL
from medkit.viz.style import BLACK, BLUE, CYCLE, MARKERS, ORANGE, VERMILION, axes_or_new

_LINES = ("-", "--", ":", "-.")


def plot_claims(
    table: pd.DataFrame, *, estimates: pd.DataFrame | None = None, ax: Any = None
) -> Any:
    """Draw every claim's estimate with both intervals, each scaled by its own estimate.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`medkit.handover.claims`.
    estimates : pandas.DataFrame, optional
        From :func:`medkit.handover.subject_estimates`; drawn as open circles.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Claims that hold lie right of zero; 1 is the estimate itself.
    """
    ax = axes_or_new(ax)
    for row, (number, claim) in enumerate(table.iterrows()):
        size = abs(claim["estimate"])
        if not np.isfinite(size) or size == 0:
            continue
        ends = np.array([claim["low"], claim["high"]]) / size
        own = np.array([claim["low_these"], claim["high_these"]]) / size
        ax.plot(ends, [row, row], color=BLACK, marker="|", markersize=9, linewidth=1.4)
        ax.plot(own, [row, row], color=BLUE, linewidth=6, alpha=0.45, marker="")
        if estimates is not None:
            values = estimates[estimates.index == number].iloc[0].dropna() / size
            ax.plot(values, np.full(len(values), row + 0.22), linestyle="", marker="o",
                    markerfacecolor="white", color=VERMILION)  # fmt: skip
        ax.plot(claim["estimate"] / size, row, marker="D", color=BLACK, markersize=5)
    ax.axvline(0, color="#666666", linewidth=1)
    names = [f"{number}  {claim['claim']}" for number, claim in table.iterrows()]
    ax.set_yticks(range(len(names)), [_wrapped(name) for name in names], fontsize=8)
    ax.invert_yaxis()
    ax.set_xlabel("estimate in units of itself [1]; right of zero the claim holds")
    return ax


def plot_iso_score(curve: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw iso-score curves over weight with their intervals, one line per pose and mode.

    Parameters
    ----------
    curve : pandas.DataFrame
        From :func:`medkit.handover.iso_score`.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Release force over weight.
    """
    ax = axes_or_new(ax)
    for index, ((pose, mode), part) in enumerate(curve.groupby(["pose", "mode"])):
        color = CYCLE[index % len(CYCLE)]
        ax.fill_between(part["weight"], part["low"], part["high"], color=color, alpha=0.18)
        ax.plot(part["weight"], part["force"], color=color, marker=MARKERS[index % len(MARKERS)],
                linestyle=_LINES[index % 4], label=f"{pose}, {mode}")  # fmt: skip
    ax.set(xlabel=WEIGHT_LABEL, ylabel=FORCE_LABEL, ylim=(0, 1.05 * float(curve["high"].max())))
    ax.legend()
    return ax


def figure_iso_score(curve: pd.DataFrame, *, level: float | None = None) -> Any:
    """Return iso-score curves as small multiples, a panel per pose and mode, on one scale."""
    groups = list(curve.groupby(["pose", "mode"]))
    columns = min(2, len(groups))
    figure, axes = plt.subplots(
        -(-len(groups) // columns), columns, squeeze=False, sharex=True, sharey=True,
        figsize=(3.9 * columns, 2.7 * -(-len(groups) // columns) + 0.3),
    )  # fmt: skip
    for ax, ((pose, mode), part) in zip(axes.ravel(), groups, strict=False):
        plot_iso_score(part, ax=ax)
        ax.get_legend().remove()
        ax.set_title(f"{pose}, {mode}")
        ax.label_outer()
    axes[0][0].set_ylim(0, 1.05 * float(curve["high"].max()))
    if level is not None:
        figure.suptitle(f"release force at an expected score of {level:g}", x=0.01, ha="left")
    return figure


def plot_recommendation(table: pd.DataFrame, *, pose: str, mode: str, ax: Any = None) -> Any:
    """Draw safety limit, naturalness limit and what lies between, over weight.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`medkit.handover.recommend_force`.
    pose, mode : str
        The condition.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Release force over weight; filled where both limits leave room.
    """
    ax = axes_or_new(ax)
    part = table[(table["pose"] == pose) & (table["mode"] == mode)]
    weight = part["weight"]
    room = part["upper"] > part["lower"]
    ax.fill_between(weight, part["lower"], part["upper"], where=room, interpolate=True,
                    color=BLUE, alpha=0.25, label="room for both")  # fmt: skip
    ax.plot(weight, part["upper_estimate"], color=BLUE, linestyle="--", marker="",
            label="naturalness, estimate")  # fmt: skip
    ax.plot(weight, part["upper"], color=BLUE, marker="", label="naturalness, cautious")
    ax.plot(weight, part["lower"], color=VERMILION, linestyle="-.", marker="", label="safety")
    ax.plot(weight, part["force"], linestyle="", marker="D", color=BLACK, label="recommended")
    top = 1.05 * float(part[["upper_estimate", "force"]].max().max())
    ax.set(xlabel=WEIGHT_LABEL, ylabel=FORCE_LABEL, title=f"{pose}, {mode}", ylim=(0, top))
    return ax


def figure_recommendation(table: pd.DataFrame) -> Any:
    """Return the recommendation as small multiples, a panel per pose and mode, on one scale."""
    groups = [name for name, _ in table.groupby(["pose", "mode"])]
    columns = min(2, len(groups))
    figure, axes = plt.subplots(
        -(-len(groups) // columns), columns, squeeze=False, sharex=True, sharey=True,
        figsize=(3.9 * columns, 2.7 * -(-len(groups) // columns) + 0.5),
    )  # fmt: skip
    for ax, (pose, mode) in zip(axes.ravel(), groups, strict=False):
        plot_recommendation(table, pose=str(pose), mode=str(mode), ax=ax)
        ax.label_outer()
    axes[0][0].set_ylim(0, 1.05 * float(table[["upper_estimate", "force"]].max().max()))
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def plot_calibration(table: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw observed against predicted frequencies (from :func:`medkit.handover.calibration`)."""
    ax = axes_or_new(ax)
    ax.plot([0, 1], [0, 1], color="#999999", linewidth=1, marker="")
    for index, (event, part) in enumerate(table.groupby("event")):
        color = CYCLE[index % len(CYCLE)]
        ax.errorbar(part["predicted"], part["observed"], yerr=part["error"], color=color,
                    marker=MARKERS[index], linestyle=_LINES[index], capsize=2,
                    label=str(event))  # fmt: skip
    ax.set(xlabel="predicted probability [1]", ylabel="observed share [1]", xlim=(-0.03, 1.03),
           ylim=(-0.03, 1.03))  # fmt: skip
    ax.legend()
    return ax


def plot_interval_width(table: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw the half width of the slope's interval over subjects (from ``slope_power``)."""
    ax = axes_or_new(ax)
    for index, (name, part) in enumerate(table.groupby("spread", sort=False)):
        ax.plot(part["subjects"], part["half_width"], color=CYCLE[index], marker=MARKERS[index],
                linestyle=_LINES[index], label=str(name))  # fmt: skip
    top = 1.05 * float(table["half_width"].max())
    ax.set(xlabel="subjects", ylabel="half width of the interval [N/kg]", ylim=(0, top))
    ax.legend()
    return ax


def plot_power(table: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw the chance to decide each claim over subjects (from ``claim_power``)."""
    ax = axes_or_new(ax)
    for index, (number, part) in enumerate(table.groupby("number")):
        ax.plot(part["subjects"], part["power"], color=CYCLE[index % len(CYCLE)],
                marker=MARKERS[index % len(MARKERS)], linestyle=_LINES[index % 4],
                label=f"claim {number}")  # fmt: skip
    ax.axhline(0.8, color="#888888", linewidth=1)
    ax.set(xlabel="subjects", ylabel="chance to decide [1]", ylim=(0, 1.03))
    ax.legend(ncols=2)
    return ax


def plot_human_release(references: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw when people let go, as bars over the time since contact.

    Parameters
    ----------
    references : pandas.DataFrame
        From :func:`medkit.datasets.handover_trials.human_references`.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        One row per figure of the literature; an arrow where no upper bound is given.
    """
    ax = axes_or_new(ax)
    ends = references[["low", "high"]].to_numpy(dtype=float)
    for row, (low, high) in enumerate(ends):
        if np.isfinite(high):
            ax.barh(row, max(high - low, 0.006), left=low, height=0.55, color=BLUE)
        else:
            ax.annotate("", (low + 0.1, row), (low, row),
                        arrowprops={"arrowstyle": "->", "color": BLUE, "linewidth": 2})  # fmt: skip
    ax.axvline(0, color="#666666", linewidth=1)
    ax.set_yticks(
        range(len(references)), [_wrapped(name) for name in references["name"]], fontsize=8
    )
    ax.set(xlabel="time after contact [s]", xlim=(-0.1, 0.56))
    ax.invert_yaxis()
    return ax


def add_load_line(ax: Any, weights: Any) -> Any:
    """Add the line on which the release force equals the load, to axes of force over weight."""
    ax.plot(weights, 9.81 * np.asarray(weights), color="#666666", linewidth=1, linestyle=":",
            marker="", label="load itself")  # fmt: skip
    return ax


def plot_link(*, thresholds: tuple[float, float] = (-1.5, 1.5), ax: Any = None) -> Any:
    """Draw how one straight line becomes three probabilities: the cumulative logit explained.

    Parameters
    ----------
    thresholds : (float, float)
        Borders between bad and acceptable, and between acceptable and good [log-odds].
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Probabilities and expected score over the linear predictor; borders as thin lines.
    """
    ax = axes_or_new(ax)
    eta = np.linspace(-6, 6, 200)
    chances = rating_probabilities(eta, np.array(thresholds))
    names = ("bad", "acceptable", "good")
    for name, color, line, values in zip(
        names, (VERMILION, ORANGE, BLUE), _LINES, chances.T, strict=False
    ):
        ax.plot(eta, values, color=color, linestyle=line, marker="", label=name)
    ax.plot(eta, chances @ [0, 0.5, 1], color=BLACK, linewidth=1, marker="", label="expected score")
    for border in thresholds:
        ax.axvline(border, color="#888888", linewidth=0.8, linestyle=":")
    ax.set(xlabel="linear predictor [log-odds]", ylabel=f"probability, {SCORE_LABEL}")
    ax.legend(loc="center right")
    return ax


def _wrapped(text: str, width: int = 34) -> str:
    lines, line = [], ""
    for word in text.split(" "):
        if line and len(line) + len(word) + 1 > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}" if line else word
    return "\n".join([*lines, line])


def plot_people(estimates: pd.Series, chosen: Any, interval: Any, *, ax: Any = None) -> Any:
    """Draw the numbers of several people, those that came filled, and the interval they give.

    Parameters
    ----------
    estimates : pandas.Series
        One number per person or block.
    chosen : sequence of str
        Who came; a name may come twice.
    interval : (float, float, float)
        Mean, lower and upper end.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The bar is the interval, orange when it covers zero.
    """
    if ax is None:
        _, ax = plt.subplots(figsize=(6.4, 2.8))
    middle, low, high = (float(value) for value in interval)
    names = list(chosen)
    for row, (name, value) in enumerate(estimates.items()):
        count = names.count(name)
        ax.plot(value, row, "o", color=BLUE, markersize=7,
                fillstyle="full" if count else "none")  # fmt: skip
        ax.annotate(f"{name} x {count}", (value, row), xytext=(7, -3),
                    textcoords="offset points", fontsize=8)  # fmt: skip
    covers = low <= 0.0 <= high
    color, row = (ORANGE if covers else BLUE), len(estimates)
    ax.plot([low, high], [row, row], color=color, marker="|", markersize=9, linewidth=2.4)
    ax.plot(middle, row, "D", color=BLACK)
    ax.axvline(0, color="#666666", linewidth=1)
    ax.set_yticks([row], ["interval"])
    ax.set(ylim=(row + 0.6, -0.6), title="covers zero" if covers else "clear of zero")
    return ax


def plot_experiments(intervals: Any, *, truth: float, ax: Any = None) -> Any:
    """Draw simulated experiments as bars (n, 3) of mean, low and high slope [N/kg].

    Bars that cover zero are orange and dashed; `truth` is the mean of the simulated people.
    """
    ax = axes_or_new(ax)
    table = np.asarray(intervals, dtype=float)
    for row, (middle, low, high) in enumerate(table):
        covers = low <= 0.0 <= high
        color = ORANGE if covers else BLUE
        ax.plot([low, high], [row, row], color=color, linestyle="--" if covers else "-", marker="")
        ax.plot(middle, row, "o", color=color)
    ax.axvline(0, color="#666666", linewidth=1)
    ax.axvline(truth, color=BLACK, linestyle=":", linewidth=1.2)
    ax.set(
        xlabel="slope of the release force [N/kg]", ylabel="experiment", yticks=[], xlim=(-4, 12)
    )
    return ax
