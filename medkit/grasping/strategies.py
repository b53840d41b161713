"""What planners are made of, by name: generators of candidates, draws, searches and closings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from operator import attrgetter
from typing import Any, cast

import trimesh

from medkit.errors import InputError
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.stopwatch import Stopwatch
from medkit.medial.axis import medial_axis
from medkit.robots.hand import Hand

#: Candidate generators by the name of their planner, as "module:function". Each is called as
#: ``(mesh, hand, *, grasp, search_radius, min_radius_ratio, watch) -> CandidateGrasps``.
CANDIDATE_SOURCES = {
    "medial": "medkit.grasping.strategies:medial_candidates",
    "medial-plus": "medkit.grasping.improved:improved_candidates",
    "normals": "medkit.grasping.baselines:normal_candidates",
    "boxes": "medkit.grasping.baselines:box_candidates",
}
#: Planners that draw their candidates in their own way, instead of `choose_candidates`.
CHOOSERS = {"medial-plus": "medkit.grasping.choosing:spread_candidates"}
#: Planners that test a candidate in their own way, called as ``(tester, hand)``.
REFINERS = {"medial-plus": "medkit.grasping.local_search:SearchingTester.around"}
#: Closing strategies by the kind of grasp, as "module:function". Each is called as
#: ``(hand, triangles, quality)`` and returns a `GraspTester`.
TESTERS = {
    "power": "medkit.grasping.testers:power_tester",
    "precision": "medkit.grasping.precision:precision_tester",
}


def looked_up(table: Mapping[str, str], name: str, what: str) -> Callable[..., Any]:
    """The function behind a name in a table of "module:function"; `InputError` if unknown."""
    if name not in table:
        known = ", ".join(sorted(table))
        raise InputError(f"Expected a {what} ({known}), but got {name!r}; name one of them.")
    module, _, function = table[name].partition(":")
    return cast(Callable[..., Any], attrgetter(function)(import_module(module)))


def medial_candidates(
    mesh: trimesh.Trimesh,
    hand: Hand,
    *,
    grasp: str,
    search_radius: float,
    min_radius_ratio: float,
    watch: Stopwatch,
) -> CandidateGrasps:
    """Candidates of the published planner (P13 algorithm 1)."""
    axis = medial_axis(mesh)
    watch.lap("medial")
    return candidates_from_axis(
        axis,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        hand_radii=radii_for(hand, grasp),
    )


def radii_for(hand: Hand, grasp: str) -> tuple[float, float]:
    """Radii of spheres that a hand can grasp [m]: pads hold what a closing fist cannot."""
    least = 0.0 if grasp == "precision" else hand.min_sphere_radius
    return least, hand.max_sphere_radius
