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
    "boxes": "medkit.grasping.box_baseline:box_candidates",
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
    """The function behind a name in a table of "module:function".

    Parameters
    ----------
    table : mapping of str to str
        For example `CANDIDATE_SOURCES` or `TESTERS`.
    name : str
        A key of it.
    what : str
        What the names stand for, for the message: "planner".

    Returns
    -------
    callable
        The function, or a method as "module:Class.method"; its module is imported now.

    Raises
    ------
    InputError
        If there is no such name.

    Examples
    --------
    >>> looked_up(TESTERS, "power", "kind of grasp").__name__
    'power_tester'
    >>> looked_up(TESTERS, "fist", "kind of grasp")
    Traceback (most recent call last):
        ...
    medkit.errors.InputError: Expected a kind of grasp (power, precision), but got 'fist'; name \
one of them.
    """
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
    """Candidates of the published planner (P13 4.4, algorithm 1).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand
        Says which spheres are too large or too small.
    grasp : str
        Kind of grasp, see `radii_for`.
    search_radius : float
        Radius of the symmetry analysis, P13's r_N [m].
    min_radius_ratio : float
        Medial spheres below this share of the largest are dropped [1].
    watch : Stopwatch
        Gets a lap "medial".

    Returns
    -------
    CandidateGrasps
        All candidates, object frame, and the fate of every medial sphere.

    Raises
    ------
    InputError
        If the radius or the ratio is out of range.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> found = medial_candidates(
    ...     trimesh.creation.capsule(0.15, 0.02), load_hand("armar3"), grasp="power",
    ...     search_radius=0.03, min_radius_ratio=0.5, watch=Stopwatch(),
    ... )  # fmt: skip
    >>> len(found) > 100, found.grasp_point.shape == found.approach.shape == (len(found), 3)
    (True, True)
    """
    axis = medial_axis(mesh)
    watch.lap("medial")
    return candidates_from_axis(
        axis,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        hand_radii=radii_for(hand, grasp),
    )


def radii_for(hand: Hand, grasp: str) -> tuple[float, float]:
    """Radii of spheres that a hand can grasp: pads hold what a closing fist cannot.

    Parameters
    ----------
    hand : Hand
        The hand.
    grasp : str
        With ``"precision"`` there is no smallest sphere.

    Returns
    -------
    tuple of float
        Smallest and largest radius [m].

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> hand = load_hand("armar3")
    >>> radii_for(hand, "power"), radii_for(hand, "precision")
    ((0.005, 0.047), (0.0, 0.047))
    """
    least = 0.0 if grasp == "precision" else hand.min_sphere_radius
    return least, hand.max_sphere_radius
