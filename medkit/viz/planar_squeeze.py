"""Pictures and short films of simulated squeezes, and of the studies made with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.patches import Circle, Polygon

from medkit.geometry import Floats
from medkit.planar.bounds import min_object_angle
from medkit.planar.squeezing import SqueezeResult
from medkit.planar.studies import PhaseDiagram
from medkit.viz.style import BLACK, BLUE, GREEN, OBJECT_GREY, ORANGE, VERMILION, axes_or_new


def plot_squeeze(result: SqueezeResult, frame: int = -1, *, ax: Any = None) -> Any:
    """Draw one recorded frame of a squeeze: object, fingers, and where the object began.

    Parameters
    ----------
    result : SqueezeResult
        A squeeze that recorded frames.
    frame : int
        Which one.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
        In millimetres; time in the title. Fingers are drawn 2.5 mm wide whatever their size.
    """
    axes = axes_or_new(ax)
    start, now = (_placed(result, index) for index in (0, frame))
    axes.add_patch(Polygon(start, fill=False, ls=":", edgecolor=BLACK, lw=0.9))
    axes.add_patch(Polygon(now, facecolor=OBJECT_GREY, edgecolor="#555555", alpha=0.8))
    color = GREEN if result.held else VERMILION
    for tip in 1e3 * result.tips[frame]:
        axes.add_patch(Circle(tuple(tip), 1.25, color=color, zorder=3))
    reach = 1.25e3 * result.outline.characteristic_length
    x, y = 1e3 * result.outline.center_mass
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), xlabel="x [mm]",
             ylabel="y [mm]", title=f"{1e3 * result.times[frame]:.0f} ms")  # fmt: skip
    axes.set_aspect("equal")
    return axes


def _placed(result: SqueezeResult, frame: int) -> Floats:
    """Outer loop of the object at a frame [mm]."""
    x, y, angle = result.poses[frame]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    local = result.outline.loops[0] - result.outline.center_mass
    return np.asarray(1e3 * (local @ turn.T + [x, y]))


def plot_squeeze_strip(result: SqueezeResult, count: int = 4, *, until: float | None = None) -> Any:
    """Draw `count` frames of a squeeze side by side, up to a time [s]; return the figure."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, count, figsize=(2.6 * count, 3.1), sharey=True)
    frames = _frames(result, count, until)
    for panel, frame in zip(panels, frames, strict=True):
        plot_squeeze(result, int(frame), ax=panel)
        panel.label_outer()
    figure.suptitle(
        f"simulated, friction {result.friction:.3f}: {result.reason}", fontsize=11, x=0.02,
        ha="left",
    )  # fmt: skip
    return figure


def _frames(result: SqueezeResult, count: int, until: float | None) -> list[int]:
    last = len(result.times) if until is None else int(np.searchsorted(result.times, until))
    return [int(frame) for frame in np.linspace(0, last - 1, min(count, last))]


def squeeze_film(
    result: SqueezeResult, *, frames: int = 12, until: float | None = None, dpi: int = 45
) -> str:
    """Make a film of a squeeze as one piece of HTML that plays without a network.

    Parameters
    ----------
    result : SqueezeResult
        A squeeze that recorded frames.
    frames : int
        Frames of the film; each costs about 5 kB.
    until : float, optional
        Time at which the film ends [s]; the end of the recording when left out.
    dpi : int
        Resolution.

    Returns
    -------
    str
        HTML with its pictures inside.
    """
    import matplotlib.pyplot as plt
    from matplotlib.animation import FuncAnimation

    figure, axes = plt.subplots(figsize=(4.2, 4.2))
    chosen = _frames(result, frames, until)

    def draw(frame: int) -> list[Any]:
        axes.clear()
        plot_squeeze(result, int(frame), ax=axes)
        return []

    with plt.rc_context({"animation.embed_limit": 5.0, "savefig.dpi": dpi, "figure.dpi": dpi}):
        film = FuncAnimation(figure, draw, frames=chosen, interval=120)
        html = str(film.to_jshtml(default_mode="once"))
    plt.close(figure)
    # matplotlib names the player at random; a fixed name keeps notebooks the same on every run
    names = sorted({part.split('"')[0] for part in html.split('id="_anim_img')[1:]})
    for name in names:
        html = html.replace(name, "medkitfilm")
    return html


def plot_phase_diagram(diagram: PhaseDiagram, *, ax: Any = None) -> Any:
    """Draw simulated verdicts over friction and object angle, with the bound through them."""
    axes = axes_or_new(ax)
    mu, angle = np.meshgrid(diagram.frictions, np.degrees(diagram.object_angles))
    for verdict, color, marker, label in (
        (True, GREEN, "s", "held (simulated)"), (False, VERMILION, "x", "slipped (simulated)"),
    ):  # fmt: skip
        where = diagram.held == verdict
        axes.plot(mu[where], angle[where], ls="", marker=marker, ms=4, color=color, label=label)
    fine = np.linspace(mu.min(), mu.max(), 200)
    axes.plot(fine, np.degrees([min_object_angle(value) for value in fine]), color=BLACK, marker="",
              label="bound")  # fmt: skip
    axes.set(xlabel="coefficient of friction [1]", ylabel="object angle [deg]")
    axes.set_ylim(np.degrees(diagram.object_angles).min() - 3, 183)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return axes


def plot_wedge_family(family: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw how far the simulated critical friction lies from the bound, in percent."""
    axes = axes_or_new(ax)
    axes.axhspan(-3, 3, color=OBJECT_GREY, alpha=0.25, lw=0, label="3 % band")
    axes.axhline(0.0, color=BLACK, lw=0.8)
    axes.plot(np.degrees(family["object_angle"]), 100 * family["deviation"], color=BLUE, marker="o",
              label="simulated against bound")  # fmt: skip
    axes.set(xlabel="object angle [deg]", ylabel="deviation of critical friction [%]")
    axes.legend(loc="lower left")
    return axes


def plot_agreement(table: pd.DataFrame, *, ax: Any = None) -> Any:
    """Draw per shape how often bound and simulation agree, and which way they differ."""
    axes = axes_or_new(ax)
    shapes = list(dict.fromkeys(table["shape"]))
    same = [float((t := table[table["shape"] == s])["bound"].eq(t["simulation"]).mean())
            for s in shapes]  # fmt: skip
    only_bound = [float((t["bound"] & ~t["simulation"]).mean())
                  for t in (table[table["shape"] == s] for s in shapes)]  # fmt: skip
    left = np.zeros(len(shapes))
    rest = 1.0 - np.array(same) - np.array(only_bound)
    for share, color, hatch, label in (
        (np.array(same), GREEN, "", "agree"),
        (np.array(only_bound), VERMILION, "//", "bound says hold, slips"),
        (rest, ORANGE, "..", "bound says slip, holds"),
    ):  # fmt: skip
        axes.barh(shapes, 100 * share, left=100 * left, color=color, hatch=hatch,
                  edgecolor="white", lw=0.5, label=label)  # fmt: skip
        left = left + share
    axes.set(xlabel="share of simulated squeezes [%]", xlim=(0, 100))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3)
    return axes
