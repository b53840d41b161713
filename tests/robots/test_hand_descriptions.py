"""Hands of the user's own: a URDF with a short YAML, and every mistake in them."""

import re
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml

from medkit.errors import InputError
from medkit.geometry import inverse
from medkit.robots import load_hand
from medkit.robots.check import PROBLEM, check_hand, closed_configuration
from medkit.robots.self_collision import SelfCollision

DATA = Path(__file__).parent / "data"


def changed(tmp_path, edit, urdf_edit=None):
    """Write the test hand with one thing changed, and return its path."""
    document = yaml.safe_load((DATA / "two_finger.yaml").read_text())
    document["package_dirs"] = [str(DATA / "packages")]
    edit(document)
    text = (DATA / "two_finger.urdf").read_text()
    (tmp_path / "two_finger.urdf").write_text(urdf_edit(text) if urdf_edit else text)
    path = tmp_path / "hand.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def test_a_urdf_hand_moves_as_pinocchio_says():
    hand = load_hand(DATA / "two_finger.yaml")
    assert hand.joint_names == ("left_knuckle", "slider")
    model = pin.buildModelFromUrdf(str(DATA / "two_finger.urdf"))
    data = model.createData()
    for q in ([0.0, 0.0], [0.7, 0.01], [-0.2, 0.02]):
        full = np.zeros(model.nq)
        for name, value in (("left_knuckle", q[0]), ("right_knuckle", q[0]), ("slider", q[1])):
            joint = model.joints[model.getJointId(name)]
            full[joint.idx_q] = value
        pin.framesForwardKinematics(model, data, full)
        base = data.oMf[model.getFrameId("palm")].homogeneous
        for name, pose in zip(hand.link_names, hand.link_poses(q), strict=True):
            placed = data.oMf[model.getFrameId(name)].homogeneous
            np.testing.assert_allclose(inverse(base) @ placed, pose, atol=1e-12)


def test_geometry_of_every_kind_becomes_bodies():
    hand = load_hand(DATA / "two_finger.yaml")
    bounds = {name: mesh.extents for name, mesh in hand.link_meshes([0.0, 0.0]).items()}
    np.testing.assert_allclose(bounds["palm"], [0.10, 0.06, 0.065], atol=1e-9)
    np.testing.assert_allclose(bounds["left_finger"], [0.012, 0.02, 0.08], atol=1e-9)
    np.testing.assert_allclose(bounds["right_finger"], [0.012, 0.02, 0.08], atol=1e-9)
    np.testing.assert_allclose(bounds["left_tip"], [0.016] * 3, atol=1e-9)
    assert len([b for b in hand.bodies if hand.link_names[b.link] == "palm"]) == 2


def test_the_package_folder_can_be_given_from_outside(tmp_path):
    path = changed(tmp_path, lambda d: d.pop("package_dirs"))
    with pytest.raises(InputError, match="--package-dir"):
        load_hand(path)
    assert len(load_hand(path, package_dirs=[DATA / "packages"]).fingers) == 2


def test_a_good_hand_has_no_problem_and_closes():
    hand = load_hand(DATA / "two_finger.yaml")
    assert not [finding for finding in check_hand(hand) if finding.level == PROBLEM]
    q = closed_configuration(hand)
    assert q[0] > 0.1
    assert not SelfCollision(hand).collides(q)


def set_key(key, value):
    return lambda document: document.__setitem__(key, value)


def set_finger(key, value):
    return lambda document: document["fingers"][0].__setitem__(key, value)


MISTAKES = {
    "missing key": (lambda d: d.pop("palm_direction"), "'palm_direction' .* is missing"),
    "unknown key": (set_key("palm_directon", [0, 0, 1]), "did you mean 'palm_direction'"),
    "no unit vector": (set_key("closing_axis", [0, 2, 0]), r"length 1 .* write \[0.0, 1.0, 0.0\]"),
    "zero vector": (set_key("closing_axis", [0, 0, 0]), "give a direction"),
    "no vector": (set_key("closing_axis", "y"), "Expected 3 numbers for 'closing_axis'"),
    "wrong schema": (set_key("schema", "hand/7"), "Expected schema 'medkit.hand/1'"),
    "unknown joint": (set_finger("joints", ["left_nuckle"]), "did you mean 'left_knuckle'"),
    "follower as joint": (set_finger("joints", ["right_knuckle"]), "Unknown joint"),
    "unknown tip link": (set_finger("tip_link", "left_tp"), "did you mean 'left_tip'"),
    "bad closing": (set_finger("closing", [2]), "one .1 or -1 per joint"),
    "no fingers": (set_key("fingers", []), "at least one"),
    "fingers as text": (set_key("fingers", "two"), "Expected a list"),
    "limits reversed": (set_key("limits", {"slider": [0.02, 0.0]}), "above 0; swap"),
    "limits of no joint": (set_key("limits", {"slyder": [0, 1]}), "did you mean 'slider'"),
    "preshape outside": (
        set_key("preshapes", {"power": {"slider": 3.0}}),
        "within its limits .* but got 3",
    ),
    "unknown preshape": (set_key("preshapes", {"pwer": {}}), "did you mean 'power'"),
    "coupling to none": (
        set_key("couplings", {"slider": {"follows": "x"}}),
        "Unknown joint 'x' in the couplings",
    ),
    "chain of couplings": (
        set_key("couplings", {"slider": {"follows": "right_knuckle"}}),
        "follows another joint itself",
    ),
    "unknown finger": (
        set_key("opposition", {"thumb": "thumb", "fingers": ["right"]}),
        "Unknown finger 'thumb'",
    ),
    "thumb against itself": (
        set_key("opposition", {"thumb": "left", "fingers": ["left"]}),
        "at least one other finger",
    ),
    "finger without joints": (set_finger("joints", []), "at least one joint"),
    "unknown unit": (set_key("units", {"length": "inch"}), "Unknown unit 'inch'"),
    "both sources": (set_key("links", [{"name": "a"}]), "either 'urdf' or 'links'"),
    "no such urdf": (set_key("urdf", "three_finger.urdf"), "Expected a URDF at .*No such file"),
    "no such base": (set_key("base", "plam"), "Expected the base link to be one of"),
    "no such package": (set_key("package", "no_such_package"), "to be installed"),
    "ragged closing": (set_finger("closing", [[1], 1]), "one .1 or -1 per joint"),
    "joint twice": (
        set_finger("joints", ["left_knuckle", "left_knuckle"]),
        r"palm to tip.*write \['left_knuckle'\]",
    ),
    "joint of another finger": (set_finger("joints", ["slider"]), "move its tip link 'left_tip'"),
    "tip link on the palm": (set_finger("tip_link", "palm"), "move its tip link 'palm'"),
    "name twice": (set_finger("name", "right"), "finger names to differ.*'right' twice"),
    "opponent twice": (
        set_key("opposition", {"thumb": "left", "fingers": ["right", "right"]}),
        "each finger once",
    ),
    "wider limits": (set_key("limits", {"slider": [0.0, 0.5]}), "within those of"),
    "joint order": (
        set_key("joint_order", ["slider"]),
        "'left_knuckle' is listed 0 times; list .*left_knuckle, slider",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_explained_in_one_sentence(tmp_path, mistake):
    edit, words = MISTAKES[mistake]
    with pytest.raises(InputError, match=words) as caught:
        load_hand(changed(tmp_path, edit))
    assert "\n" not in str(caught.value)


URDF_MISTAKES = {
    "no xml": (lambda text: text[:200], "Expected XML"),
    "xacro": (lambda _: "<xacro/>", "xacro file has to be expanded"),
    "floating": (lambda text: text.replace('"prismatic"', '"floating"'), "type 'floating'"),
    "no such link": (lambda text: text.replace('child link="right_tip"', 'child link="x"'), "'x'"),
    "words": (lambda text: text.replace('xyz="-0.04 0 0.02"', 'xyz="a b c"'), "'a b c'"),
    "no mesh": (lambda text: text.replace("finger.stl", "f.stl"), "Expected to find the mesh"),
    "no number": (lambda text: text.replace('upper="1.2"', 'upper="wide"'), "'wide'"),
    "no size": (lambda text: text.replace('size="0.10 0.06 0.04"', ""), "three numbers for 'size'"),
    "link twice": (
        lambda text: text.replace("</robot>", '<link name="palm"/></robot>'),
        "'palm' twice",
    ),
    "joint twice": (
        lambda text: text.replace('name="left_tip_joint"', 'name="slider"'),
        "'slider' twice",
    ),
    "two parents": (
        lambda text: text.replace('child link="right_tip"', 'child link="left_tip"'),
        "one parent for every link.*'left_tip'",
    ),
    "no links": (lambda _: '<robot name="none"/>', "at least one link"),
    "no axis": (
        lambda text: text.replace('axis xyz="0 0 1"', 'axis xyz="0 0 0"'),
        "axis of joint 'slider'",
    ),
    "turned-over box": (
        lambda text: text.replace('size="0.10', 'size="-0.10'),
        "above zero.*'size' of <box>",
    ),
    "no radius": (
        lambda text: text.replace('radius="0.008"', 'radius="0"'),
        "above zero.*'radius' of <sphere>",
    ),
    "no bodies": (
        lambda text: re.sub(r"<(collision|visual)>.*?</\1>", "", text, flags=re.DOTALL),
        "at least one link with a body",
    ),
    "flat limits": (lambda text: text.replace('upper="0.02"', 'upper="0"'), "lower limit .*slider"),
}


@pytest.mark.parametrize("mistake", URDF_MISTAKES)
def test_mistakes_in_the_urdf_too(tmp_path, mistake):
    edit, words = URDF_MISTAKES[mistake]
    with pytest.raises(InputError, match=words) as caught:
        load_hand(changed(tmp_path, lambda document: None, edit))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [("[1, 2", "parsing failed"), ("- a\n- b", "'key: value' lines"), ("", "'key: value' lines")],
)
def test_what_is_no_description_is_refused(tmp_path, text, words):
    path = tmp_path / "hand.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        load_hand(path)
    with pytest.raises(InputError, match="reading failed"):
        load_hand(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="names this file under 'urdf'"):
        load_hand(DATA / "two_finger.urdf")


def test_joints_are_listed_from_palm_to_tip(tmp_path):
    document = yaml.safe_load((DATA / "two_finger.yaml").read_text())
    for key in ("urdf", "package_dirs"):
        document.pop(key)
    turn = {"type": "revolute", "axis": [0, 1, 0], "limits": [0, 1]}
    ball = [{"spheres": [[0, 0, 0, 0.01], [0, 0, 0.02, 0.01]]}]
    document["links"] = [
        {"name": "left_tip", "joint": turn | {"name": "slider"}, "body": ball},
        {"name": "middle", "joint": turn | {"name": "first"}, "body": ball},
        {"name": "right_tip", "parent": "middle", "joint": turn | {"name": "second"}, "body": ball},
    ]
    document["fingers"][0]["joints"] = ["slider"]
    path = tmp_path / "hand.yaml"
    document["fingers"][1]["joints"] = ["first", "second"]
    path.write_text(yaml.safe_dump(document))
    assert len(load_hand(path).fingers[1].joints) == 2
    document["fingers"][1]["joints"] = ["second", "first"]
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError, match=r"palm to tip.*write \['first', 'second'\]"):
        load_hand(path)


def test_a_key_given_twice_is_refused_instead_of_the_first_being_forgotten(tmp_path):
    path = changed(tmp_path, lambda document: None)
    path.write_text(path.read_text() + "\nname: again\n")
    with pytest.raises(InputError, match="'name' is given twice"):
        load_hand(path)


def test_the_original_of_a_mirrored_hand_is_no_mirror_image_itself(tmp_path):
    path = tmp_path / "mirrored.yaml"
    path.write_text("schema: medkit.hand/1\nname: two\nmirror_of: mirrored.yaml")
    with pytest.raises(InputError, match="mirror image itself"):
        load_hand(path)


INLINE_MISTAKES = {
    "parent below": ({"parent": "tip"}, "to be a link above it"),
    "twice": ({"name": "base"}, "appears twice"),
    "joint type": ({"joint": {"name": "j", "type": "ball"}}, "Unknown joint type"),
    "reversed": (
        {"joint": {"name": "j", "axis": [0, 0, 1], "limits": [2, 1]}},
        "lower, upper.*swap",
    ),
    "box corners": ({"body": [{"box": [[1, 1, 1], [0, 0, 0]]}]}, "order the corners"),
    "box rows": ({"body": [{"box": [[1, 1, 1]]}]}, "two corners"),
    "ragged": ({"body": [{"spheres": [[1, 1, 1]]}]}, "rows of 4 numbers"),
    "flat": ({"body": [{"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}]}, "solid"),
}


@pytest.mark.parametrize("mistake", INLINE_MISTAKES)
def test_mistakes_in_an_inline_table(tmp_path, mistake):
    extra, words = INLINE_MISTAKES[mistake]
    document = yaml.safe_load((DATA / "two_finger.yaml").read_text())
    for key in ("urdf", "package_dirs", "base"):
        document.pop(key)
    document["links"] = [{"name": "finger"} | extra]
    path = tmp_path / "hand.yaml"
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError, match=words):
        load_hand(path)


def finding(hand, topic):
    return [f for f in check_hand(hand) if f.topic == topic and f.level == PROBLEM]


def test_the_check_finds_what_loads_but_cannot_work(tmp_path):
    backwards = load_hand(changed(tmp_path, set_finger("tip_normal", [-1, 0, 0])))
    assert finding(backwards, "closing")
    slanted = load_hand(changed(tmp_path, set_key("closing_axis", [0, 0, 1])))
    assert finding(slanted, "directions")
    degrees = load_hand(changed(tmp_path, lambda d: None, lambda t: t.replace('"1.2"', '"70"')))
    assert finding(degrees, "limits")
    huge = load_hand(changed(tmp_path, set_key("sphere_radius", {"min": 5, "max": 35})))
    assert finding(huge, "ball size")
    crossed = load_hand(changed(tmp_path, set_key("preshapes", {"power": {"left_knuckle": 1.2}})))
    assert finding(crossed, "preshape power")


def test_a_hand_can_come_from_an_installed_package(tmp_path, monkeypatch):
    info = tmp_path / "site" / "fake_hand-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-hand\nVersion: 1.0\n")
    share = tmp_path / "site" / "share"
    shutil.copytree(DATA / "packages", share)
    shutil.copy(DATA / "two_finger.urdf", share)
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    edit = {"package": "fake-hand", "package_dirs": ["share"], "urdf": "share/two_finger.urdf"}
    hand = load_hand(changed(tmp_path, lambda document: document.update(edit)))
    assert hand.joint_names == ("left_knuckle", "slider")


def test_a_mirrored_hand_takes_everything_from_its_original(tmp_path):
    path = tmp_path / "mirrored.yaml"
    text = "schema: medkit.hand/1\nname: two\nmirror_of: " + str(DATA / "two_finger.yaml")
    path.write_text(text)
    assert load_hand(path).name == "two"
    path.write_text(text + "\npalm_direction: [0, 0, 1]")
    with pytest.raises(InputError, match="Unexpected key 'palm_direction'"):
        load_hand(path)


def test_sliding_joints_and_the_owners_of_links_are_known():
    hand = load_hand(DATA / "two_finger.yaml")
    assert hand.prismatic_joints == ("slider",)
    owners = hand.finger_of_link()
    assert owners == {"left_finger": 0, "left_tip": 0, "right_finger": 1, "right_tip": 1}
    assert load_hand("wsg50").prismatic_joints == ("left finger", "right finger")
    assert load_hand("schunk").prismatic_joints == ()
