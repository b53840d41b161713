"""P13's three simulation experiments: yields by object and planner, with intervals and reasons."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from medkit.arguments import short, whole
from medkit.errors import InputError
from medkit.files import write_text
from medkit.geometry import expected
from medkit.grasping.bench import FRICTION
from medkit.grasping.bench import ObjectBench as ObjectBench
from medkit.grasping.experiment_cache import cache_file, stored
from medkit.grasping.grasp_set import OUTCOMES
from medkit.grasping.parallel import in_processes
from medkit.grasping.settings import EXPERIMENTS as EXPERIMENTS
from medkit.grasping.settings import Experiment as Experiment
from medkit.grasping.settings import Setting
from medkit.grasping.yields import failure_reasons as failure_reasons
from medkit.grasping.yields import mean_yields as mean_yields
from medkit.grasping.yields import yield_table as yield_table
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand


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
    path = cache_file(mesh, hand, settings, asked) if cache else None
    rows = stored(path)
    if rows is None:
        rows = run_object(
            mesh, hand, settings, candidates_per_object=asked["most"], seed=asked["seed"],
            friction=asked["friction"],
        )  # fmt: skip
        if path is not None:
            with suppress(InputError, OSError):
                write_text(path, json.dumps(rows))
    return rows
