"""``medial-plus``: the published candidates, guided by touch points and free space (not in P13).

Four changes, each for a reason that holds for every object and hand: the fingers of a power grasp
straddle the two touch points of a sphere; a candidate is dropped before any closing where palm or
fingers would stand in the object, or where the sphere is a detail of a thicker part; candidates are
drawn one by one instead of sphere by sphere; and each is tried in a few ways, the published one
first, and beside it where none of them holds. The last is a local search (see `local_search`): one
candidate of this planner costs about five closings of the published one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats, unit
from medkit.grasping.candidate_set import CandidateGrasps, SphereFate
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.reach import blocked, local_thickness, way_out
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.strategies import radii_for
from medkit.medial.axis import MedialAxis, medial_axis
from medkit.medial.surface import sample_surface
from medkit.robots.hand import Hand

if TYPE_CHECKING:
    import trimesh

#: Approach directions around a symmetry axis; P13 takes four.
AXIS_STEPS = 8
#: Turns of a rim's approach about the chord between its touch points [rad].
RIM_TURNS = np.radians([-45.0, 0.0, 45.0])
#: Half the width of the way that the palm needs, over the largest radius that the hand encloses.
PALM_SHARE = 0.5
#: Candidates that are looked at; P13 tests about 300 an object.
MOST = 4000
#: Half the thickness of a finger, over that radius.
FINGER_SHARE = 0.2
#: Half the distance of the outer fingers, over that radius; where a hand as wide as it is finds no
#: room, a narrower one, and in the end a single finger a side.
WIDTHS = (0.4, 0.2, 0.0)
#: A sphere whose centre lies in another one so many times as large is a detail of a thicker part.
DETAIL = 1.5


def improved_candidates(
    mesh: trimesh.Trimesh,
    hand: Hand,
    *,
    grasp: str,
    search_radius: float,
    min_radius_ratio: float,
    watch: Stopwatch,
) -> CandidateGrasps:
    """Candidates of ``medial-plus``, in the form that the planners call.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand
        Gives the radii that it can grasp.
    grasp : str
        ``"power"`` or ``"precision"``.
    search_radius, min_radius_ratio
        See `candidates_from_axis`.
    watch : Stopwatch
        Books the time of the medial axis.

    Returns
    -------
    CandidateGrasps
        In the order of the spheres; spheres whose every approach is blocked keep their fate.
        Where all are blocked, the published ones, without those in parts much too thick.

    Notes
    -----
    No published source; the straddled touch points carry P13's remark in 4.4.4 over to rims.
    """
    axis = medial_axis(mesh)
    watch.lap("medial")
    published = candidates_from_axis(
        axis,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        hand_radii=radii_for(hand, grasp),
        axis_steps=AXIS_STEPS,
    )
    found = _thinned(straddle(published, axis) if grasp == "power" else published)
    surface = sample_surface(mesh).points
    for width in WIDTHS:
        met = conditions_met(found, axis, surface, room=hand.max_sphere_radius, width=width)
        if met.any():
            return found.select(np.flatnonzero(met))
    # where no way is free, the published ones, but for details of what no hand encloses: the
    # closing tells what they are worth
    thickness = local_thickness(axis, published.grasp_point)
    return published.select(np.flatnonzero(thickness <= DETAIL * hand.max_sphere_radius))


def _thinned(found: CandidateGrasps) -> CandidateGrasps:
    """Those of every so-manieth sphere, where there are many more than anyone tests."""
    spheres = np.unique(found.sphere)
    stride = -(-len(found) // MOST) if len(found) else 1
    return found.select(np.flatnonzero(np.isin(found.sphere, spheres[::stride])))


def conditions_met(
    found: CandidateGrasps, axis: MedialAxis, surface: Floats, *, room: float, width: float = 0.0
) -> NDArray[np.bool_]:
    """Whether the hand has room at each candidate, judged without closing it.

    Parameters
    ----------
    found : CandidateGrasps
        Candidates.
    axis : MedialAxis
        All spheres of the object.
    surface : ndarray, shape (n, 3)
        Samples of the surface [m].
    room : float
        Largest radius that the hand encloses [m].
    width : float
        Half the distance of the outer fingers along the closing axis, over `room` [1].

    Returns
    -------
    ndarray of bool, shape (m,)
        True where the sphere is no detail of a thicker part, the palm comes from outside and as
        near as the hand encloses, and nothing stands where the fingers go.
    """
    detail = local_thickness(axis, found.grasp_point) > DETAIL * found.radius
    met = ~detail
    rows = np.flatnonzero(met)
    depth, behind = way_out(axis, found.grasp_point[rows], -found.approach[rows])
    met[rows] = np.isinf(behind) & (depth <= found.radius[rows] + room)
    rows = np.flatnonzero(met)
    back = depth_of_object(
        surface, found.grasp_point[rows], found.approach[rows], width=PALM_SHARE * room
    )
    met[rows] = back <= room
    rows = np.flatnonzero(met)
    met[rows] = ~blocked(axis, finger_places(found.select(rows), room, width))
    return met


def finger_places(found: CandidateGrasps, room: float, width: float = 0.0) -> Floats:
    """Where the fingers of each candidate go, on both sides of its sphere.

    Parameters
    ----------
    found : CandidateGrasps
        m candidates.
    room : float
        Length by which fingers reach and stand off, radius of the hand's largest ball [m].
    width : float
        Half the distance of the outer fingers along the closing axis, over `room` [1].

    Returns
    -------
    ndarray, shape (m, 18, 3)
        Two sides times three depths times three places along the closing axis, object frame [m].

    Examples
    --------
    >>> x, y, z = np.eye(3)[:, None]
    >>> one = CandidateGrasps(
    ...     np.zeros((1, 3)), x, z, np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int8),
    ...     np.array([0.02]), np.zeros(1, dtype=np.int8),
    ... )  # fmt: skip
    >>> places = finger_places(one, 0.05)[0]
    >>> places.shape, bool(np.all(places @ x[0] <= 0.0)), bool(np.all(abs(places @ y[0]) > 0.02))
    ((18, 3), True, True)
    """
    side = np.cross(found.approach, found.closing_axis)
    aside = (found.radius + FINGER_SHARE * room)[:, None] * side
    places = [
        found.grasp_point + sign * aside - back * room * found.approach + along * found.closing_axis
        for sign in (1.0, -1.0)
        for back in (1.0, 0.5, 0.0)
        for along in (-width * room, 0.0, width * room)
    ]
    return np.stack(places, axis=1)


def straddle(found: CandidateGrasps, axis: MedialAxis) -> CandidateGrasps:
    """Turn the hand at rims so that the fingers close across the chord of the touch points.

    Parameters
    ----------
    found : CandidateGrasps
        Published candidates.
    axis : MedialAxis
        The spheres that they are from.

    Returns
    -------
    CandidateGrasps
        Each candidate of a rim in several turns about the chord, at right angles to it; the
        closing axis is at right angles to both. Others stay.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import candidates_from_axis, medial_axis
    >>> axis = medial_axis(trimesh.creation.box([0.02, 0.12, 0.16]))
    >>> found = straddle(candidates_from_axis(axis, search_radius=0.03), axis)
    >>> chord = np.diff(axis.touch_points[found.sphere], axis=1)[:, 0]
    >>> rim = found.kind == SphereFate.RIM
    >>> bool(abs((chord * found.approach).sum(axis=1)[rim]).max() < 1e-9)
    True
    """
    rim = found.kind == SphereFate.RIM
    rows = np.flatnonzero(rim)
    touch = axis.touch_points[found.sphere[rows]]
    chord = unit(touch[:, 1] - touch[:, 0])
    along = np.einsum("ij,ij->i", found.approach[rows], chord)
    clear = np.abs(along) < np.cos(np.radians(30.0))
    rows, chord, along = rows[clear], chord[clear], along[clear]
    ahead = unit(found.approach[rows] - along[:, None] * chord)
    side = np.cross(ahead, chord)
    side *= np.where(np.einsum("ij,ij->i", side, found.closing_axis[rows]) < 0.0, -1.0, 1.0)[
        :, None
    ]
    cos, sin = np.cos(RIM_TURNS)[None, :, None], np.sin(RIM_TURNS)[None, :, None]
    approach = (cos * ahead[:, None] + sin * side[:, None]).reshape(-1, 3)
    closing = (cos * side[:, None] - sin * ahead[:, None]).reshape(-1, 3)
    turned = replace(
        found.select(np.repeat(rows, len(RIM_TURNS))), approach=approach, closing_axis=closing
    )
    return _together(found.select(np.flatnonzero(~rim)), turned)


def depth_of_object(points: Floats, centers: Floats, approach: Floats, *, width: float) -> Floats:
    """How far the object reaches from each centre against the approach.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Samples of the surface [m].
    centers, approach : ndarray, shape (m, 3)
        Grasp points [m] and unit directions.
    width : float
        Half the width of the way that has to be free [m].

    Returns
    -------
    ndarray, shape (m,)
        Largest distance [m] against the approach of samples within `width` of its line: as near
        the palm can come. Zero where the line meets no sample.

    Examples
    --------
    >>> wall = np.array([[0.0, 0.0, -0.2], [0.3, 0.0, -0.5]])
    >>> depth_of_object(wall, np.zeros((1, 3)), np.array([[0, 0, 1.0]]), width=0.1).tolist()
    [0.2]
    """
    depth = np.zeros(len(centers))
    for k in range(len(centers)):
        away = points - centers[k]
        back = -(away @ approach[k])
        across = np.einsum("ij,ij->i", away, away) - back**2
        depth[k] = back[across < width**2].max(initial=0.0)
    return depth


def _together(first: CandidateGrasps, second: CandidateGrasps) -> CandidateGrasps:
    """Both, in the order of the spheres."""
    order = np.argsort(np.concatenate([first.sphere, second.sphere]), kind="stable")
    names = ("grasp_point", "approach", "closing_axis", "sphere", "kind", "radius")
    columns = {
        name: np.concatenate([getattr(first, name), getattr(second, name)])[order] for name in names
    }
    return replace(first, **columns)
