"""`medkit similarity` from grasp file to table, and what it refuses."""

import json
import re

import numpy as np
import pandas as pd
import pytest
import trimesh

from medkit.cli import main
from medkit.datasets import human_grasps_folder, load_human_grasps
from medkit.robots import load_hand

EXTENTS = [0.09, 0.09, 0.14]


def document(folder, outcome="force_closure", count=6):
    mesh = trimesh.creation.cylinder(0.045, 0.14, sections=64)
    mesh.export(folder / "can.stl")
    hand = load_hand("armar3")
    grasps = []
    for k in range(count):
        pose = np.eye(4)
        pose[:3, 3] = [0.12, 0.01 * k, 0.005 * k]
        grasps.append(
            {
                "outcome": outcome, "pose": pose.tolist(),
                "joints": dict.fromkeys(hand.joint_names, 0.0), "approach": [-1.0, 0.0, 0.0],
                "closing_axis": [0.0, 0.0, 1.0], "grasp_point": [0.0, 0.0, 0.0],
                "sphere_radius": 0.04, "contacts": [], "epsilon": 0.1, "pregrasp": pose.tolist(),
            }
        )  # fmt: skip
    return {
        "schema": "medkit.grasps/1",
        "object": {"path": str(folder / "can.stl"), "sha256": "", "scale": 1.0,
                   "extents": EXTENTS, "center_mass": [0.0, 0.0, 0.0], "repairs": []},
        "hand": "armar3", "planner": "medial", "grasp": "power", "parameters": {}, "seed": 0,
        "counts": {"spheres": 1, "candidates": count},
        "timing_s": {"medial": 0.0, "symmetry": 0.0, "closing": 0.0, "quality": 0.0, "total": 0.0},
        "grasps": grasps,
    }  # fmt: skip


@pytest.fixture(scope="module")
def humans(tmp_path_factory):
    """Two trials of every subject and object are enough here."""
    folder = tmp_path_factory.mktemp("people")
    table = load_human_grasps()
    table[table["trial"] <= 2].assign(simulated=1).to_csv(folder / "few.csv", index=False)
    (folder / "objects.csv").write_text((human_grasps_folder() / "objects.csv").read_text())
    return str(folder)


@pytest.fixture
def grasp_file(tmp_path):
    path = tmp_path / "grasps.json"
    path.write_text(json.dumps(document(tmp_path)))
    return path


def test_ranking_is_printed_and_written(humans, grasp_file, tmp_path, capsys):
    out = tmp_path / "ranking.csv"
    assert main(["similarity", str(grasp_file), humans, "--out", str(out), "--top", "3"]) == 0
    said = capsys.readouterr().out
    assert "SIMULATED recordings of the cylinder; symmetry Dinf" in said
    assert "3 more" in said
    table = pd.read_csv(out)
    assert sorted(table["grasp"]) == list(range(6))
    assert table["d_symmetric"].is_monotonic_increasing


def test_choices_are_obeyed(humans, grasp_file, tmp_path, capsys):
    out = tmp_path / "ranking.json"
    options = ["--by", "d_z", "--subject", "S2", "--upright", "--out", str(out)]
    assert main(["similarity", str(grasp_file), humans, *options]) == 0
    assert "symmetry Cinf" in capsys.readouterr().out
    rows = json.loads(out.read_text())
    assert {row["subject"] for row in rows} == {"S2"}
    assert [row["d_z"] for row in rows] == sorted(row["d_z"] for row in rows)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "table.txt"], ".csv or .json"),
        (["--top", "0"], "one or more"),
        (["--object", "teapot"], "teapot"),
        (["--subject", "nobody"], "nobody"),
        (["--mesh", "none.stl"], "none.stl"),
    ],
)
def test_wrong_arguments_end_with_one_line(humans, grasp_file, options, words, capsys):
    assert main(["similarity", str(grasp_file), humans, *options]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert words in said[-1]
    assert len(said) == 1


def test_without_mesh_the_object_has_to_be_named(humans, grasp_file, tmp_path, capsys):
    (tmp_path / "can.stl").unlink()
    assert main(["similarity", str(grasp_file), humans]) == 2
    assert "--object" in capsys.readouterr().err
    assert main(["similarity", str(grasp_file), humans, "--object", "cylinder"]) == 0
    assert "no mesh" in capsys.readouterr().out


def test_only_force_closure_grasps_count_unless_all_are_wanted(humans, tmp_path, capsys):
    path = tmp_path / "grasps.json"
    path.write_text(json.dumps(document(tmp_path, outcome="not_force_closure", count=5)))
    assert main(["similarity", str(path), humans]) == 2
    assert "--all" in capsys.readouterr().err
    assert main(["similarity", str(path), humans, "--all"]) == 0


def test_recordings_with_errors_are_refused(humans, grasp_file, tmp_path, capsys):
    folder = tmp_path / "people"
    folder.mkdir()
    table = pd.read_csv(f"{humans}/few.csv").query("trial == 1 and object == 'cylinder'")
    table[["x", "y", "z"]] *= 1000.0
    table.to_csv(folder / "mm.csv", index=False)
    (folder / "objects.csv").write_text((human_grasps_folder() / "objects.csv").read_text())
    assert main(["similarity", str(grasp_file), str(folder)]) == 2
    said = capsys.readouterr().err
    assert "millimetres" in said
    assert "5 errors" in said


def test_a_fault_in_every_trial_fits_on_a_screen(grasp_file, humans, tmp_path, capsys):
    folder = tmp_path / "people"
    folder.mkdir()
    pd.read_csv(f"{humans}/few.csv").assign(object="cup").to_csv(folder / "few.csv", index=False)
    (folder / "objects.csv").write_text((human_grasps_folder() / "objects.csv").read_text())
    assert main(["similarity", str(grasp_file), str(folder)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 12
    assert all(line.startswith("error: ") for line in lines[:10])
    assert lines[10].endswith("findings more")


@pytest.mark.parametrize(
    ("people", "things", "words"),
    [
        (lambda text: text, lambda text: text + text.splitlines()[1] + "\n", "comes twice"),
        (lambda text: text.replace(",", ";"), lambda text: text, "separated by semicolons"),
        (lambda text: text.replace(",", "\t"), lambda text: text, "separated by tabs"),
        (lambda text: text.replace("S3,", ",", 1), lambda text: text, "column subject .* has none"),
    ],
)
def test_a_broken_folder_gives_one_sentence(
    grasp_file, humans, tmp_path, capsys, people, things, words
):
    folder = tmp_path / "people"
    folder.mkdir()
    with open(f"{humans}/few.csv", encoding="utf-8") as file:
        (folder / "few.csv").write_text(people(file.read()))
    (folder / "objects.csv").write_text(things((human_grasps_folder() / "objects.csv").read_text()))
    assert main(["similarity", str(grasp_file), str(folder)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert re.search(words, lines[0])
