"""Where two fingers may go: all force-closure pairs of a polygon, and regions with room in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from medkit.geometry import Floats, expected
from medkit.planar.bounds import cone_half_angle
from medkit.planar.outlines import Outline, SmoothOutline, checked_outline


@dataclass(frozen=True)
class EdgePair:
    """All force-closure grasps with one finger on each of two edges.

    Attributes
    ----------
    first, second : int
        Numbers of the edges.
    inward : bool
        True for a squeeze, False when the fingers push apart.
    region : ndarray, shape (k, 2)
        Corners of the convex polygon of good places (s, t): distances along the two edges from
        their starts [m]. Its interior is force-closure, its border is not where it is a cone's.
    independent : ndarray, shape (2, 2)
        Rows [from, to] for s and for t [m]: any place on the first interval goes with any on
        the second.
    """

    first: int
    second: int
    inward: bool
    region: Floats
    independent: Floats

    @property
    def area(self) -> float:
        """Area of the region [m^2]."""
        x, y = self.region.T
        return float(0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))

    @property
    def room(self) -> float:
        """Length of the shorter independent interval [m]."""
        return float(np.diff(self.independent, axis=1).min())


def force_closure_pairs(outline: Outline, *, friction: float) -> tuple[EdgePair, ...]:
    """All pairs of edges that two fingers can use, with the places on them, exactly.

    Parameters
    ----------
    outline : Outline
        Polygon, with holes or without.
    friction : float
        Coefficient of friction [1].

    Returns
    -------
    tuple of EdgePair
        Sorted by room, the roomiest first.

    Raises
    ------
    InputError
        If `friction` is negative.

    Notes
    -----
    The chord must lie strictly inside both cones. Its directions are then those of the overlap
    of one cone with the other turned by 180 degrees, again a cone, and "the chord lies left of
    one edge of it and right of the other" is linear in the two places. So the good places are a
    rectangle cut by two lines. Independent regions after Nguyen 1988: the rectangle inside that
    polygon whose shorter side is longest, and among those the one of largest total length.

    Examples
    --------
    >>> from medkit.planar.shapes import rectangle
    >>> [(pair.first, pair.second) for pair in force_closure_pairs(rectangle(), friction=0.2)]
    [(1, 3), (0, 2)]
    """
    beta = cone_half_angle(friction)
    outline = checked_outline(outline)
    pairs = []
    for i in range(len(outline.starts)):
        for j in range(i + 1, len(outline.starts)):
            for sense in (1.0, -1.0):
                pair = _pair(outline, i, j, sense, beta)
                if pair is not None:
                    pairs.append(pair)
    return tuple(sorted(pairs, key=lambda pair: -pair.room))


def _pair(outline: Outline, i: int, j: int, sense: float, beta: float) -> EdgePair | None:
    n_i, n_j = sense * outline.inward_normals[i], sense * outline.inward_normals[j]
    turn = np.arctan2(n_i[0] * -n_j[1] + n_i[1] * n_j[0], -(n_i @ n_j))  # from n_i to -n_j
    if abs(turn) >= 2.0 * beta:
        return None
    facing = np.arctan2(n_i[1], n_i[0]) + turn / 2.0
    half = beta - abs(turn) / 2.0
    gap = outline.starts[j] - outline.starts[i]
    lines = []
    for angle, side in ((facing - half, 1.0), (facing + half, -1.0)):
        across = side * np.array([-np.sin(angle), np.cos(angle)])
        # across @ (gap + t tangent_j - s tangent_i) > 0
        lines.append([across @ outline.tangents[i], -across @ outline.tangents[j], across @ gap])
    size = np.array([outline.lengths[i], outline.lengths[j]])
    region = np.array([[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]])
    for a, b, c in lines:
        region = _clip(region, np.array([a, b]), c)
    if len(region) < 3 or _area(region) < 1e-9 * size[0] * size[1]:
        return None
    return EdgePair(i, j, sense > 0.0, region, _roomiest(np.array(lines), size))


def _clip(polygon: Floats, normal: Floats, offset: float) -> Floats:
    """Part of a convex polygon where normal @ x <= offset."""
    height = polygon @ normal - offset
    kept = []
    for k in range(len(polygon)):
        here, after = height[k - 1], height[k]
        if (here > 0.0) != (after > 0.0):
            share = here / (here - after)
            kept.append(polygon[k - 1] + share * (polygon[k] - polygon[k - 1]))
        if after <= 0.0:
            kept.append(polygon[k])
    points = np.array(kept).reshape(-1, 2)
    step = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    return np.asarray(points[step > 1e-12 * step.max(initial=0.0)])


def _area(polygon: Floats) -> float:
    x, y = polygon.T
    return float(0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))


def _roomiest(lines: Floats, size: Floats) -> Floats:
    """Rectangle within the region: longest shorter side, then longest sum of both sides."""
    a, b, c = lines.T
    # unknowns s0, s1, t0, t1, w and the distances of both middles from the middles of the edges;
    # the worst corner of the rectangle decides for each line
    none = 0.0 * a
    rows = [np.column_stack([np.minimum(a, 0.0), np.maximum(a, 0.0), np.minimum(b, 0.0),
                             np.maximum(b, 0.0), none, none, none])]  # fmt: skip
    rows.append(np.array([[1, -1, 0, 0, 1, 0, 0], [0, 0, 1, -1, 1, 0, 0]], dtype=float))
    rows.append(np.array([[0.5, 0.5, 0, 0, 0, -1, 0], [-0.5, -0.5, 0, 0, 0, -1, 0],
                          [0, 0, 0.5, 0.5, 0, 0, -1], [0, 0, -0.5, -0.5, 0, 0, -1]]))  # fmt: skip
    half = size / 2
    limits = np.concatenate([c, [0.0, 0.0], [half[0], -half[0], half[1], -half[1]]])
    bounds = [(0, size[0])] * 2 + [(0, size[1])] * 2 + [(0, None)] * 3
    # the shorter side counts most, then the sum, then being in the middle
    cost = [1e-3, -1e-3, 1e-3, -1e-3, -1.0, 1e-5, 1e-5]
    unit = float(size.max())
    scaled = [(low, None if high is None else high / unit) for low, high in bounds]
    found = linprog(cost, A_ub=np.vstack(rows), b_ub=limits / unit, bounds=scaled)
    return np.asarray(found.x[:4].reshape(2, 2) * unit)


def antipodal_pairs(outline: SmoothOutline) -> tuple[Floats, Floats]:
    """All pairs of places of a smooth curve that face each other exactly.

    Parameters
    ----------
    outline : SmoothOutline
        The curve.

    Returns
    -------
    parameters : ndarray, shape (k, 2)
        Curve parameters of both places [rad].
    points : ndarray, shape (k, 2, 2)
        The places [m]. The chord is normal to the curve at both, so that two fingers hold there
        with any friction above zero.

    Examples
    --------
    >>> from medkit.planar.shapes import ellipse
    >>> len(antipodal_pairs(ellipse())[0])
    2
    """
    remedy = "pass a smooth outline, such as ellipse(); polygons have force_closure_pairs"
    outline = expected(outline, SmoothOutline, "a smooth outline", remedy)
    count = 256
    grid: Floats = np.arange(count + 1, dtype=float) * (2 * np.pi / count)
    place, velocity = outline.curve(grid), outline.curve(grid, 1)
    chord = place[None] - place[:, None]
    first = np.einsum("ijk,ik->ij", chord, velocity)
    second = np.einsum("ijk,jk->ij", chord, velocity)
    seeds = np.argwhere(_changes(first) & _changes(second))
    seeds = seeds[seeds[:, 1] - seeds[:, 0] > 2]
    found = [_polish(outline, grid[seed] + np.pi / count) for seed in seeds]
    pairs = [pair for pair in found if pair is not None]
    kept: list[Floats] = []
    for pair in pairs:
        turned = [np.abs(np.exp(1j * pair) - np.exp(1j * known)).max()
                  for other in kept for known in (other, other[::-1])]  # fmt: skip
        if min(turned, default=1.0) > 1e-6:
            kept.append(pair)
    parameters = np.array(kept).reshape(-1, 2)
    return parameters, outline.curve(parameters)


def _changes(values: Floats) -> np.ndarray:
    corner = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
    return np.asarray((corner.min(axis=0) <= 0.0) & (corner.max(axis=0) >= 0.0))


def _polish(outline: SmoothOutline, start: Floats) -> Floats | None:
    """Newton on 'the chord is normal at both ends'; None when it leaves the neighbourhood."""
    pair = start.copy()
    for _ in range(30):
        place, velocity, bend = (outline.curve(pair, order) for order in (0, 1, 2))
        chord = place[1] - place[0]
        residual = velocity @ chord
        matrix = np.array([
            [bend[0] @ chord - velocity[0] @ velocity[0], velocity[0] @ velocity[1]],
            [-velocity[1] @ velocity[0], bend[1] @ chord + velocity[1] @ velocity[1]],
        ])  # fmt: skip
        try:
            pair = pair - np.linalg.solve(matrix, residual)
        except np.linalg.LinAlgError:
            return None
    near = np.abs(pair - start).max() < 0.1
    apart = np.linalg.norm(chord) > 1e-3 * outline.characteristic_length
    return np.sort(pair % (2 * np.pi)) if near and apart else None
