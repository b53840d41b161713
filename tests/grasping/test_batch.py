"""Laws of the batch: resumed, serial and distributed runs write the same grasps."""

from dataclasses import replace

import dask
import distributed
import numpy as np
import pytest
import trimesh

from medkit.datasets import load_folder
from medkit.errors import InputError
from medkit.grasping.batch import plan_many
from medkit.grasping.grasp_file import read_grasps
from medkit.robots import load_hand

HAND = load_hand("wsg50")
OBJECTS = {
    "bar": trimesh.creation.cylinder(0.015, 0.12, sections=24),
    "ball": trimesh.creation.icosphere(2, 0.02),
    "box": trimesh.creation.box([0.03, 0.04, 0.1]),
}
ASK = {"max_candidates": 4, "planner": "normals"}


def poses(files):
    return {name: [g.pose for g in read_grasps(path).grasps] for name, path in files.items()}


def same(one, two):
    return all(np.array_equal(one[name], two[name]) for name in OBJECTS)


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    return poses(plan_many(OBJECTS, HAND, tmp_path_factory.mktemp("serial"), **ASK))


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local


def test_a_finished_object_is_not_planned_again_and_a_changed_one_is(tmp_path):
    planned = []

    def note(name, found):
        planned.append(name)

    plan_many(OBJECTS, HAND, tmp_path, done=note, **ASK)
    plan_many(OBJECTS, HAND, tmp_path, done=note, **ASK)
    assert planned == ["bar", "ball", "box"]
    (tmp_path / "ball.json").write_text("{")
    larger = {**OBJECTS, "bar": trimesh.creation.cylinder(0.02, 0.12, sections=24)}
    plan_many(larger, HAND, tmp_path, done=note, **ASK)
    assert planned == ["bar", "ball", "box", "bar", "ball"]


@pytest.mark.parametrize(
    ("first", "then"),
    [({"friction": 0.3}, {}), ({}, {"friction": 0.3}), ({"grasp": "precision"}, {}),
     ({}, {"max_candidates": 2})],
)  # fmt: skip
def test_an_argument_that_differs_or_is_left_out_is_planned_anew(tmp_path, first, then):
    planned, ball = [], {"ball": OBJECTS["ball"]}
    for more in (first, then, then):
        plan_many(ball, HAND, tmp_path, done=lambda name, _: planned.append(name), **ASK | more)
    assert planned == ["ball", "ball"]


def test_a_hand_that_was_changed_under_its_name_is_planned_anew(tmp_path):
    planned, ball = [], {"ball": OBJECTS["ball"]}
    frame = HAND.T_hand_power.copy()
    frame[2, 3] -= 0.005
    for hand in (HAND, replace(HAND, T_hand_power=frame), replace(HAND, T_hand_power=frame)):
        plan_many(ball, hand, tmp_path, done=lambda name, _: planned.append(name), **ASK)
    assert planned == ["ball", "ball"]


def test_the_order_of_the_objects_does_not_matter(tmp_path, serial):
    assert same(serial, poses(plan_many(dict(reversed(OBJECTS.items())), HAND, tmp_path, **ASK)))


def test_worker_processes_go_on_after_an_interruption_with_the_serial_grasps(
    tmp_path, cluster, serial
):
    planned = []

    def stop_at_the_second(name, found):
        planned.append(name)
        if len(planned) == 2:
            raise KeyboardInterrupt

    ask = {"scheduler": cluster.scheduler_address, **ASK}
    with pytest.raises(KeyboardInterrupt):
        plan_many(OBJECTS, HAND, tmp_path, done=stop_at_the_second, **ask)
    assert sorted(path.stem for path in tmp_path.iterdir()) == sorted(planned)
    found = plan_many(OBJECTS, HAND, tmp_path, done=lambda name, _: planned.append(name), **ask)
    assert sorted(planned) == sorted(OBJECTS)
    assert list(found) == list(OBJECTS)
    assert same(serial, poses(found))


def test_the_same_name_with_other_parameters_is_not_mixed_up_on_a_shared_scheduler(
    tmp_path, cluster
):
    ball, address = {"ball": OBJECTS["ball"]}, cluster.scheduler_address
    counts = []
    for most in (2, 3):
        folder = tmp_path / str(most)
        folder.mkdir()
        ask = ASK | {"max_candidates": most}
        files = plan_many(ball, HAND, folder, scheduler=address, **ask)
        counts.append(len(read_grasps(files["ball"]).grasps))
    assert counts == [2, 3]


def test_a_cluster_made_for_the_run_gives_the_serial_grasps_and_ends(tmp_path, serial):
    assert same(serial, poses(plan_many(OBJECTS, HAND, tmp_path, workers=2, **ASK)))


def test_an_object_that_cannot_be_planned_does_not_stop_the_others(tmp_path, cluster):
    whole = OBJECTS["ball"]
    empty = trimesh.Trimesh(np.zeros((3, 3)), [[0, 1, 2]], process=False)
    pair = {"nothing": empty, "ball": whole}
    for folder, more in (("a", {}), ("b", {"scheduler": cluster.scheduler_address})):
        (tmp_path / folder).mkdir()
        with pytest.raises(InputError, match="1 cannot, among them 'nothing'"):
            plan_many(pair, HAND, tmp_path / folder, **ASK | more)
        assert [path.name for path in (tmp_path / folder).iterdir()] == ["ball.json"]


def test_bad_folders_and_names_are_refused(tmp_path):
    with pytest.raises(InputError, match="existing folder"):
        plan_many(OBJECTS, HAND, tmp_path / "nowhere", **ASK)
    with pytest.raises(InputError, match="file names"):
        plan_many({"a/b": OBJECTS["ball"]}, HAND, tmp_path, **ASK)


@pytest.mark.parametrize(
    ("objects", "more", "words"),
    [
        (OBJECTS, {"workers": -1}, "workers to be a whole number of at least 0"),
        (OBJECTS, {"workers": "two"}, "workers to be a whole number"),
        (OBJECTS, {"seed": -1}, "seed to be a whole number of at least 0"),
        (OBJECTS, {"seed": 1.5}, "seed to be a whole number"),
        (OBJECTS, {"scheduler": 5}, "address of a dask scheduler"),
        (OBJECTS, {"scheduler": "nobody"}, "dask scheduler at 'nobody'.*tcp://"),
        (OBJECTS, {"scheduler": "tcp://127.0.0.1:9"}, "dask scheduler at 'tcp://127.0.0.1:9'"),
        (["ball"], {}, "names with their meshes"),
        ({"ball": None}, {}, "mesh of 'ball'"),
        (None, {}, "names with their meshes"),
        ([("ball", OBJECTS["ball"]), ("ball", OBJECTS["box"])], {}, "'ball' comes twice"),
    ],
)
def test_what_cannot_be_a_batch_is_refused_before_any_work(tmp_path, objects, more, words):
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        pytest.raises(InputError, match=words) as caught,
    ):
        plan_many(objects, HAND, tmp_path, **ASK | more)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_broken_file_in_a_folder_is_named_by_its_own_sentence(tmp_path):
    OBJECTS["ball"].export(tmp_path / "a.stl")
    (tmp_path / "b.stl").write_text("no mesh")
    with pytest.raises(InputError, match=r"triangle in b\.stl"):
        plan_many(load_folder(tmp_path), HAND, tmp_path, **ASK)
