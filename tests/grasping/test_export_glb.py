"""A grasp as GLB: everything in its place when another program reads it."""

import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.geometry import random_rotation, transform
from medkit.grasping.export_glb import write_grasp_glb
from medkit.robots import load_hand

HAND = load_hand("wsg50")
BOX = trimesh.creation.box((0.05, 0.08, 0.2))


def grasp():
    rng = np.random.default_rng(2)
    return {
        "pose": transform(random_rotation(rng), rng.normal(size=3)).tolist(),
        "joints": {"left finger": -0.03, "right finger": -0.01},
    }


def test_object_and_links_come_back_in_place_with_y_up(tmp_path):
    entry = grasp()
    write_grasp_glb(tmp_path / "g.glb", BOX, HAND, entry)
    scene = trimesh.load_scene(tmp_path / "g.glb")
    assert set(scene.geometry) == {"object", "housing", "left finger", "right finger"}
    world = dict(zip(*placed(scene), strict=True))
    np.testing.assert_allclose(world["object"].extents, [0.05, 0.2, 0.08], atol=1e-6)
    for name, mesh in HAND.link_meshes(HAND.coordinates(entry["joints"])).items():
        mesh.apply_transform(np.array(entry["pose"]))
        low, high = mesh.bounds
        expected = [[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]]
        np.testing.assert_allclose(world[name].bounds, expected, atol=1e-6)


def placed(scene):
    names, meshes = [], []
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        names.append(name)
        meshes.append(scene.geometry[name].copy().apply_transform(pose))
    return names, meshes


def test_fingers_differ_in_colour_from_object_and_palm(tmp_path):
    write_grasp_glb(tmp_path / "g.glb", BOX, HAND, grasp())
    scene = trimesh.load_scene(tmp_path / "g.glb")
    colours = {tuple(m.visual.material.main_color) for m in scene.geometry.values()}
    assert len(colours) == 4


def test_the_object_itself_is_left_alone_and_incomplete_grasps_are_refused(tmp_path):
    before = BOX.visual
    with pytest.raises(InputError, match="'joints' in the grasp"):
        write_grasp_glb(tmp_path / "g.glb", BOX, HAND, {"pose": np.eye(4).tolist()})
    assert BOX.visual is before
    assert list(tmp_path.iterdir()) == []
