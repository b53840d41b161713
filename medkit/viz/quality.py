"""Friction cones, wrench polytopes with their balls, and the polytope that grows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from medkit import quality
from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.geometry import Floats, nonnegative
from medkit.quality.steps import ExpansionStep
from medkit.viz.style import BLACK, BLUE, OBJECT_GREY, ORANGE, SKY, VERMILION, axes_or_new

PLANAR_LABELS = ("force x [N]", "force y [N]", "torque z / scale [N]")
SPATIAL_LABELS = (
    "force x [N]", "force y [N]", "force z [N]",
    "torque x / scale [N]", "torque y / scale [N]", "torque z / scale [N]",
)  # fmt: skip


def plot_friction_cones_2d(
    contacts: Contacts, *, outline: ArrayLike | None = None, size: float = 0.5, ax: Any = None
) -> Any:
    """Draw planar contacts with their friction cones, opening into the object.

    Parameters
    ----------
    contacts : Contacts
        Planar contacts.
    outline : array-like, shape (k, 2), optional
        Outline of the object [m], closed by itself.
    size : float
        Drawn length of a unit normal force [m].
    ax : matplotlib axes, optional
        Where to draw.

    Returns
    -------
    matplotlib axes
    """
    if contacts.dimension != 2:
        raise InputError(
            "Expected planar contacts, but got spatial ones; project them or use"
            " plot_wrench_projection."
        )
    axes = axes_or_new(ax)
    if outline is not None:
        axes.fill(*np.asarray(outline, dtype=float).T, color=OBJECT_GREY, alpha=0.5, zorder=1)
    edges = contacts.cone_edges(torque_origin=np.zeros(2))
    for point, normal, sides in zip(contacts.points, contacts.normals, edges, strict=True):
        corners = np.array([point, point + size * sides[0], point + size * sides[1]])
        axes.fill(*corners.T, color=SKY, alpha=0.5, zorder=2)
        axes.plot(*corners[[1, 0, 2]].T, color=BLUE, marker="", zorder=3)
        axes.annotate(
            "", point + size * normal, point, zorder=4,
            arrowprops={"arrowstyle": "-|>", "color": BLACK, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
    axes.plot(*contacts.points.T, "o", color=VERMILION, zorder=5)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return axes


def plot_wrench_polytope(
    wrenches: ArrayLike, *, epsilon: float = 0.0, direction: ArrayLike | None = None, ax: Any = None
) -> Any:
    """Draw a planar wrench space as a solid body with the ball that touches its nearest facet.

    Parameters
    ----------
    wrenches : array-like, shape (n, m, 3) or (n, 3)
        Planar wrenches ``[fx, fy, tz / scale]`` [N].
    epsilon : float
        Radius of the ball [N].
    direction : array-like, shape (3,), optional
        The weakest direction; its facet is coloured and turned to the reader.
    ax : matplotlib 3-D axes, optional
        Where to draw.

    Returns
    -------
    matplotlib axes
    """
    rows = _rows(wrenches, 3)
    axes = axes_or_new(ax, projection="3d")
    hull = ConvexHull(rows)
    toward = None if direction is None else np.asarray(direction, dtype=float)
    near = np.zeros(len(hull.simplices), bool)
    if toward is not None:
        near = hull.equations[:, :3] @ toward > 1.0 - 1e-9
    _draw_facets(axes, rows, hull.simplices, near)
    _draw_ball(axes, nonnegative(epsilon, "epsilon", " N"), toward)
    _dress(axes, rows, toward)
    return axes


def plot_expansion_step(step: ExpansionStep, *, wrenches: ArrayLike, ax: Any = None) -> Any:
    """Draw one step of the growing polytope in the planar wrench space.

    The nearest facet is orange, the support point that is added next vermilion, the primitive
    wrenches small dots.
    """
    rows = _rows(wrenches, 3)
    axes = axes_or_new(ax, projection="3d")
    near = np.arange(len(step.simplices)) == step.nearest
    _draw_facets(axes, step.points, step.simplices, near)
    axes.scatter(*rows.T, color=BLACK, s=6, depthshade=False)
    if step.upper - step.lower > 1e-9:
        axes.scatter(*step.support[:, None], color=VERMILION, s=45, marker="D", depthshade=False)
    _draw_ball(axes, max(step.lower, 0.0), None)
    _dress(axes, rows, None)
    return axes


def plot_wrench_projection(
    wrenches: ArrayLike, first: int, second: int, *, epsilon: float = 0.0, ax: Any = None
) -> Any:
    """Draw the shadow of a spatial wrench space on two of its six axes, with the ball's shadow.

    Parameters
    ----------
    wrenches : array-like, shape (n, m, 6) or (n, 6)
        Wrenches ``[force, torque / scale]`` [N].
    first, second : int
        Which of the six coordinates to draw across and up.
    epsilon : float
        Radius of the ball [N]; it lies inside every shadow, and need not touch any.
    ax : matplotlib axes, optional
        Where to draw.

    Returns
    -------
    matplotlib axes
    """
    flat = _rows(wrenches, 6)[:, [first, second]]
    axes = axes_or_new(ax)
    corners = flat[ConvexHull(flat).vertices]
    axes.fill(*corners.T, color=SKY, alpha=0.5, edgecolor=BLUE, linewidth=1.5)
    axes.plot(*flat.T, ".", color=BLUE, markersize=3)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(epsilon * np.cos(turn), epsilon * np.sin(turn), color=VERMILION, marker="")
    axes.plot(0.0, 0.0, "+", color=BLACK)
    axes.set(xlabel=SPATIAL_LABELS[first], ylabel=SPATIAL_LABELS[second], aspect="equal")
    return axes


def plot_epsilon_over_friction(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    values: ArrayLike,
    torque_origin: ArrayLike,
    torque_scale: float,
    edges: Sequence[int | None] = (8, None),
    ax: Any = None,
) -> Any:
    """Draw epsilon of one grasp over the friction, a curve for each number of cone edges.

    Parameters
    ----------
    points, normals : array-like, shape (n, 3) or (n, 2)
        Contacts [m] and inward unit normals [1].
    values : array-like, shape (k,)
        Friction coefficients [1].
    torque_origin, torque_scale
        As in `medkit.quality.epsilon` [m].
    edges : sequence of int or None
        Numbers of edges; None, the round cone, is drawn dashed.
    ax : matplotlib axes, optional
        Where to draw.

    Returns
    -------
    matplotlib axes
    """
    axes, frictions = axes_or_new(ax), np.asarray(values, dtype=float)
    for count in edges:
        radii = [
            quality.epsilon(
                points, normals, friction=friction, torque_origin=torque_origin,
                torque_scale=torque_scale, edges=count,
            ).lower
            for friction in frictions
        ]  # fmt: skip
        style = ("--", "round cones") if count is None else ("-", f"{count} edges")
        axes.plot(frictions, radii, style[0], marker="", label=style[1])
    axes.set(xlabel="friction coefficient", ylabel="epsilon [N]", ylim=(0.0, None))
    axes.legend(loc="upper left")
    return axes


def _rows(wrenches: ArrayLike, dimension: int) -> Floats:
    rows = np.asarray(wrenches, dtype=float)
    if rows.ndim < 2 or rows.shape[-1] != dimension:
        raise InputError(
            f"Expected wrenches with {dimension} columns, but got shape {rows.shape};"
            " pass what Contacts.wrenches returns."
        )
    return rows.reshape(-1, dimension)


def _draw_facets(axes: Any, points: Floats, simplices: Any, near: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    for mask, colour, alpha in ((~near, SKY, 0.25), (near, ORANGE, 0.75)):
        if mask.any():
            axes.add_collection3d(
                Poly3DCollection(
                    points[simplices[mask]], facecolor=colour, edgecolor=BLUE, alpha=alpha,
                    linewidth=0.7,
                )
            )  # fmt: skip


def _draw_ball(axes: Any, radius: float, toward: Floats | None) -> None:
    if radius > 0.0:
        turn, tilt = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
        axes.plot_wireframe(
            radius * np.cos(turn) * np.sin(tilt), radius * np.sin(turn) * np.sin(tilt),
            radius * np.cos(tilt), color=VERMILION, linewidth=0.5,
        )  # fmt: skip
    axes.scatter(0.0, 0.0, 0.0, color=BLACK, marker="+", s=40, depthshade=False)
    if toward is not None and radius > 0.0:
        axes.scatter(*(radius * toward)[:, None], color=BLACK, s=25, depthshade=False)


def _dress(axes: Any, rows: Floats, toward: Floats | None) -> None:
    reach = 1.05 * np.abs(rows).max()
    axes.set(
        xlabel=PLANAR_LABELS[0], ylabel=PLANAR_LABELS[1], zlabel=PLANAR_LABELS[2],
        xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach),
    )  # fmt: skip
    axes.set_box_aspect((1, 1, 1), zoom=0.82)
    axes.locator_params(nbins=4)
    if toward is not None:
        azimuth = np.rad2deg(np.arctan2(toward[1], toward[0]))
        axes.view_init(elev=np.rad2deg(np.arcsin(np.clip(toward[2], -0.9, 0.9))), azim=azimuth + 35)
