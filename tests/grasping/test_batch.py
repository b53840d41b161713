"""Laws of the batch: resumed, serial and distributed runs write the same grasps."""

import distributed
import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.grasping.batch import plan_many
from medkit.grasping.grasp_file import read_grasps
from medkit.robots import load_hand

HAND = load_hand("wsg50")
OBJECTS = {
    "bar": trimesh.creation.cylinder(0.015, 0.12, sections=24),
    "ball": trimesh.creation.icosphere(2, 0.02),
}
ASK = {"max_candidates": 4, "planner": "normals"}


def poses(files):
    return {name: [g.pose for g in read_grasps(path).grasps] for name, path in files.items()}


def test_a_finished_object_is_not_planned_again_and_a_changed_one_is(tmp_path):
    planned = []

    def note(name, found):
        planned.append(name)

    plan_many(OBJECTS, HAND, tmp_path, done=note, **ASK)
    plan_many(OBJECTS, HAND, tmp_path, done=note, **ASK)
    assert planned == ["bar", "ball"]
    (tmp_path / "ball.json").write_text("{")
    larger = {**OBJECTS, "bar": trimesh.creation.cylinder(0.02, 0.12, sections=24)}
    plan_many(larger, HAND, tmp_path, done=note, **ASK)
    assert planned == ["bar", "ball", "bar", "ball"]


def test_the_order_of_the_objects_does_not_matter(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one = poses(plan_many(OBJECTS, HAND, tmp_path / "a", **ASK))
    two = poses(plan_many(dict(reversed(OBJECTS.items())), HAND, tmp_path / "b", **ASK))
    assert all(np.array_equal(one[name], two[name]) for name in OBJECTS)


def test_a_cluster_gives_the_same_grasps_as_the_serial_run(tmp_path):
    (tmp_path / "serial").mkdir()
    (tmp_path / "cluster").mkdir()
    serial = poses(plan_many(OBJECTS, HAND, tmp_path / "serial", **ASK))
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        found = plan_many(OBJECTS, HAND, tmp_path / "cluster", scheduler=address, **ASK)
    clustered = poses(found)
    assert all(np.array_equal(serial[name], clustered[name]) for name in OBJECTS)


def test_bad_folders_and_names_are_refused(tmp_path):
    with pytest.raises(InputError, match="existing folder"):
        plan_many(OBJECTS, HAND, tmp_path / "nowhere", **ASK)
    with pytest.raises(InputError, match="file names"):
        plan_many({"a/b": OBJECTS["ball"]}, HAND, tmp_path, **ASK)
