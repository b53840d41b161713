"""Pictures of grasps: the hand on its object, every sphere's fate, where the candidates go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, unit
from medkit.grasping import CandidateGrasps, ClosedGrasp, Grasp, MedialAxis, SphereFate
from medkit.robots import Hand
from medkit.viz.hands import LIGHT, PALM_COLOUR, finger_colours
from medkit.viz.style import (
    BLACK,
    BLUE,
    GREEN,
    OBJECT_GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    axes_or_new,
)

if TYPE_CHECKING:
    import trimesh

#: Colour, marker and words of each fate. Fates that bear candidates have filled markers.
FATES: dict[SphereFate, tuple[str, str, str]] = {
    SphereFate.AXIS: (ORANGE, "o", "axis: hand from around"),
    SphereFate.RIM: (GREEN, "^", "rim: hand from outside"),
    SphereFate.BALL: (BLUE, "*", "ball: hand from anywhere"),
    SphereFate.DOMINANT_SPHERE: (BLUE, "D", "one sphere: hand across faces"),
    SphereFate.INSIDE_SHEET: (SKY, ".", "inside a sheet: out of reach"),
    SphereFate.TOO_LARGE_FOR_HAND: (PURPLE, "s", "too large for the hand"),
    SphereFate.TOO_SMALL_FOR_HAND: (PURPLE, "v", "too small for the hand"),
    SphereFate.TOO_FEW_NEIGHBORS: (VERMILION, "x", "too few neighbours"),
    SphereFate.OBJECT_ANGLE_TOO_SMALL: (OBJECT_GREY, ".", "object angle too small"),
    SphereFate.BELOW_RADIUS_RATIO: (OBJECT_GREY, "+", "surface detail"),
    SphereFate.REPRESENTED: (SKY, "+", "stands behind another"),
}
#: Colour of the approach arrows by where a candidate is from; baselines have none.
SOURCES = {
    SphereFate.AXIS: ORANGE,
    SphereFate.RIM: GREEN,
    SphereFate.BALL: BLUE,
    SphereFate.DOMINANT_SPHERE: BLUE,
}
#: Longest edge of a drawn triangle [m]: small ones are sorted rightly by depth.
EDGE = 0.012
CM = 100.0


def plot_grasp(
    grasp: Grasp | ClosedGrasp | ArrayLike,
    mesh: trimesh.Trimesh,
    hand: Hand,
    *,
    q: ArrayLike | None = None,
    ax: Any = None,
    arrow: float = 0.025,
    around: float | None = 0.05,
    view: ArrayLike | None = None,
) -> Any:
    """Draw a hand on an object with its contacts.

    Parameters
    ----------
    grasp : Grasp, ClosedGrasp or array-like, shape (4, 4)
        A grasp, or the pose ``T_object_hand`` of the hand alone [m].
    mesh : trimesh.Trimesh
        The object, drawn in light grey [m].
    hand : Hand
        The hand: each finger in a colour of its own, the palm grey.
    q : array-like, shape (nq,), optional
        Joint coordinates, needed with a pose alone; the power preshape when left out.
    ax : Axes3D, optional
        Axes to draw into; new ones when left out.
    arrow : float
        Length of the arrows that end at the contacts and point into the object [m].
    around : float or None
        How much to show around the hand [m]; None shows the whole object.
    view : array-like, shape (3,), optional
        Direction from the object to the eye; obliquely from beside the hand when left out.

    Returns
    -------
    Axes3D
        In centimetres. Contacts are drawn over everything, so none is hidden.

    Raises
    ------
    InputError
        If `grasp` is neither a grasp nor a pose.
    """
    axes = axes_or_new(ax, projection="3d")
    axes.computed_zorder = False
    pose, joints, points, normals = _parts(grasp, hand, q)
    seen = unit(_view(pose[:3, :3], hand) if view is None else np.asarray(view, dtype=float))
    azimuth = np.degrees(np.arctan2(seen[1], seen[0]))
    axes.view_init(float(np.degrees(np.arcsin(seen[2]))), float(azimuth))
    triangles, colours = _hand_triangles(hand, joints, pose)
    corners = triangles.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    body = _small(mesh.vertices, mesh.faces, max(EDGE, 0.03 * float(mesh.extents.max())))
    if around is None:
        low, high = np.minimum(low, mesh.bounds[0]), np.maximum(high, mesh.bounds[1])
    else:
        middle, half = 0.5 * (low + high), 0.5 * float((high - low).max()) + around
        body = body[(np.abs(body.mean(axis=1) - middle) < half).all(axis=1)]
    _add_triangles(
        axes,
        np.concatenate([body, triangles]),
        np.concatenate([_shaded(body, "#D6D6D6"), colours]),
    )
    if len(points):
        start = CM * (points - arrow * normals)
        axes.quiver(*start.T, *(CM * arrow * normals).T, color=BLACK, lw=1.1, zorder=5,
                    arrow_length_ratio=0.35)  # fmt: skip
        axes.plot(*(CM * points).T, ls="", marker="o", ms=4, color=VERMILION,
                  mec="white", mew=0.5, zorder=6)  # fmt: skip
    return _frame(axes, low, high)


def plot_fates(
    axis: MedialAxis,
    candidates: CandidateGrasps,
    mesh: trimesh.Trimesh | None = None,
    *,
    ax: Any = None,
    legend: bool = True,
    counts: bool = False,
) -> Any:
    """Draw every medial sphere's centre by its fate (P13 figure 4.10).

    Parameters
    ----------
    axis : MedialAxis
        The spheres.
    candidates : CandidateGrasps
        From `candidates_from_axis` of the same spheres.
    mesh : trimesh.Trimesh, optional
        The object, drawn as a pale veil [m].
    ax : Axes3D, optional
        Axes to draw into; new ones when left out.
    legend : bool
        Whether to name the fates, those that occur.
    counts : bool
        Whether the names carry the number of spheres.

    Returns
    -------
    Axes3D
        In centimetres.

    Raises
    ------
    InputError
        If spheres and fates differ in number.
    """
    if len(candidates.fate) != len(axis.centers):
        raise InputError(
            f"Expected the candidates of these {len(axis.centers)} spheres, but they know"
            f" {len(candidates.fate)}; pass both from the same object."
        )
    axes = axes_or_new(ax, projection="3d")
    drawn = _veil(axes, mesh, axis.centers)
    for fate, (colour, marker, words) in FATES.items():
        own = candidates.fate == fate
        if own.any():
            bears = fate in SOURCES
            size = 90.0 if marker in "*D" else 9.0 if bears else 5.0
            label = f"{words} ({own.sum()})" if counts else words
            axes.scatter(*(CM * axis.centers[own]).T, c=colour, marker=marker, s=size,
                         linewidths=0.0 if marker not in "x+" else 0.7, label=label,
                         depthshade=False)  # fmt: skip
    if legend:
        axes.legend(loc="upper left", fontsize=7, markerscale=1.5, handletextpad=0.2)
    return _frame(axes, drawn.min(axis=0), drawn.max(axis=0))


def legend_of_fates(figure: Any, *, columns: int = 4) -> Any:
    """Name once, below a row of pictures by `plot_fates`, every fate that occurs in one of them.

    Parameters
    ----------
    figure : matplotlib Figure
        Its axes were drawn with ``legend=False``.
    columns : int
        Entries side by side.

    Returns
    -------
    matplotlib.legend.Legend
        The legend.
    """
    from matplotlib.lines import Line2D

    seen = {text for axes in figure.axes for text in axes.get_legend_handles_labels()[1]}
    marks = [
        Line2D(
            [],
            [],
            ls="",
            color=colour,
            marker=marker,
            ms=7.0 if marker != "." else 9.0,
            label=words,
        )
        for colour, marker, words in FATES.values()
        if words in seen
    ]
    return figure.legend(handles=marks, loc="outside lower center", ncols=columns, fontsize=8)


def plot_candidates(
    candidates: CandidateGrasps,
    mesh: trimesh.Trimesh | None = None,
    *,
    most: int = 60,
    length: float = 0.05,
    ax: Any = None,
) -> Any:
    """Draw candidates as approach arrows that end at their grasp points (P13 figure 4.10).

    Parameters
    ----------
    candidates : CandidateGrasps
        The candidates.
    mesh : trimesh.Trimesh, optional
        The object, drawn as a pale veil [m].
    most : int
        Spheres whose candidates are drawn, evenly from all that bear some.
    length : float
        Length of the arrows [m].
    ax : Axes3D, optional
        Axes to draw into; new ones when left out.

    Returns
    -------
    Axes3D
        In centimetres. Orange arrows are from axes, green from rims, blue from single spheres;
        a short purple bar at the tail shows the closing axis.
    """
    axes = axes_or_new(ax, projection="3d")
    spheres = np.unique(candidates.sphere)
    if len(spheres) > most:
        spheres = spheres[np.linspace(0, len(spheres) - 1, most).round().astype(int)]
        candidates = candidates.select(np.isin(candidates.sphere, spheres))
    tails = candidates.grasp_point - length * candidates.approach
    bar = 0.16 * length * candidates.closing_axis
    for kind in np.unique(candidates.kind):
        known = candidates.kind == kind
        colour = SOURCES.get(kind, BLACK)
        arrows = CM * length * candidates.approach[known]
        axes.quiver(*(CM * tails[known]).T, *arrows.T, color=colour, lw=0.9,
                    arrow_length_ratio=0.2)  # fmt: skip
    axes.quiver(*(CM * (tails - bar)).T, *(2 * CM * bar).T, color=PURPLE, lw=1.6,
                arrow_length_ratio=0.0)  # fmt: skip
    points = np.vstack([tails, candidates.grasp_point])
    drawn = _veil(axes, mesh, points)
    return _frame(axes, drawn.min(axis=0), drawn.max(axis=0))


def _parts(grasp: Any, hand: Hand, q: ArrayLike | None) -> tuple[Floats, Floats, Floats, Floats]:
    """Pose, joints, contact points and normals of whatever was given."""
    if isinstance(grasp, Grasp):
        return grasp.pose, grasp.q, grasp.points, grasp.normals
    if isinstance(grasp, ClosedGrasp):
        return grasp.pose, grasp.q, grasp.contacts.points, grasp.contacts.normals
    pose = np.asarray(grasp, dtype=float)
    if pose.shape != (4, 4):
        raise InputError(
            f"Expected a grasp or a pose of shape (4, 4), but got shape {pose.shape}; pass one"
            " grasp of `GraspSet.grasps`."
        )
    joints = np.asarray(hand.preshapes["power"] if q is None else q, dtype=float)
    return pose, joints, np.zeros((0, 3)), np.zeros((0, 3))


def _view(rotation: Floats, hand: Hand) -> Floats:
    """From beside the hand: fingers and thumb in profile, the object not in the way."""
    palm, closing = rotation @ hand.palm_direction, rotation @ hand.closing_axis
    side = np.cross(palm, closing)
    # of the two sides and the two ends, those that are seen from above
    side = side if side[2] >= 0.0 else -side
    closing = closing if closing[2] >= 0.0 else -closing
    return np.asarray(0.45 * side + 0.75 * closing - 0.5 * palm)


def _hand_triangles(hand: Hand, q: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """Small triangles (n, 3, 3) of all links and their colours (n, 3)."""
    colours = finger_colours(hand)
    pieces, shades = [], []
    for name, link in hand.link_meshes(q).items():
        link.apply_transform(pose)
        pieces.append(_small(link.vertices, link.faces, EDGE))
        shades.append(_shaded(pieces[-1], colours.get(name, PALM_COLOUR)))
    return np.concatenate(pieces), np.concatenate(shades)


def _small(vertices: Floats, faces: ArrayLike, edge: float) -> Floats:
    """Triangles (n, 3, 3) with no edge beyond `edge` [m]: large ones hide what is before them."""
    from trimesh.remesh import subdivide_to_size

    points, pieces = subdivide_to_size(vertices, faces, edge, max_iter=20)
    return np.asarray(points[pieces], dtype=float)


def _shaded(triangles: Floats, colour: str) -> Floats:
    """Half-Lambert shades (n, 3) of one colour."""
    from matplotlib.colors import to_rgb

    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.maximum(np.linalg.norm(across, axis=1), 1e-300)
    light = 0.45 + 0.55 * (0.5 + 0.5 * (across @ LIGHT) / size)
    return np.clip(np.outer(light, to_rgb(colour)), 0.0, 1.0)


def _add_triangles(axes: Any, triangles: Floats, colours: Floats) -> None:
    """One collection for everything: only so do hand and object hide each other rightly."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(
        Poly3DCollection(CM * triangles, facecolors=colours, edgecolors=colours, linewidths=0.2)
    )


def _veil(axes: Any, mesh: trimesh.Trimesh | None, points: Floats) -> Floats:
    """Draw a mesh palely behind points (n, 3) [m]; all that has to be in view."""
    if mesh is None:
        return points
    vertices = np.asarray(mesh.vertices)
    axes.plot_trisurf(*(CM * vertices.T), triangles=mesh.faces, color=OBJECT_GREY, alpha=0.12,
                      linewidth=0)  # fmt: skip
    return np.vstack([points, vertices])


def _frame(axes: Any, low: Floats, high: Floats) -> Any:
    """Equal scales in centimetres around a box [m]."""
    from matplotlib.ticker import MaxNLocator

    middle, half = 0.5 * CM * (low + high), 0.51 * CM * max(float((high - low).max()), 0.01)
    for letter, m in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{letter}lim")(m - half, m + half)
        getattr(axes, f"set_{letter}label")(f"{letter} [cm]", labelpad=-4, fontsize=8)
        getattr(axes, f"{letter}axis").set_major_locator(MaxNLocator(3))
    # room for the labels, and no white ground that would cover a neighbour's
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.patch.set_visible(False)
    axes.tick_params(labelsize=7, pad=-2)
    return axes
