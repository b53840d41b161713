"""The rotations and mirror planes that map a mesh onto itself, found with a stated tolerance.

Every isometry of a surface keeps the centroid of its hull, so only directions through it are
searched. A candidate's misfit is the root-mean-square distance from the turned surface to the
surface, over the shape's radius; it needs no matching of vertices and so works on scans. Parts that
pass are put together to an exact group, whose every element is tested again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from scipy.spatial import QhullError, cKDTree

from medkit.arguments import generator
from medkit.errors import InputError
from medkit.geometry import Floats, expected, perpendicular, positive, rotation_about, unit
from medkit.similarity.symmetry import (
    SymmetryGroup,
    ball_group,
    revolution_group,
    trivial_group,
)
from medkit.similarity.symmetry_candidates import (
    candidate_groups,
    distinct_lines,
    hemisphere,
    upwards,
)

#: Misfit that still counts as symmetric, as a share of the shape's radius.
TOLERANCE = 0.02
#: Rotations by these folds are looked for; a regular polygon of more sides passes for a circle.
FOLDS = (2, 3, 4, 5, 6, 7, 8)
#: Turns [rad] no fold above divides; only a body of revolution passes all of them.
GENERIC_TURNS = (0.41, 1.0, 1.9, 2.6)
_DENSE, _PROBES, _COARSE, _DIRECTIONS = 30_000, 1_200, 120, 500


@dataclass(frozen=True)
class _Surface:
    """A surface in units of its own radius about its centroid, ready for distance queries."""

    center: Floats  # (3,) [m]
    radius: float  # [m]
    points: Floats  # (n, 3) dense
    normals: Floats  # (n, 3)
    tree: cKDTree
    probes: Floats  # (m, 3) sparse
    principal: Floats  # (3, 3) rows
    moments: Floats  # (3,) along them, over the largest, ascending

    def offsets(self, moved: Floats) -> Floats:
        """Signed distances [radius] of points, from the plane of the nearest sample."""
        distance, index = self.tree.query(moved)
        plane = np.einsum("na,na->n", moved - self.points[index], self.normals[index])
        # Beside an edge the plane of the nearest sample may run far from the surface.
        return np.asarray(np.where(distance > 0.03, np.copysign(distance, plane), plane))

    def misfit(self, isometry: Floats) -> float:
        """Root-mean-square distance [radius] after an isometry (3, 3) about the centroid."""
        return float(np.sqrt(np.mean(self.offsets(self.probes @ isometry.T) ** 2)))


def symmetry_group_from_mesh(
    mesh: trimesh.Trimesh, *, tolerance: float = TOLERANCE, rng: np.random.Generator | None = None
) -> SymmetryGroup:
    """Find the rotations and mirror planes of a mesh (asked for by P13 6.2.5).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A surface [m]; it may be open, and its triangles may be of any size.
    tolerance : float
        Greatest misfit [1]: root-mean-square distance between the surface and its image, over
        the largest distance from the centroid.
    rng : numpy.random.Generator, optional
        Draws the surface samples; a fixed one if left out, so that a mesh has one answer.

    Returns
    -------
    SymmetryGroup
        Closed under composition to rounding error. `residual` is the worst misfit among its
        parts.

    Raises
    ------
    InputError
        If no mesh came or it has no area, the tolerance is not above zero, or `rng` is not a
        generator.

    Examples
    --------
    >>> symmetry_group_from_mesh(trimesh.creation.cylinder(0.04, 0.12, sections=64)).name
    'Dinf'
    """
    limit = positive(tolerance, "tolerance")
    expected(mesh, trimesh.Trimesh, "a mesh", "read one with medkit.meshes.load_mesh")
    rng = np.random.default_rng(0) if rng is None else generator(rng)
    surface = _surface_from_mesh(mesh, rng)
    group = _rotation_group(surface, limit)
    group = replace(group, center=surface.center)
    return replace(group, mirrors=_mirrors(surface, group, limit))


def _surface_from_mesh(mesh: trimesh.Trimesh, rng: np.random.Generator) -> _Surface:
    triangles = np.asarray(mesh.triangles, dtype=float)
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(cross, axis=1)
    if not np.all(np.isfinite(area)) or area.sum() <= 0.0:
        raise InputError(
            f"Expected a mesh with area, but its {len(triangles)} triangles have none or are not"
            " finite; load another mesh."
        )
    face = rng.choice(len(area), size=_DENSE, p=area / area.sum())
    u, v = rng.random((2, _DENSE, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    corner = triangles[face]
    points = corner[:, 0] + u * (corner[:, 1] - corner[:, 0]) + v * (corner[:, 2] - corner[:, 0])
    center = _hull_centroid(triangles)
    radius = float(np.linalg.norm(triangles.reshape(-1, 3) - center, axis=1).max())
    points = (points - center) / radius
    moments, principal = np.linalg.eigh(points.T @ points)
    return _Surface(
        center, radius, points, cross[face] / area[face, None], cKDTree(points),
        points[:_PROBES], principal.T, moments / moments[2],
    )  # fmt: skip


def _hull_centroid(triangles: Floats) -> Floats:
    """Centroid of the convex hull, which holes, inner faces and uneven sampling leave in place."""
    corners = triangles.reshape(-1, 3)
    try:
        hull = trimesh.convex.convex_hull(corners)
    except QhullError:  # a flat sheet
        return np.asarray(0.5 * (corners.min(axis=0) + corners.max(axis=0)))
    return np.asarray(hull.center_mass)


def _rotation_group(surface: _Surface, limit: float) -> SymmetryGroup:
    worst = max(surface.misfit(rotation_about(axis, turn))
                for axis in np.eye(3) for turn in GENERIC_TURNS)  # fmt: skip
    if worst < limit:
        return replace(ball_group(), residual=worst)
    revolution = _revolution(surface, limit)
    if revolution is not None:
        return revolution
    return _finite_group(surface, limit)


def _revolution(surface: _Surface, limit: float) -> SymmetryGroup | None:
    """The group of a body of revolution, whose axis is a principal axis of the surface."""
    best: tuple[float, Floats] = (np.inf, surface.principal[0])
    for start in surface.principal:
        axis = _refined_axis(surface, start, GENERIC_TURNS)
        worst = max(surface.misfit(rotation_about(axis, turn)) for turn in GENERIC_TURNS)
        best = min(best, (worst, axis), key=lambda pair: pair[0])
    residual, axis = best
    if residual >= limit:
        return None
    flip = surface.misfit(rotation_about(perpendicular(axis), np.pi))
    flips = flip < limit
    return replace(
        revolution_group(upwards(axis), flips=flips),
        residual=max(residual, flip) if flips else residual,
    )


def _finite_group(surface: _Surface, limit: float) -> SymmetryGroup:
    axes = _axes_of_rotation(surface, limit)
    for candidate in candidate_groups(axes):
        residual = max(surface.misfit(part) for part in candidate.rotations)
        if residual < limit:
            return replace(candidate, residual=residual)
    return trivial_group()


def _axes_of_rotation(surface: _Surface, limit: float) -> dict[int, list[Floats]]:
    """For each fold the axes (3,) whose turn by 2 pi / fold passes, best first."""
    directions = _directions(surface, limit)
    found = {}
    for fold in FOLDS:
        turn = 2.0 * np.pi / fold
        coarse = _coarse_misfits(surface, directions, turn)
        starts = directions[_local_minima(directions, coarse, limit)]
        refined = [_refined_axis(surface, start, (turn,)) for start in starts]
        scored = [(surface.misfit(rotation_about(axis, turn)), axis) for axis in refined]
        passing = sorted((pair for pair in scored if pair[0] < limit), key=lambda pair: pair[0])
        found[fold] = distinct_lines([axis for _, axis in passing])
    return found


def _directions(surface: _Surface, limit: float) -> Floats:
    """Where axes can be: the principal axes, and all of a plane or of space where moments agree.

    A turn of three or more folds makes the two moments across its axis equal, so unequal moments
    leave the principal axes alone. What counts as equal grows with the tolerance.
    """
    low, middle, high = surface.moments
    slack = 8.0 * limit
    if high - low < slack:
        return np.vstack([surface.principal, hemisphere(_DIRECTIONS)])
    planes = []
    for close, pair in ((middle - low, (0, 1)), (high - middle, (1, 2))):
        if close < slack:
            angles = np.pi * np.arange(1, 90) / 90.0
            first, second = surface.principal[list(pair)]
            planes.append(np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second)
    return np.vstack([surface.principal, *planes])


def _coarse_misfits(surface: _Surface, directions: Floats, turn: float) -> Floats:
    probes = surface.probes[:_COARSE]
    turns = np.stack([rotation_about(direction, turn) for direction in directions])
    moved = np.einsum("dab,nb->dna", turns, probes).reshape(-1, 3)
    offsets = surface.offsets(moved).reshape(len(directions), -1)
    return np.asarray(np.sqrt(np.mean(offsets**2, axis=1)))


def _local_minima(directions: Floats, misfits: Floats, limit: float) -> np.ndarray:
    """Directions with the least misfit within 9 deg, and not hopelessly bad, at most 24."""
    near = np.abs(directions @ directions.T) > np.cos(np.deg2rad(9.0))
    least = np.where(near, misfits[None, :], np.inf).min(axis=1)
    chosen = np.flatnonzero((misfits <= least) & (misfits < limit + 0.08))
    return chosen[np.argsort(misfits[chosen], kind="stable")][:24]


def _refined_axis(surface: _Surface, start: Floats, turns: tuple[float, ...]) -> Floats:
    probes = surface.probes[: 2 * _COARSE]

    def offsets(axis: Floats) -> Floats:
        turned = [probes @ rotation_about(axis, turn).T for turn in turns]
        return surface.offsets(np.concatenate(turned))

    return _refined(start, offsets)


def _refined(start: Floats, offsets: Callable[[Floats], Floats], *, steps: int = 6) -> Floats:
    """Tilt a direction so that squared offsets shrink: Gauss-Newton in its two tilt angles."""
    line, step = start, 1e-3
    now = offsets(line)
    for _ in range(steps):
        first = perpendicular(line)
        second = np.cross(line, first)
        slopes = np.stack([(offsets(unit(line + step * d)) - now) / step for d in (first, second)])
        tilt = np.linalg.lstsq(slopes.T, -now, rcond=None)[0]
        tilt *= min(1.0, 0.1 / max(float(np.linalg.norm(tilt)), 1e-12))
        trial = unit(line + tilt[0] * first + tilt[1] * second)
        then = offsets(trial)
        if not then @ then < (1.0 - 1e-4) * (now @ now):
            break
        line, now = trial, then
    return line


def _mirrors(surface: _Surface, group: SymmetryGroup, limit: float) -> Floats:
    """Normals (m, 3) of the mirror planes; one of each kind for a body of revolution."""
    if group.continuous == "all":
        return np.array([[0.0, 0.0, 1.0]])
    if group.continuous == "axis":
        candidates = [perpendicular(group.axis), group.axis]
    else:
        candidates = _mirror_candidates(surface, limit)
    passing = []
    for normal in candidates:
        misfit = surface.misfit(np.eye(3) - 2.0 * np.outer(normal, normal))
        if misfit < limit:
            passing.append((misfit, normal))
    passing.sort(key=lambda pair: pair[0])
    planes = distinct_lines([normal for _, normal in passing])
    return np.asarray(planes).reshape(-1, 3)


def _mirror_candidates(surface: _Surface, limit: float) -> list[Floats]:
    directions = _directions(surface, limit)
    reflections = np.eye(3) - 2.0 * np.einsum("da,db->dab", directions, directions)
    moved = np.einsum("dab,nb->dna", reflections, surface.probes[:_COARSE]).reshape(-1, 3)
    offsets = surface.offsets(moved).reshape(len(directions), -1)
    coarse = np.sqrt(np.mean(offsets**2, axis=1))
    probes = surface.probes[: 2 * _COARSE]

    def after(normal: Floats) -> Floats:
        return surface.offsets(probes - 2.0 * np.outer(probes @ normal, normal))

    return [
        _refined(start, after) for start in directions[_local_minima(directions, coarse, limit)]
    ]
