"""Planners: a generator of candidates times a closing strategy, then quality."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
import trimesh

from medkit.geometry import Floats, expected, nonnegative
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.choosing import choose_candidates
from medkit.grasping.grasp_set import Grasp, GraspSet, ObjectRecord
from medkit.grasping.parallel import Progress, processes_for, run_candidates
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.strategies import CANDIDATE_SOURCES, CHOOSERS, REFINERS, TESTERS, looked_up
from medkit.grasping.testers import GraspTester, Quality, warm_quality
from medkit.meshes import mass_properties
from medkit.meshes.usable import refuse_unusable
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand

#: Candidates that are tested when nothing else is asked for (P13 5.1.3: about 300 an object).
DEFAULT_CANDIDATES = 400


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
        Generator of candidates, one of `strategies.CANDIDATE_SOURCES`: ``"medial"`` as published,
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

    Examples
    --------
    >>> import trimesh
    >>> rod = trimesh.creation.capsule(0.12, 0.012)
    >>> rng = np.random.default_rng(0)
    >>> found = plan_grasps(rod, "wsg50", grasp="precision", max_candidates=4, rng=rng)
    >>> len(found), found.hand, found.grasp, sum(found.outcomes.values())
    (4, 'wsg50', 'precision', 4)
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

    def prepared() -> GraspTester:
        tester = make_tester(hand, np.asarray(mesh.triangles, dtype=float), quality)
        if planner in REFINERS:
            tester = looked_up(REFINERS, planner, "planner")(tester, hand)
        return cast(GraspTester, tester)

    tested = _tested(chosen, prepared, jobs=jobs, progress=progress, watch=watch)
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
        timing=watch.stages(
            quality=sum(spent for _, spent in tested), jobs=processes_for(len(chosen), jobs)
        ),
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

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand or str
        The hand, or its name.
    friction : float
        Friction coefficient of hard point contacts [1].
    search_radius : float
        Radius of the symmetry analysis, P13's r_N [m].
    min_radius_ratio : float
        Medial spheres below this share of the largest are dropped [1].
    max_candidates : int or None
        Candidates to test at most; None for all.
    planner : str
        Generator of candidates, see `plan_grasps`.
    rng : numpy.random.Generator
        Draws the spheres when there are more candidates than asked for.
    jobs : int
        Processes; the result does not depend on it.
    progress : callable, optional
        See `plan_grasps`.

    Returns
    -------
    GraspSet
        Every tested candidate with its outcome, in the object frame.

    Raises
    ------
    InputError
        As `plan_grasps`.

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


def _tested(
    chosen: CandidateGrasps,
    prepared: Callable[[], GraspTester],
    *,
    jobs: int,
    progress: Progress | None,
    watch: Stopwatch,
) -> tuple[tuple[Grasp, float], ...]:
    """Prepare hand and object, then test; without a candidate nothing is prepared for it."""
    if not len(chosen):
        watch.lap("preparation")
        return tuple(progress((), 0)) if progress else ()
    tester = prepared()
    if processes_for(len(chosen), jobs) == 1:
        warm_up(tester, chosen)
    watch.lap("preparation")
    tested = tuple(run_candidates(tester, chosen, jobs=jobs, progress=progress))
    watch.lap("closing")
    return tested


def warm_up(tester: GraspTester, candidates: CandidateGrasps) -> None:
    """Test one candidate in vain, so that none of those that count waits for compiled kernels.

    Parameters
    ----------
    tester : GraspTester
        Closes the hand and judges the result.
    candidates : CandidateGrasps
        The first of them is tested; with none, nothing happens.
    """
    for _ in run_candidates(tester, candidates.select(np.arange(min(len(candidates), 1)))):
        warm_quality()


def object_record(mesh: trimesh.Trimesh, center: Floats, **known: Any) -> ObjectRecord:
    """What is known of an object: hash of its arrays until a file is named.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The object [m].
    center : ndarray, shape (3,)
        Its centre of mass, object frame [m].
    **known : object
        Fields of `ObjectRecord` that are known better: path, sha256, scale, repairs.

    Returns
    -------
    ObjectRecord
        The record; `sha256` is of vertices and faces as little-endian 64-bit numbers.

    Examples
    --------
    >>> record = object_record(trimesh.creation.box((0.1, 0.2, 0.3)), np.zeros(3), path="box.stl")
    >>> record.path, record.extents.tolist(), len(record.sha256)
    ('box.stl', [0.1, 0.2, 0.3], 64)
    """
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
    """The same result with the file, scale and repairs of its object, and the seed.

    Parameters
    ----------
    found : GraspSet
        A result of `plan_grasps`, which knows arrays and a generator only.
    seed : int or None
        Seed of the generator that drew the candidates.
    **known : object
        Fields of `ObjectRecord`: path, sha256, scale [m per unit of the file], repairs.

    Returns
    -------
    GraspSet
        A new result; `found` stays as it is.

    Raises
    ------
    TypeError
        If `known` names a field that `ObjectRecord` has not.

    Examples
    --------
    >>> rod = trimesh.creation.capsule(0.12, 0.02)
    >>> found = plan_grasps(rod, "armar3", max_candidates=2, rng=np.random.default_rng(3))
    >>> known = with_origin(found, seed=3, path="rod.stl")
    >>> known.seed, known.object.path, found.seed
    (3, 'rod.stl', None)
    """
    return replace(found, seed=seed, object=replace(found.object, **known))
