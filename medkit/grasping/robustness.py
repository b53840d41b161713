"""How a planner's yield bears errors in the hand's pose, and another friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from medkit.arguments import generator
from medkit.geometry import nonnegative, rotation_about, unit
from medkit.grasping.bench import ObjectBench
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.grasp_set import FORCE_CLOSURE, Grasp
from medkit.grasping.power import Contacts
from medkit.grasping.settings import Setting
from medkit.grasping.testers import MIN_CONTACTS, Quality


def displaced(
    candidates: CandidateGrasps, *, shift: float, turn: float, rng: np.random.Generator
) -> CandidateGrasps:
    """Candidates as a hand meets them that is off by `shift` [m] and `turn` [rad].

    Parameters
    ----------
    candidates : CandidateGrasps
        As planned.
    shift : float
        Length of a displacement in a random direction, another for each candidate [m].
    turn : float
        Angle of a turn about a random axis through the grasp point [rad].
    rng : numpy.random.Generator
        Draws directions and axes.

    Returns
    -------
    CandidateGrasps
        The same candidates, moved.

    Raises
    ------
    InputError
        If `shift` or `turn` is negative or not finite.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping.baselines import surface_normal_candidates
    >>> planned = surface_normal_candidates(trimesh.creation.box((0.1, 0.1, 0.1)), candidates=24)
    >>> met = displaced(planned, shift=0.005, turn=0.1, rng=np.random.default_rng(0))
    >>> away = np.linalg.norm(met.grasp_point - planned.grasp_point, axis=1)
    >>> bool(np.allclose(away, 0.005)), bool((met.approach * planned.approach).sum(1).min() > 0.99)
    (True, True)
    """
    nonnegative(shift, "shift", " m")
    nonnegative(turn, "turn", " rad")
    directions = (
        unit(rng.normal(size=(len(candidates), 3))) if len(candidates) else np.zeros((0, 3))
    )
    axes = unit(rng.normal(size=(len(candidates), 3))) if len(candidates) else np.zeros((0, 3))
    turns = np.array([rotation_about(axis, turn) for axis in axes]).reshape(-1, 3, 3)
    return replace(
        candidates,
        grasp_point=candidates.grasp_point + shift * directions,
        approach=np.einsum("nij,nj->ni", turns, candidates.approach),
        closing_axis=np.einsum("nij,nj->ni", turns, candidates.closing_axis),
    )


def yields_under_errors(
    bench: ObjectBench,
    setting: Setting,
    *,
    shifts: Sequence[float] = (0.0, 0.001, 0.002, 0.005, 0.01),
    turns: Sequence[float] = tuple(np.deg2rad([0.0, 2.0, 5.0, 10.0])),
    most: int | None,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Yield of one planner on one object when the hand is misplaced.

    Every candidate is tested once for each error. Shifts are tried without turns, and turns
    without shifts. A planner that searches does so once, without an error; what it settled on is
    what the misplaced hand does, closing once.

    Parameters
    ----------
    bench : ObjectBench
        The prepared object.
    setting : Setting
        The planner.
    shifts, turns : sequences of float
        Sizes of the errors [m], [rad].
    most : int or None
        Candidates at most.
    rng : numpy.random.Generator
        Draws candidates and errors.

    Returns
    -------
    pandas.DataFrame
        ``shift`` [m], ``turn`` [rad], ``tested``, ``held`` (force-closure grasps), ``kept``: of
        the candidates that hold without an error, those that still hold, ``held_before``.

    Raises
    ------
    InputError
        If a shift or a turn is negative or not finite.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> bench = ObjectBench(trimesh.creation.icosphere(3, 0.03), load_hand("wsg50"))
    >>> table = yields_under_errors(bench, Setting("normals", "power"), shifts=(0.0, 0.01),
    ...                             turns=(), most=4, rng=np.random.default_rng(0))
    >>> table.tested.tolist(), bool((table.kept <= table.held_before).all())
    ([4, 4], True)
    """
    generator(rng)
    for turn in turns:
        nonnegative(turn, "turn", " rad")
    chosen = bench.chosen(setting, most=most, rng=rng)
    tester = bench.tester(setting.grasp, setting.planner)
    ways = [tester.settled(*row) for row in chosen.rows()]
    planned = replace(
        chosen,
        grasp_point=np.array([way.point for way in ways]).reshape(-1, 3),
        approach=np.array([way.approach for way in ways]).reshape(-1, 3),
        closing_axis=np.array([way.closing_axis for way in ways]).reshape(-1, 3),
    )

    def holds(met: CandidateGrasps) -> np.ndarray:
        rows = zip(ways, met.rows(), strict=True)
        outcomes = [way.tester.test(*row)[0].outcome for way, row in rows]
        return np.array([outcome == FORCE_CLOSURE for outcome in outcomes], dtype=bool)

    before = holds(planned)
    errors = [(s, 0.0) for s in shifts] + [(0.0, t) for t in turns if t > 0.0]
    rows = []
    for shift, turn in errors:
        moved = displaced(planned, shift=shift, turn=turn, rng=rng)
        held = before if shift == turn == 0.0 else holds(moved)
        rows.append(
            {
                "planner": setting.planner, "shift": shift, "turn": turn, "tested": len(held),
                "held": int(held.sum()), "held_before": int(before.sum()),
                "kept": int((held & before).sum()),
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def yields_over_friction(
    grasps: Sequence[Grasp], quality: Quality, frictions: Sequence[float]
) -> pd.DataFrame:
    """Judge the same contacts again with other friction coefficients.

    The hand closes by geometry alone, so contacts do not depend on friction; only the verdict does.

    Parameters
    ----------
    grasps : sequence of Grasp
        Tested grasps, for example of `ObjectBench.grasps`.
    quality : Quality
        The object's centre of mass and torque scale; its own friction is not used.
    frictions : sequence of float
        Friction coefficients [1].

    Returns
    -------
    pandas.DataFrame
        ``friction`` [1], ``tested``, ``held`` and ``median_epsilon`` [N] of those that hold (0
        where none does).

    Raises
    ------
    InputError
        If a friction coefficient is negative or not finite.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> bench = ObjectBench(trimesh.creation.icosphere(3, 0.03), load_hand("wsg50"))
    >>> setting = Setting("normals", "power")
    >>> grasps, _ = bench.grasps(setting, most=4, rng=np.random.default_rng(0))
    >>> table = yields_over_friction(grasps, bench.quality, [0.1, 0.5])
    >>> table.tested.tolist(), bool(table.held.is_monotonic_increasing)
    ([4, 4], True)
    """
    rows = []
    for friction in frictions:
        judged = replace(quality, friction=nonnegative(friction, "friction"))
        values = np.array(
            [
                judged.epsilon(Contacts(g.points, g.normals, np.zeros(len(g.points), np.int64)))
                for g in grasps
                if len(g.points) >= MIN_CONTACTS
            ]
        )
        held = values[values > 0.0]
        median = float(np.median(held)) if len(held) else 0.0
        rows.append([friction, len(grasps), len(held), median])
    return pd.DataFrame(rows, columns=["friction", "tested", "held", "median_epsilon"])
