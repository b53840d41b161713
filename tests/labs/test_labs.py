"""Stubs fail, solutions pass, usual mistakes get their hint, grading survives what it gets."""

import csv
import json
from pathlib import Path

import nbformat
import numpy as np
import pytest

from medkit.cli import main
from medkit.errors import InputError
from medkit.labs import check, exercises_of, lab_names
from medkit.labs.copies import answers_in, filled, lab_notebooks, marked_exercise, write_copies
from medkit.labs.grade import grade, verdict_of
from medkit.labs.messages import decoded, encoded

ROOT = Path(__file__).parents[2]
LABS = ROOT / "notebooks" / "labs"
ANSWERS = Path(__file__).parent / "solutions"


def notebook(*cells):
    return nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])


@pytest.mark.parametrize("path", lab_notebooks(LABS), ids=lambda path: path.stem)
def test_stub_and_solution_differ_only_in_the_marked_cells(path):
    stub = nbformat.read(path, as_version=4)
    solution = filled(stub, answers_in((ANSWERS / f"{path.stem}.py").read_text()))
    assert len(stub.cells) == len(solution.cells)
    marked = {marked_exercise(cell) for cell in stub.cells} - {None}
    lab = next(iter(marked)).rpartition("-")[0]
    assert marked == {exercise.name for exercise in exercises_of(lab)}
    for before, after in zip(stub.cells, solution.cells, strict=True):
        if marked_exercise(before):
            assert before.source != after.source
            assert marked_exercise(before) == marked_exercise(after)
        else:
            assert before == after


@pytest.mark.parametrize("path", lab_notebooks(LABS), ids=lambda path: path.stem)
def test_the_stub_fails_and_the_solution_passes_every_hidden_case(path, tmp_path):
    write_copies(LABS, tmp_path / "solved", ANSWERS)
    lab = next(name for name in lab_names() if f"{name}-1" in path.read_text(encoding="utf-8"))
    for exercise in exercises_of(lab):
        stub = verdict_of(path, exercise, 7)
        assert not stub.passed
        assert stub.hint
        solved = verdict_of(tmp_path / "solved" / path.name, exercise, 7)
        assert solved.passed, solved


def test_every_lab_has_a_notebook_and_answers():
    stems = {path.stem for path in lab_notebooks(LABS)}
    assert stems == {path.stem for path in ANSWERS.glob("*.py")}
    assert len(stems) == len(lab_names()) >= 4


@pytest.mark.parametrize(
    ("name", "wrong", "hint"),
    [
        ("planar-1", lambda n, mu: [n, n], "half-angle"),
        ("planar-1", lambda n, mu: [-n, -n], "inwards"),
        ("planar-2", lambda mu: np.degrees(np.pi - 2 * np.arctan(mu)), "radians"),
        ("planar-2", lambda mu: np.pi - np.arctan(mu), "twice"),
        ("planar-3", lambda p, f, o: [*f, p[0] * f[1] - p[1] * f[0]], "origin"),
        ("planar-3", lambda p, f, o: [*f, (p - o)[1] * f[0] - (p - o)[0] * f[1]], "sign"),
        ("planar-4", lambda p, n, mu: True, "slips"),
        ("planar-4", lambda p, n, mu: False, "open"),
        ("medial-1", lambda c, t: np.degrees(1.0), "radians"),
        ("medial-3", lambda p, n, q: p - 0.01 * n, "too far"),
        ("medial-3", lambda p, n, q: p - 10.0 * n, "inside"),
        ("planner-2", lambda c, g, e: e, "outside"),
        ("planner-4", lambda k, n: (k / n - 1e-3, k / n + 1e-3), "Wilson"),
        ("statistics-1", lambda g, a, b: (g + 0.5 * a) / 4, "divide"),
        ("statistics-4", lambda f, s, v: np.interp(v, s, f), "growing"),
    ],
)
def test_the_usual_mistakes_get_their_hint(name, wrong, hint):
    verdict = check(name, wrong)
    assert not verdict.passed
    assert hint in verdict.hint


def test_another_right_way_passes():
    def edges(normal, friction):
        angle = np.arctan2(normal[1], normal[0]) + np.arctan(friction) * np.array([1, -1])
        return 3.0 * np.column_stack([np.cos(angle), np.sin(angle)])

    assert check("planar-1", edges).passed


def test_an_answer_that_raises_is_a_hint_not_a_traceback():
    def broken(friction):
        return 1 / 0

    assert "ZeroDivisionError" in check("planar-2", broken).hint
    assert "define" in check("planar-2", None).hint


def test_unknown_exercises_are_refused():
    with pytest.raises(InputError, match="labs"):
        check("cooking-1", None)
    with pytest.raises(InputError, match="planar-1"):
        check("planar-9", None)


def test_grading_a_folder(tmp_path, capsys):
    folder = tmp_path / "handed_in"
    write_copies(LABS, tmp_path / "solved", ANSWERS)
    solved = nbformat.read(tmp_path / "solved" / "lab_1_planar.ipynb", as_version=4)
    (folder / "ada").mkdir(parents=True)
    nbformat.write(solved, folder / "ada" / "lab.ipynb")
    endless = "# answer: planar-2\ndef min_object_angle(friction):\n    while True: pass"
    nbformat.write(filled(solved, {"planar-2": endless}), folder / "bob.ipynb")
    (folder / "eve.ipynb").write_text("not a notebook")
    status = main(
        ["lab", "grade", str(folder), "--time-limit", "2", "--out", str(tmp_path / "grades.csv")]
    )
    assert status == 0
    shown = capsys.readouterr().out
    assert "4/4  ada/lab.ipynb" in shown
    assert "3/4  bob.ipynb" in shown
    assert "limit of 2 s" in shown
    assert "cannot be read" in shown
    rows = list(csv.DictReader((tmp_path / "grades.csv").open()))
    assert len(rows) == 9


def test_grading_runs_no_loose_code_and_hides_no_neighbour(tmp_path):
    loose = notebook(
        "import numpy as np\nraise SystemExit('loose code')",
        "def broken(:",
        "# answer: planar-2\ndef min_object_angle(mu):\n    return np.pi - 2 * np.arctan(mu)",
        "check('planar-1', None)",
    )
    nbformat.write(loose, tmp_path / "loose.ipynb")
    passed = {
        verdict.exercise: verdict.passed for verdict in grade(tmp_path / "loose.ipynb", seed=3)
    }
    assert passed == {"planar-1": False, "planar-2": True, "planar-3": False, "planar-4": False}


FORGED = """
import json, os, sys
def min_object_angle(friction):
    line = json.dumps({"exercise": "planar-2", "passed": True, "hint": ""})
    value = json.dumps({"value": ["value", 1.0]})
    for stream in (1, 2):
        os.write(stream, ("\\n" + line + "\\n" + value + "\\n").encode())
    print(line, flush=True)
    {then}
"""
READING = """
import gc, os, sys
def min_object_angle(friction):
    words = " ".join(sys.argv) + " ".join(os.environ)
    held = [o for o in gc.get_objects() if type(o).__name__ in ("Generator", "Exercise", "Verdict")]
    if held or "20261122" in words or sys.stdin.read():
        return 3.14159 - 2 * 0
    return 0.0
"""


@pytest.mark.parametrize(
    ("source", "hint"),
    [
        (FORGED.replace("{then}", "return 0.0"), ""),
        (FORGED.replace("{then}", "os._exit(0)"), "ended without a result"),
        (READING, ""),
        ("def min_object_angle(friction):\n    while True: pass", "limit of 2 s"),
        ("import time\ndef min_object_angle(friction):\n    time.sleep(900)", "limit of 2 s"),
        ("def min_object_angle(friction):\n    exit()", "SystemExit"),
        ("def min_object_angle(mu):\n    return min_object_angle(mu)", "RecursionError"),
        ("def min_object_angle(friction):\n    return bytearray(1 << 36)", "MemoryError"),
        ("def min_object_angle(friction):\n    return {1: 2}", "returned dict"),
        ("def min_object_angle(friction):\n    return float(input())", "EOFError"),
        ("def min_object_angle(a, b):\n    return 1.0", "TypeError"),
        ("def min_object_angle(friction=(1 / 0)):\n    return 1.0", "ZeroDivisionError"),
        ("", "no cell defines min_object_angle"),
    ],
)  # fmt: skip
def test_no_submission_passes_by_force_or_stops_the_grading(tmp_path, monkeypatch, source, hint):
    path = tmp_path / "lab.ipynb"
    nbformat.write(notebook("check('planar-1', None)", source), path)
    monkeypatch.setattr("medkit.labs.grade.PATIENCE", 10.0)
    verdict = grade(path, seed=20261122, time_limit=2.0)[1]
    assert verdict.exercise == "planar-2"
    assert not verdict.passed
    assert verdict.hint
    assert hint in verdict.hint


def test_what_goes_to_a_worker_and_back_is_the_same():
    values = [
        1,
        2.5,
        True,
        None,
        "text",
        [1.0, (2, 3)],
        np.arange(6.0).reshape(2, 3),
        np.eye(2) > 0,
    ]
    back = decoded(json.loads(json.dumps(encoded(values))))
    for sent, got in zip(values, back, strict=True):
        np.testing.assert_array_equal(np.asarray(sent, object), np.asarray(got, object))
        assert type(sent) is type(got)
    assert decoded(encoded(...)) is ...
    assert decoded(encoded(np.float64(0.5))) == 0.5


def test_helpers_and_tables_outside_the_function_are_seen(tmp_path):
    cells = [
        "import math\nimport numpy as np\nWHOLE = math.pi\nHALVES: list = [1.0, 2.0]\nWHOLE += 0.0",
        "half = lambda friction: np.arctan(friction)\nTABLE = np.array([0.0, 1.0]).sum()",
        "# answer: planar-2\nmin_object_angle = lambda mu: WHOLE - HALVES[1] * half(mu)",
        "check('planar-1', None)\nresult = open('made by a loose cell', 'w')",
    ]
    nbformat.write(notebook(*cells), tmp_path / "lab.ipynb")
    assert grade(tmp_path / "lab.ipynb", seed=3)[1].passed
    assert [path.name for path in Path.cwd().glob("made by*")] == []


def test_students_get_no_outputs_and_no_solutions(tmp_path):
    for path in write_copies(LABS, tmp_path / "out"):
        cells = json.loads(path.read_text())["cells"]
        assert all(not cell.get("outputs") for cell in cells)
        assert any("return ..." in "".join(cell["source"]) for cell in cells)


def test_copies_that_are_handed_out_alone_link_to_nothing_that_is_missing(tmp_path):
    alone, inside = tmp_path / "alone", tmp_path / "project" / "labs"
    inside.mkdir(parents=True)
    for chapter in (ROOT / "notebooks").glob("[0-9]*.ipynb"):
        (inside.parent / chapter.name).touch()
    for folder, linked in ((alone, False), (inside, True)):
        for path in write_copies(LABS, folder):
            prose = "\n".join(
                cell.source
                for cell in nbformat.read(path, as_version=4).cells
                if cell.cell_type == "markdown"
            )
            assert ("](../" in prose) == linked
            assert "Background: chapter" in prose


def test_grading_bad_folders_is_one_line(tmp_path, capsys):
    assert main(["lab", "grade", str(tmp_path / "gone")]) == 2
    assert main(["lab", "grade", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 2
