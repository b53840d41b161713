"""P13's three simulation experiments: yields by object and planner, with intervals and reasons."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh
from statsmodels.stats.proportion import proportion_confint

from medkit.errors import InputError
from medkit.files import cache_folder, write_text
from medkit.geometry import Floats
from medkit.grasping.baselines import fitted_box_candidates, surface_normal_candidates
from medkit.grasping.candidates import CandidateGrasps, candidates_from_axis
from medkit.grasping.grasp_set import FORCE_CLOSURE, OUTCOMES, Grasp
from medkit.grasping.planners import TESTERS, Quality, choose_candidates, looked_up, run_candidates
from medkit.medial.axis import MedialAxis, medial_axis
from medkit.meshes import mass_properties
from medkit.robots.hand import Hand

#: The planners that are compared, and P13's names for two of them.
PRINTED_PLANNERS = {"medial": "MAT", "normals": "Berenson07"}
FRICTION = 0.5  # P13 5.1.3


@dataclass(frozen=True)
class Setting:
    """One column of a table: a planner, the kind of grasp, and the medial planner's parameters."""

    planner: str
    grasp: str = "power"
    search_radius: float = 0.03
    min_radius_ratio: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """Objects (name, scale) and settings of one of P13's experiments."""

    title: str
    objects: tuple[tuple[str, float], ...]
    settings: tuple[Setting, ...]


_LARGE = ("glasses", "ant", "chair", "fish_large", "bird", "figure", "bust", "amphora", "teapot",
          "giraffe")  # fmt: skip
_HAND = ("clown", "elephant", "fish", "gnome", "dog", "sitting_cat", "lying_cat", "moon", "seal",
         "star")  # fmt: skip
_PRECISION = (("clown", 1.0), ("elephant", 1.0), ("fish", 1.0), ("moon", 1.0), ("seal", 1.0),
              ("glasses", 0.25), ("giraffe", 0.25))  # fmt: skip
#: P13 5.1.4 to 5.1.6, with the box baseline beside.
EXPERIMENTS = {
    1: Experiment(
        "power grasps, large objects",
        tuple((name, 1.0) for name in _LARGE),
        (Setting("medial", "power", 0.06), Setting("normals"), Setting("boxes")),
    ),
    2: Experiment(
        "power grasps, hand-sized objects",
        tuple((name, 1.0) for name in _HAND),
        (
            *(
                Setting("medial", "power", radius, ratio)
                for radius in (0.01, 0.03)
                for ratio in (0.0, 0.3, 0.5, 0.7)
            ),
            Setting("normals"),
            Setting("boxes"),
        ),
    ),
    3: Experiment(
        "precision grasps",
        _PRECISION,
        (
            *(
                Setting("medial", "precision", radius, ratio)
                for radius in (0.01, 0.03)
                for ratio in (0.0, 0.3)
            ),
            Setting("normals", "precision"),
            Setting("boxes", "precision"),
        ),
    ),
}


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

    def __init__(self, mesh: trimesh.Trimesh, hand: Hand, *, friction: float = FRICTION) -> None:
        body = mass_properties(mesh)
        self.mesh = mesh
        self.hand = hand
        self.quality = Quality(friction, body.center_mass, body.torque_scale)
        self._axis: MedialAxis | None = None
        self._testers: dict[str, Any] = {}

    @property
    def axis(self) -> MedialAxis:
        """The object's medial axis, computed at the first need."""
        if self._axis is None:
            self._axis = medial_axis(self.mesh)
        return self._axis

    def tester(self, grasp: str) -> Any:
        """What closes and judges grasps of a kind, prepared at the first need."""
        if grasp not in self._testers:
            make = looked_up(TESTERS, grasp, "kind of grasp")
            triangles = np.asarray(self.mesh.triangles, dtype=float)
            self._testers[grasp] = make(self.hand, triangles, self.quality)
        return self._testers[grasp]

    def candidates(self, setting: Setting) -> CandidateGrasps:
        """All candidates of a setting."""
        if setting.planner == "medial":
            # Pads hold what a closing fist cannot: the least radius is for power grasps only.
            least = self.hand.min_sphere_radius if setting.grasp == "power" else 0.0
            return candidates_from_axis(
                self.axis,
                search_radius=setting.search_radius,
                min_radius_ratio=setting.min_radius_ratio,
                hand_radii=(least, self.hand.max_sphere_radius),
            )
        if setting.planner == "normals":
            return surface_normal_candidates(self.mesh)
        if setting.planner == "boxes":
            return fitted_box_candidates(self.mesh)
        raise InputError(
            f"Expected a planner medial, normals or boxes, but got {setting.planner!r};"
            " name one of them."
        )

    def grasps(
        self, setting: Setting, *, most: int | None, rng: np.random.Generator
    ) -> tuple[list[Grasp], Floats]:
        """Tested grasps of a setting, at most so many, and the time each took [s]."""
        chosen = choose_candidates(self.candidates(setting), most, rng)
        found, spent = [], []
        begin = time.process_time()
        for grasp, _ in run_candidates(self.tester(setting.grasp), chosen):
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
        Setting, number of candidates found and tested, count of each outcome, median processor
        time of a test [s].
    """
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
        stopped. The key covers mesh, hand, settings and the planner's own code.
    progress : callable, optional
        Called with the name of each object before it is tested.

    Returns
    -------
    pandas.DataFrame
        One row for each object and setting: see `run_object`; ``object`` is the name.
    """
    pairs = objects.items() if isinstance(objects, Mapping) else objects
    frames = []
    for name, mesh in pairs:
        if progress is not None:
            progress(name)
        asked = {"most": candidates_per_object, "seed": seed, "friction": friction}
        path = _cache_file(mesh, hand, settings, asked) if cache else None
        rows = _stored(path)
        if rows is None:
            rows = run_object(
                mesh, hand, settings,
                candidates_per_object=candidates_per_object, seed=seed, friction=friction,
            )  # fmt: skip
            if path is not None:
                with suppress(InputError, OSError):
                    write_text(path, json.dumps(rows))
        frames.append(pd.DataFrame(rows).assign(object=name))
    if not frames:
        raise InputError("Expected at least one object, but got none; pass names and meshes.")
    return pd.concat(frames, ignore_index=True)


COLUMNS = ["planner", "grasp", "search_radius", "min_radius_ratio"]


def yield_table(results: pd.DataFrame) -> pd.DataFrame:
    """Yield of every object and setting with its Wilson interval.

    Parameters
    ----------
    results : pandas.DataFrame
        From `run_experiment`.

    Returns
    -------
    pandas.DataFrame
        ``yield_pct``, ``low_pct``, ``high_pct`` [%] (95 %) and ``tested``.
    """
    low, high = proportion_confint(
        results[FORCE_CLOSURE].to_numpy(), np.maximum(results.tested.to_numpy(), 1), method="wilson"
    )
    table = results[["object", *COLUMNS, "tested"]].copy()
    table["yield_pct"] = 100.0 * results[FORCE_CLOSURE] / results.tested.where(results.tested > 0)
    table["low_pct"], table["high_pct"] = 100.0 * low, 100.0 * high
    return table


def mean_yields(
    results: pd.DataFrame, *, rng: np.random.Generator, resamples: int = 2000
) -> pd.DataFrame:
    """Mean over objects of the yield of each setting, with a bootstrap interval over objects.

    Parameters
    ----------
    results : pandas.DataFrame
        From `run_experiment`.
    rng : numpy.random.Generator
        Draws the resamples.
    resamples : int
        How many.

    Returns
    -------
    pandas.DataFrame
        One row a setting: ``yield_pct``, ``low_pct``, ``high_pct`` [%] (95 %), ``objects``.
    """
    rows = []
    for key, part in yield_table(results).dropna(subset="yield_pct").groupby(COLUMNS, sort=False):
        values = part.yield_pct.to_numpy()
        means = values[rng.integers(0, len(values), (resamples, len(values)))].mean(axis=1)
        low, high = np.percentile(means, [2.5, 97.5])
        rows.append([*key, values.mean(), low, high, len(values)])
    return pd.DataFrame(rows, columns=[*COLUMNS, "yield_pct", "low_pct", "high_pct", "objects"])


def failure_reasons(results: pd.DataFrame) -> pd.DataFrame:
    """Share of each outcome among the tested candidates of each setting [%], rows adding to 100."""
    counts = results.groupby(COLUMNS, sort=False)[list(OUTCOMES)].sum()
    return 100.0 * counts.div(counts.sum(axis=1), axis=0)


def _cache_file(
    mesh: trimesh.Trimesh, hand: Hand, settings: Sequence[Setting], asked: Mapping[str, Any]
) -> Path | None:
    """Where the counts of one object are kept, or None where no cache can be written."""
    digest = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces, hand.limits, *[b.vertices for b in hand.bodies]):
        digest.update(np.ascontiguousarray(array).tobytes())
    for preshape in sorted(hand.preshapes):
        digest.update(np.ascontiguousarray(hand.preshapes[preshape]).tobytes())
    digest.update(json.dumps([[asdict(s) for s in settings], dict(asked)]).encode())
    here = Path(__file__).parent
    for source in sorted([*here.glob("*.py"), *(here.parent / "quality").glob("*.py")]):
        digest.update(source.read_bytes())
    try:
        return cache_folder("experiments") / f"{digest.hexdigest()[:24]}.json"
    except OSError:
        return None


def _stored(path: Path | None) -> list[dict[str, Any]] | None:
    if path is None or not path.is_file():
        return None
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None  # a broken cache file is made anew
    return rows if isinstance(rows, list) else None
