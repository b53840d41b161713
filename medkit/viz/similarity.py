"""Pictures of recorded reaches, grasps and rankings."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from medkit.datasets.human_grasps import FINGERS
from medkit.geometry import Floats
from medkit.similarity.movements import THRESHOLD, Movement
from medkit.similarity.recordings import Recording, speeds
from medkit.similarity.synergies import JOINTS, Synergies
from medkit.viz.style import (
    BLACK,
    BLUE,
    CYCLE,
    MARKERS,
    OBJECT_GREY,
    ORANGE,
    VERMILION,
    axes_or_new,
)

#: From above or from the side: the two axes shown, and their names.
VIEWS = {"above": ((0, 1), "x, to the right [mm]", "y, away [mm]"),
         "front": ((0, 2), "x, to the right [mm]", "z, up [mm]"),
         "side": ((1, 2), "y, away [mm]", "z, up [mm]")}  # fmt: skip


def plot_speed(
    recording: Recording, sensor: str, movements: list[Movement], *, ax: Any = None
) -> Any:
    """Speed of one tracker over time, with the threshold and the movements found."""
    ax = axes_or_new(ax)
    track = recording.sensors.index(sensor)
    ax.plot(recording.times, speeds(recording)[:, track], color=BLUE, marker="", label=sensor)
    ax.axhline(THRESHOLD, color=BLACK, linestyle=":", linewidth=1.0, label="threshold")
    for number, movement in enumerate(movements):
        start, end = recording.times[[movement.start, movement.end]]
        ax.axvspan(start, end, color=ORANGE, alpha=0.2, label=None if number else "movement")
    ax.set(xlabel="time [s]", ylabel="speed [m/s]")
    ax.legend()
    return ax


def plot_outline(
    shape: str, extents: Any, *, view: str = "above", ax: Any = None, color: str = OBJECT_GREY
) -> Any:
    """Outline of a standing cylinder or box [mm], seen from above or from a side."""
    from matplotlib.patches import Ellipse, Rectangle

    ax = axes_or_new(ax)
    (first, second), xlabel, ylabel = VIEWS[view]
    width, height = 1e3 * np.asarray(extents, dtype=float)[[first, second]]
    if shape == "cylinder" and view == "above":
        patch: Any = Ellipse((0.0, 0.0), width, height)
    else:
        patch = Rectangle((-0.5 * width, -0.5 * height), width, height)
    patch.set(facecolor=color, edgecolor=BLACK, alpha=0.6, zorder=0)
    ax.add_patch(patch)
    ax.set(xlabel=xlabel, ylabel=ylabel, aspect="equal")
    ax.autoscale_view()
    return ax


def plot_fingertips(
    fingertips: Floats, *, view: str = "above", ax: Any = None, legend: bool = True, **style: Any
) -> Any:
    """Fingertips (n, 5, 3) [m] of several grasps, one colour and marker per finger [mm]."""
    ax = axes_or_new(ax)
    (first, second), xlabel, ylabel = VIEWS[view]
    tips = np.asarray(fingertips).reshape(-1, len(FINGERS), 3)
    for finger, name in enumerate(FINGERS):
        ax.plot(
            1e3 * tips[:, finger, first], 1e3 * tips[:, finger, second], linestyle="none",
            color=CYCLE[finger], marker=MARKERS[finger], label=name if legend else None, **style,
        )  # fmt: skip
    ax.set(xlabel=xlabel, ylabel=ylabel, aspect="equal")
    if legend:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return ax


def plot_ranked_grasps(
    origins: Floats, approaches: Floats, distances: Floats, *, view: str = "above",
    human: Floats | None = None, ax: Any = None,
) -> Any:  # fmt: skip
    """Planned grasps as arrows with a disc, large where people's are near (P13 figure 6.10).

    `origins` (n, 3) [m] hand positions, `approaches` (n, 3) directions of movement, `distances`
    (n,) [m] by some measure, `human` (k, 3) [m] averaged fingertips, drawn in black.
    """
    ax = axes_or_new(ax)
    (first, second), xlabel, ylabel = VIEWS[view]
    places, ways = 1e3 * np.asarray(origins), np.asarray(approaches)
    span = float(np.ptp(distances)) or 1.0
    alike = 1.0 - (np.asarray(distances) - np.min(distances)) / span
    ax.quiver(
        places[:, first], places[:, second], ways[:, first], ways[:, second], color=BLUE,
        angles="xy", scale_units="xy", scale=1.0 / 25.0, width=0.003, alpha=0.6, zorder=1,
    )  # fmt: skip
    ax.scatter(
        places[:, first], places[:, second], s=6.0 + 140.0 * alike**3, color=VERMILION,
        edgecolor=BLACK, linewidth=0.4, alpha=0.7, zorder=2, label="planned hand",
    )  # fmt: skip
    if human is not None:
        tips = 1e3 * np.asarray(human)
        ax.plot(tips[:, first], tips[:, second], "o", color=BLACK, markersize=6,
                label="human fingertips", zorder=3)  # fmt: skip
    ax.set(xlabel=xlabel, ylabel=ylabel, aspect="equal")
    return ax


def plot_rank_matrix(table: pd.DataFrame, measures: tuple[str, ...], *, ax: Any = None) -> Any:
    """Ranks of the grasps under several measures, one line per grasp."""
    ax = axes_or_new(ax)
    ranks = table[list(measures)].rank().to_numpy()
    for row, line in enumerate(ranks):
        best = row == int(np.argmin(ranks[:, 0]))
        ax.plot(range(len(measures)), line, color=VERMILION if best else OBJECT_GREY,
                marker="o", linewidth=2.2 if best else 0.8, zorder=2 if best else 1)  # fmt: skip
    ax.set(xticks=range(len(measures)), ylabel="rank (1: most human-like)", xlabel="measure")
    ax.set_xticklabels(measures)
    ax.invert_yaxis()
    return ax


def plot_rank_agreement(agreement: dict[str, pd.DataFrame], *, ax: Any = None) -> Any:
    """Rank correlations between measures with intervals, a colour and marker per object.

    `agreement` maps names of objects to tables of `medkit.similarity.ranking.rank_agreement`.
    """
    ax = axes_or_new(ax)
    shifts = np.linspace(-0.12, 0.12, len(agreement)) if len(agreement) > 1 else np.zeros(1)
    for shift, (name, rows) in zip(shifts, agreement.items(), strict=True):
        reach = [rows["tau"] - rows["low"], rows["high"] - rows["tau"]]
        ax.errorbar(np.arange(len(rows)) + shift, rows["tau"], yerr=reach, linestyle="none",
                    capsize=3, label=name)  # fmt: skip
    rows = next(iter(agreement.values()))
    ax.axhline(0.0, color=BLACK, linewidth=0.8)
    ax.set_xticks(range(len(rows)), rows["first"] + "\n" + rows["second"], fontsize=8)
    ax.set(ylabel="rank correlation [1]", xlabel="pair of measures")
    ax.legend()
    return ax


def plot_joint_angles(postures: dict[str, Floats], *, ax: Any = None) -> Any:
    """Angles of the fifteen joints of named postures (15,) [rad], one line each [deg]."""
    if ax is None:
        _, ax = plt.subplots(figsize=(6.8, 3.8))
    for name, angles in postures.items():
        ax.plot(range(len(JOINTS)), np.rad2deg(angles), label=name)
    names = [joint.replace("_", " ") for joint in JOINTS]
    ax.set_xticks(range(len(JOINTS)), names, rotation=60, ha="right", fontsize=8)
    ax.set(ylabel="joint angle [deg]", xlabel="joint")
    ax.legend(loc="upper right")
    return ax


def plot_variance_share(synergies: Synergies, *, ax: Any = None, label: str = "") -> Any:
    """Share of the joint angles' variance that the first components carry."""
    ax = axes_or_new(ax)
    count = np.arange(1, len(synergies.share) + 1)
    ax.plot(count, 100.0 * synergies.share, label=label or None)
    ax.set(xlabel="number of components", ylabel="share of variance [%]", ylim=(0.0, 102.0))
    return ax
