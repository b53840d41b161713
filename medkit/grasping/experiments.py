"""P13's three simulation experiments: yields by object and planner, with intervals and reasons."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from medkit.arguments import short, whole
from medkit.errors import InputError
from medkit.files import cache_folder, write_text
from medkit.geometry import Floats, expected, nonnegative
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.choosing import choose_candidates
from medkit.grasping.grasp_set import OUTCOMES, Grasp
from medkit.grasping.parallel import in_processes, run_candidates
from medkit.grasping.settings import EXPERIMENTS as EXPERIMENTS
from medkit.grasping.settings import Experiment as Experiment
from medkit.grasping.settings import Setting
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.strategies import (
    CANDIDATE_SOURCES,
    CHOOSERS,
    REFINERS,
    TESTERS,
    looked_up,
    radii_for,
)
from medkit.grasping.testers import Quality
from medkit.grasping.yields import failure_reasons as failure_reasons
from medkit.grasping.yields import mean_yields as mean_yields
from medkit.grasping.yields import yield_table as yield_table
from medkit.medial.axis import MedialAxis, medial_axis
from medkit.meshes import mass_properties
from medkit.meshes.usable import refuse_unusable
from medkit.robots.digest import hand_digest
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand

FRICTION = 0.5  # P13 5.1.3


class ObjectBench:
    """One object prepared once for many settings: medial axis, closing, quality.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand
        The hand.
    friction : float
        Friction coefficient of hard point contacts [1].
    """

    def __init__(
        self, mesh: trimesh.Trimesh, hand: Hand | str, *, friction: float = FRICTION
    ) -> None:
        refuse_unusable(mesh)
        body = mass_properties(mesh)
        self.mesh = mesh
        self.hand = usable_hand(hand)
        rough = nonnegative(friction, "friction")
        self.quality = Quality(rough, body.center_mass, body.torque_scale)
        self._axis: MedialAxis | None = None
        self._testers: dict[str, Any] = {}

    @property
    def axis(self) -> MedialAxis:
        """The object's medial axis, computed at the first need."""
        if self._axis is None:
            self._axis = medial_axis(self.mesh)
        return self._axis

    def tester(self, grasp: str, planner: str = "medial") -> Any:
        """What closes and judges grasps of a kind as a planner does; prepared at the first need."""
        if grasp not in self._testers:
            make = looked_up(TESTERS, grasp, "kind of grasp")
            triangles = np.asarray(self.mesh.triangles, dtype=float)
            self._testers[grasp] = make(self.hand, triangles, self.quality)
        tester = self._testers[grasp]
        if planner in REFINERS:
            return looked_up(REFINERS, planner, "planner")(tester, self.hand)
        return tester

    def candidates(self, setting: Setting) -> CandidateGrasps:
        """All candidates of a setting, as `plan_grasps` would have them."""
        if setting.planner == "medial":
            return candidates_from_axis(
                self.axis,
                search_radius=setting.search_radius,
                min_radius_ratio=setting.min_radius_ratio,
                hand_radii=radii_for(self.hand, setting.grasp),
            )
        source = looked_up(CANDIDATE_SOURCES, setting.planner, "planner")
        found: CandidateGrasps = source(
            self.mesh,
            self.hand,
            grasp=setting.grasp,
            search_radius=setting.search_radius,
            min_radius_ratio=setting.min_radius_ratio,
            watch=Stopwatch(),
        )
        return found

    def chosen(
        self, setting: Setting, *, most: int | None, rng: np.random.Generator
    ) -> CandidateGrasps:
        """At most so many candidates of a setting, drawn as its planner draws them."""
        found = self.candidates(setting)
        if setting.planner in CHOOSERS:
            drawn: CandidateGrasps = looked_up(CHOOSERS, setting.planner, "planner")(
                found, most, rng
            )
            return drawn
        return choose_candidates(found, most, rng)

    def grasps(
        self, setting: Setting, *, most: int | None, rng: np.random.Generator
    ) -> tuple[list[Grasp], Floats]:
        """Tested grasps of a setting, at most so many, and the time each took [s]."""
        chosen = self.chosen(setting, most=most, rng=rng)
        found, spent = [], []
        begin = time.process_time()
        for grasp, _ in run_candidates(self.tester(setting.grasp, setting.planner), chosen):
            found.append(grasp)
            spent.append(time.process_time() - begin)
        return found, np.diff(np.asarray([0.0, *spent]))


def run_object(
    mesh: trimesh.Trimesh,
    hand: Hand,
    settings: Sequence[Setting],
    *,
    candidates_per_object: int | None,
    seed: int = 0,
    friction: float = FRICTION,
) -> list[dict[str, Any]]:
    """Counts of outcomes for one object, one row a setting.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand
        The hand.
    settings : sequence of Setting
        Columns of the table.
    candidates_per_object : int or None
        Candidates tested at most for each setting; None for all.
    seed : int
        Draws the candidates, the same for every setting.
    friction : float
        Friction coefficient of hard point contacts [1].

    Returns
    -------
    list of dict
        Setting, number of candidates tested, count of each outcome, median processor time of a
        test [s].

    Raises
    ------
    InputError
        If a setting names a planner or a kind of grasp that does not exist, or the mesh or the
        friction cannot be used.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> ball = trimesh.creation.icosphere(3, 0.03)
    >>> setting = Setting("normals", "power")
    >>> row, = run_object(ball, load_hand("wsg50"), [setting], candidates_per_object=4)
    >>> row["tested"], sum(row[name] for name in OUTCOMES)
    (4, 4)
    """
    _check_settings(settings)
    seed = whole(seed, "seed", 0)
    bench = ObjectBench(mesh, hand, friction=friction)
    rows = []
    for setting in settings:
        grasps, spent = bench.grasps(
            setting, most=candidates_per_object, rng=np.random.default_rng(seed)
        )
        counts = {name: sum(g.outcome == name for g in grasps) for name in OUTCOMES}
        median = float(np.median(spent)) if len(spent) else float("nan")
        rows.append({**asdict(setting), "tested": len(grasps), **counts, "median_s": median})
    return rows


def run_experiment(
    objects: Mapping[str, trimesh.Trimesh] | Iterable[tuple[str, trimesh.Trimesh]],
    hand: Hand,
    settings: Sequence[Setting],
    *,
    candidates_per_object: int | None,
    seed: int = 0,
    friction: float = FRICTION,
    cache: bool = True,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """Test many objects with the same settings; a finished object is not tested again.

    Parameters
    ----------
    objects : mapping or iterable of (name, mesh)
        Closed meshes [m], for example from `medkit.datasets.load_folder`.
    hand : Hand
        The hand.
    settings : sequence of Setting
        For example ``EXPERIMENTS[1].settings``.
    candidates_per_object : int or None
        Candidates tested at most for each object and setting; None for all. P13 tests about 300.
    seed, friction
        See `run_object`.
    cache : bool
        Keep each object's counts in the user's cache, so that an interrupted run goes on where it
        stopped. The key covers mesh, hand, settings and the code that plans.
    jobs : int
        Objects tested at a time, each in a process of its own; the counts do not depend on it.
    progress : callable, optional
        Called with the name of each object when its counts are there, in the order given.

    Returns
    -------
    pandas.DataFrame
        One row for each object and setting: see `run_object`; ``object`` is the name.

    Raises
    ------
    InputError
        If there is no object, and as `run_object`.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> balls = {f"{r} mm": trimesh.creation.icosphere(3, r / 1000) for r in (20, 30)}
    >>> settings = [Setting("normals", "power")]
    >>> table = run_experiment(balls, load_hand("wsg50"), settings, candidates_per_object=4,
    ...                        cache=False)
    >>> table.object.tolist(), table.tested.tolist()
    (['20 mm', '30 mm'], [4, 4])
    """
    pairs = _named(objects)
    _check_settings(settings)
    hand, seed, jobs = usable_hand(hand), whole(seed, "seed", 0), whole(jobs, "jobs")
    asked = {"most": candidates_per_object, "seed": seed, "friction": friction}
    tasks = [(mesh.vertices, mesh.faces, hand, settings, asked, cache) for _, mesh in pairs]
    found = in_processes(_counted, tasks, jobs) if jobs > 1 else map(_counted, tasks)
    frames = []
    for (name, _), rows in zip(pairs, found, strict=True):
        frames.append(pd.DataFrame(rows).assign(object=name))
        if progress is not None:
            progress(name)
    return pd.concat(frames, ignore_index=True)


def _named(objects: Any) -> list[tuple[str, trimesh.Trimesh]]:
    """Names and meshes as pairs, at least one."""
    pairs = list(objects.items() if isinstance(objects, Mapping) else objects)
    if not pairs:
        raise InputError("Expected at least one object, but got none; pass names and meshes.")
    for pair in pairs:
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(
                f"Expected names with their meshes, but got {short(pair)}; pass a dictionary, or"
                " what load_folder gives."
            )
    return [(name, mesh) for name, mesh in pairs]


def _check_settings(settings: Any) -> None:
    if not settings:
        raise InputError("Expected at least one setting, but got none; pass a list of Setting.")
    for one in settings:
        remedy = "pass Setting(planner, grasp, ...), or EXPERIMENTS[1].settings"
        expected(one, Setting, "a setting", remedy)


def _counted(task: tuple) -> list[dict[str, Any]]:
    """Rows of one object, from the cache or by testing; what a process runs."""
    vertices, faces, hand, settings, asked, cache = task
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    path = _cache_file(mesh, hand, settings, asked) if cache else None
    rows = _stored(path)
    if rows is None:
        rows = run_object(
            mesh, hand, settings, candidates_per_object=asked["most"], seed=asked["seed"],
            friction=asked["friction"],
        )  # fmt: skip
        if path is not None:
            with suppress(InputError, OSError):
                write_text(path, json.dumps(rows))
    return rows


def _cache_file(
    mesh: trimesh.Trimesh, hand: Hand, settings: Sequence[Setting], asked: Mapping[str, Any]
) -> Path | None:
    """Where the counts of one object are kept, or None where no cache can be written."""
    digest = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(hand_digest(hand).encode())
    digest.update(json.dumps([[asdict(s) for s in settings], dict(asked)]).encode())
    digest.update(_code_digest())
    try:
        return cache_folder("experiments") / f"{digest.hexdigest()[:24]}.json"
    except OSError:
        return None


@lru_cache(maxsize=1)
def _code_digest() -> bytes:
    """Hash of every file of code that a count can depend on, as it was when first asked for."""
    package = Path(__file__).parents[1]
    rooms = ("grasping", "medial", "quality", "robots", "meshes")
    found = [source for room in rooms for source in (package / room).rglob("*.py")]
    digest = hashlib.sha256()
    for source in sorted([*found, package / "contacts.py", package / "geometry.py"]):
        digest.update(source.read_bytes())
    return digest.digest()


def _stored(path: Path | None) -> list[dict[str, Any]] | None:
    if path is None or not path.is_file():
        return None
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None  # a broken cache file is made anew
    return rows if isinstance(rows, list) else None
