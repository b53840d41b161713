"""The shapes of the planar chapters, each made by one function."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from medkit.arguments import numbers, whole
from medkit.errors import InputError
from medkit.geometry import expected, nonnegative, points_array, positive
from medkit.planar.outlines import Outline, SmoothOutline, outline_from_loops, smooth_outline


def rectangle(width: float = 0.08, height: float = 0.04) -> Outline:
    """Rectangle of `width` by `height` [m], centred at the origin.

    Examples
    --------
    >>> round(rectangle(0.08, 0.04).area, 9)
    0.0032
    """
    x, y = positive(width, "width", " m") / 2, positive(height, "height", " m") / 2
    return outline_from_loops([[-x, -y], [x, -y], [x, y], [-x, y]], name="rectangle")


def regular_polygon(corners: int, radius: float = 0.04) -> Outline:
    """Regular polygon with its `corners` at `radius` [m] from the origin, one of them on top."""
    size = positive(radius, "radius", " m")
    count = whole(corners, "corners", 3)
    turn = np.pi / 2 + 2 * np.pi * np.arange(count) / count
    return outline_from_loops(
        size * np.column_stack([np.cos(turn), np.sin(turn)]), name=f"regular {count}-gon"
    )


def triangle(angles_deg: tuple[float, float] = (30.0, 80.0), base: float = 0.08) -> Outline:
    """Triangle over a `base` [m] on the x axis with the two given angles at it [deg].

    Raises
    ------
    InputError
        If the angles leave nothing for the third.
    """
    angles = numbers(angles_deg, "angles_deg")
    if len(angles) != 2:
        raise InputError(f"Expected two angles, but got {len(angles)}; pass (left, right) [deg].")
    first, second = (math.radians(positive(angle, "angle", " deg")) for angle in angles)
    if first + second >= math.pi:
        raise InputError(
            f"Expected two angles of less than 180 deg together, but got {angles_deg};"
            " make one smaller."
        )
    width = positive(base, "base", " m")
    reach = width * math.sin(second) / math.sin(first + second)
    top = (reach * math.cos(first), reach * math.sin(first))
    return outline_from_loops([(0.0, 0.0), (width, 0.0), top], name="triangle")


def l_shape(size: float = 0.08, thickness: float = 0.03) -> Outline:
    """L of equal legs: outer length `size` [m], leg width `thickness` [m]."""
    a, t = positive(size, "size", " m"), positive(thickness, "thickness", " m")
    corners = np.array([[0.0, 0.0], [a, 0.0], [a, t], [t, t], [t, a], [0.0, a]])
    return outline_from_loops(corners, name="L")


def t_shape(size: float = 0.08, thickness: float = 0.025) -> Outline:
    """T as wide and as high as `size` [m], bars of width `thickness` [m]."""
    a, t = positive(size, "size", " m") / 2, positive(thickness, "thickness", " m")
    low, arm = -a, a - t
    return outline_from_loops(
        [[-t / 2, low], [t / 2, low], [t / 2, arm], [a, arm], [a, a], [-a, a], [-a, arm],
         [-t / 2, arm]],
        name="T",
    )  # fmt: skip


def star(points: int = 5, radius: float = 0.045, inner_ratio: float = 0.5) -> Outline:
    """Star with its tips at `radius` [m] and its notches at `inner_ratio` of it."""
    tips = whole(points, "points", 2)
    turn = np.pi / 2 + np.pi * np.arange(2 * tips) / tips
    reach = positive(radius, "radius", " m") * np.where(
        np.arange(len(turn)) % 2 == 0, 1.0, positive(inner_ratio, "inner_ratio")
    )
    return outline_from_loops(
        reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]), name="star"
    )


def wedge(object_angle: float, *, radius: float = 0.02) -> tuple[Outline, np.ndarray]:
    """Wedge whose flanks hold a medial disk of a wanted object angle, and its touch points.

    Parameters
    ----------
    object_angle : float
        Object angle alpha of the disk [rad], in (0, pi]; the flanks meet at pi - alpha.
    radius : float
        Radius of the disk [m], centred at the origin.

    Returns
    -------
    outline : Outline
        Symmetric about the y axis, the narrow end on top.
    touch_points : ndarray, shape (2, 2)
        Left and right touch point of the disk [m].

    Raises
    ------
    InputError
        If the angle is out of range.

    Notes
    -----
    Bottom and top lie 1.2 disk radii from the centre, so that the flanks alone hold the disk;
    where the flanks meet before that, the top lies halfway between disk and apex.
    """
    angle = positive(object_angle, "object_angle", " rad")
    if angle > math.pi:
        raise InputError(
            f"Expected an object angle of up to pi rad, but got {angle:g} rad; pass radians."
        )
    size = positive(radius, "radius", " m")
    half = angle / 2
    touch = size * np.array([math.sin(half), math.cos(half)])
    slide = np.array([-math.cos(half), math.sin(half)])  # up along the right flank
    apex = size / max(math.cos(half), 1e-12)
    top = touch + slide * (min(1.2 * size, (size + apex) / 2) - touch[1]) / slide[1]
    low = touch - slide * (1.2 * size + touch[1]) / slide[1]
    corners = np.array([[-low[0], low[1]], low, top, [-top[0], top[1]]])
    outline = outline_from_loops(corners, name=f"wedge {math.degrees(math.pi - angle):.0f} deg")
    return outline, np.array([[-touch[0], touch[1]], touch])


def ellipse(width: float = 0.08, height: float = 0.05) -> SmoothOutline:
    """Ellipse of full `width` and `height` [m], centred at the origin."""
    a, b = positive(width, "width", " m") / 2, positive(height, "height", " m") / 2
    return smooth_outline([(a - b) / 2, 0.0, (a + b) / 2], name="ellipse")


def banana(length: float = 0.1, thickness: float = 0.03) -> SmoothOutline:
    """Bent ellipse: `length` [m] along the bend, `thickness` [m] in the middle."""
    half, thick = positive(length, "length", " m") / 2, positive(thickness, "thickness", " m") / 2
    turn = np.arange(64) * (2 * np.pi / 64)
    x, y = half * np.cos(turn), thick * np.sin(turn)
    bent = y + 0.9 * x**2 / half
    return smooth_outline(_series(x, bent - 0.3 * half, 4), name="banana")


def smooth_through(points: ArrayLike, harmonics: int = 8) -> SmoothOutline:
    """Smooth outline near points given in order around it, shape (n, 2) [m]."""
    array = points_array(points, 2)
    order = min(whole(harmonics, "harmonics"), (len(array) - 1) // 2)
    return smooth_outline(_series(array[:, 0], array[:, 1], order))


def _series(x: np.ndarray, y: np.ndarray, order: int) -> np.ndarray:
    spectrum = np.fft.fft(x + 1j * y) / len(x)
    return np.concatenate([spectrum[-order:], spectrum[: order + 1]])


def random_smooth(
    rng: np.random.Generator, *, radius: float = 0.035, roughness: float = 0.35
) -> SmoothOutline:
    """Random smooth blob: a circle of `radius` [m] with four random harmonics of its radius.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the shape.
    radius : float
        Mean radius [m].
    roughness : float
        Size of the harmonics relative to the radius, in [0, 0.5].

    Returns
    -------
    SmoothOutline
        Star-shaped, so it never crosses itself.

    Raises
    ------
    InputError
        If `roughness` is out of range.
    """
    remedy = "pass numpy.random.default_rng(seed)"
    rng = expected(rng, np.random.Generator, "a random generator", remedy)
    roughness = nonnegative(roughness, "roughness")
    if roughness > 0.5:
        raise InputError(
            f"Expected a roughness from 0 to 0.5, but got {roughness:g}; choose a smaller one."
        )
    turn = np.arange(128) * (2 * np.pi / 128)
    order = np.arange(2, 6)
    share = rng.uniform(0.5, 1.0, 4) / order
    size = roughness * share / share.sum()
    phase = rng.uniform(0.0, 2 * np.pi, 4)
    reach = 1.0 + (size * np.cos(np.multiply.outer(turn, order) + phase)).sum(axis=1)
    reach *= positive(radius, "radius", " m")
    series = _series(reach * np.cos(turn), reach * np.sin(turn), 8)
    return smooth_outline(series, name="random smooth")


def frame(size: float = 0.08, thickness: float = 0.02) -> Outline:
    """Square frame: outer side `size` [m], walls of `thickness` [m], a square hole."""
    a = positive(size, "size", " m") / 2
    b = a - positive(thickness, "thickness", " m")
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return outline_from_loops(a * square, [b * square], name="frame")
