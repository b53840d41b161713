"""Pictures of medial axes: centres, touch points, and what local symmetry says about them."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from medkit.geometry import Floats
from medkit.grasping import LocalSymmetry, MedialAxis, MedialSphereGrid, SymmetryKind
from medkit.viz.style import BLACK, BLUE, GREEN, OBJECT_GREY, ORANGE, SKY, VERMILION, axes_or_new

PALE = "#d9dde2"  # what is left aside
KIND_COLORS = {
    SymmetryKind.AXIS: BLACK,
    SymmetryKind.RIM: VERMILION,
    SymmetryKind.INTERIOR: SKY,
    SymmetryKind.TOO_FEW: ORANGE,
    SymmetryKind.POINT: GREEN,
}
KIND_NAMES = {
    SymmetryKind.AXIS: "axis",
    SymmetryKind.RIM: "rim of a sheet",
    SymmetryKind.INTERIOR: "interior of a sheet",
    SymmetryKind.TOO_FEW: "too few neighbours",
    SymmetryKind.POINT: "point",
}


def plot_centers(
    axis: MedialAxis, values: Floats | None = None, *, label: str = "", ax: Any = None
) -> Any:
    """Draw the centres of medial spheres in 3-D, coloured by `values` (n,) with a `label`.

    Returns
    -------
    matplotlib.axes.Axes
        In centimetres.
    """
    ax = axes_or_new(ax, projection="3d")
    c = 100.0 * axis.centers
    dots = ax.scatter(*c.T, c=BLUE if values is None else values, s=3, linewidths=0)
    if values is not None:
        ax.figure.colorbar(dots, ax=ax, label=label, shrink=0.6, pad=0.12)
    return _finish(ax, c)


def plot_surface(mesh: trimesh.Trimesh, *, alpha: float = 0.15, ax: Any = None) -> Any:
    """Draw a mesh as a pale surface in 3-D, in centimetres."""
    ax = axes_or_new(ax, projection="3d")
    v = 100.0 * np.asarray(mesh.vertices)
    ax.plot_trisurf(*v.T, triangles=mesh.faces, color=OBJECT_GREY, alpha=alpha, linewidth=0)
    return _finish(ax, v)


def plot_kinds(axis: MedialAxis, symmetry: LocalSymmetry, *, ax: Any = None) -> Any:
    """Draw the centres coloured by the kind of their neighbourhood (P13 figures 4.8 and 4.9)."""
    ax = axes_or_new(ax, projection="3d")
    c = 100.0 * axis.centers
    for kind, color in KIND_COLORS.items():
        own = symmetry.kind == kind
        if np.any(own):
            ax.scatter(*c[own].T, c=color, s=4, linewidths=0, label=KIND_NAMES[kind])
    ax.legend(loc="upper left", markerscale=3, fontsize=8)
    return _finish(ax, c)


def plot_directions(
    axis: MedialAxis,
    symmetry: LocalSymmetry,
    which: NDArray[np.int64],
    *,
    plane: tuple[int, int] = (0, 1),
    length: float = 0.01,
    ax: Any = None,
) -> Any:
    """Draw e1, e2 and the centroid of some spheres, seen along a coordinate axis (figure 4.7).

    Parameters
    ----------
    axis, symmetry : MedialAxis, LocalSymmetry
        Spheres and their analysis.
    which : ndarray of int
        Spheres to annotate.
    plane : tuple of int
        Coordinates to draw.
    length : float
        Length of the arrows [m].
    ax : matplotlib.axes.Axes, optional
        Where to draw.
    """
    ax = axes_or_new(ax)
    first, second = plane
    ax.scatter(100 * axis.centers[:, first], 100 * axis.centers[:, second], c=OBJECT_GREY, s=4)
    for i in which:
        c = 100 * axis.centers[i]
        mean = 100 * symmetry.centroid[i]
        circle = _circle(c[first], c[second], 100 * symmetry.radius)
        ax.plot(*circle, color=ORANGE, lw=0.8, marker="")
        ax.plot([c[first], mean[first]], [c[second], mean[second]], color=BLUE, lw=1, marker="")
        ax.plot(mean[first], mean[second], color=BLUE, marker="o", ms=3)
        for e, color in ((symmetry.e1[i], VERMILION), (symmetry.e2[i], GREEN)):
            d = 100 * length * e
            ax.plot([c[first] - d[first], c[first] + d[first]],
                    [c[second] - d[second], c[second] + d[second]],
                    color=color, marker="")  # fmt: skip
    ax.set_xlabel(f"{'xyz'[first]} [cm]")
    ax.set_ylabel(f"{'xyz'[second]} [cm]")
    ax.set_aspect("equal")
    return ax


def plot_side(
    axis: MedialAxis,
    values: Floats | None = None,
    *,
    within: MedialAxis | None = None,
    plane: tuple[int, int] | None = None,
    limits: tuple[float, float] | None = None,
    ax: Any = None,
) -> Any:
    """Draw the centres seen along a coordinate axis.

    Parameters
    ----------
    axis : MedialAxis
        Spheres to draw.
    values : ndarray, shape (n,), optional
        One number a sphere, drawn as its colour.
    within : MedialAxis, optional
        Spheres to draw in pale grey behind; they choose the frame, so that pictures of one object
        with other filters can be held against each other.
    plane : tuple of int, optional
        Coordinates to draw; else the two in which the object is longest.
    limits : tuple of float, optional
        Values at the two ends of the colours; else the smallest and the largest.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        In centimetres.
    """
    ax = axes_or_new(ax)
    whole = axis if within is None else within
    first, second = plane or np.argsort(np.ptp(whole.centers, axis=0))[::-1][:2]
    frame = 100.0 * whole.centers[:, [first, second]]
    if within is not None:
        ax.scatter(*frame.T, color=PALE, s=1, linewidths=0)
    low, high = limits or (None, None)
    dots = 100.0 * axis.centers[:, [first, second]]
    ax.scatter(
        *dots.T, c=BLUE if values is None else values, s=3, linewidths=0, vmin=low, vmax=high
    )
    for name, at in (("x", 0), ("y", 1)):
        getattr(ax, f"set_{name}lim")(frame[:, at].min() - 1, frame[:, at].max() + 1)
    ax.set(xlabel=f"{'xyz'[first]} [cm]", ylabel=f"{'xyz'[second]} [cm]", aspect="equal")
    return ax


def plot_search(grid: MedialSphereGrid, place: ArrayLike, radius: float, *, ax: Any = None) -> Any:
    """Draw the cells that a search in a flat grid opens, what it tests there and what it finds.

    Parameters
    ----------
    grid : MedialSphereGrid
        With centres in a plane of constant z.
    place : array-like, shape (2,)
        The search is about the sphere nearest to this point [m].
    radius : float
        Search radius [m].
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        In millimetres; its title names the cell density and counts.
    """
    ax = axes_or_new(ax)
    xy = grid.axis.centers[:, :2]
    own = xy[np.argmin(np.linalg.norm(xy - np.asarray(place), axis=1))]
    _, _, low, width, _ = grid.cells()
    cell = np.floor((xy - low[:2]) / width[:2])
    first, last = (np.floor((own + sign * radius - low[:2]) / width[:2]) for sign in (-1, 1))
    tested = np.all((cell >= first) & (cell <= last), axis=1)
    found = np.linalg.norm(xy - own, axis=1) <= radius
    for chosen, color in ((tested, OBJECT_GREY), (found, BLUE)):
        ax.scatter(*(1000 * xy[chosen].T), color=color, s=3, linewidths=0)
    for k, line in enumerate((ax.axvline, ax.axhline)):
        for border in low[k] + width[k] * np.arange(first[k], last[k] + 2):
            line(1000 * border, color=BLACK, lw=0.4, marker="")
    x, y = 1000.0 * own
    ax.plot(*_circle(x, y, 1000.0 * radius), color=ORANGE, marker="")
    ax.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    ax.grid(visible=False)
    count = f"{tested.sum()} tested, {found.sum()} found"
    ax.set_title(f"C = {grid.cell_density:g}: {count}", fontsize=9)
    return ax


def _circle(x: float, y: float, radius: float) -> tuple[Floats, Floats]:
    t = np.linspace(0.0, 2.0 * np.pi, 100)
    return x + radius * np.cos(t), y + radius * np.sin(t)


def _finish(ax: Any, points: Floats) -> Any:
    """Equal scales, and at most a few ticks, around points in centimetres."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * max(float((high - low).max()), 1.0)
    for name, m in zip("xyz", middle, strict=True):
        getattr(ax, f"set_{name}lim")(m - half, m + half)
        getattr(ax, f"set_{name}label")(f"{name} [cm]")
        getattr(ax, f"{name}axis").set_major_locator(_ticks())
    ax.set_box_aspect((1, 1, 1))
    return ax


def _ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(3)
