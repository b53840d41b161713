"""``medial-plus``: the published candidates, guided by touch points and free space (not in P13).

Four changes, each for a reason that holds for every object and hand: the fingers of a power grasp
straddle the two touch points of a sphere; a candidate is dropped before any closing where palm or
fingers would stand in the object, or where the sphere is a detail of a thicker part; candidates are
drawn one by one instead of sphere by sphere; and each is tried in a few ways, the published one
first. The last is a local search: one candidate of this planner costs four or five closings of the
published one.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, unit
from medkit.grasping.candidates import CandidateGrasps, SphereFate, candidates_from_axis
from medkit.grasping.grasp_set import START_COLLISION, Grasp
from medkit.grasping.planners import radii_for, sphere_numbers
from medkit.grasping.power import PowerCloser
from medkit.grasping.reach import blocked, local_thickness, way_out
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.testers import PowerTester
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
#: How far a power grasp stands back from where the palm meets the object, as shares of the
#: largest radius that the hand encloses.
STAND_BACK = (1.0 / 3.0, 2.0 / 3.0, 1.0)
#: How much wider the pads open than published, beside thin parts they need room; and how far they
#: stand back, as a share of that radius.
WIDE, PAD_BACK = 1.5, 0.2


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
        The published ones where all are blocked.

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
    # where no way is free, the published ones: the closing tells what they are worth
    return published


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
    """Where the fingers of each candidate go, on both sides of its sphere, (m, 18, 3) [m]."""
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


def spread_candidates(
    candidates: CandidateGrasps, most: int | None, rng: np.random.Generator
) -> CandidateGrasps:
    """At most so many candidates, drawn one by one and evenly from all.

    The published planner draws spheres and takes all candidates of each: few spheres, many alike.
    Spheres are numbered by their distance from the middle of all, so that the same ones are drawn
    in whatever order they come.
    """
    if most is not None and most < 1:
        raise InputError(f"Expected at least one candidate, but got {most}; give a larger number.")
    if most is None or len(candidates) <= most:
        return candidates
    order = np.argsort(sphere_numbers(candidates), kind="stable")
    drawn = order[rng.permutation(len(candidates))[:most]]
    return candidates.select(np.sort(drawn))


class SearchingTester:
    """Tests each candidate in a few ways and keeps the best.

    Parameters
    ----------
    tester : object
        What tests one of them: `PowerTester` or `PrecisionTester`.
    room : float
        Largest radius that the hand encloses [m].
    """

    def __init__(self, tester: Any, room: float) -> None:
        self.tester = tester
        self.room = room
        self.power = isinstance(tester, PowerTester)
        self.other = _fingers_reversed(tester) if self.power else _wider_open(tester)
        self._finger_of = tester.closer.hand.finger_of_link()

    @classmethod
    def around(cls, tester: Any, hand: Hand) -> SearchingTester:
        """Search with a hand's own room."""
        return cls(tester, hand.max_sphere_radius)

    def parts(self) -> dict[str, Any]:
        """What another process needs to build the same tester."""
        return {"type": type(self.tester), "parts": self.tester.parts(), "room": self.room}

    @classmethod
    def from_parts(cls, parts: Mapping[str, Any]) -> SearchingTester:
        """Build a tester from `parts`."""
        return cls(parts["type"].from_parts(parts["parts"]), parts["room"])

    def test(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> tuple[Grasp, float]:
        """The best of the tried grasps, the first among equals, and the time of all qualities."""
        first, spent = self.tester.test(point, approach, closing_axis, radius)
        tried, times = [first], [spent]
        for tester, step in self._ways(first):
            grasp, spent = tester.test(point + step * approach, approach, closing_axis, radius)
            tried.append(grasp)
            times.append(spent)
        best = max(tried, key=lambda grasp: grasp.epsilon)
        return replace(best, grasp_point=point), sum(times)

    def _ways(self, first: Grasp) -> list[tuple[Any, float]]:
        """What to try after the published grasp: testers, and how far the point moves [m]."""
        if not self.power:
            back = -PAD_BACK * self.room
            return [(self.other, 0.0), (self.tester, back), (self.other, back)]
        if first.outcome == START_COLLISION:
            return []
        ways = [(self.tester, step) for step in self._steps(first)]
        touching = {self._finger_of.get(name) for name in first.links}
        idle = len(touching - {None}) < len(self.tester.closer.hand.fingers)
        return [*ways, (self.other, 0.0)] if idle else ways

    def _steps(self, first: Grasp) -> list[float]:
        """How far to move the point along the approach [m] to stand back from the object.

        A power grasp ends with the palm on the object: a deeper point ends there as well, and one
        less deep only counts from where the hand was drawn back to.
        """
        palm = (first.pose @ self.tester.closer.hand.T_hand_power)[:3, 3]
        drawn_back = float((first.grasp_point - palm) @ first.approach)
        return [-drawn_back - share * self.room for share in STAND_BACK]


def _fingers_reversed(tester: PowerTester) -> PowerTester:
    """The same tests with the fingers closing in reverse order: one may have barred another."""
    closer = tester.closer
    order = tuple(finger.name for finger in closer.hand.fingers)[::-1]
    return PowerTester(PowerCloser(closer.hand, closer.field, finger_order=order), tester.quality)


def _wider_open(tester: Any) -> Any:
    """The same precision tests with the pads further apart."""
    wide = copy(tester)
    wide.closer = copy(tester.closer)
    wide.closer.opening_factor = WIDE * tester.closer.opening_factor
    return wide


def _together(first: CandidateGrasps, second: CandidateGrasps) -> CandidateGrasps:
    """Both, in the order of the spheres."""
    order = np.argsort(np.concatenate([first.sphere, second.sphere]), kind="stable")
    names = ("grasp_point", "approach", "closing_axis", "sphere", "kind", "radius")
    columns = {
        name: np.concatenate([getattr(first, name), getattr(second, name)])[order] for name in names
    }
    return replace(first, **columns)
