"""The second baseline: candidates from a decomposition into boxes (Huebner 2008).

Only the candidates differ from the medial planner's: hand, closing and quality are the same.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.arguments import whole
from medkit.geometry import Floats, positive
from medkit.grasping.baselines import ROLLS, joined_candidates, refuse_empty, rolled
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.medial.surface import sample_surface
from medkit.robots.hand import Hand

#: A box is split while its halves' boxes take up less than this share of its volume.
SPLIT_SHARE, DEEPEST = 0.90, 4


def fitted_box_candidates(
    mesh: trimesh.Trimesh, *, rolls: int = ROLLS, split_share: float = SPLIT_SHARE
) -> CandidateGrasps:
    """Candidates from a decomposition into boxes (Huebner et al. 2008).

    A box of least volume around the surface's samples is split by the cut across one of its axes
    that leaves the least volume in the two halves' own boxes, as long as that saves enough. The
    hand approaches each face of each box towards the box's centre.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    rolls : int
        Roll angles about each approach direction, evenly around.
    split_share : float
        Split a box while the halves' boxes take up less than this share of it [1].

    Returns
    -------
    CandidateGrasps
        Grasp points at the boxes' centres; no spheres, radius half the least box edge across.

    Raises
    ------
    InputError
        If there is no mesh, fewer than one roll is asked for, or the share is not above zero.

    Examples
    --------
    >>> found = fitted_box_candidates(trimesh.creation.cylinder(0.03, 0.2))
    >>> len(found) == 24, len(np.unique(found.grasp_point.round(4), axis=0))
    (True, 1)
    """
    refuse_empty(mesh)
    rolls = whole(rolls, "rolls")
    positive(split_share, "split_share")
    boxes = fitted_boxes(mesh, split_share=split_share)
    parts = []
    for pose, half in boxes:
        for axis, sign in itertools.product(range(3), (1.0, -1.0)):
            approach = sign * pose[:3, axis]
            u, v = (axis + 1) % 3, (axis + 2) % 3
            along = pose[:3, u if half[u] >= half[v] else v]
            parts.append(
                rolled(
                    pose[None, :3, 3],
                    approach[None],
                    rolls,
                    along[None],
                    np.delete(half, axis).min(),
                )
            )
    return joined_candidates(parts)


def fitted_boxes(
    mesh: trimesh.Trimesh, *, split_share: float = SPLIT_SHARE
) -> list[tuple[Floats, Floats]]:
    """Boxes of the decomposition (Huebner et al. 2008).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    split_share : float
        Split a box while the halves' boxes take up less than this share of it [1].

    Returns
    -------
    list of (ndarray, ndarray)
        ``T_object_box`` (4, 4) and half edges (3,) [m] of each box.

    Examples
    --------
    >>> (pose, half), = fitted_boxes(trimesh.creation.box((0.1, 0.06, 0.04)))
    >>> sorted((2 * half).round(2).tolist())
    [0.04, 0.06, 0.1]
    """
    spacing = float(np.linalg.norm(mesh.extents)) / 60.0
    return _split(sample_surface(mesh, spacing=spacing).points, split_share, DEEPEST)


def _split(points: Floats, share: float, deepest: int) -> list[tuple[Floats, Floats]]:
    to_box, extents = trimesh.bounds.oriented_bounds(points)
    pose, half = np.linalg.inv(to_box), 0.5 * np.asarray(extents)
    cut = _best_cut(trimesh.transform_points(points, to_box), half) if deepest > 0 else None
    if cut is None or cut[0] > share or min(cut[1].sum(), (~cut[1]).sum()) < 12:
        return [(pose, half)]
    below = cut[1]
    return _split(points[below], share, deepest - 1) + _split(points[~below], share, deepest - 1)


def _best_cut(local: Floats, half: Floats) -> tuple[float, NDArray[np.bool_]] | None:
    """Share of the volume left by the best cut across an axis, and which points lie below it."""
    best: tuple[float, NDArray[np.bool_]] | None = None
    whole = float(np.prod(half))
    for axis, place in itertools.product(range(3), np.linspace(-0.8, 0.8, 17)):
        below = local[:, axis] < place * half[axis]
        if not below.any() or below.all():
            continue
        left = sum(float(np.prod(0.5 * np.ptp(local[side], axis=0))) for side in (below, ~below))
        if best is None or left / whole < best[0]:
            best = (left / whole, below)
    return best


def box_candidates(mesh: trimesh.Trimesh, hand: Hand, **unused: Any) -> CandidateGrasps:
    """`fitted_box_candidates` as the planners call it; neither hand nor spheres matter."""
    return fitted_box_candidates(mesh)
