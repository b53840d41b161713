"""A wrong argument gets one sentence: what was expected, what came, what to do."""

import numpy as np
import pandas as pd
import pytest
import trimesh

from medkit import grasping, handover, planar, quality
from medkit.errors import InputError
from medkit.geometry import expected, points_array
from medkit.grasping.batch import plan_many
from medkit.grasping.planners import CANDIDATE_SOURCES
from medkit.robots import load_hand

HAND = load_hand("wsg50")
BOX = trimesh.creation.box((0.03, 0.04, 0.1))
SQUARE = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]]


def plan(mesh=BOX, hand=HAND, **options):
    options = {"rng": np.random.default_rng(0), "max_candidates": 2} | options
    return grasping.plan_grasps(mesh, hand, **options)


def turned(mesh):
    inside_out = mesh.copy()
    inside_out.invert()
    return inside_out


def sheet():
    return trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 1]])


def with_nan():
    vertices = np.array(BOX.vertices)
    vertices[0, 0] = np.nan
    return trimesh.Trimesh(vertices, BOX.faces, process=False)


#: What a student may type by mistake, what the sentence names, and the remedy in it.
MISTAKES = {
    "a mesh's name": (lambda: plan("mug"), "'mug'", "load_mesh"),
    "no mesh": (lambda: plan(None), "None", "load_mesh"),
    "a hand's number": (lambda: plan(hand=3), "int 3", "load_hand"),
    "a hand nobody knows": (lambda: plan(hand="claw"), "'claw'", "wsg50"),
    "a seed in place of a generator": (lambda: plan(rng=0), "int 0", "default_rng"),
    "no generator": (lambda: plan(rng=None), "None", "default_rng"),
    "nothing to plan on": (lambda: plan(trimesh.Trimesh()), "no triangle", "repair_mesh"),
    "a sheet": (lambda: plan(sheet()), "volume", "repair_mesh"),
    "a point": (lambda: plan(trimesh.Trimesh(np.zeros((3, 3)), [[0, 1, 2]], process=False)),
                "volume", "repair_mesh"),
    "inside out": (lambda: plan(turned(BOX)), "inside-out", "repair_mesh"),
    "NaN": (lambda: plan(with_nan()), "NaN", "export"),
    "a mesh's name for the axis": (lambda: grasping.medial_axis("mug"), "'mug'", "load_mesh"),
    "a mesh for the grid": (
        lambda: grasping.MedialSphereGrid.from_axis(BOX), "trimesh.Trimesh", "medial_axis"),
    "a planar axis for the grid": (
        lambda: grasping.MedialSphereGrid.from_axis(planar.medial_axis(SQUARE)),
        "medkit.planar.MedialAxis", "medkit.grasping.medial_axis"),
    "an axis for the symmetry": (
        lambda: grasping.local_symmetry(grasping.medial_axis(BOX), 0.03),
        "medkit.medial.MedialAxis", "from_axis"),
    "words for an outline": (lambda: planar.medial_axis(["a", "b"]), "numbers", "outer loop"),
    "a mesh for an outline": (lambda: planar.medial_axis(BOX), "trimesh.Trimesh", "outline"),
    "a word for friction": (
        lambda: quality.is_force_closure([[0.0, 0, 0]], [[0.0, 0, 1]], friction="x"),
        "'x'", "coefficient"),
    "ragged contacts": (
        lambda: quality.is_force_closure([[0.0, 0], [1.0]], [[0.0, 1]], friction=0.5),
        "something else", "arrays"),
    "a list for a table": (lambda: handover.score([1, 2]), "a list", "load_trials"),
    "a list for means": (lambda: handover.mean_scores([1], ["pose"]), "a list", "load_trials"),
    "no table": (lambda: handover.claims(None), "None", "load_trials"),
    "a seed for the claims": (
        lambda: handover.claims(handover.load_trials(), rng=0), "int 0", "default_rng"),
    "a number for a hand": (lambda: load_hand(3), "int 3", "armar3"),
    "a hand for its name": (lambda: load_hand(HAND), "medkit.robots.Hand", "armar3"),
    "ragged points": (lambda: points_array([[0, 1], [2]], 2), "numbers", "row"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_gets_one_sentence_that_says_what_to_do(name):
    mistake, came, remedy = MISTAKES[name]
    with pytest.raises(InputError) as caught:
        mistake()
    text = str(caught.value)
    assert text.startswith("Expected ")
    assert came in text
    assert remedy in text
    assert "\n" not in text
    assert text.endswith((".", "?"))


@pytest.mark.parametrize("planner", CANDIDATE_SOURCES)
@pytest.mark.parametrize(("edge", "scale"), [(100.0, "0.001"), (12.0, "0.01"), (1e-4, "1.5e+03")])
def test_a_mesh_in_other_units_is_refused_before_any_work(planner, edge, scale):
    with pytest.raises(InputError, match="longest edge") as caught:
        plan(trimesh.creation.box((edge, edge / 2, edge / 2)), planner=planner)
    assert f"load_mesh(path, scale={scale})" in str(caught.value)
    assert "--scale" not in str(caught.value)


@pytest.mark.parametrize("edge", [0.8, 0.01])
def test_furniture_and_trinkets_are_planned(edge):
    planned = plan(trimesh.creation.box((edge, edge / 2, edge / 2)), planner="boxes")
    assert len(planned) == 2


def test_the_name_of_a_hand_does_for_the_hand(tmp_path):
    by_name, by_hand = plan(hand="wsg50"), plan(hand=HAND)
    assert by_name.hand == by_hand.hand == "wsg50"
    assert [one.pose.tolist() for one in by_name.grasps] == [
        one.pose.tolist() for one in by_hand.grasps
    ]
    ask = {"max_candidates": 2, "planner": "boxes"}
    planned = []
    for hand in ("wsg50", HAND):
        done = lambda name, _: planned.append(name)  # noqa: E731
        plan_many({"box": BOX}, hand, tmp_path, done=done, **ask)
    assert planned == ["box"]


def test_a_batch_tells_the_wrong_object_and_plans_the_rest(tmp_path):
    metres = trimesh.creation.box((30.0, 40.0, 100.0))
    with pytest.raises(InputError, match=r"among them 'millimetres' \(.*scale=0\.001"):
        plan_many({"millimetres": metres, "box": BOX}, HAND, tmp_path, planner="boxes",
                  max_candidates=2)  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["box.json"]


def test_points_do_for_an_outline():
    direct = planar.medial_axis(planar.outline_from_loops(SQUARE))
    for points in (SQUARE, np.array(SQUARE), tuple(map(tuple, SQUARE))):
        assert np.array_equal(planar.medial_axis(points).centers, direct.centers)


@pytest.mark.parametrize(
    ("value", "named"),
    [(None, "None"), (3, "int 3"), ("x" * 99, "str 'xxx"), ([1, 2], "a list of 2"),
     (np.zeros((4, 3)), "numpy.ndarray of 4"), (pd.DataFrame(), "pandas.DataFrame")],
)  # fmt: skip
def test_what_came_is_named_in_few_words(value, named):
    with pytest.raises(InputError) as caught:
        expected(value, dict, "a dictionary", "pass {}")
    text = str(caught.value)
    assert text.startswith("Expected a dictionary, but got ")
    assert named in text
    assert len(text) < 120
    assert text.endswith("; pass {}.")


def test_what_is_right_comes_back_as_it_is():
    value = {"a": 1}
    assert expected(value, dict, "a dictionary", "pass {}") is value
