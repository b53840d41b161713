"""The plan command and its file: round trip, refusals, same result in two processes."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from medkit.cli import main
from medkit.errors import InputError
from medkit.grasping import grasp_document, plan_power_grasps, read_grasps, write_grasps
from medkit.grasping.grasp_file import grasps_from_document
from medkit.robots import load_hand


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
    ],
)
def test_broken_documents_are_refused_by_name(found, change, message):
    document = json.loads(json.dumps(grasp_document(found)))
    change(document)
    with pytest.raises(InputError, match=message):
        grasps_from_document(document)


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


def test_an_interrupt_leaves_no_file(bar, tmp_path, monkeypatch):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr("medkit.grasping.planners.plan_grasps", interrupted)
    assert main(["plan", bar, "--out", str(tmp_path / "out.json")]) == 130
    assert list(tmp_path.iterdir()) == []
