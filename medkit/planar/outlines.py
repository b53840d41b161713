"""Outlines of planar objects: polygons with holes, and smooth closed curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.arguments import whole
from medkit.errors import InputError
from medkit.geometry import Floats, expected, points_array


@dataclass(frozen=True)
class Outline:
    """A planar region bounded by straight edges; the interior lies to the left of every edge.

    Make one with :func:`outline_from_loops` or a shape function: those check the input.

    Attributes
    ----------
    loops : tuple of ndarray, shape (m, 2)
        Vertices [m] of the outer loop (counter-clockwise), then of each hole (clockwise).
    name : str
        What to write on a picture.
    """

    loops: tuple[Floats, ...]
    name: str = "outline"

    @cached_property
    def starts(self) -> Floats:
        """Start points of all edges, shape (n, 2) [m]."""
        return np.vstack(self.loops)

    @cached_property
    def ends(self) -> Floats:
        """End points of all edges, shape (n, 2) [m]."""
        return np.vstack([np.roll(loop, -1, axis=0) for loop in self.loops])

    @cached_property
    def lengths(self) -> Floats:
        """Lengths of all edges, shape (n,) [m]."""
        return np.asarray(np.linalg.norm(self.ends - self.starts, axis=1))

    @cached_property
    def tangents(self) -> Floats:
        """Unit directions of all edges, shape (n, 2) [1]."""
        return np.asarray((self.ends - self.starts) / self.lengths[:, None])

    @cached_property
    def inward_normals(self) -> Floats:
        """Unit normals of all edges, shape (n, 2) [1], pointing into the object."""
        return np.column_stack([-self.tangents[:, 1], self.tangents[:, 0]])

    @cached_property
    def area(self) -> float:
        """Area without the holes [m^2]."""
        return float(0.5 * _cross(self.starts, self.ends).sum())

    @cached_property
    def center_mass(self) -> Floats:
        """Centre of mass of the region at even density, shape (2,) [m]."""
        weight = _cross(self.starts, self.ends)[:, None]
        return np.asarray(((self.starts + self.ends) * weight).sum(axis=0) / (6.0 * self.area))

    @cached_property
    def characteristic_length(self) -> float:
        """Largest distance of the outline from its centre of mass [m]."""
        return float(np.linalg.norm(self.starts - self.center_mass, axis=1).max())

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell which points lie inside, by counting crossings of a ray.

        Parameters
        ----------
        points : array-like, shape (n, 2)
            Points [m].

        Returns
        -------
        ndarray of bool, shape (n,)
            True inside the outer loop and outside every hole. Points on the outline may go
            either way.
        """
        query = points_array(points, 2)
        a, b = self.starts, self.ends
        x, y = query[:, :1], query[:, 1:]
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
        left = x < a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
        return np.asarray((spans & left).sum(axis=1) % 2 == 1)

    def distance(self, points: ArrayLike) -> Floats:
        """Distance of points of shape (n, 2) from the nearest edge, shape (n,) [m], unsigned."""
        query = points_array(points, 2)[:, None, :] - self.starts
        along = np.clip(np.einsum("nij,ij->ni", query, self.tangents), 0.0, self.lengths)
        rest = query - along[..., None] * self.tangents
        return np.asarray(np.linalg.norm(rest, axis=2).min(axis=1))

    def inward_normal_at(self, point: ArrayLike) -> Floats:
        """Unit normal into the object at the place of the outline nearest to a point, (2,)."""
        gap = np.asarray(point, dtype=float) - self.starts
        along = np.clip((gap * self.tangents).sum(axis=1), 0.0, self.lengths)
        away = np.linalg.norm(gap - along[:, None] * self.tangents, axis=1)
        return np.asarray(self.inward_normals[int(np.argmin(away))])


def checked_outline(outline: Any) -> Outline:
    """Return an outline as it is, or raise `InputError` that says how to make one."""
    remedy = "pass outline_from_loops(points) or a shape such as medkit.planar.rectangle()"
    return expected(outline, Outline, "an outline", remedy)


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def outline_from_loops(
    outer: ArrayLike, holes: Sequence[ArrayLike] = (), *, name: str = "outline"
) -> Outline:
    """Check loops of vertices and make an outline of them.

    Parameters
    ----------
    outer : array-like, shape (m, 2)
        Vertices of the outer loop [m], in either direction, without repeating the first.
    holes : sequence of array-like, shape (k, 2)
        Vertices of each hole [m].
    name : str
        What to write on a picture.

    Returns
    -------
    Outline
        With the outer loop counter-clockwise and the holes clockwise. Vertices in the middle of
        a straight line are dropped.

    Raises
    ------
    InputError
        If a loop has fewer than three corners, a number that is not finite, no area, if loops
        cross themselves or each other, or if a hole is not inside.

    Examples
    --------
    >>> outline_from_loops([[0, 0], [2, 0], [2, 1], [0, 1]]).area
    2.0
    """
    remedy = "pass a list of loops of points, or leave it out"
    expected(holes, (list, tuple, np.ndarray), "a list of holes", remedy)
    loops = [_checked_loop(outer, "the outer loop", 1.0)]
    loops += [_checked_loop(hole, f"hole {i}", -1.0) for i, hole in enumerate(holes)]
    result = Outline(tuple(loops), name)
    _refuse_crossings(result)
    body = Outline((loops[0],))
    for index, hole in enumerate(loops[1:]):
        others = [Outline((-other[::-1],)) for i, other in enumerate(loops[1:]) if i != index]
        if not body.contains(hole).all() or any(o.contains(-hole).any() for o in others):
            raise InputError(
                f"Expected every hole inside the outer loop and outside the other holes, but hole"
                f" {index} is not; move it or leave it out."
            )
    return result


def _checked_loop(points: ArrayLike, name: str, sense: float) -> Floats:
    loop = points_array(points, 2, name)
    size = np.ptp(loop, axis=0).max() if len(loop) else 0.0
    if len(loop) > 1 and np.linalg.norm(loop[0] - loop[-1]) <= 1e-12 * size:
        loop = loop[:-1]
    steps = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    loop = loop[steps > 1e-12 * size]
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    bend = _cross(before, after)
    reach = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    forward = (before * after).sum(axis=1) > 0.0
    corners = loop[(np.abs(bend) > 1e-10 * reach) | ~forward]
    if len(corners) < 3:
        raise InputError(
            f"Expected at least 3 corners in {name}, but got {len(corners)}"
            " (repeated and straight-through vertices do not count); add vertices."
        )
    area = 0.5 * _cross(corners, np.roll(corners, -1, axis=0)).sum()
    if abs(area) <= 1e-12 * size**2:
        raise InputError(
            f"Expected {name} to enclose an area, but it encloses {abs(area):.3g} m^2;"
            " its vertices must not lie on one line."
        )
    return corners if area * sense > 0.0 else corners[::-1].copy()


def _refuse_crossings(outline: Outline) -> None:
    a, b = outline.starts, outline.ends
    first, second = np.triu_indices(len(a), k=1)
    tolerance = 1e-12 * float(np.ptp(a, axis=0).max()) ** 2
    side_1, side_2 = _sides(a[first], b[first], a[second], b[second])
    side_3, side_4 = _sides(a[second], b[second], a[first], b[first])
    crossing = (side_1 * side_2 < 0.0) & (side_3 * side_4 < 0.0)
    apart = ~(np.all(b[first] == a[second], axis=1) | np.all(b[second] == a[first], axis=1))
    low_1, high_1 = np.minimum(a, b)[first], np.maximum(a, b)[first]
    low_2, high_2 = np.minimum(a, b)[second], np.maximum(a, b)[second]
    boxes = np.all((low_1 <= high_2) & (low_2 <= high_1), axis=1)
    touching = (side_1 * side_2 <= tolerance**2) & (side_3 * side_4 <= tolerance**2)
    bad = np.flatnonzero(apart & boxes & (crossing | touching))
    if len(bad):
        raise InputError(
            f"Expected an outline that does not cross or touch itself, but edges"
            f" {int(first[bad[0]])} and {int(second[bad[0]])} meet; reorder or move the vertices."
        )


def _sides(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats]:
    return _cross(b - a, c - a), _cross(b - a, d - a)


@dataclass(frozen=True)
class SmoothOutline(Outline):
    """A region bounded by one smooth closed curve, z(t) = sum of c_k exp(i k t), t in [0, 2 pi).

    `loops` holds a fine polygon on the curve, for pictures and for the physics engine.

    Attributes
    ----------
    coefficients : ndarray of complex, shape (2 m + 1,)
        Fourier coefficients c_k [m] for k = -m .. m, with x the real and y the imaginary part.
    """

    coefficients: NDArray[np.complex128] = None  # type: ignore[assignment]

    def curve(self, parameter: ArrayLike, derivative: int = 0) -> Floats:
        """Points of the curve or its derivatives by the parameter.

        Parameters
        ----------
        parameter : array-like, shape (n,)
            Curve parameter t [rad].
        derivative : int
            0 for points, 1 for the velocity, 2 and 3 for the next ones.

        Returns
        -------
        ndarray, shape (n, 2)
            Coordinates [m], or their derivatives [m/rad^derivative].
        """
        order = (len(self.coefficients) - 1) // 2
        k = np.arange(-order, order + 1)
        wave = np.exp(1j * np.multiply.outer(np.asarray(parameter, dtype=float), k))
        value = wave @ (self.coefficients * (1j * k) ** derivative)
        return np.stack([value.real, value.imag], axis=-1)

    def inward_normal_at(self, point: ArrayLike) -> Floats:
        """Unit normal into the object at the place of the curve nearest to a point, (2,)."""
        target = np.asarray(point, dtype=float)
        turn = np.linspace(0.0, 2.0 * np.pi, 2048, endpoint=False)
        t = turn[int(np.argmin(np.linalg.norm(self.curve(turn) - target, axis=1)))]
        for _ in range(8):  # Newton on the foot of the perpendicular
            gap, velocity, bend = (self.curve(t, order) for order in (0, 1, 2))
            gap = gap - target
            t = t - (gap @ velocity) / (velocity @ velocity + gap @ bend)
        velocity = self.curve(t, 1)
        return np.array([-velocity[1], velocity[0]]) / np.linalg.norm(velocity)


def smooth_outline(
    coefficients: ArrayLike, *, samples: int = 192, name: str = "smooth curve"
) -> SmoothOutline:
    """Make a smooth outline of Fourier coefficients c_k, k = -m .. m.

    Parameters
    ----------
    coefficients : array-like of complex, shape (2 m + 1,)
        Fourier coefficients [m].
    samples : int
        Vertices of the polygon that stands for the curve in pictures and simulations.
    name : str
        What to write on a picture.

    Returns
    -------
    SmoothOutline
        Counter-clockwise.

    Raises
    ------
    InputError
        If the number of coefficients is even, one is not finite, or the curve crosses itself.
    """
    try:
        series = np.asarray(coefficients, dtype=complex)
    except (TypeError, ValueError):
        series = np.zeros(0, dtype=complex)
    if series.ndim != 1 or len(series) % 2 == 0 or len(series) < 3 or not np.isfinite(series).all():
        raise InputError(
            f"Expected an odd number of at least 3 finite Fourier coefficients, but got shape"
            f" {series.shape}; pass c_k for k = -m .. m."
        )
    k = np.arange(len(series)) - (len(series) - 1) // 2
    if (k * np.abs(series) ** 2).sum() < 0.0:
        series = series[::-1].copy()
    draft = SmoothOutline((np.zeros((0, 2)),), name, series)
    count = whole(samples, "samples", 3)
    turn = np.arange(count) * (2.0 * np.pi / count)
    polygon = outline_from_loops(draft.curve(turn), name=name)
    return SmoothOutline(polygon.loops, name, series)
