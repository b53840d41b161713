"""Laws of the experiments: counts add up, intervals hold, a finished object is not repeated."""

import dataclasses
from dataclasses import astuple

import numpy as np
import pandas as pd
import pytest
import trimesh

from medkit.errors import InputError
from medkit.grasping import experiments, study
from medkit.grasping.experiments import (
    EXPERIMENTS,
    ObjectBench,
    Setting,
    failure_reasons,
    mean_yields,
    run_experiment,
    run_object,
    yield_table,
)
from medkit.grasping.grasp_set import OUTCOMES
from medkit.grasping.planners import plan_grasps
from medkit.grasping.study import load_study
from medkit.grasping.yields import COLUMNS, ratio_of_means
from medkit.robots import load_hand

HAND = load_hand("wsg50")
BAR = trimesh.creation.cylinder(0.015, 0.12, sections=32)
SETTINGS = (Setting("medial", "power", 0.03, 0.5), Setting("normals"), Setting("boxes"))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setenv("MEDKIT_CACHE", str(tmp_path_factory.mktemp("cache")))
    yield run_experiment({"bar": BAR}, HAND, SETTINGS, candidates_per_object=8)
    patch.undo()


def test_outcomes_add_up_to_the_tested_candidates(results):
    assert len(results) == len(SETTINGS)
    assert (results[list(OUTCOMES)].sum(axis=1) == results.tested).all()
    assert (results.tested == 8).all()


def test_a_yield_lies_in_its_wilson_interval_within_zero_and_a_hundred(results):
    table = yield_table(results)
    assert ((table.low_pct <= table.yield_pct) & (table.yield_pct <= table.high_pct)).all()
    assert table.low_pct.min() >= 0.0
    assert table.high_pct.max() <= 100.0


def test_wilson_s_interval_of_eight_in_ten_is_the_textbook_s():
    row = {"planner": "medial", "grasp": "power", "search_radius": 0.03, "min_radius_ratio": 0.5}
    frame = pd.DataFrame([{**row, "object": "x", "tested": 10, "force_closure": 8}])
    table = yield_table(frame)
    assert table.low_pct[0] == pytest.approx(49.0, abs=0.1)
    assert table.high_pct[0] == pytest.approx(94.3, abs=0.1)


def test_reasons_are_shares_of_a_hundred(results):
    assert failure_reasons(results).sum(axis=1).to_numpy() == pytest.approx(100.0)


def test_the_mean_over_objects_is_within_its_bootstrap_interval(results):
    twice = pd.concat([results, results.assign(object="other", force_closure=0)])
    means = mean_yields(twice, rng=np.random.default_rng(0), resamples=200)
    assert (means.objects == 2).all()
    assert ((means.low_pct <= means.yield_pct) & (means.yield_pct <= means.high_pct)).all()


def test_the_ratio_of_a_setting_to_one_with_half_its_grasps_is_two():
    frame = pd.DataFrame(
        [
            {"object": name, "planner": planner, "grasp": "power", "search_radius": 0.03,
             "min_radius_ratio": 0.5, "tested": 20, "force_closure": held}
            for planner, counts in (("medial", (8, 12, 18)), ("normals", (4, 6, 9)))
            for name, held in zip("abc", counts, strict=True)
        ]
    )  # fmt: skip
    parts = [frame[frame.planner == planner] for planner in ("medial", "normals")]
    ratio, low, high = ratio_of_means(*parts, rng=np.random.default_rng(0), resamples=100)
    assert (ratio, low, high) == pytest.approx((2.0, 2.0, 2.0))


@pytest.mark.parametrize("experiment", [1, 2, 3])
def test_a_stored_study_is_of_the_experiment_s_objects_and_settings(experiment):
    stored, wanted = load_study(experiment), EXPERIMENTS[experiment]
    assert (stored[list(OUTCOMES)].sum(axis=1) == stored.tested).all()
    assert stored.tested.max() >= 30
    names = [name for name, _ in wanted.objects]
    assert list(stored.object) == [name for name in names for _ in wanted.settings]
    settings = list(stored[COLUMNS].itertuples(index=False, name=None))
    assert settings == [astuple(setting) for setting in wanted.settings] * len(names)


def test_a_study_of_some_objects_is_made_by_one_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(study, "HAND", "wsg50")
    few = dataclasses.replace(EXPERIMENTS[3], objects=(("fish", 1.0),), settings=SETTINGS[1:2])
    monkeypatch.setitem(EXPERIMENTS, 3, few)
    assert study.main(["3", "--candidates", "2", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == "fish\n"
    stored = pd.read_csv(tmp_path / "experiment_3.csv")
    assert list(stored.columns) == list(study.STORED)
    assert stored.tested.tolist() == [2]


def test_a_study_of_something_else_is_refused(capsys):
    with pytest.raises(InputError, match="Expected experiment 1, 2, 3"):
        load_study(4)
    with pytest.raises(InputError, match="Expected objects of experiment 3"):
        study.study(3, objects=["mug"])
    assert study.main(["7"]) == 2
    assert "Expected experiment" in capsys.readouterr().err


def test_a_finished_object_is_taken_from_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path))
    ask = {"candidates_per_object": 3}
    first = run_experiment({"bar": BAR}, HAND, SETTINGS[:1], **ask)

    def not_again(*args, **kwargs):
        raise AssertionError("the object was tested again")

    monkeypatch.setattr(experiments, "run_object", not_again)
    pd.testing.assert_frame_equal(run_experiment({"bar": BAR}, HAND, SETTINGS[:1], **ask), first)
    with pytest.raises(AssertionError, match="again"):
        run_experiment({"bar": BAR}, HAND, SETTINGS[:1], candidates_per_object=4)
    turned = dataclasses.replace(HAND, closing_axis=-HAND.closing_axis)
    with pytest.raises(AssertionError, match="again"):
        run_experiment({"bar": BAR}, turned, SETTINGS[:1], **ask)


def test_the_same_seed_gives_the_same_counts():
    one, two = (
        run_object(BAR, HAND, SETTINGS[:1], candidates_per_object=5, seed=3) for _ in range(2)
    )
    for a, b in zip(one, two, strict=True):
        assert {k: a[k] for k in OUTCOMES} == {k: b[k] for k in OUTCOMES}


def test_the_three_experiments_have_the_objects_and_columns_of_the_thesis():
    assert [len(EXPERIMENTS[k].objects) for k in (1, 2, 3)] == [10, 10, 7]
    medial = [[s for s in EXPERIMENTS[k].settings if s.planner == "medial"] for k in (1, 2, 3)]
    assert [len(settings) for settings in medial] == [1, 8, 4]
    improved = [
        [s for s in EXPERIMENTS[k].settings if s.planner == "medial-plus"] for k in EXPERIMENTS
    ]
    assert [len(settings) for settings in improved] == [1, 4, 2]
    assert medial[0][0].search_radius == 0.06


@pytest.mark.parametrize("grasp", ["power", "precision"])
@pytest.mark.parametrize("planner", ["medial", "medial-plus", "normals", "boxes"])
def test_an_experiment_tests_what_the_planner_would_plan(planner, grasp):
    setting = Setting(planner, grasp, 0.03, 0.5)
    tested, _ = ObjectBench(BAR, HAND).grasps(setting, most=4, rng=np.random.default_rng(2))
    planned = plan_grasps(
        BAR, HAND, grasp=grasp, planner=planner, search_radius=0.03, min_radius_ratio=0.5,
        max_candidates=4, rng=np.random.default_rng(2),
    )  # fmt: skip
    assert [g.outcome for g in tested] == [g.outcome for g in planned.grasps]
    assert [g.epsilon for g in tested] == [g.epsilon for g in planned.grasps]
    for one, other in zip(tested, planned.grasps, strict=True):
        assert np.array_equal(one.pose, other.pose)


def test_objects_in_two_processes_give_the_serial_counts(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path))
    pair = {"bar": BAR, "ball": trimesh.creation.icosphere(2, 0.02)}
    ask = {"candidates_per_object": 3, "cache": False}
    names = []
    serial = run_experiment(pair, HAND, SETTINGS[1:2], **ask)
    both = run_experiment(pair, HAND, SETTINGS[1:2], jobs=2, progress=names.append, **ask)
    columns = ["object", "tested", *OUTCOMES]
    pd.testing.assert_frame_equal(both[columns], serial[columns])
    assert names == ["bar", "ball"]


def test_no_object_and_no_planner_are_refused():
    with pytest.raises(InputError, match="at least one object"):
        run_experiment({}, HAND, SETTINGS, candidates_per_object=1)
    with pytest.raises(InputError, match="Expected a planner"):
        ObjectBench(BAR, HAND).candidates(Setting("guess"))
