"""Grasp sets as XML: what goes out comes back, and the convention is the reader's."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from medkit.errors import InputError
from medkit.geometry import inverse, random_rotation, transform
from medkit.grasping.export_xml import read_grasps_xml, write_grasps_xml


def pose(seed):
    rng = np.random.default_rng(seed)
    return transform(random_rotation(rng), rng.normal(size=3))


def document(count=3):
    outcomes = ["force_closure", "start_collision", "force_closure"]
    return {
        "schema": "medkit.grasps/1",
        "object": {"path": "models/mug <1>.obj"},
        "hand": "armar3",
        "planner": "medial",
        "grasp": "power",
        "grasps": [
            {
                "outcome": outcomes[k % 3],
                "pose": pose(k).tolist(),
                "pregrasp": pose(k + 10).tolist(),
                "joints": {"Index R J0": 0.1 * k, "Thumb R J1": 1 / 3},
                "contacts": [],
                "epsilon": 0.125 * k if k != 1 else None,
            }
            for k in range(count)
        ],
    }


def test_every_number_comes_back(tmp_path):
    source = document()
    assert write_grasps_xml(tmp_path / "g.xml", source, outcomes=None) == 3
    back = read_grasps_xml(tmp_path / "g.xml")
    assert back["object"]["path"] == "mug <1>"
    assert back["hand"] == "armar3"
    for one, other in zip(source["grasps"], back["grasps"], strict=True):
        np.testing.assert_allclose(other["pose"], one["pose"], atol=1e-14)
        np.testing.assert_allclose(other["pregrasp"], one["pregrasp"], atol=1e-14)
        assert other["joints"] == one["joints"]
        assert other["outcome"] == one["outcome"]
        assert other["epsilon"] == (one["epsilon"] or 0.0)


def test_only_good_grasps_go_out_unless_asked(tmp_path):
    assert write_grasps_xml(tmp_path / "g.xml", document()) == 2
    names = [grasp["name"] for grasp in read_grasps_xml(tmp_path / "g.xml")["grasps"]]
    assert names == ["Grasp 0", "Grasp 2"]


def test_the_transform_is_the_object_in_the_tool_frame_in_millimetres(tmp_path):
    source, tool = document(1), pose(7)
    write_grasps_xml(tmp_path / "g.xml", source, T_hand_tcp=tool, preshape="Grasp Preshape")
    grasp = ET.parse(tmp_path / "g.xml").find(".//Grasp")
    assert grasp.get("Preshape") == "Grasp Preshape"
    rows = [grasp.find(f"Transform/Matrix4x4/row{k}") for k in (1, 2, 3, 4)]
    matrix = np.array([[float(row.get(f"c{c}")) for c in (1, 2, 3, 4)] for row in rows])
    expected = inverse(tool) @ inverse(source["grasps"][0]["pose"])
    expected[:3, 3] *= 1000.0
    np.testing.assert_allclose(matrix, expected, atol=1e-10)
    back = read_grasps_xml(tmp_path / "g.xml", T_hand_tcp=tool)["grasps"][0]
    np.testing.assert_allclose(back["pose"], source["grasps"][0]["pose"], atol=1e-13)


def test_degrees_of_other_writers_are_understood(tmp_path):
    write_grasps_xml(tmp_path / "g.xml", document(1))
    text = (tmp_path / "g.xml").read_text().replace('unit="radian"', 'unit="degree"')
    (tmp_path / "g.xml").write_text(text)
    joints = read_grasps_xml(tmp_path / "g.xml")["grasps"][0]["joints"]
    assert joints["Thumb R J1"] == pytest.approx(np.radians(1 / 3))


def test_sliding_joints_go_out_in_millimetres_and_come_back_in_metres(tmp_path):
    source = document(1)
    source["grasps"][0]["joints"]["slider"] = 0.0125
    write_grasps_xml(tmp_path / "g.xml", source, prismatic=["slider"])
    node = ET.parse(tmp_path / "g.xml").find(".//Node[@name='slider']")
    assert (node.get("unit"), float(node.get("value"))) == ("mm", 12.5)
    assert read_grasps_xml(tmp_path / "g.xml")["grasps"][0]["joints"]["slider"] == 0.0125


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda text: text[:100], "Expected XML"),
        (lambda text: "<ManipulationObject/>", "Expected a <GraspSet>"),
        (lambda text: text.replace("row2", "row7"), "rows are missing"),
        (lambda text: text.replace('c3="', 'c3="z'), "4 x 4 transform in 'Grasp 0'"),
        (lambda text: text.replace("Matrix4x4", "Quaternion"), "no Matrix4x4"),
        (lambda text: text.replace('quality="', 'quality="x'), "number as 'quality' of 'Grasp 0'"),
        (lambda text: text.replace('value="', 'value="nan'), "number as 'value' of 'Index R J0'"),
        (lambda text: text.replace('c4="1.0"', 'c4="nan"'), "4 x 4 transform in 'Grasp 0'"),
        (lambda text: text.replace('c4="1.0"', 'c4="0.0"'), "no rotation and translation"),
        (lambda text: text.replace('unit="radian"', 'unit="furlong"'), "got 'furlong'"),
        (lambda text: text.replace("<Node name=", "<Node title="), "to name its joint"),
    ],
)
def test_broken_files_are_explained(tmp_path, edit, words):
    path = tmp_path / "g.xml"
    write_grasps_xml(path, document(1))
    path.write_text(edit(path.read_text()))
    with pytest.raises(InputError, match=words):
        read_grasps_xml(path)


def test_other_documents_and_missing_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"medkit\.grasps/1"):
        write_grasps_xml(tmp_path / "g.xml", {"grasps": []})
    with pytest.raises(InputError, match="reading failed"):
        read_grasps_xml(tmp_path / "none.xml")
    with pytest.raises(InputError, match="existing folder"):
        write_grasps_xml(tmp_path / "no" / "g.xml", document(1))
    assert list(tmp_path.iterdir()) == []
