"""Pictures of the planar room: contacts and cones, outlines and disks, squeezes and diagrams."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import ConvexHull

from medkit.planar.bounds import cone_half_angle, is_antipodal, min_object_angle
from medkit.planar.closure import epsilon, is_force_closure, primitive_wrenches
from medkit.planar.disks import MedialAxis
from medkit.planar.materials import MATERIALS
from medkit.planar.outlines import Outline
from medkit.planar.regions import EdgePair
from medkit.viz.style import (
    BLACK,
    BLUE,
    GREEN,
    OBJECT_GREY,
    ORANGE,
    SEQUENTIAL,
    SKY,
    VERMILION,
    axes_or_new,
)


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
        name = pair.name if pair.high <= 1.6 else f"{pair.name} (up to {pair.high:g})"
        axes.text(
            side, height, name, va="center", fontsize=8,
            ha="right" if pair.low > 0.5 else "left",
        )  # fmt: skip
    if friction is not None:
        mark = np.degrees(min_object_angle(friction))
        axes.plot([friction], [mark], color=VERMILION, marker="o", ms=8, ls="")
        axes.annotate(
            f"{mark:.1f} deg", (friction, mark), xytext=(8, 8), textcoords="offset points"
        )
    axes.set(xlabel="coefficient of static friction [1]", ylabel="object angle [deg]",
             xlim=(0.0, 1.6), ylim=(0.0, 182.0), yticks=range(0, 181, 30))  # fmt: skip
    axes.legend(loc="upper right")
    return axes


def plot_outline(outline: Outline, *, ax: Any = None) -> Any:
    """Draw an outline as a filled region, holes left open; axes in millimetres."""
    axes = axes_or_new(ax)
    vertices, codes = [], []
    for loop in outline.loops:
        closed = 1e3 * np.vstack([loop, loop[:1]])
        vertices.append(closed)
        codes.append([Path.MOVETO] + [Path.LINETO] * (len(loop) - 1) + [Path.CLOSEPOLY])
    shape = Path(np.vstack(vertices), np.concatenate(codes))
    axes.add_patch(PathPatch(shape, facecolor="#ECECEC", edgecolor="#555555", lw=1.2, zorder=1))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    return axes


def plot_medial_axis(axis: MedialAxis, *, ax: Any = None, colorbar: bool = True) -> Any:
    """Draw outline and medial disks' centres, coloured by object angle from 0 to 180 deg."""
    axes = plot_outline(axis.outline, ax=ax)
    order = np.argsort(axis.object_angles)
    dots = axes.scatter(
        *(1e3 * axis.centers[order].T), c=np.degrees(axis.object_angles[order]), s=7,
        cmap=SEQUENTIAL, vmin=0.0, vmax=180.0, zorder=3,
    )  # fmt: skip
    if colorbar:
        axes.figure.colorbar(
            dots, ax=axes, label="object angle [deg]", shrink=0.8, ticks=range(0, 181, 60)
        )
    return axes


def plot_disks(axis: MedialAxis, indices: Any, *, ax: Any = None, color: str = BLUE) -> Any:
    """Add some medial disks with the radii to their touch points to axes in millimetres."""
    axes = axes_or_new(ax)
    turn = np.linspace(0.0, 2.0 * np.pi, 121)
    for index in np.atleast_1d(indices):
        center, radius = 1e3 * axis.centers[index], 1e3 * axis.radii[index]
        rim = center + radius * np.column_stack([np.cos(turn), np.sin(turn)])
        axes.plot(rim[:, 0], rim[:, 1], color=color, lw=1.0, marker="", zorder=4)
        spokes = np.insert(1e3 * axis.touch_points[index], 1, center, axis=0)
        axes.plot(spokes[:, 0], spokes[:, 1], color=color, lw=0.9, ls="--", marker="", zorder=4)
        axes.plot(spokes[::2, 0], spokes[::2, 1], color=color, ls="", marker="o", zorder=5)
    return axes


def plot_grasp(
    outline: Outline, points: Any, normals: Any, *, friction: float, ax: Any = None
) -> Any:
    """Draw an outline with contacts, their inward normals and cones, and say if they hold it."""
    axes = plot_outline(outline, ax=ax)
    held = is_force_closure(points, normals, friction=friction, outline=outline)
    length = 450.0 * outline.characteristic_length
    for point, normal in zip(1e3 * np.asarray(points), np.asarray(normals), strict=True):
        draw_cone(axes, point, normal, friction, length=length, color=GREEN if held else VERMILION)
        start, way = point - 0.5 * length * normal, 0.42 * length * normal
        axes.annotate("", point - 0.06 * length * normal, start, arrowprops={"width": 2.0,
                      "headwidth": 7.0, "headlength": 7.0, "color": BLACK})  # fmt: skip
        axes.update_datalim([start, start + way])
    axes.autoscale_view()
    axes.set_title("force closure" if held else "no force closure")
    return axes


def plot_wrench_space(
    points: Any, normals: Any, *, friction: float, outline: Outline, ax: Any = None
) -> Any:
    """Draw the hull of the primitive wrenches as a solid body, with the epsilon ball inside.

    Parameters
    ----------
    points, normals : array-like, shape (n, 2)
        Contacts [m], [1].
    friction : float
        Coefficient of friction [1].
    outline : Outline
        The object, for centre and length of the torques.
    ax : matplotlib Axes3D, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes3D
        Forces [N] and torque over characteristic length [N], normal forces adding up to 1 N.
    """
    axes = axes_or_new(ax, projection="3d")
    axes.computed_zorder = False  # else the ball shows through the body in the body's colour
    wrenches = primitive_wrenches(points, normals, friction=friction, outline=outline)
    if np.linalg.matrix_rank(wrenches - wrenches.mean(axis=0), tol=1e-9) == 3:
        hull = ConvexHull(wrenches)
        body = Poly3DCollection(wrenches[hull.simplices], alpha=0.25, facecolor=SKY,
                                edgecolor=BLUE, lw=0.5, zorder=1)  # fmt: skip
        axes.add_collection3d(body)
    axes.scatter(*wrenches.T, color=BLUE, s=12, zorder=3)
    radius = epsilon(points, normals, friction=friction, outline=outline).lower
    if radius > 0.0:
        u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
        ball = radius * np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
        axes.plot_surface(*ball, color=ORANGE, alpha=0.9, lw=0, zorder=2)
    axes.scatter([0], [0], [0], color=BLACK, s=20, zorder=4)
    reach = 1.05 * np.abs(wrenches).max()
    axes.set(xlabel="fx [N]", ylabel="fy [N]", zlabel="torque / length [N]",
             xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))  # fmt: skip
    ticks = np.round(np.linspace(-1.0, 1.0, 3) * reach / 1.05, 2)
    axes.set(xticks=ticks, yticks=ticks, zticks=ticks)
    axes.set_title(f"epsilon {radius:.3f} N" if radius > 0 else "the origin is not inside")
    return axes


def plot_edge_pair(outline: Outline, pair: EdgePair, *, ax: Any = None) -> Any:
    """Draw the independent intervals of a pair of edges on the outline."""
    axes = plot_outline(outline, ax=ax)
    for edge, interval, color in zip(
        (pair.first, pair.second), pair.independent, (BLUE, ORANGE), strict=True
    ):
        ends = outline.starts[edge] + interval[:, None] * outline.tangents[edge]
        axes.plot(*(1e3 * ends.T), color=color, lw=6, marker="", solid_capstyle="butt", zorder=3)
    axes.set_title(f"edges {pair.first} and {pair.second}: {1e3 * pair.room:.1f} mm of room")
    return axes


def plot_region(pair: EdgePair, places: Any, held: Any, *, ax: Any = None) -> Any:
    """Draw the good region of a pair of edges with its largest box, and grasps that were asked.

    Parameters
    ----------
    pair : EdgePair
        Region and box.
    places : array-like, shape (n, 2)
        Places on both edges [m].
    held : array-like of bool, shape (n,)
        Which of them were found force-closure.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
        Place on the first edge against place on the second [mm].
    """
    axes, spots, good = axes_or_new(ax), 1e3 * np.asarray(places), np.asarray(held, dtype=bool)
    axes.fill(*(1e3 * pair.region.T), color="#DDDDDD", label="good region")
    axes.plot(*spots[good].T, "o", color=GREEN, ms=2.5, ls="", label="force closure")
    axes.plot(*spots[~good].T, "x", color=VERMILION, ms=4, mew=0.8, ls="", label="not")
    (s0, s1), (t0, t1) = 1e3 * pair.independent
    axes.plot([s0, s1, s1, s0, s0], [t0, t0, t1, t1, t0], color=BLACK, marker="",
              label="independent")  # fmt: skip
    axes.set(xlabel="place on the first edge [mm]", ylabel="place on the second edge [mm]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return axes


def plot_graspable_shares(shares: dict[tuple[str, str], Any]) -> Any:
    """Draw per shape and material how much of the axis holds; returns the figure.

    Parameters
    ----------
    shares : dict of (shape, material) to pair of float
        Share of the axis at the lower and at the upper end of the range of friction, 0 to 1.

    Returns
    -------
    matplotlib Figure
        One panel per shape; careful and lucky shares [%].
    """
    shapes = list(dict.fromkeys(shape for shape, _ in shares))
    names = list(dict.fromkeys(name for _, name in shares))
    figure, panels = plt.subplots(
        1, len(shapes), figsize=(2.9 * len(shapes), 3.4), sharey=True, squeeze=False
    )
    for panel, shape in zip(panels[0], shapes, strict=True):
        low, high = 100 * np.array([shares[shape, name] for name in names]).T
        panel.barh(names, high, color=SKY, hatch="//", edgecolor="white", label="lucky")
        panel.barh(names, low, color=BLUE, label="careful")
        panel.set(title=shape, xlabel="graspable [% of axis]", xlim=(0, 100))
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure
