"""From local symmetry to candidate grasps, with every sphere's fate (P13 4.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, nonnegative, positive, unit
from medkit.grasping.candidate_set import CandidateGrasps, Ints, SphereFate
from medkit.grasping.reach import way_out
from medkit.grasping.special_solids import (
    COMPACT,
    Rows,
    borders_of_whole_sheets,
    outer_touch,
    solid_candidates,
)
from medkit.medial.axis import MedialAxis
from medkit.medial.filters import MIN_OBJECT_ANGLE
from medkit.medial.grid import MedialSphereGrid
from medkit.medial.symmetry import LocalSymmetry, SymmetryKind, local_symmetry

#: P13 5.1.3: approach directions around a symmetry axis.
AXIS_STEPS = 4
#: A sphere without enough neighbours counts as dominant from this share of the largest radius.
DOMINANT_RATIO = 0.9
#: Spheres from this share of the largest radius are the inscribed one, up to sampling.
INSCRIBED_RATIO = 0.97


def candidates_from_axis(
    axis: MedialAxis,
    *,
    search_radius: float,
    min_radius_ratio: float = 0.0,
    hand_radii: tuple[float, float] = (0.0, np.inf),
    min_object_angle: float = MIN_OBJECT_ANGLE,
    axis_steps: int = AXIS_STEPS,
) -> CandidateGrasps:
    """Candidate grasps of an object from its medial axis (P13 4.2 to 4.4, algorithms 1 to 3).

    Balls, solids about one dominant sphere (4.4.4) and sheets that every neighbourhood holds whole
    are treated as special cases.

    Parameters
    ----------
    axis : MedialAxis
        All spheres of the object.
    search_radius : float
        Radius of the neighbourhoods of the symmetry analysis, P13's r_N [m].
    min_radius_ratio : float
        Spheres below this share of the largest radius are dropped as surface detail [1].
    hand_radii : (float, float)
        Smallest and largest sphere that the hand can hold [m]. They limit the candidates, not
        the symmetry analysis (P13 4.3).
    min_object_angle : float
        Least object angle [rad].
    axis_steps : int
        Approach directions around a symmetry axis.

    Returns
    -------
    CandidateGrasps
        In the order of the spheres; empty when no sphere serves.

    Raises
    ------
    InputError
        If a parameter is out of range.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import medial_axis
    >>> axis = medial_axis(trimesh.creation.capsule(0.2, 0.02))
    >>> found = candidates_from_axis(axis, search_radius=0.03)
    >>> bool((abs(found.closing_axis[:, 2]) > 0.99).all())  # along the capsule
    True
    """
    positive(search_radius, "search_radius", " m")
    ratio = nonnegative(min_radius_ratio, "min_radius_ratio")
    if ratio > 1.0:
        raise InputError(
            f"Expected min_radius_ratio between 0 and 1, but got {ratio:g}; it is a share of the"
            " largest radius."
        )
    if axis_steps < 1:
        raise InputError(f"Expected at least one axis step, but got {axis_steps}; P13 takes 4.")
    fate = np.full(len(axis.centers), SphereFate.TOO_FEW_NEIGHBORS, dtype=np.int8)
    narrow = axis.object_angles < min_object_angle - 1e-9
    # a large sphere of small object angle, as in a wide corner, sets no scale for thickness
    largest = float(axis.radii[~narrow].max(initial=0.0))
    if narrow.all():
        # no sphere is wide enough: only the inscribed ones stand for the solid (P13 4.4.4)
        narrow = axis.radii < INSCRIBED_RATIO * axis.radii.max(initial=0.0)
        largest = float(axis.radii.max(initial=0.0))
    small = axis.radii < ratio * largest
    fate[small] = SphereFate.BELOW_RADIUS_RATIO
    fate[narrow] = SphereFate.OBJECT_ANGLE_TOO_SMALL
    kept = np.flatnonzero(~narrow & ~small)
    if not len(kept):
        return _joined([], axis, fate)
    part = axis.select(kept)
    symmetry = local_symmetry(MedialSphereGrid.from_axis(part), search_radius)
    symmetry = borders_of_whole_sheets(symmetry, part.centers)
    fate[kept] = _fates(part, symmetry, largest, hand_radii)
    across = _inwards(part, symmetry)
    buried = _buried(axis, part, across, fate[kept] == SphereFate.RIM, search_radius)
    fate[kept[buried]] = SphereFate.INSIDE_SHEET
    solids = solid_candidates(axis, part, fate, kept, search_radius)
    parts = [
        _around_axes(
            part, symmetry, kept, np.flatnonzero(fate[kept] == SphereFate.AXIS), axis_steps
        ),
        _across_rims(part, symmetry, kept, np.flatnonzero(fate[kept] == SphereFate.RIM), across),
        *solids,
    ]
    return _joined(parts, axis, fate)


def _fates(
    part: MedialAxis, symmetry: LocalSymmetry, largest: float, hand_radii: tuple[float, float]
) -> NDArray[np.int8]:
    """Fates of the spheres that the symmetry analysis saw; POINT and dominant ones as BALL."""
    names = {
        SymmetryKind.AXIS: SphereFate.AXIS,
        SymmetryKind.RIM: SphereFate.RIM,
        SymmetryKind.INTERIOR: SphereFate.INSIDE_SHEET,
        SymmetryKind.TOO_FEW: SphereFate.TOO_FEW_NEIGHBORS,
        SymmetryKind.POINT: SphereFate.BALL,
    }
    table = np.array([names[kind] for kind in SymmetryKind], dtype=np.int8)
    fate = table[symmetry.kind]
    dominant = (symmetry.kind == SymmetryKind.TOO_FEW) & (part.radii >= DOMINANT_RATIO * largest)
    # centres that spread little against the thickness are one sphere, seen through noise; a
    # lonely sphere has no spread either, but says nothing
    compact = np.sqrt(np.maximum(symmetry.lambdas[:, 0], 0.0)) < COMPACT * part.radii
    compact &= symmetry.kind != SymmetryKind.TOO_FEW
    fate[dominant | compact] = SphereFate.BALL
    serves = np.isin(fate, [SphereFate.AXIS, SphereFate.RIM, SphereFate.BALL])
    fate[serves & (part.radii > hand_radii[1])] = SphereFate.TOO_LARGE_FOR_HAND
    fate[serves & (part.radii < hand_radii[0])] = SphereFate.TOO_SMALL_FOR_HAND
    return fate


def _around_axes(
    part: MedialAxis, symmetry: LocalSymmetry, kept: Ints, rows: Ints, steps: int
) -> Rows:
    """Directions evenly around each axis, closing axis along it and against it (P13 4.4.1).

    The first direction is that of a touch point: on a prism the palm then faces a side, not an
    edge (P13 4.4.4), and the candidates turn with the object.
    """
    axis = _outwards(symmetry.e1[rows], part, rows)
    first = outer_touch(part)[rows]
    first -= np.einsum("ij,ij->i", first, axis)[:, None] * axis
    short = np.linalg.norm(first, axis=1) < 1e-3 * part.radii[rows]
    first[short] = _outwards(symmetry.e2[rows], part, rows)[short]
    first = unit(first)
    second = np.cross(axis, first)
    angles = 2.0 * np.pi * np.arange(steps) / steps
    approach = np.cos(angles)[:, None] * first[:, None] + np.sin(angles)[:, None] * second[:, None]
    approach = np.repeat(approach, 2, axis=1).reshape(-1, 3)
    closing = np.tile(np.stack([axis, -axis], axis=1), (1, steps, 1)).reshape(-1, 3)
    return np.repeat(kept[rows], 2 * steps), approach, closing


def _inwards(part: MedialAxis, symmetry: LocalSymmetry) -> Floats:
    """Across the rim towards the centroid of the neighbourhood, (n, 3) (P13 4.15)."""
    inwards = np.einsum("ij,ij->i", symmetry.e2, symmetry.centroid - part.centers)
    return np.asarray(np.where(inwards < 0.0, -1.0, 1.0)[:, None] * symmetry.e2)


def _buried(
    axis: MedialAxis, part: MedialAxis, across: Floats, rim: NDArray[np.bool_], radius: float
) -> Ints:
    """Rows at the end of a sheet of centres that is no rim of the object: no way from outside.

    The limit on the object angle cuts sheets off in the middle of thick bodies. Seen from there
    the object goes on for more than the neighbourhood, or begins again within it.
    """
    rows = np.flatnonzero(rim)
    depth, room = way_out(axis, part.centers[rows], -across[rows])
    return rows[(depth > part.radii[rows] + radius) | (room < radius)]


def _across_rims(
    part: MedialAxis, symmetry: LocalSymmetry, kept: Ints, rows: Ints, across: Floats
) -> Rows:
    """From outside across the rim (P13 4.4.2)."""
    rim = _outwards(symmetry.e1[rows], part, rows)
    closing = np.stack([rim, -rim], axis=1).reshape(-1, 3)
    return np.repeat(kept[rows], 2), np.repeat(across[rows], 2, axis=0), closing


def _outwards(directions: Floats, part: MedialAxis, rows: Ints) -> Floats:
    """Turn directions (n, 3), whose signs are arbitrary, away from the middle of all spheres.

    The order of a sphere's candidates then belongs to the object, not to the frame of its mesh.
    """
    away = part.centers[rows] - part.centers.mean(axis=0)
    return directions * np.where((directions * away).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]


def _joined(parts: list[Rows], axis: MedialAxis, fate: NDArray[np.int8]) -> CandidateGrasps:
    if not parts:
        parts = [(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3)))]
    sphere, approach, closing = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(sphere, kind="stable")
    sphere = sphere[order]
    return CandidateGrasps(
        grasp_point=axis.centers[sphere],
        approach=approach[order],
        closing_axis=closing[order],
        sphere=sphere,
        kind=fate[sphere],
        radius=axis.radii[sphere],
        fate=fate,
    )
