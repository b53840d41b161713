"""The first baseline: candidates from surface normals (Berenson 2007).

Only the candidates differ from the medial planner's: hand, closing and quality are the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.arguments import whole
from medkit.errors import InputError
from medkit.geometry import Floats, expected, perpendicular
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.robots.hand import Hand

#: Candidates aimed at: P13 5.1.3 tests 300 to 500 an object.
CANDIDATES = 400
#: Roll angles about each approach direction, 90 degrees apart (P13 5.1.3).
ROLLS = 4
#: Below this, 1 + the cosine between two approaches says that they are opposite [1].
OPPOSITE = 1e-9


def surface_normal_candidates(
    mesh: trimesh.Trimesh, *, candidates: int = CANDIDATES, rolls: int = ROLLS
) -> CandidateGrasps:
    """Candidates from the normals where rays from the bounding box hit (Berenson et al. 2007).

    Each face of the bounding box is sampled on a regular grid; a ray goes inwards from each
    sample; where it first hits the surface, the hand approaches against the normal there. The
    normal says nothing about the turn of the hand: it is turned from the candidate before by the
    shortest way (P13 4.6), and then by the roll angles.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    candidates : int
        About how many are wanted; the grid's spacing follows from it.
    rolls : int
        Roll angles about each approach direction, evenly around.

    Returns
    -------
    CandidateGrasps
        Grasp points on the surface; no spheres, radius 0.

    Raises
    ------
    InputError
        If there is no mesh, or fewer than one candidate or roll is asked for.

    Examples
    --------
    >>> found = surface_normal_candidates(trimesh.creation.box((0.1, 0.1, 0.1)), candidates=96)
    >>> len(found), np.unique(np.abs(found.approach).round(6)).tolist()
    (96, [0.0, 1.0])
    """
    refuse_empty(mesh)
    candidates, rolls = whole(candidates, "candidates"), whole(rolls, "rolls")
    wanted = max(1.0, candidates / rolls)
    area = float(sum(np.prod(np.delete(mesh.extents, axis)) * 2.0 for axis in range(3)))
    spacing = float(np.sqrt(area / wanted))
    points, normals = _grid_hits(mesh, spacing)
    for _ in range(12):  # rays that miss are made up for by a finer grid
        if 0.95 * wanted <= len(points) <= 1.15 * wanted:
            break
        spacing *= float(np.clip(np.sqrt(max(len(points), 1) / (1.03 * wanted)), 0.5, 1.5))
        points, normals = _grid_hits(mesh, spacing)
    return rolled(points, -normals, rolls, carried_axes(-normals))


def refuse_empty(mesh: Any) -> None:
    """Refuse what is no triangle mesh, and a mesh without triangles."""
    remedy = "read one with medkit.meshes.load_mesh(path)"
    expected(mesh, trimesh.Trimesh, "a triangle mesh", remedy)
    if len(mesh.faces) == 0:
        raise InputError(f"Expected a closed body, but the mesh holds no triangle; {remedy}.")


def carried_axes(approach: Floats) -> Floats:
    """Closing axes of a hand that is turned from each approach to the next by the shortest way.

    Parameters
    ----------
    approach : ndarray, shape (n, 3)
        Unit directions, in the order in which they are tested.

    Returns
    -------
    ndarray, shape (n, 3)
        Unit axes at right angles to them. Opposite directions follow by half a turn about the
        axis itself.

    Examples
    --------
    >>> ways = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> bool(abs(carried_axes(ways)[3] @ carried_axes(ways)[0]) < 1e-9)  # around a corner: turned
    True
    """
    axes = np.empty_like(approach)
    axis = perpendicular(approach[:1])[0] if len(approach) else np.zeros(3)
    for k, ahead in enumerate(approach):
        before = approach[max(k - 1, 0)]
        turn = 1.0 + before @ ahead
        if turn > OPPOSITE:
            axis = axis - (axis @ ahead) / turn * (before + ahead)
        axis = axis - (axis @ ahead) * ahead  # rounding must not add up
        axis = axis / np.linalg.norm(axis)
        axes[k] = axis
    return axes


def _grid_hits(mesh: trimesh.Trimesh, spacing: float) -> tuple[Floats, Floats]:
    """First hits (n, 3) of rays from all faces of the bounding box, and outward normals there."""
    low, high = np.asarray(mesh.bounds)
    points, normals = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        grid = [_middles(low[a], high[a], spacing) for a in (u, v)]
        across = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 2)
        heights, faces = _heights(np.asarray(mesh.triangles), axis, across)
        for side in (0, 1):
            hit = faces[:, side] >= 0
            place = np.zeros((int(hit.sum()), 3))
            place[:, u], place[:, v] = across[hit].T
            place[:, axis] = heights[hit, side]
            points.append(place)
            normals.append(mesh.face_normals[faces[hit, side]])
    return np.vstack(points), np.vstack(normals)


def _middles(low: float, high: float, spacing: float) -> Floats:
    count = max(1, round((high - low) / spacing))
    return low + (np.arange(count) + 0.5) * (high - low) / count


def _heights(triangles: Floats, axis: int, across: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Lowest and highest surface point (n, 2) over points (n, 2); faces, -1 where none."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    a, b, c = (triangles[:, k][:, [u, v]] for k in range(3))
    area = _cross(b - a, c - a)
    heights = np.tile([np.inf, -np.inf], (len(across), 1))
    faces = np.full((len(across), 2), -1, dtype=np.int64)
    flat = np.abs(area) < 1e-18
    area[flat] = 1.0
    for row, p in enumerate(across):
        wb, wc = _cross(p - a, c - a) / area, _cross(b - a, p - a) / area
        inside = np.flatnonzero((wb >= 0) & (wc >= 0) & (wb + wc <= 1) & ~flat)
        if len(inside):
            weights = np.stack([1 - wb[inside] - wc[inside], wb[inside], wc[inside]], axis=1)
            level = (weights * triangles[inside][:, :, axis]).sum(axis=1)
            for side, pick in ((0, np.argmin(level)), (1, np.argmax(level))):
                heights[row, side], faces[row, side] = level[pick], inside[pick]
    return heights, faces


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def rolled(
    points: Floats, approach: Floats, rolls: int, first: Floats | None = None, radius: float = 0.0
) -> CandidateGrasps:
    """Candidates with closing axes evenly around each approach, from `first` (n, 3) on."""
    first = perpendicular(approach) if first is None else first
    second = np.cross(approach, first)
    angles = 2.0 * np.pi * np.arange(rolls) / rolls
    axes = np.cos(angles)[:, None] * first[:, None] + np.sin(angles)[:, None] * second[:, None]
    count = len(points) * rolls
    return CandidateGrasps(
        grasp_point=np.repeat(points, rolls, axis=0),
        approach=np.repeat(approach, rolls, axis=0),
        closing_axis=axes.reshape(-1, 3),
        sphere=np.repeat(np.arange(len(points)), rolls),
        kind=np.full(count, -1, dtype=np.int8),
        radius=np.full(count, radius),
        fate=np.zeros(0, dtype=np.int8),
    )


def joined_candidates(parts: list[CandidateGrasps]) -> CandidateGrasps:
    """One struct of candidates from several that have no spheres; places are numbered anew."""
    names = ("grasp_point", "approach", "closing_axis", "kind", "radius")
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in names
    }
    shift = np.cumsum([0] + [int(part.sphere.max(initial=-1)) + 1 for part in parts[:-1]])
    sphere = np.concatenate([part.sphere + s for part, s in zip(parts, shift, strict=True)])
    return CandidateGrasps(**arrays, sphere=sphere, fate=np.zeros(0, dtype=np.int8))


def normal_candidates(mesh: trimesh.Trimesh, hand: Hand, **unused: Any) -> CandidateGrasps:
    """`surface_normal_candidates` as the planners call it; neither hand nor spheres matter."""
    return surface_normal_candidates(mesh)
