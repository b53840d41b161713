"""Planners: a generator of candidates times a closing strategy, then quality."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from operator import attrgetter
from typing import Any, cast

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, expected, nonnegative
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.grasp_set import Grasp, GraspSet, ObjectRecord
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.testers import MIN_CONTACTS as MIN_CONTACTS
from medkit.grasping.testers import GraspTester, warm_quality
from medkit.grasping.testers import PowerTester as PowerTester
from medkit.grasping.testers import Quality as Quality
from medkit.grasping.testers import judge as judge
from medkit.grasping.testers import power_tester as power_tester
from medkit.medial.axis import medial_axis
from medkit.meshes import mass_properties, refuse_wrong_scale
from medkit.meshes.loading import used_part
from medkit.meshes.repair import FLAT_VOLUME
from medkit.meshes.surfaces import signed_volume
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand

#: Candidates that are tested when nothing else is asked for (P13 5.1.3: about 300 an object).
DEFAULT_CANDIDATES = 400

Progress = Callable[[Iterable[Any], int], Iterable[Any]]


def plan_grasps(
    mesh: trimesh.Trimesh,
    hand: Hand | str,
    *,
    grasp: str = "power",
    planner: str = "medial",
    friction: float = 0.5,
    search_radius: float = 0.03,
    min_radius_ratio: float = 0.5,
    max_candidates: int | None = DEFAULT_CANDIDATES,
    rng: np.random.Generator,
    jobs: int = 1,
    progress: Progress | None = None,
) -> GraspSet:
    """Plan grasps of an object with a hand (P13 ch. 4 and 5.1).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m], as `medkit.meshes.repair_mesh` returns it.
    hand : Hand or str
        The hand, or its name for `medkit.robots.load_hand`.
    grasp : str
        Closing strategy, one of `TESTERS`: ``"power"`` or ``"precision"``.
    planner : str
        Generator of candidates, one of `CANDIDATE_SOURCES`: ``"medial"`` as published,
        ``"medial-plus"`` with the changes of `medkit.grasping.improved`, where one candidate is
        a local search over several closings, or a baseline.
    friction : float
        Friction coefficient of hard point contacts [1].
    search_radius : float
        Radius of the symmetry analysis, P13's r_N [m].
    min_radius_ratio : float
        Medial spheres below this share of the largest are dropped [1].
    max_candidates : int or None
        Candidates to test at most, those of spheres drawn with `rng`; None for all.
    rng : numpy.random.Generator
        Draws the spheres when there are more candidates than asked for.
    jobs : int
        Processes; the result does not depend on it.
    progress : callable, optional
        Called as ``progress(results, total)``, returns the iterable to walk, for a bar.

    Returns
    -------
    GraspSet
        Every tested candidate with its outcome.

    Raises
    ------
    InputError
        If an argument is of the wrong type or out of range, a name is unknown, or the mesh is
        in other units than metres, encloses no volume or is turned inside-out.
    """
    refuse_unusable(mesh)
    hand = usable_hand(hand)
    remedy = "pass rng=numpy.random.default_rng(0)"
    expected(rng, np.random.Generator, "a random generator as rng", remedy)
    nonnegative(friction, "friction")
    source = looked_up(CANDIDATE_SOURCES, planner, "planner")
    make_tester = looked_up(TESTERS, grasp, "kind of grasp")
    watch = Stopwatch()
    candidates = source(
        mesh,
        hand,
        grasp=grasp,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        watch=watch,
    )
    watch.lap("symmetry")
    choose = looked_up(CHOOSERS, planner, "planner") if planner in CHOOSERS else choose_candidates
    chosen = choose(candidates, max_candidates, rng)
    body = mass_properties(mesh)
    quality = Quality(friction, body.center_mass, body.torque_scale)
    tester = make_tester(hand, np.asarray(mesh.triangles, dtype=float), quality)
    if planner in REFINERS:
        tester = looked_up(REFINERS, planner, "planner")(tester, hand)
    processes = processes_for(len(chosen), jobs)
    if processes == 1:
        warm_up(tester, chosen)
    watch.lap("preparation")
    tested = tuple(run_candidates(tester, chosen, jobs=jobs, progress=progress))
    watch.lap("closing")
    return GraspSet(
        object=object_record(mesh, body.center_mass),
        hand=hand.name,
        planner=planner,
        grasp=grasp,
        joint_names=hand.joint_names,
        parameters={
            "friction": friction,
            "search_radius": search_radius,
            "min_radius_ratio": min_radius_ratio,
            "max_candidates": max_candidates,
        },
        seed=None,
        sphere_counts=candidates.fate_counts(),
        candidates_found=len(candidates),
        timing=watch.stages(quality=sum(spent for _, spent in tested), jobs=processes),
        grasps=tuple(one for one, _ in tested),
    )


def plan_power_grasps(
    mesh: trimesh.Trimesh,
    hand: Hand | str,
    *,
    friction: float = 0.5,
    search_radius: float = 0.03,
    min_radius_ratio: float = 0.5,
    max_candidates: int | None = DEFAULT_CANDIDATES,
    planner: str = "medial",
    rng: np.random.Generator,
    jobs: int = 1,
    progress: Progress | None = None,
) -> GraspSet:
    """Plan power grasps: `plan_grasps` with ``grasp="power"`` (P13 ch. 4, algorithms 1 to 5).

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> bar = trimesh.creation.capsule(0.15, 0.02)
    >>> found = plan_power_grasps(
    ...     bar, load_hand("armar3"), max_candidates=8, rng=np.random.default_rng(0)
    ... )
    >>> len(found), bool(found.force_closure.any())
    (8, True)
    """
    return plan_grasps(
        mesh,
        hand,
        grasp="power",
        planner=planner,
        friction=friction,
        search_radius=search_radius,
        min_radius_ratio=min_radius_ratio,
        max_candidates=max_candidates,
        rng=rng,
        jobs=jobs,
        progress=progress,
    )


def refuse_unusable(mesh: trimesh.Trimesh) -> None:
    """Refuse a mesh that planners could not use: `InputError` that says what to do."""
    remedy = (
        "read one with medkit.meshes.load_mesh(path), or take .mesh of what repair_mesh returns"
    )
    expected(mesh, trimesh.Trimesh, "a triangle mesh", remedy)
    if len(mesh.faces) == 0:
        raise InputError(
            "Expected a closed body, but the mesh holds no triangle; check the file, then plan on"
            " medkit.meshes.repair_mesh(mesh).mesh."
        )
    corners = np.asarray(mesh.vertices, dtype=float)[np.asarray(mesh.faces)]
    if not np.all(np.isfinite(corners)):
        raise InputError(
            "Expected finite vertex coordinates, but the mesh holds NaN or infinity;"
            " export it again."
        )
    refuse_flat(mesh)
    try:
        refuse_wrong_scale(mesh)
    except InputError as error:  # its remedy is an option of the command line
        advice = re.sub(r"--scale (\S+)", r"load_mesh(path, scale=\1)", str(error))
        raise InputError(advice) from None


def refuse_flat(mesh: trimesh.Trimesh) -> None:
    """Refuse a mesh of no volume, judged as `repair_mesh` does, or with inward normals."""
    surface = used_part(mesh)
    least = FLAT_VOLUME * float(np.linalg.norm(np.ptp(surface[0], axis=0))) ** 3
    volume = signed_volume(surface)
    if volume >= least > 0.0:
        return
    fault = "is inside-out" if volume <= -least < 0.0 else "encloses no volume"
    raise InputError(
        f"Expected a closed body with outward normals, but the mesh {fault};"
        " plan on medkit.meshes.repair_mesh(mesh).mesh."
    )


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


#: Candidate generators by the name of their planner, as "module:function". Each is called as
#: ``(mesh, hand, *, grasp, search_radius, min_radius_ratio, watch) -> CandidateGrasps``.
CANDIDATE_SOURCES = {
    "medial": "medkit.grasping.planners:medial_candidates",
    "medial-plus": "medkit.grasping.improved:improved_candidates",
    "normals": "medkit.grasping.baselines:normal_candidates",
    "boxes": "medkit.grasping.baselines:box_candidates",
}
#: Planners that draw their candidates in their own way, instead of `choose_candidates`.
CHOOSERS = {"medial-plus": "medkit.grasping.improved:spread_candidates"}
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


def choose_candidates(
    candidates: CandidateGrasps, most: int | None, rng: np.random.Generator
) -> CandidateGrasps:
    """At most so many candidates: all those of spheres drawn without replacement, in order.

    Spheres are numbered by their distance from the middle of all, so that the same ones are
    drawn however the object lies in its frame.
    """
    if most is not None and most < 1:
        raise InputError(f"Expected at least one candidate, but got {most}; give a larger number.")
    if most is None or len(candidates) <= most:
        return candidates
    number = sphere_numbers(candidates)
    place = np.argsort(rng.permutation(number.max() + 1))
    order = np.argsort(place[number], kind="stable")
    return candidates.select(np.sort(order[:most]))


def sphere_numbers(candidates: CandidateGrasps) -> NDArray[np.int64]:
    """Number (n,) of each candidate's sphere, counted by distance from the middle of all."""
    _, first, group = np.unique(candidates.sphere, return_index=True, return_inverse=True)
    points = candidates.grasp_point[first]
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return np.argsort(np.argsort(away, kind="stable"), kind="stable")[group]


def processes_for(count: int, jobs: int) -> int:
    """Number of processes that test `count` candidates when there may be `jobs`."""
    return jobs if jobs > 1 and count >= 2 * jobs else 1


def warm_up(tester: GraspTester, candidates: CandidateGrasps) -> None:
    """Test one candidate in vain, so that none of those that count waits for compiled kernels."""
    for _ in run_candidates(tester, candidates.select(np.arange(min(len(candidates), 1)))):
        warm_quality()


def run_candidates(
    tester: GraspTester,
    candidates: CandidateGrasps,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Iterator[tuple[Grasp, float]]:
    """Test candidates one after the other, in this process or in several; same order, same result.

    Parameters
    ----------
    tester : GraspTester
        Closes and judges one candidate after the other.
    candidates : CandidateGrasps
        The candidates.
    jobs : int
        Number of processes.
    progress : callable, optional
        Wraps the iterable of results.
    """
    rows = [
        (
            candidates.grasp_point[k],
            candidates.approach[k],
            candidates.closing_axis[k],
            float(candidates.radius[k]),
        )
        for k in range(len(candidates))
    ]
    if processes_for(len(rows), jobs) == 1:
        results: Iterable[tuple[Grasp, float]] = (tester.test(*row) for row in rows)
        yield from progress(results, len(rows)) if progress else results
        return
    from medkit.grasping.parallel import tested_in_processes

    results = tested_in_processes(tester, rows, jobs)
    yield from progress(results, len(rows)) if progress else results


def object_record(mesh: trimesh.Trimesh, center: Floats, **known: Any) -> ObjectRecord:
    """What is known of an object: hash of its arrays until a file is named."""
    digest = hashlib.sha256(np.ascontiguousarray(mesh.vertices, dtype="<f8").tobytes())
    digest.update(np.ascontiguousarray(mesh.faces, dtype="<i8").tobytes())
    record = ObjectRecord(
        path="",
        sha256=digest.hexdigest(),
        scale=1.0,
        extents=np.asarray(mesh.extents, dtype=float),
        center_mass=np.asarray(center, dtype=float),
    )
    return replace(record, **known)


def with_origin(found: GraspSet, *, seed: int | None, **known: Any) -> GraspSet:
    """The same result with the file, scale and repairs of its object, and the seed."""
    return replace(found, seed=seed, object=replace(found.object, **known))
