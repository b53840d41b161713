"""Pictures of the planar room: contacts and cones, outlines and disks, squeezes and diagrams."""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.planar.bounds import cone_half_angle, is_antipodal, min_object_angle
from medkit.planar.materials import MATERIALS
from medkit.viz.style import BLACK, BLUE, GREEN, OBJECT_GREY, ORANGE, VERMILION, axes_or_new


def plot_two_contacts(object_angle: float, *, friction: float, ax: Any = None) -> Any:
    """Draw a medial disk of radius one, its two touch points, their cones and the chord.

    Parameters
    ----------
    object_angle : float
        Angle between the two radii that end in the touch points [rad].
    friction : float
        Coefficient of static friction [1].
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
        Lengths in disk radii.
    """
    axes = axes_or_new(ax)
    held = is_antipodal(object_angle, friction=friction)
    colour = GREEN if held else VERMILION
    half = 0.5 * object_angle
    touch = np.array([[-np.sin(half), np.cos(half)], [np.sin(half), np.cos(half)]])
    _draw_flanks(axes, touch)
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(np.cos(turn), np.sin(turn), color=BLACK, lw=1.0, marker="")
    for point in touch:
        axes.plot([0.0, point[0]], [0.0, point[1]], color=BLACK, lw=0.8, ls=":", marker="")
        draw_cone(axes, point, -point, friction, length=1.6, color=colour)
    axes.plot(touch[:, 0], touch[:, 1], color=colour, lw=2.2, marker="o", ms=6)
    verdict = "force closure" if held else "no force closure"
    axes.set_title(
        f"object angle {np.degrees(object_angle):.0f} deg, friction {friction:.2f}\n{verdict}"
    )
    axes.set(xlabel="x [disk radii]", ylabel="y [disk radii]", xlim=(-2.1, 2.1), ylim=(-1.6, 1.9))
    axes.set_aspect("equal")
    return axes


def _draw_flanks(axes: Any, touch: Any) -> None:
    along = np.array([[-1.2], [1.2]])
    sides = [point + along * np.array([-point[1], point[0]]) for point in touch]
    for line in sides:
        axes.plot(line[:, 0], line[:, 1], color=OBJECT_GREY, lw=5.0, marker="", zorder=1)


def draw_cone(
    axes: Any, point: Any, normal: Any, friction: float, *, length: float, color: str
) -> None:
    """Add a filled friction cone with its apex at a contact to existing axes."""
    beta = cone_half_angle(friction)
    facing = np.arctan2(normal[1], normal[0])
    sweep = facing + np.linspace(-beta, beta, 25)
    rim = np.asarray(point) + length * np.column_stack([np.cos(sweep), np.sin(sweep)])
    corner = np.vstack([point, rim, point])
    axes.fill(corner[:, 0], corner[:, 1], color=color, alpha=0.18, lw=0)
    axes.plot(corner[:, 0], corner[:, 1], color=color, lw=0.9, marker="")


def plot_object_angle_bound(*, friction: float | None = None, ax: Any = None) -> Any:
    """Draw the smallest object angle over friction, with the materials of the table.

    Parameters
    ----------
    friction : float, optional
        A value to mark on the curve [1].
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
        Friction [1] against object angle [deg].
    """
    axes = axes_or_new(ax)
    grid = np.linspace(0.0, 1.6, 321)
    bound = np.degrees([min_object_angle(value) for value in grid])
    axes.plot(grid, bound, color=BLUE, marker="", label="bound, itself not force closure")
    axes.fill_between(grid, bound, 180.0, color=BLUE, alpha=0.12, lw=0, label="force closure")
    for row, pair in enumerate(MATERIALS):
        height = 4.0 + 9.0 * row
        axes.plot([pair.low, min(pair.high, 1.6)], [height, height], color=ORANGE, marker="|", ms=8)
        side = pair.low - 0.02 if pair.low > 0.5 else min(pair.high, 1.6) + 0.02
        axes.text(
            side, height, pair.name, va="center", fontsize=8,
            ha="right" if pair.low > 0.5 else "left",
        )  # fmt: skip
    if friction is not None:
        mark = np.degrees(min_object_angle(friction))
        axes.plot([friction], [mark], color=VERMILION, marker="o", ms=8, ls="")
        axes.annotate(
            f"{mark:.1f} deg", (friction, mark), xytext=(8, 8), textcoords="offset points"
        )
    axes.set(xlabel="coefficient of static friction [1]", ylabel="object angle [deg]",
             xlim=(0.0, 1.6), ylim=(0.0, 182.0))  # fmt: skip
    axes.legend(loc="upper right")
    return axes
