"""The plan command and its file: round trip, refusals, same result in two processes."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.cli import main
from medkit.cli.plan import passing_pads, summary
from medkit.errors import InputError
from medkit.grasping import (
    grasp_document,
    plan_grasps,
    plan_power_grasps,
    read_grasps,
    write_grasps,
)
from medkit.grasping.export_xml import read_grasps_xml
from medkit.grasping.grasp_file import grasps_from_document
from medkit.grasping.grasp_set import GraspSet
from medkit.robots import load_hand

#: Two sliding bars on a third: the shortest description of a hand on top of a URDF.
URDF_HAND = """
schema: medkit.hand/1
name: grip
source: made up for a test
urdf: grip.urdf
base: palm
palm_direction: [0, 0, 1]
closing_axis: [0, 1, 0]
power_frame: {xyz: [0, 0, 0.1]}
sphere_radius: {min: 0.002, max: 0.045}
fingers:
  - {name: left, joints: [left], closing: [-1], tip_link: left, tip_point: [0.01, 0, 0.03],
     tip_normal: [1, 0, 0]}
  - {name: right, joints: [right], closing: [-1], tip_link: right, tip_point: [-0.01, 0, 0.03],
     tip_normal: [-1, 0, 0]}
preshapes: {power: {left: 0.06, right: 0.06}}
opposition: {thumb: left, fingers: [right]}
"""


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    path = tmp_path_factory.mktemp("mesh") / "bar.stl"
    trimesh.creation.capsule(0.12, 0.025).export(path)
    return str(path)


@pytest.fixture(scope="module")
def found():
    mesh = trimesh.creation.capsule(0.12, 0.025)
    rng = np.random.default_rng(0)
    return plan_power_grasps(mesh, load_hand("armar3"), max_candidates=10, rng=rng)


def test_file_round_trip(found, tmp_path):
    write_grasps(tmp_path / "grasps.json", found)
    again = read_grasps(tmp_path / "grasps.json")
    assert grasp_document(again) == grasp_document(found)


def test_counts_add_up(found):
    counts = grasp_document(found)["counts"]
    assert counts["spheres"] == sum(counts["sphere_fates"].values())
    assert counts["candidates"] == sum(found.outcomes.values()) == len(found.grasps) == 10


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(schema="other"), "schema"),
        (lambda d: d.pop("hand"), "hand"),
        (lambda d: d["object"].pop("sha256"), "sha256"),
        (lambda d: d["grasps"][0].pop("pose"), "pose"),
        (lambda d: d["grasps"][0].update(approach=[1.0, 2.0]), "approach"),
        (lambda d: d["grasps"][1].update(joints={}), "joints"),
        (lambda d: d["grasps"][0].update(epsilon=float("nan")), "epsilon"),
        (lambda d: d["grasps"][0].update(epsilon=-0.1), "epsilon"),
        (lambda d: d["object"].update(repairs=None), "repairs"),
        (lambda d: d["object"].update(repairs="turned outwards"), "repairs"),
        (lambda d: d["object"].update(scale="small"), "scale"),
        (lambda d: d["object"].update(scale=0.0), "scale"),
        (lambda d: d["counts"].update(candidates_found="many"), "candidates_found"),
        (lambda d: d["counts"].update(sphere_fates=[1]), "sphere_fates"),
        (lambda d: d["counts"].update(sphere_fates={"axis": "many"}), "sphere_fates"),
        (lambda d: d["timing_s"].update(total="long"), "timing_s"),
        (lambda d: d.update(seed="zero"), "seed"),
        (lambda d: d["grasps"][0]["joints"].update({"Thumb R J0": "bent"}), "Thumb R J0"),
        (lambda d: d["grasps"][0]["joints"].update({"Thumb R J0": float("nan")}), "Thumb R J0"),
        (lambda d: d["grasps"][0].update(joints=[1.0, 2.0]), "joints"),
        (lambda d: d["grasps"].__setitem__(0, 5), "outcome"),
        (lambda d: d["grasps"][0].update(pose=[[0.0] * 4] * 4), "pose"),
        (lambda d: d["grasps"][0].update(pose=np.diag([-1.0, 1.0, 1.0, 1.0]).tolist()), "pose"),
        (lambda d: d["grasps"][0].update(approach=[2.0, 0.0, 0.0]), "approach"),
        (lambda d: d["grasps"][0].update(sphere_radius=-1.0), "sphere_radius"),
        (
            lambda d: d["grasps"][0].update(
                contacts=[{"point": [0.0] * 3, "normal": [2.0, 0.0, 0.0], "link": "a"}]
            ),
            "normal",
        ),
    ],
)
def test_broken_documents_are_refused_by_name(found, change, message):
    document = json.loads(json.dumps(grasp_document(found)))
    change(document)
    with pytest.raises(InputError, match=message) as caught:
        grasps_from_document(document)
    assert "\n" not in str(caught.value)


def test_a_file_nested_without_end_is_refused(tmp_path):
    path = tmp_path / "grasps.json"
    path.write_text("[" * 100_000)
    with pytest.raises(InputError, match="Expected JSON"):
        read_grasps(path)
    with pytest.raises(InputError, match="path of a grasp file"):
        read_grasps(None)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
        max_leaves=5,
    ),
    st.data(),
)
@settings(max_examples=300, derandomize=True, deadline=None)
def test_whatever_stands_in_a_place_it_is_read_or_refused_but_never_breaks(found, junk, data):
    document = json.loads(json.dumps(grasp_document(found)))
    place = document
    while True:
        keys = sorted(place) if isinstance(place, dict) else range(len(place))
        key = data.draw(st.sampled_from(keys))
        inner = place[key]
        if not (isinstance(inner, dict | list) and inner) or data.draw(st.booleans()):
            break
        place = inner
    place[key] = junk
    with contextlib.suppress(InputError):
        assert isinstance(grasps_from_document(document), GraspSet)


def test_two_processes_give_the_same_file(bar, tmp_path):
    texts = []
    for jobs in ("1", "2"):
        out = tmp_path / f"{jobs}.json"
        options = ["--max-candidates", "8", "--jobs", jobs, "--out", str(out)]
        assert main(["plan", bar, *options]) == 0
        texts.append(json.loads(out.read_text())["grasps"])
    assert texts[0] == texts[1]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--friction", "-1"], "friction"),
        (["--friction", "nan"], "friction"),
        (["--hand", "nobody"], "hand"),
        (["--planner", "nobody"], "planner"),
        (["--scale", "1000"], "--scale"),
        (["--search-radius", "0"], "search-radius"),
        (["--min-radius-ratio", "2"], "min-radius-ratio"),
        (["--jobs", "0"], "jobs"),
        (["--max-candidates", "0"], "max-candidates"),
        (["--seed", "-3"], "seed"),
    ],
)
def test_bad_input_is_one_line_and_status_two(bar, options, message, capsys):
    assert main(["plan", bar, *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_an_output_folder_that_is_missing_is_refused_before_any_work(bar, tmp_path, capsys):
    missing = tmp_path / "nowhere" / "out.json"
    assert main(["plan", bar, "--out", str(missing)]) == 2
    assert "folder" in capsys.readouterr().err
    assert not missing.parent.exists()


@pytest.mark.parametrize("option", ["--out", "--xml", "--html", "--glb"])
def test_an_empty_file_name_is_no_wish_for_no_file(bar, option, capsys):
    assert main(["plan", bar, option, ""]) == 2
    assert "Expected a file name for the output" in capsys.readouterr().err


def test_two_outputs_in_one_file_are_refused(bar, tmp_path, capsys):
    same = str(tmp_path / "out")
    assert main(["plan", bar, "--out", same, "--xml", same]) == 2
    assert "another file for each output" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_all_outputs_tell_of_the_same_grasps(bar, tmp_path, capsys):
    names = {"--out": "g.json", "--xml": "g.xml", "--html": "g.html", "--glb": "g.glb"}
    options = [text for key, name in names.items() for text in (key, str(tmp_path / name))]
    assert main(["plan", bar, "--max-candidates", "8", *options]) == 0
    assert "best epsilon" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names.values())
    held = [g for g in read_grasps(tmp_path / "g.json").grasps if g.outcome == "force_closure"]
    back = read_grasps_xml(tmp_path / "g.xml")["grasps"]
    assert len(held) == len(back) > 0
    for one, other in zip(held, back, strict=True):
        np.testing.assert_allclose(other["pose"], one.pose, atol=1e-12)
        np.testing.assert_allclose(list(other["joints"].values()), one.q, atol=1e-12)
    scene = trimesh.load_scene(tmp_path / "g.glb")
    assert set(scene.geometry) == {"object", *load_hand("armar3").link_meshes(held[0].q)}
    assert scene.geometry["object"].volume == pytest.approx(trimesh.load(bar).volume, rel=1e-4)


def test_a_hand_whose_meshes_lie_in_a_package_folder_is_planned_with(bar, tmp_path, capsys):
    (tmp_path / "parts" / "grip").mkdir(parents=True)
    trimesh.creation.box([0.02, 0.02, 0.08]).export(tmp_path / "parts" / "grip" / "bar.stl")
    mesh = '<geometry><mesh filename="package://grip/bar.stl"/></geometry>'
    shape = f"<collision>{mesh}</collision>"
    slide = (
        '<joint name="{0}" type="prismatic"><parent link="palm"/><child link="{0}"/>'
        '<axis xyz="{1} 0 0"/><origin xyz="0 0 0.08"/>'
        '<limit lower="0.015" upper="0.06" effort="1" velocity="1"/></joint>'
    )
    (tmp_path / "grip.urdf").write_text(
        f'<robot name="grip"><link name="palm">{shape}</link>'
        f'<link name="left">{shape}</link><link name="right">{shape}</link>'
        + slide.format("left", -1)
        + slide.format("right", 1)
        + "</robot>"
    )
    (tmp_path / "grip.yaml").write_text(URDF_HAND)
    hand = str(tmp_path / "grip.yaml")
    options = ["--max-candidates", "2", "--hand", hand]
    assert main(["plan", bar, *options]) == 2
    assert "package://" in capsys.readouterr().err
    assert main(["plan", bar, *options, "--package-dir", str(tmp_path / "parts")]) == 0
    assert "hand grip" in capsys.readouterr().out


def test_an_interrupt_leaves_no_file(bar, tmp_path, monkeypatch):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr("medkit.grasping.planners.plan_grasps", interrupted)
    assert main(["plan", bar, "--out", str(tmp_path / "out.json")]) == 130
    assert list(tmp_path.iterdir()) == []


def test_pads_that_pass_each_other_are_said_to():
    """Six candidates that touched too little, by a good gripper and by one with a pad too low."""
    hand, rod = load_hand("wsg50"), trimesh.creation.capsule(0.1, 0.008)
    options = {"grasp": "precision", "max_candidates": 6, "rng": np.random.default_rng(0)}
    found = plan_grasps(rod, hand, **options)
    few = replace(
        found, grasps=tuple(replace(one, outcome="too_few_contacts") for one in found.grasps)
    )
    low = replace(hand.fingers[1], tip_point=hand.fingers[1].tip_point - [0.0, 0.0, 0.03])
    askew = replace(hand, fingers=(hand.fingers[0], low))
    assert passing_pads(few, hand) == 0
    assert passing_pads(few, askew) == 6
    assert passing_pads(found, askew) == passing_pads(replace(few, grasp="power"), askew) == 0
    assert "for 6 of them this hand's pads pass each other" in summary(few, passing=6)
    assert "pass each other" not in summary(few)
