"""Medial axis of smooth closed curves: disks that touch the curve itself, not a polygon on it."""

from __future__ import annotations

import numpy as np

from medkit.geometry import Floats
from medkit.planar.disks import MedialAxis, angle_between, node_disk
from medkit.planar.outlines import SmoothOutline

TURN = 2.0 * np.pi
#: Touch points closer than this many grid steps belong to the tip of a branch.
TIP_STEPS = 6.0

#: Where a run of disks ends: (t,) at a tip, (t, s before, s after) where the partner jumps.
Place = tuple[float, ...]


class _Curve:
    """A curve with its grid of candidates for the second touch point."""

    def __init__(self, outline: SmoothOutline, count: int) -> None:
        self.outline = outline
        self.step = TURN / count
        self.grid: Floats = np.arange(count, dtype=float) * self.step
        self.points = outline.curve(self.grid)

    def frame(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Points, inward unit normals and curvature at parameters of shape (n,)."""
        velocity, bend = self.outline.curve(t, 1), self.outline.curve(t, 2)
        speed = np.linalg.norm(velocity, axis=1)
        normals = np.column_stack([-velocity[:, 1], velocity[:, 0]]) / speed[:, None]
        return self.outline.curve(t), normals, (bend * normals).sum(axis=1) / speed**2

    def partners(self, t: Floats) -> Floats:
        """Parameter of the second touch point of the disk that touches at t, shape (n,) [rad]."""
        points, normals, curvature = self.frame(t)
        gap = self.points[None] - points[:, None]
        square = (gap**2).sum(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            tightness = 2.0 * np.einsum("nij,nj->ni", gap, normals) / square
        own = np.abs(_wrapped(self.grid[None] - t[:, None])) < 0.5 * self.step
        tightness[own] = np.broadcast_to(curvature[:, None], own.shape)[own]
        s = self.grid[np.argmax(tightness, axis=1)]
        for _ in range(12):
            s = s + np.clip(self._newton_step(s, points, normals), -self.step, self.step)
        return s

    def _newton_step(self, s: Floats, points: Floats, normals: Floats) -> Floats:
        place, velocity = self.outline.curve(s), self.outline.curve(s, 1)
        gap = place - points
        forward = (gap * normals).sum(axis=1)
        radius = (gap**2).sum(axis=1) / (2.0 * np.where(forward == 0.0, 1e-300, forward))
        spoke = gap - radius[:, None] * normals
        slope = (velocity**2).sum(axis=1) + (spoke * self.outline.curve(s, 2)).sum(axis=1)
        return np.asarray(-(spoke * velocity).sum(axis=1) / np.where(slope == 0.0, 1e-300, slope))

    def tip(self, guess: float) -> float:
        """Parameter of the curvature maximum near a guess [rad]."""
        t, reach = guess, 4.0 * self.step
        for _ in range(40):
            spots = t + np.linspace(-reach, reach, 9)
            t = float(spots[np.argmax(self.frame(spots)[2])])
            reach *= 0.5
        return t


def _wrapped(angle: Floats) -> Floats:
    return (angle + np.pi) % TURN - np.pi


def smooth_medial_axis(outline: SmoothOutline, spacing: float) -> MedialAxis:
    """Medial axis of a smooth curve; see :func:`medkit.planar.medial.medial_axis`."""
    perimeter = float(np.linalg.norm(np.diff(outline.loops[0], axis=0), axis=1).sum())
    order = (len(outline.coefficients) - 1) // 2
    if np.abs(np.delete(outline.coefficients, [order, order + 1])).max() < 1e-12 * perimeter:
        return _circle(outline)
    curve = _Curve(outline, int(np.clip(2.0 * perimeter / spacing, max(256, 32 * order), 2048)))
    start = _first_tip(curve)
    return _assemble(outline, curve, _chains(curve, start))


def _first_tip(curve: _Curve) -> float:
    """A parameter where a branch ends, so that no branch runs across the start."""
    t: Floats = curve.grid + 0.5 * curve.step
    near = int(np.argmin(np.abs(_wrapped(curve.partners(t) - t))))
    return curve.tip(float(t[near]))


def _chains(curve: _Curve, start: float) -> list[tuple[Floats, Floats, Place, Place]]:
    """Runs of disks with partners t < s, and what is at both ends: a tip or a jump."""
    t: Floats = start + curve.grid + 0.5 * curve.step
    s = _unwrapped(curve.partners(t), start)
    apart = np.flatnonzero(np.abs(_wrapped(s - t)) > TIP_STEPS * curve.step)
    chains: list[tuple[Floats, Floats, Place, Place]] = []
    first, opening = 0, (start,)  # type: tuple[int, Place]
    for k, i in enumerate(apart):
        following = apart[k + 1] if k + 1 < len(apart) else -1
        border: Place | None
        if following != i + 1:  # the samples of a tip lie between, or the start follows
            border = (curve.tip(0.5 * float(t[i] + s[i])) if following > 0 else start,)
        else:
            border = _jump(curve, start, (t[i], s[i]), (t[i + 1], s[i + 1]))
        if border is None:
            continue
        run = apart[first : k + 1]
        if s[i] > t[i]:
            chains.append((t[run], s[run], opening, border))
        first, opening = k + 1, border
    return chains


def _unwrapped(s: Floats, start: float) -> Floats:
    return start + (s - start) % TURN


def _jump(
    curve: _Curve, start: float, a: tuple[float, float], b: tuple[float, float]
) -> Place | None:
    """Bisect a gap between neighbours; return (t, s before, s after) if it does not close."""
    while abs(a[1] - b[1]) > 4.0 * curve.step:
        if b[0] - a[0] < 1e-6 * curve.step:
            return _three_touches(curve, np.array([0.5 * (a[0] + b[0]), a[1], b[1]]))
        t = 0.5 * (a[0] + b[0])
        middle = (t, float(_unwrapped(curve.partners(np.array([t])), start)[0]))
        a, b = (middle, b) if abs(middle[1] - a[1]) < abs(middle[1] - b[1]) else (a, middle)
    return None


def _three_touches(curve: _Curve, t: Floats) -> Place:
    """Newton for the disk that touches at three places, from parameters nearby."""
    points, normals, _ = curve.frame(t[:1])
    gap = curve.outline.curve(t[1]) - points[0]
    radius = float(gap @ gap / (2.0 * gap @ normals[0]))
    center = points[0] + radius * normals[0]
    for _ in range(20):
        spoke = curve.outline.curve(t) - center
        velocity = curve.outline.curve(t, 1)
        slope = (velocity**2).sum(axis=1) + (spoke * curve.outline.curve(t, 2)).sum(axis=1)
        t = t - (spoke * velocity).sum(axis=1) / slope
        spoke = curve.outline.curve(t) - center
        length = np.linalg.norm(spoke, axis=1)
        matrix = np.column_stack([-spoke / length[:, None], -np.ones(3)])
        center = center + np.linalg.solve(matrix, -length)[:2]
    return tuple(t.tolist())


def _assemble(
    outline: SmoothOutline, curve: _Curve, chains: list[tuple[Floats, Floats, Place, Place]]
) -> MedialAxis:
    rows, branch_nodes = [], []
    nodes = _Nodes(curve, outline.characteristic_length)
    for number, (t, s, opening, closing) in enumerate(chains):
        branch_nodes.append([nodes.number(opening), nodes.number(closing)])
        points, normals, _ = curve.frame(t)
        touch = outline.curve(s)
        gap = touch - points
        radius = (gap**2).sum(axis=1) / (2.0 * (gap * normals).sum(axis=1))
        center = points + radius[:, None] * normals
        rows.append(
            (center, radius, np.stack([points, touch], axis=1), np.full(len(radius), number))
        )
    centers, radii, touches, branch = (np.concatenate(part) for part in zip(*rows, strict=True))
    angles = angle_between(touches[:, 0] - centers, touches[:, 1] - centers)
    return MedialAxis(
        outline, np.vstack([centers, nodes.centers]), np.concatenate([radii, nodes.radii]),
        np.concatenate([angles, [n[0] for n in nodes.disks]]),
        np.concatenate([touches, [n[1] for n in nodes.disks]]),
        np.concatenate([radii * np.sin(angles / 2), [n[2] for n in nodes.disks]]),
        np.concatenate([branch, np.full(len(nodes.radii), -1)]).astype(np.int64),
        np.array(nodes.centers), np.array(nodes.radii), np.array(branch_nodes, dtype=np.int64),
    )  # fmt: skip


class _Nodes:
    """Tips and branch points met so far; the same branch point is met from two of its sides."""

    def __init__(self, curve: _Curve, size: float) -> None:
        self.curve, self.size = curve, size
        self.centers: list[Floats] = []
        self.radii: list[float] = []
        self.disks: list[tuple[float, Floats, float]] = []

    def number(self, where: Place) -> int:
        """Number of a node, new or known."""
        point, normal, curvature = self.curve.frame(np.array(where[:1]))
        radius, touches = 1.0 / curvature[0], point
        if len(where) > 1:
            touches = np.vstack([point, self.curve.outline.curve(np.array(where[1:]))])
            gap = touches[1:] - point
            radius = float(((gap**2).sum(axis=1) / (2.0 * gap @ normal[0])).mean())
        center = point[0] + radius * normal[0]
        for known, other in enumerate(self.centers):
            if np.linalg.norm(other - center) < 1e-6 * self.size:
                return known
        self.centers.append(center)
        self.radii.append(float(radius))
        self.disks.append(node_disk(center, np.vstack([touches, touches])))
        return len(self.radii) - 1


def _circle(outline: SmoothOutline) -> MedialAxis:
    """The axis of a circle is its centre."""
    touch = outline.curve(np.array([0.0, np.pi]))
    center, radius = touch.mean(axis=0)[None], np.linalg.norm(touch[:1] - touch[1:], axis=1) / 2
    return MedialAxis(
        outline, center, radius, np.array([np.pi]), touch[None], radius.copy(), np.array([-1]),
        center, radius, np.zeros((0, 2), dtype=np.int64),
    )  # fmt: skip
