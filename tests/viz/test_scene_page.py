"""The page with the grasps in 3-D: complete in itself, and true to the hand's kinematics."""

import base64
import json
import re

import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.geometry import random_rotation, transform
from medkit.robots import load_hand
from medkit.viz.scene import MOST_FACES, scene_html, write_scene_html

HAND = load_hand("wsg50")
BOX = trimesh.creation.box((0.05, 0.08, 0.1))


def grasp(seed=0, **changes):
    rng = np.random.default_rng(seed)
    entry = {
        "outcome": "force_closure",
        "pose": transform(random_rotation(rng), rng.normal(size=3)).tolist(),
        "joints": {"left finger": -0.03, "right finger": -0.02},
        "contacts": [{"point": [0, 0, 0.05], "normal": [0, 0, -1], "link": "left finger"}],
        "epsilon": 0.1,
        "pregrasp": np.eye(4).tolist(),
        "sphere_radius": 0.02,
    }
    return entry | changes


def data_of(page):
    return json.loads(re.search(r'type="application/json">(.*?)</script>', page, re.S)[1])


def floats(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def test_links_are_posed_where_the_kinematics_put_them():
    entry = grasp(4)
    shown = data_of(scene_html(BOX, HAND, [entry], title="A box"))["grasps"][0]
    matrices = floats(shown["poses"]).reshape(-1, 4, 4).swapaxes(1, 2)
    q = HAND.coordinates(entry["joints"])
    expected = np.array(entry["pose"]) @ HAND.link_poses(q)
    np.testing.assert_allclose(matrices, expected[[b.link for b in HAND.bodies]], atol=1e-6)


def test_the_object_is_drawn_as_it_is():
    shown = data_of(scene_html(BOX, HAND, [], title="A box"))["object"]
    np.testing.assert_allclose(floats(shown["points"]).reshape(-1, 3), BOX.vertices, atol=1e-7)


def test_the_page_asks_for_nothing_from_elsewhere():
    page = scene_html(BOX, HAND, [grasp()], title="A box")
    assert not re.search(r"https?:|src=|@import|url\((?!data:)", page)
    assert "{{" not in page


def test_force_closure_by_epsilon_comes_first_and_every_outcome_is_there():
    entries = [
        grasp(outcome="start_collision", epsilon=None, contacts=[]),
        grasp(epsilon=0.1),
        grasp(epsilon=0.3),
    ]
    shown = data_of(scene_html(BOX, HAND, entries, title="A box"))["grasps"]
    assert [entry["number"] for entry in shown] == [2, 1, 0]
    assert shown[-1]["epsilon"] is None
    fewer = data_of(scene_html(BOX, HAND, entries, title="A box", most=1))["grasps"]
    assert [entry["number"] for entry in fewer] == [2]


def test_names_cannot_break_out_of_the_page():
    entry = grasp(outcome="</script><b>")
    page = scene_html(BOX, HAND, [entry], title="<i>A & B</i>")
    assert "&lt;i&gt;A &amp; B&lt;/i&gt;" in page
    assert "</script><b>" not in page
    assert data_of(page)["grasps"][0]["outcome"] == "</script><b>"


def test_a_very_fine_object_is_made_light_and_keeps_its_size():
    ball = trimesh.creation.icosphere(subdivisions=6, radius=0.05)
    assert len(ball.faces) > MOST_FACES
    page = scene_html(ball, HAND, [grasp(k) for k in range(100)], title="A ball")
    assert len(page) < 2_000_000
    points = floats(data_of(page)["object"]["points"]).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.05, atol=1e-6)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"joints": {}}, "'pose' in grasp 0"),
        (grasp(pose=[1, 2]), "'pose' of grasp 0 as a 4 x 4"),
        (grasp(joints={"knee": 1.0}), "but got 'knee'"),
    ],
)
def test_grasps_that_cannot_be_drawn_are_refused(entry, words):
    with pytest.raises(InputError, match=words):
        scene_html(BOX, HAND, [entry], title="A box")


def test_writing_twice_gives_the_same_file(tmp_path):
    for name in ("one.html", "two.html"):
        write_scene_html(
            tmp_path / name, title="A box", object_mesh=BOX, hand=HAND, grasps=[grasp()]
        )
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()
