"""Balls, solids with one dominant inscribed sphere, and sheets seen whole (P13 4.4.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats, perpendicular, unit
from medkit.grasping.candidate_set import Ints, SphereFate
from medkit.medial.axis import MedialAxis
from medkit.medial.symmetry import LocalSymmetry, SymmetryKind

Rows = tuple[Ints, Floats, Floats]  # sphere, approach, closing axis

#: Centres spread less than this share of the radius belong to one dominant sphere.
COMPACT = 0.1
#: A sphere on the straight border of a sheet is so far from the centroid of its neighbourhood, a
#: half-disc, in standard deviations along it: 4 R / 3 pi over R / 2.
ON_BORDER = 8.0 / (3.0 * np.pi)

#: Touch points count as opposing when the angle between them is within this of 180 deg [rad].
OPPOSING = np.radians(12.0)
#: Chords closer than this are one [rad].
SAME_CHORD = np.radians(25.0)
#: More distinct chords than this: the solid is a ball for all that matters to the hand. An
#: icosahedron has ten.
MOST_CHORDS = 10
#: Directions around a chord.
STEPS = 4
#: Approach directions of a ball, and turns of the hand about each.
BALL_DIRECTIONS, BALL_ROLLS = 16, 4


def solid_candidates(
    axis: MedialAxis,
    part: MedialAxis,
    fate: NDArray[np.int8],
    kept: Ints,
    search_radius: float,
) -> list[Rows]:
    """One sphere for each heap of coinciding ones, as a ball or by its opposing touch points."""
    parts: list[Rows] = []
    left = kept[fate[kept] == SphereFate.BALL]
    row_of = {int(sphere): row for row, sphere in enumerate(kept)}
    outer = outer_touch(part)
    while len(left):
        rows = np.array([row_of[int(sphere)] for sphere in left])
        # the widest pair of touch points, and among equals the inscribed sphere
        wide = (-part.radii[rows], -part.object_angles[rows].round(6))
        first = rows[np.lexsort(wide)[0]]
        away = np.linalg.norm(part.centers[rows] - part.centers[first], axis=1)
        heap = rows[away <= search_radius]
        fate[kept[heap]] = SphereFate.REPRESENTED
        touch = part.touch_points[heap].reshape(-1, 3)
        all_touch = np.concatenate([touch, _touches_about(axis, part, first)])
        chords = opposing_chords(all_touch - part.centers[first], part.radii[first])
        fate[kept[first]] = SphereFate.DOMINANT_SPHERE if len(chords) else SphereFate.BALL
        other = touch[
            np.linalg.norm(np.cross(touch - part.centers[first], outer[first]), axis=1).argmax()
        ]
        approach, closing = ball_directions(chords, (outer[first], other - part.centers[first]))
        parts.append((np.full(len(approach), kept[first]), approach, closing))
        left = left[away > search_radius]
    return parts


def _touches_about(axis: MedialAxis, part: MedialAxis, row: int) -> Floats:
    """Touch points (n, 3) of all spheres that nearly coincide with one of `part`.

    A sphere knows the two touch points that are widest apart and no others. The further faces
    of a cube are touched by spheres about its middle whose own two points lie on faces that
    meet: too narrow to bear candidates, but they touch the solid as well.
    """
    away = np.linalg.norm(axis.centers - part.centers[row], axis=1)
    return axis.touch_points[away <= COMPACT * part.radii[row]].reshape(-1, 3)


def outer_touch(part: MedialAxis) -> Floats:
    """From each centre to that of its two touch points that is further from the middle (n, 3)."""
    touch = part.touch_points - part.centers[:, None]
    away = part.centers - part.centers.mean(axis=0)
    inner = (touch[:, 0] * away).sum(axis=1) < (touch[:, 1] * away).sum(axis=1)
    return np.where(inner[:, None], touch[:, 1], touch[:, 0])


def borders_of_whole_sheets(symmetry: LocalSymmetry, centers: Floats) -> LocalSymmetry:
    """Find the rims of sheets so small that every neighbourhood holds the whole of one.

    There rho tells the shape of the sheet and not where on it a sphere lies: a flat box the size
    of the hand would be the inside of a sheet all over, and have no candidates.

    Parameters
    ----------
    symmetry : LocalSymmetry
        All spheres of an object; returned as it is where any bears candidates.
    centers : ndarray, shape (n, 3)
        Their centres [m].

    Returns
    -------
    LocalSymmetry
        The same with spheres as far from the centroid of their neighbourhood as a straight border
        would be as `SymmetryKind.RIM`, ``e2`` towards the centroid.

    Notes
    -----
    No published source: P13 4.3 takes the search radius small against the sheets.
    """
    inside = symmetry.kind == SymmetryKind.INTERIOR
    if not inside.any() or (~inside & (symmetry.kind != SymmetryKind.TOO_FEW)).any():
        return symmetry
    offset = symmetry.centroid - centers
    normal = np.cross(symmetry.e1, symmetry.e2)
    offset -= np.einsum("ij,ij->i", offset, normal)[:, None] * normal
    away = np.linalg.norm(offset, axis=1)
    rows = np.flatnonzero(inside & (away >= ON_BORDER * np.sqrt(symmetry.lambdas[:, 0])))
    kind, e1, e2 = symmetry.kind.copy(), symmetry.e1.copy(), symmetry.e2.copy()
    kind[rows] = SymmetryKind.RIM
    e2[rows] = offset[rows] / away[rows, None]
    e1[rows] = np.cross(e2[rows], normal[rows])
    return replace(symmetry, kind=kind, e1=e1, e2=e2)


def opposing_chords(touch: Floats, radius: float) -> Floats:
    """Directions in which a sphere touches on both sides.

    Parameters
    ----------
    touch : ndarray, shape (n, 3)
        Touch points relative to the sphere's centre [m].
    radius : float
        The sphere's radius [m]; touch points further than a tenth from it are left out.

    Returns
    -------
    ndarray, shape (c, 3)
        Unit chord directions, no two the same, that of the nearest touch first; none for a ball,
        which touches everywhere.

    Examples
    --------
    >>> cube = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    >>> len(opposing_chords(cube, 1.0))
    3
    """
    length = np.linalg.norm(touch, axis=1)
    near = np.abs(length - radius) < 0.1 * radius
    # the foot of a face is the nearest of its points
    order = np.flatnonzero(near)[np.argsort(length[near], kind="stable")]
    directions = touch[order] / length[order, None]
    opposed = (directions @ directions.T).min(axis=1, initial=1.0) <= -np.cos(OPPOSING)
    chords: list[Floats] = []
    for direction in directions[opposed]:
        if all(abs(direction @ chord) < np.cos(SAME_CHORD) for chord in chords):
            chords.append(direction)
        if len(chords) > MOST_CHORDS:
            return np.zeros((0, 3))
    return np.array([_middle(directions, chord) for chord in chords]).reshape(-1, 3)


def _middle(directions: Floats, chord: Floats) -> Floats:
    """Mean (3,) of the directions (n, 3) that are one chord, whichever end they point to.

    Samples lie about the foot of a face, seldom on it; their mean goes square across the face.
    """
    along = directions @ chord
    same = np.abs(along) >= np.cos(SAME_CHORD)
    return unit((np.sign(along[same])[:, None] * directions[same]).mean(axis=0))


def even_directions(count: int) -> Floats:
    """Directions spread evenly over the sphere, always the same ones (a Fibonacci lattice).

    Parameters
    ----------
    count : int
        How many.

    Returns
    -------
    ndarray, shape (count, 3)
        Unit directions, in an order in which the first few are spread as well.

    Examples
    --------
    >>> bool(abs(even_directions(20).mean(axis=0)).max() < 0.05)
    True
    """
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    place = np.arange(count)
    height = 1.0 - (2.0 * place + 1.0) / count
    turn = 2.0 * np.pi * golden * place
    width = np.sqrt(1.0 - height**2)
    lattice = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    # from pole to pole in strides of the golden ratio, so that a part of them is spread too
    return lattice[np.argsort((place * golden) % 1.0, kind="stable")]


def ball_directions(
    chords: Floats, seen: tuple[Floats, Floats] | None = None
) -> tuple[Floats, Floats]:
    """Approach directions and closing axes for one sphere that stands for its solid.

    Parameters
    ----------
    chords : ndarray, shape (c, 3)
        Its opposing touch directions. With none the solid is a ball, and directions come from
        all around, each with several turns of the hand: see `even_directions`.
    seen : tuple of two ndarrays, shape (3,), optional
        Two directions of the solid, to which the directions are tied so that they turn with it.
        The axes of the frame when left out.

    Returns
    -------
    approach, closing_axis : ndarrays, shape (n, 3)
        Unit directions. With chords the approach lies in the plane normal to a chord, along
        other chords where there are any, and the fingers close across the chord.
    """
    frame = np.eye(3) if seen is None else _frame(*seen)
    if not len(chords):
        approach = even_directions(BALL_DIRECTIONS)
        first = perpendicular(approach)
        second = np.cross(approach, first)
        turns = 2.0 * np.pi * np.arange(BALL_ROLLS) / BALL_ROLLS
        axes = np.cos(turns)[:, None] * first[:, None] + np.sin(turns)[:, None] * second[:, None]
        return np.repeat(approach, BALL_ROLLS, axis=0) @ frame.T, axes.reshape(-1, 3) @ frame.T
    rows = []
    for k, chord in enumerate(chords):
        others = np.delete(chords, k, axis=0)
        others = others - np.outer(others @ chord, chord)
        long = np.linalg.norm(others, axis=1) > 0.5
        start = unit(others[long][0]) if long.any() else frame @ perpendicular(frame.T @ chord)
        for angle in 2.0 * np.pi * np.arange(STEPS) / STEPS:
            approach = np.cos(angle) * start + np.sin(angle) * np.cross(chord, start)
            closing = np.cross(chord, approach)
            rows += [(approach, closing), (approach, -closing)]
    return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])


def _frame(first: Floats, second: Floats) -> Floats:
    """Right-handed unit axes as columns (3, 3), the first along `first`, the second near `second`.

    Where the two are parallel, any axes do.
    """
    x = unit(first)
    across = np.cross(x, second)
    if np.linalg.norm(across) < 1e-6 * np.linalg.norm(second):
        across = perpendicular(x)
    z = unit(across)
    return np.stack([x, np.cross(z, x), z], axis=1)
