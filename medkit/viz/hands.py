"""Pictures of hands: shaded convex bodies in three dimensions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from medkit.geometry import Floats, unit
from medkit.robots import Hand
from medkit.viz.style import BLUE, CYCLE, axes_or_new

#: Direction from which the light falls, in the frame of the axes.
LIGHT = unit([-0.5, -0.7, 1.0])
PALM_COLOUR = "#9AA7B1"


def plot_hand(
    hand: Hand,
    q: ArrayLike,
    *,
    ax: Any = None,
    T_world_hand: Floats | None = None,
    alpha: float = 1.0,
    frame: bool = True,
) -> Any:
    """Draw a hand at one configuration.

    Parameters
    ----------
    hand : Hand
        The hand.
    q : array-like, shape (nq,)
        Joint coordinates [rad or m].
    ax : Axes3D, optional
        Axes to draw into; new ones when left out.
    T_world_hand : ndarray, shape (4, 4), optional
        Pose of the hand base in the frame of the axes [m]; the identity when left out.
    alpha : float
        Opacity [1].
    frame : bool
        Whether to set the limits of the axes to the hand and label them.

    Returns
    -------
    Axes3D
        The axes. Each finger has a colour of its own, the palm is grey.
    """
    axes = axes_or_new(ax, projection="3d")
    pose = np.eye(4) if T_world_hand is None else T_world_hand
    colours = finger_colours(hand)
    corners = []
    for name, mesh in hand.link_meshes(q).items():
        mesh.apply_transform(pose)
        add_mesh(axes, mesh.triangles, mesh.face_normals, colours.get(name, PALM_COLOUR), alpha)
        corners.append(mesh.bounds)
    if frame:
        frame_axes(axes, np.vstack(corners))
        face_the_palm(axes, pose[:3, :3] @ hand.palm_direction, pose[:3, :3] @ hand.closing_axis)
    return axes


def face_the_palm(axes: Any, palm: Floats, closing: Floats) -> None:
    """Turn 3-D axes so that the palm is seen obliquely from the front."""
    level = palm * [1, 1, 0] if np.linalg.norm(palm[:2]) > 0.3 else np.cross(closing, palm)
    view = unit(level + 0.75 * closing * [1, 1, 0] + [0, 0, 0.35])
    azimuth = float(np.degrees(np.arctan2(view[1], view[0])))
    axes.view_init(float(np.degrees(np.arcsin(view[2]))), azimuth)


def finger_colours(hand: Hand) -> dict[str, str]:
    """Colour of every link that a finger moves, by link name."""
    return {name: CYCLE[k % len(CYCLE)] for name, k in hand.finger_of_link().items()}


def add_mesh(axes: Any, triangles: Any, normals: Any, colour: str, alpha: float = 1.0) -> None:
    """Add triangles (n, 3, 3) [m] with outward normals (n, 3), shaded flat, to 3-D axes."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    # half-Lambert: no face is black, neighbours still differ
    light = 0.45 + 0.55 * (0.5 + 0.5 * np.asarray(normals) @ LIGHT)
    faces = np.clip(np.outer(light, to_rgb(colour)), 0.0, 1.0)
    rgba = np.column_stack([faces, np.full(len(faces), alpha)])
    axes.add_collection3d(
        Poly3DCollection(triangles, facecolors=rgba, edgecolors=rgba, linewidths=0.2)
    )


def frame_axes(axes: Any, points: Floats) -> None:
    """Set equal limits around points (n, 3) [m], with labels."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.5 * float(np.ptp(points, axis=0).max()) * 1.02
    for letter, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{letter}lim")(centre - half, centre + half)
        getattr(axes, f"set_{letter}label")(f"{letter} [m]", labelpad=6)
        getattr(axes, f"{letter}axis").set_major_locator(_ticks())
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.tick_params(labelsize=7, pad=1)


def _ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def plot_hand_directions(hand: Hand, *, ax: Any, length: float = 0.08) -> Any:
    """Draw palm direction (solid) and closing axis (dashed) as arrows of `length` [m]."""
    start = hand.T_hand_power[:3, 3]
    for vector, style, label in (
        (hand.palm_direction, "-", "palm direction"),
        (hand.closing_axis, "--", "closing axis"),
    ):
        ax.quiver(*start, *(length * vector), color=BLUE, linestyle=style, label=label)
    # above every body: the dot lies on the palm, where a finger would hide it
    ax.plot(*start[:, None], "o", color=BLUE, mec="white", ms=9, zorder=1000, label="grasp point")
    return ax
