"""``medial-plus``: the published candidates, guided by touch points and free space (not in P13).

Four changes, each for a reason that holds for every object and hand: the fingers straddle the two
touch points of a sphere; the palm comes only from where nothing is in its way; candidates are drawn
one by one instead of sphere by sphere; and each is tried at a few distances from the palm, the
published one first. The last is a local search: one candidate of this planner costs several
closings of the published one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats, unit
from medkit.grasping.candidates import CandidateGrasps, SphereFate, candidates_from_axis
from medkit.grasping.grasp_set import START_COLLISION, Grasp
from medkit.grasping.planners import sphere_numbers
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
#: How far a power grasp stands back from where the palm meets the object, as shares of the
#: largest radius that the hand encloses.
STAND_BACK = (1.0 / 3.0, 2.0 / 3.0, 1.0)
#: Where the point of a precision grasp goes along the approach, as shares of the largest radius
#: that the hand encloses less the sphere's own.
PAD_DEPTHS = (1.0, -0.5)


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
    least = 0.0 if grasp == "precision" else hand.min_sphere_radius
    published = candidates_from_axis(
        axis,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        hand_radii=(least, hand.max_sphere_radius),
        axis_steps=AXIS_STEPS,
    )
    found = straddle(published, axis)
    depth = depth_of_object(
        sample_surface(mesh).points,
        found.grasp_point,
        found.approach,
        width=PALM_SHARE * hand.max_sphere_radius,
    )
    free = depth <= hand.max_sphere_radius
    # where no way is free, the published ones: the closing tells what they are worth
    return found.select(np.flatnonzero(free)) if free.any() else published


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
    """Tests each candidate at a few depths in the palm and keeps the best.

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
        for step in self._steps(first, radius):
            moved = point + step * approach
            grasp, spent = self.tester.test(moved, approach, closing_axis, radius)
            tried.append(grasp)
            times.append(spent)
        best = max(tried, key=lambda grasp: grasp.epsilon)
        return replace(best, grasp_point=point), sum(times)

    def _steps(self, first: Grasp, radius: float) -> list[float]:
        """How far to move the point along the approach [m] after the grasp of the published one.

        A power grasp ends with the palm on the object: a deeper point ends there as well, and one
        less deep only counts from where the hand was drawn back to.
        """
        if not isinstance(self.tester, PowerTester):
            return [share * max(self.room - radius, 0.0) for share in PAD_DEPTHS]
        if first.outcome == START_COLLISION:
            return []
        palm = (first.pose @ self.tester.closer.hand.T_hand_power)[:3, 3]
        drawn_back = float((first.grasp_point - palm) @ first.approach)
        return [-drawn_back - share * self.room for share in STAND_BACK]


def _together(first: CandidateGrasps, second: CandidateGrasps) -> CandidateGrasps:
    """Both, in the order of the spheres."""
    order = np.argsort(np.concatenate([first.sphere, second.sphere]), kind="stable")
    names = ("grasp_point", "approach", "closing_axis", "sphere", "kind", "radius")
    columns = {
        name: np.concatenate([getattr(first, name), getattr(second, name)])[order] for name in names
    }
    return replace(first, **columns)
