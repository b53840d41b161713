"""Lower envelopes of parabolas: the whole arithmetic of a polygon's exact medial axis.

A disk that touches the outline in a point grows until it meets something else. Seen from an edge,
with x the place on the edge, the radius at which it meets another edge is a linear function of x,
and at which it meets a corner a parabola. Seen from a reflex corner, with tau = tan(theta / 2) the
direction, the curvature 1 / r times (1 + tau^2) is a parabola in tau, whatever it meets. So the
cell of every site is a lower envelope of parabolas over an interval, with breakpoints in closed
form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from medkit.geometry import Floats
from medkit.planar.outlines import Outline

#: Below this, two abscissae or two relative values count as equal (the outline has size one).
TINY = 1e-10
#: Ties of value, slope and curvature: rounding, and what rounding of a root makes of a slope.
TIE = (1e-13, 1e-11, 1e-10)


@dataclass(frozen=True)
class Sites:
    """Edges and reflex corners of an outline of size one, as struct of arrays.

    Site i below `n` is edge i, site n + k is reflex corner k. `after` is the edge that follows
    each edge in its loop, `bends` the angle [rad] by which the outline turns on the way there,
    positive at convex corners.
    """

    starts: Floats
    tangents: Floats
    normals: Floats
    lengths: Floats
    corners: Floats
    cone_middles: Floats
    cone_widths: Floats
    after: np.ndarray
    bends: Floats

    @property
    def n(self) -> int:
        """Number of edges."""
        return len(self.starts)


def sites_from_outline(outline: Outline) -> Sites:
    """Collect edges and reflex corners; a convex corner never stops a growing disk."""
    corners, middles, widths = [], [], []
    after, bends = np.zeros(len(outline.starts), dtype=np.int64), np.zeros(len(outline.starts))
    first = 0
    for loop in outline.loops:
        index = first + np.arange(len(loop))
        incoming, outgoing = np.roll(index, 1), index
        t_in, t_out = outline.tangents[incoming], outline.tangents[outgoing]
        turn = np.arctan2(t_in[:, 0] * t_out[:, 1] - t_in[:, 1] * t_out[:, 0],
                          (t_in * t_out).sum(axis=1))  # fmt: skip
        reflex = turn < -1e-12
        normal = outline.inward_normals[outgoing][reflex]
        corners.append(loop[reflex])
        widths.append(-turn[reflex])
        middles.append(np.arctan2(normal[:, 1], normal[:, 0]) - turn[reflex] / 2)
        after[incoming], bends[incoming] = outgoing, turn
        first += len(loop)
    return Sites(
        outline.starts, outline.tangents, outline.inward_normals, outline.lengths,
        np.vstack(corners), np.concatenate(middles), np.concatenate(widths), after, bends,
    )  # fmt: skip


@dataclass(frozen=True)
class Parabolas:
    """Candidate functions q0 + q1 x + q2 x^2 on [low, high], each owned by a site."""

    q: Floats
    low: Floats
    high: Floats
    owner: np.ndarray


def seen_from_edge(sites: Sites, i: int) -> Parabolas:
    """Radius at which the disk tangent to edge i at x meets every other site."""
    a, t, n = sites.starts[i], sites.tangents[i], sites.normals[i]
    # one minus the cosine, without cancellation between nearly parallel edges
    slack = 0.5 * ((sites.normals - n) ** 2).sum(axis=1)
    facing = slack > 1e-12
    slack = np.where(facing, slack, 1.0)
    away = a - sites.starts
    q0 = (away * sites.normals).sum(axis=1) / slack
    q1 = sites.normals @ t / slack
    across = sites.tangents @ n
    s0 = (away * sites.tangents).sum(axis=1) + q0 * across
    s1 = sites.tangents @ t + q1 * across
    low, high = np.zeros(sites.n), np.full(sites.n, sites.lengths[i])
    for c0, c1 in ((s0, s1), (sites.lengths - s0, -s1), (q0, q1)):
        low, high = _where_positive(c0, c1, low, high)
    near = _neighbours(sites, i)
    facing[[i, sites.after[i], *np.flatnonzero(sites.after == i)]] = False
    lines = np.flatnonzero(facing & (high - low > TINY))
    x, y = (sites.corners - a) @ t, (sites.corners - a) @ n
    points = np.flatnonzero(y > TINY)
    half = 0.5 / y[points]
    bent = np.column_stack([(x[points] ** 2 + y[points] ** 2) * half, -2 * x[points] * half, half])
    flat = np.column_stack([q0[lines], q1[lines], np.zeros(len(lines))])
    return Parabolas(
        np.vstack([flat, bent, near.q]),
        np.concatenate([low[lines], np.zeros(len(points)), near.low]),
        np.concatenate([high[lines], np.full(len(points), sites.lengths[i]), near.high]),
        np.concatenate([lines, sites.n + points, near.owner]),
    )


def _neighbours(sites: Sites, i: int) -> Parabolas:
    """Radius at which the disk tangent to edge i meets the edges before and after it.

    Between neighbours nearly in line the general formula divides one rounding error by another;
    measured from the shared corner the radius is exact whatever the bend.
    """
    length, rows = float(sites.lengths[i]), []
    before, after = int(np.flatnonzero(sites.after == i)[0]), int(sites.after[i])
    if sites.bends[before] > TINY:
        slope = 1.0 / np.tan(sites.bends[before] / 2)
        rows.append((0.0, slope, 0.0, min(length, float(sites.lengths[before])), before))
    if sites.bends[i] > TINY:
        slope = 1.0 / np.tan(sites.bends[i] / 2)
        rows.append(
            (length * slope, -slope, max(0.0, length - float(sites.lengths[after])), length, after)
        )
    table = np.array(rows, dtype=float).reshape(-1, 5)
    q = np.column_stack([table[:, :2], np.zeros(len(table))])
    return Parabolas(q, table[:, 2], table[:, 3], table[:, 4].astype(np.int64))


def _where_positive(c0: Floats, c1: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Shrink [low, high] to where c0 + c1 x >= 0, up to rounding."""
    flat = np.abs(c1) < 1e-14
    root = -c0 / np.where(flat, 1.0, c1)
    low = np.where(~flat & (c1 > 0), np.maximum(low, root), low)
    high = np.where(~flat & (c1 < 0), np.minimum(high, root), high)
    return low, np.where(flat & (c0 < -TINY), low - 1.0, high)


def seen_from_corner(sites: Sites, k: int) -> Parabolas:
    """Minus the curvature (1 + tau^2) / r of the disk through corner k that meets each site."""
    v, middle = sites.corners[k], sites.cone_middles[k]
    limit = float(np.tan(sites.cone_widths[k] / 4))
    ahead = np.array([np.cos(middle), np.sin(middle)])
    side = np.array([-ahead[1], ahead[0]])
    away = v - sites.starts
    depth = (away * sites.normals).sum(axis=1)
    low, high, lines = _foot_intervals(sites, away, depth, middle, limit)
    a, b = 1.0 / depth[lines], -sites.normals[lines] / depth[lines][:, None]
    gap = sites.corners - v
    square = (gap**2).sum(axis=1)
    points = np.flatnonzero(square > TINY**2)
    a = np.concatenate([a, np.zeros(len(points))])
    b = np.vstack([b, 2.0 * gap[points] / square[points][:, None]])
    toward, across = b @ ahead, b @ side
    return Parabolas(
        -np.column_stack([a + toward, 2.0 * across, a - toward]),
        np.concatenate([low, np.full(len(points), -limit)]),
        np.concatenate([high, np.full(len(points), limit)]),
        np.concatenate([lines, sites.n + points]),
    )


def _foot_intervals(
    sites: Sites, away: Floats, depth: Floats, middle: float, limit: float
) -> tuple[Floats, Floats, np.ndarray]:
    """Directions tau for which the disk meets an edge between its two ends."""
    ok = np.flatnonzero(depth > TINY)
    place = (away[ok] * sites.tangents[ok]).sum(axis=1)
    facing = np.arctan2(sites.normals[ok, 1], sites.normals[ok, 0]) - middle
    first = np.pi - 2 * np.arctan((sites.lengths[ok] - place) / depth[ok])
    last = np.pi + 2 * np.arctan(place / depth[ok])
    edge = 2 * np.arctan(limit)
    low, high, lines = [], [], []
    for turn in (-2 * np.pi, 0.0, 2 * np.pi, 4 * np.pi):
        a = np.maximum(facing - last + turn, -edge)
        b = np.minimum(facing - first + turn, edge)
        keep = b - a > TINY
        low.append(np.tan(a[keep] / 2))
        high.append(np.tan(b[keep] / 2))
        lines.append(ok[keep])
    return np.concatenate(low), np.concatenate(high), np.concatenate(lines)


def lower_envelope(
    functions: Parabolas, start: float, end: float
) -> list[tuple[float, float, int]]:
    """Sweep over [start, end] and return the pieces (from, to, owner) of the lowest function.

    Parameters
    ----------
    functions : Parabolas
        Candidates; at every abscissa at least one must be defined.
    start, end : float
        The interval.

    Returns
    -------
    list of (float, float, int)
        Pieces in order, neighbours with different owners.

    Raises
    ------
    RuntimeError
        If no candidate is defined somewhere; the message carries the abscissa.
    """
    pieces: list[tuple[float, float, int]] = []
    x = start
    while x < end - TINY:
        best = _lowest_just_after(functions, x)
        stop = _next_event(functions, best, x, min(end, float(functions.high[best])))
        best, stop = _confirmed(functions, best, x, stop, end)
        owner = int(functions.owner[best])
        if pieces and pieces[-1][2] == owner:
            pieces[-1] = (pieces[-1][0], stop, owner)
        else:
            pieces.append((x, stop, owner))
        x = stop
    return pieces


def _lowest_just_after(functions: Parabolas, x: float) -> int:
    valid = np.flatnonzero((functions.low <= x + TINY) & (functions.high > x + TINY))
    if not len(valid):
        raise RuntimeError(f"medial axis: no neighbour found at abscissa {x!r} of a site")
    for order in range(3):
        c, b, a = functions.q[valid].T
        value = (c + x * (b + x * a), b + 2 * x * a, a)[order]
        lowest = float(value.min())
        valid = valid[value <= lowest + TIE[order] * max(1.0, abs(lowest))]
    return int(valid[0])


def _confirmed(
    functions: Parabolas, best: int, x: float, stop: float, end: float
) -> tuple[int, float]:
    """Look again halfway: near a tie, rounding may have picked the wrong one of two functions."""
    for _ in range(len(functions.owner)):
        middle = 0.5 * (x + stop)
        value = functions.q @ np.array([1.0, middle, middle * middle])
        value[(functions.low > middle) | (functions.high < middle)] = np.inf
        rival = int(np.argmin(value))
        if value[best] - value[rival] <= TIE[0] * max(1.0, abs(float(value[rival]))):
            break
        if functions.low[rival] > x + TINY:
            return best, float(functions.low[rival])
        best = rival
        stop = _next_event(functions, best, x, min(end, float(functions.high[best])))
    return best, stop


def _next_event(functions: Parabolas, best: int, x: float, stop: float) -> float:
    """First abscissa after x where another function dips below the current one."""
    c, b, a = (functions.q - functions.q[best]).T
    first, second = _roots(a, b, c)
    low, high = np.maximum(functions.low, x + TINY), np.minimum(functions.high, stop)
    events = [stop]
    for root in (first, second):
        hit = (root > low) & (root < high)
        hit[hit] &= b[hit] + 2 * a[hit] * root[hit] < 0.0
        if hit.any():
            events.append(float(root[hit].min()))
    # an edge takes over from its own corner without a crossing: both meet with the same slope
    entry = functions.low
    height = c + entry * (b + entry * a)
    enters = (entry > x + TINY) & (entry < stop) & (height < 1e3 * TINY)
    if enters.any():
        events.append(float(entry[enters].min()))
    return min(events)


def _roots(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Both real roots of a x^2 + b x + c, nan where there are none, without cancellation."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        q = -0.5 * (b + np.where(b >= 0, root, -root))
        far, near = np.where(a == 0.0, np.nan, q / np.where(a == 0.0, 1.0, a)), c / q
    return np.nan_to_num(far, nan=np.inf), np.nan_to_num(near, nan=np.inf)
