"""Laws of pose errors: no error changes nothing, errors are as large as stated."""

import numpy as np
import pytest
import trimesh

from medkit.grasping.baselines import surface_normal_candidates
from medkit.grasping.experiments import ObjectBench, Setting
from medkit.grasping.robustness import displaced, yields_over_friction, yields_under_errors
from medkit.robots import load_hand

BAR = trimesh.creation.cylinder(0.015, 0.12, sections=32)
CANDIDATES = surface_normal_candidates(BAR, candidates=60)


def test_an_error_has_the_stated_length_and_angle():
    moved = displaced(CANDIDATES, shift=0.004, turn=0.1, rng=np.random.default_rng(0))
    way = np.linalg.norm(moved.grasp_point - CANDIDATES.grasp_point, axis=1)
    assert way == pytest.approx(np.full(len(way), 0.004))
    cosine = np.einsum("ij,ij->i", moved.approach, CANDIDATES.approach)
    assert cosine.min() >= np.cos(0.1) - 1e-9
    assert np.allclose(np.einsum("ij,ij->i", moved.approach, moved.closing_axis), 0.0, atol=1e-9)


def test_no_error_changes_nothing():
    moved = displaced(CANDIDATES, shift=0.0, turn=0.0, rng=np.random.default_rng(0))
    assert np.allclose(moved.grasp_point, CANDIDATES.grasp_point)
    assert np.allclose(moved.approach, CANDIDATES.approach)


def test_what_is_kept_is_at_most_what_held_before():
    bench = ObjectBench(BAR, load_hand("wsg50"))
    table = yields_under_errors(
        bench, Setting("medial", "power", 0.03, 0.5), shifts=(0.0, 0.005), turns=(0.1,),
        most=6, rng=np.random.default_rng(1),
    )  # fmt: skip
    assert len(table) == 3
    assert (table.kept <= table.held_before).all()
    assert (table.kept <= table.held).all()
    assert table.kept[0] == table.held[0] == table.held_before[0]


def test_more_friction_never_loses_a_grasp_and_the_planner_s_own_gives_its_own_verdicts():
    bench = ObjectBench(BAR, load_hand("wsg50"))
    setting = Setting("medial", "power", 0.03, 0.5)
    grasps, _ = bench.grasps(setting, most=8, rng=np.random.default_rng(1))
    table = yields_over_friction(grasps, bench.quality, [0.0, 0.2, 0.5, 1.0])
    assert (np.diff(table.held) >= 0).all()
    assert table.held[2] == sum(grasp.outcome == "force_closure" for grasp in grasps) > 0
    assert table.held[0] == 0
    assert (table.tested == 8).all()


def test_without_an_error_a_search_holds_what_the_planner_holds():
    bench = ObjectBench(BAR, load_hand("wsg50"))
    setting = Setting("medial-plus", "power", 0.03, 0.5)
    rng = np.random.default_rng
    table = yields_under_errors(bench, setting, shifts=(0.0,), turns=(), most=6, rng=rng(1))
    grasps, _ = bench.grasps(setting, most=6, rng=rng(1))
    assert table.held[0] == sum(grasp.outcome == "force_closure" for grasp in grasps)


def test_a_misplaced_hand_does_not_search_again(monkeypatch):
    bench = ObjectBench(BAR, load_hand("armar3"))
    setting, searches = Setting("medial-plus", "power", 0.03, 0.5), []
    search = bench.tester("power", "medial-plus")
    monkeypatch.setattr(bench, "tester", lambda *_: search)
    for shifts in ((), (0.0,), (0.002, 0.005, 0.01)):
        before = search.closings
        yields_under_errors(
            bench, setting, shifts=shifts, turns=(), most=4, rng=np.random.default_rng(1)
        )
        searches.append(search.closings - before)
    assert searches[0] == searches[1] == searches[2] >= 4
