"""A wrong argument gets one sentence: what was expected, what came, what to do."""

import inspect
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import trimesh

from medkit import datasets, grasping, handover, medial, planar, quality, similarity
from medkit.errors import InputError
from medkit.geometry import expected, points_array
from medkit.grasping import baselines, box_baseline, experiments, robustness
from medkit.grasping.batch import plan_many
from medkit.grasping.strategies import CANDIDATE_SOURCES
from medkit.robots import load_hand
from medkit.similarity import clusters, hands, ranking, symmetry

HAND = load_hand("wsg50")
BOX = trimesh.creation.box((0.03, 0.04, 0.1))
SQUARE = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]]


def plan(mesh=BOX, hand=HAND, **options):
    options = {"rng": np.random.default_rng(0), "max_candidates": 2} | options
    return grasping.plan_grasps(mesh, hand, **options)


BENCH = experiments.ObjectBench(BOX, HAND)
NORMALS = experiments.Setting("normals", "power")


def run_objects(objects=None, settings=(NORMALS,), **options):
    options = {"candidates_per_object": 2, "cache": False} | options
    return experiments.run_experiment(objects or {"box": BOX}, HAND, settings, **options)


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
    "a name for the normals": (
        lambda: baselines.surface_normal_candidates("mug"), "'mug'", "load_mesh"),
    "no triangle for the normals": (
        lambda: baselines.surface_normal_candidates(trimesh.Trimesh()), "no triangle", "load_mesh"),
    "a word for candidates": (
        lambda: baselines.surface_normal_candidates(BOX, candidates="a"), "'a'", "candidates"),
    "half a roll": (
        lambda: baselines.surface_normal_candidates(BOX, rolls=0.5), "0.5", "rolls"),
    "no mesh for the boxes": (
        lambda: box_baseline.fitted_box_candidates(None), "None", "load_mesh"),
    "no rolls for the boxes": (
        lambda: box_baseline.fitted_box_candidates(BOX, rolls=0), "0", "rolls"),
    "no mesh for a bench": (lambda: experiments.ObjectBench(None, HAND), "None", "load_mesh"),
    "a slippery bench": (
        lambda: experiments.ObjectBench(BOX, HAND, friction=-1.0), "-1", "not negative"),
    "a seed for the errors": (
        lambda: robustness.yields_under_errors(BENCH, NORMALS, most=2, rng=0), "int 0",
        "default_rng"),
    "a turn below zero": (
        lambda: robustness.yields_under_errors(
            BENCH, NORMALS, most=2, turns=[-1.0], rng=np.random.default_rng(0)),
        "-1", "not negative"),
    "a word for a setting": (lambda: run_objects(settings=["normals"]), "'normals'", "Setting"),
    "no settings": (lambda: run_objects(settings=[]), "none", "Setting"),
    "a seed below zero": (lambda: run_objects(seed=-1), "-1", "seed"),
    "no processes": (lambda: run_objects(jobs=0), "0", "jobs"),
    "names without meshes": (
        lambda: run_objects(objects=["mug"]), "'mug'", "load_folder"),
    "a word for a joint": (
        lambda: HAND.coordinates({"left finger": "open"}), "'open'", "number"),
    "an unknown preshape": (lambda: HAND.coordinates({}, preshape="fist"), "'fist'", "power"),
    "words for joints": (lambda: HAND.fingertips("open"), "'open'", "joint_names"),
    "many poses for one": (
        lambda: HAND.link_meshes(np.zeros((3, 2))), "(3, 2)", "one configuration"),
    "too few joints": (lambda: HAND.joint_values([0.01]), "(1,)", "joint_names"),
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


#: What one may pass by mistake in place of anything: the law is that no argument lets it through to
#: an error that says nothing.
WRONG = {
    "a word": "x", "nothing": None, "NaN": float("nan"), "a negative number": -1.0,
    "a dictionary": {"a": object()}, "ragged rows": [[0, 1], [2]], "an object": object(),
    "NaN in an array": np.full(3, np.nan),
}  # fmt: skip

PINCH = {"points": [[-0.04, 0.0], [0.04, 0.0]], "normals": [[1.0, 0.0], [-1.0, 0.0]]}
CIRCLE = [[np.cos(t), np.sin(t)] for t in np.arange(0.0, 6.0, 0.3)]
QUICK = planar.SqueezeSettings(push_steps=2, settle_steps=2)
HUMAN_TABLE = datasets.load_human_grasps().query("object == 'box' and trial == 1")
HUMANS = similarity.grasps_from_recordings(HUMAN_TABLE)[0]
BALL, SIZES = symmetry.ball_group(), [0.1, 0.1, 0.1]
REFERENCE = similarity.human_reference(HUMANS, recorded_extents=SIZES, extents=SIZES, group=BALL)
FOLDER = tempfile.TemporaryDirectory()  # goes with the process
BOX.export(Path(FOLDER.name) / "box.stl")
#: Right values where similarity and datasets are meant.
COMPARED = {
    "planned": HUMANS.fingertips, "human": HUMANS.fingertips, "recordings": HUMANS.fingertips,
    "fingertips": np.vstack([HUMANS.fingertips] * 3), "radius": 0.1, "group": BALL, "fingers": 5,
    "humans": HUMANS, "recorded_extents": SIZES, "extents": SIZES, "interchangeable": False,
    "reference": REFERENCE, "subject": HUMANS.subjects()[0], "by": "d_z", "table": HUMAN_TABLE,
    "cutoff": 8.0, "rate": 100.0, "settle": 0.0, "objects": datasets.load_human_objects(),
    "mesh": trimesh.creation.icosphere(1), "rng": np.random.default_rng(0), "draws": 20, "most": 2,
    "references": 2, "leave_out": "subject", "center": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0],
    "second": [1.0, 0.0, 0.0], "fold": 3, "flips": True, "measures": ("d_eucl", "d_z"),
    "threshold": 0.1, "tolerance": 0.02, "size": "hand", "scale": 1.0, "ratings": None,
    "path": None, "load_folder": {"path": FOLDER.name}, "load_printed": {"name": "timing_symmetry"},
    "name": "salt_box", "rank_agreement": {
        "table": similarity.rank_grasps(1.1 * HUMANS.fingertips, REFERENCE)},
}  # fmt: skip
TRIALS = handover.load_trials().query("subject in ('T1', 'T2') and force_N in (2, 5, 10)")
COUNTS = [[1, 3, 16], [5, 10, 5], [16, 3, 1]]
#: The same for handover.
RATED = {
    "trials": TRIALS, "draws": 3, "shuffles": 9, "bins": 2, "leave_subject_out": False,
    "level": 0.75, "subject": "T1", "rng": np.random.default_rng(0), "tables": {"two": TRIALS},
    "terms": ("root_force",), "slopes": (), "eta": 0.0, "thresholds": [-1.0, 1.0],
    "design": [[1.0], [2.0], [3.0]], "counts": COUNTS, "ridge": 1e-3, "tolerance": 1e-8,
    "start": None, "estimates": handover.subject_estimates(TRIALS), "subjects": 2, "chance": 0.8,
    "slope_power": {"estimates": [1.0, 2.0, 3.0], "subjects": (4,)}, "observed": 4, "size": 5,
    "claim_power": {"subjects": (4,)}, "repetitions": 4, "studies": 2, "spread": ((0.6,),),
    "power": pd.DataFrame({"number": 1, "subjects": [4, 8], "power": [0.5, 0.9]}),
    "weight_error_kg": 0.1, "bump_N": 0.5, "weights": [0.1], "scope": "these", "by": ["pose"],
    "irregular": "drop", "path": None, "ratings": None, "weight_g": 20, "printed_g": 24,
}  # fmt: skip
AXIS = medial.medial_axis(BOX)
#: The same for the medial axis in space.
SPATIAL = {
    "axis": AXIS, "min_angle": 2.0, "ratio": 0.5, "min_lambda": 0.01, "scale": 1.1, "mesh": BOX,
    "grid": medial.MedialSphereGrid.from_axis(AXIS), "radius": 0.03, "rho_axis": 0.01,
    "rho_plane": 0.4, "min_neighbors": 5, "point_spread": 0.02, "spacing": 0.01,
    "side": "interior", "touch_tolerance": 0.001, "sample": medial.sample_surface(BOX),
    "crease_angle": 0.5,
}  # fmt: skip
#: One right value for each name of an argument, and for a function where the name means another.
RIGHT = PINCH | {
    "friction": 0.5, "torque_origin": [0.0, 0.0], "torque_scale": 0.04, "edges": 8, "norm": "l1",
    "contact": "point", "patch_radius": 0.005, "tolerance": 0.01, "largest": 100.0, "limit": 20,
    "wrenches": np.vstack([np.eye(3), -np.ones((1, 3))]), "outline": planar.rectangle(),
    "outlines": [planar.rectangle()], "frictions": {"steel": 0.5}, "disks": 1, "settings": QUICK,
    "jobs": 1, "length": 0.1, "thickness": 0.02, "width": 0.08, "height": 0.04, "size": 0.08,
    "axis": planar.medial_axis(SQUARE), "min_span": 0.01, "min_angle": 1.0, "scale": 1.1,
    "object_angle": 2.0, "object_angles": [2.0], "first": "metals", "second": "wood",
    "spacing": 0.01, "outer": SQUARE, "holes": (), "name": "shape", "progress": False,
    "rng": np.random.default_rng(0), "radius": 0.03, "roughness": 0.3, "corners": 5,
    "p1": [-0.04, 0.0], "p2": [0.04, 0.0], "low": 0.1, "high": 1.0, "samples": 64,
    "coefficients": [0.0, 0.03, 0.001], "harmonics": 4, "fixture": "points", "offset": 0.0,
    "frames": 0, "inner_ratio": 0.5, "angles_deg": (30.0, 80.0), "base": 0.08,
    "epsilon_many": {name: [rows] for name, rows in PINCH.items()},
    "antipodal_pairs": {"outline": planar.ellipse()}, "phase_diagram": {"frictions": [0.5]},
    "star": {"points": 5}, "smooth_through": {"points": CIRCLE},
}  # fmt: skip


ROOMS = (quality, planar, medial, similarity, handover, datasets)
#: Which of them a room takes.
RIGHT_IN = {
    "quality": RIGHT, "planar": RIGHT, "similarity": COMPARED, "datasets": COMPARED,
    "handover": RATED, "medial": SPATIAL,
}  # fmt: skip
#: What students call though the room's front does not name it.
BEHIND = {
    similarity: [
        ranking.rank_agreement, ranking.ranking_stability, hands.correspondence,
        hands.scaled_to_object, symmetry.trivial_group, symmetry.cyclic_group,
        symmetry.dihedral_group, symmetry.revolution_group, symmetry.ball_group,
        clusters.find_clusters, clusters.aligned,
    ],
}  # fmt: skip


def public_functions(room):
    names = getattr(room, "__all__", [name for name in vars(room) if name[0] != "_"])
    front = [one for one in (getattr(room, name) for name in names) if inspect.isfunction(one)]
    return front + BEHIND.get(room, [])


def public_arguments(*rooms):
    for room in rooms:
        for function in public_functions(room):
            for argument in inspect.signature(function).parameters.values():
                if argument.kind is not argument.VAR_KEYWORD:
                    name = f"{function.__name__}-{argument.name}"
                    yield pytest.param(function, argument.name, id=name)


def right_arguments(function):
    known = RIGHT_IN[function.__module__.split(".")[1]]
    known = known | known.get(function.__name__, {})
    names = inspect.signature(function).parameters.values()
    return {one.name: known[one.name] for one in names if one.kind is not one.VAR_KEYWORD}


@pytest.mark.parametrize(("function", "argument"), list(public_arguments(*ROOMS)))
def test_whatever_comes_is_used_or_refused_in_one_sentence(function, argument):
    right = right_arguments(function)
    refused = 0
    for wrong in WRONG.values():
        try:
            function(**right | {argument: wrong})
        except InputError as error:
            text, refused = str(error), refused + 1
            assert text.startswith("Expected "), text
            assert text.endswith("."), text
            assert "\n" not in text
    # a name, a switch and what a frictionless test ignores are all that takes anything
    free = ("name", "progress", "patch_radius", "edges", "torque_origin", "torque_scale")
    assert refused or argument in free


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize(
    "function",
    [handover.fit_population, handover.iso_score, handover.recommend_force, handover.calibration,
     handover.link_comparison, handover.slope_estimates, handover.method_agreement,
     handover.proportional_odds_check, handover.leave_one_subject_out],
    ids=lambda function: function.__name__,
)  # fmt: skip
def test_what_is_no_table_of_trials_is_refused_in_one_sentence(function, wrong):
    with pytest.raises(InputError, match=r"^Expected a table of trials.*load_trials"):
        function(wrong)


@pytest.mark.parametrize("room", ROOMS)
def test_the_right_arguments_of_the_law_are_right(room):
    for function in public_functions(room):
        right = right_arguments(function)
        if len(right) > 1:  # the law replaces the only argument of the others
            function(**right)
