"""What a class hands in: right answers in many styles pass, and a miss says where to look."""

from functools import partial
from itertools import product

import nbformat
import numpy as np
import pandas as pd
import pytest
from scipy.stats import beta, binomtest, permutation_test

from medkit.labs import check
from medkit.labs.exercise import line_of
from medkit.labs.grade import grade, submissions
from medkit.labs.messages import decoded, encoded
from medkit.labs.reading import bound_names, definitions, read_cells, why_missing

HEAD = "import numpy as np\nfrom medkit.labs import check"
SECOND = "# answer: planar-2\n"
RIGHT = "def min_object_angle(friction):\n    return np.pi - 2 * np.arctan(friction)"


def hand_in(folder, *cells, name="lab.ipynb"):
    path = folder / name
    code = [nbformat.v4.new_code_cell(cell) for cell in (HEAD, *cells)]
    nbformat.write(nbformat.v4.new_notebook(cells=code), path)
    return path


def second(folder, source, **settings):
    """Return the verdict on exercise planar-2 of a notebook that holds `source` in its cell."""
    return grade(hand_in(folder, SECOND + source, **settings), seed=4, time_limit=5.0)[1]


def interval(method, level=0.95):
    return lambda found, tested: binomtest(found, tested).proportion_ci(level, method)


def jeffreys(found, tested):
    return beta.ppf([0.025, 0.975], found + 0.5, tested - found + 0.5)


def normal_interval(found, tested):
    share = found / tested
    half = 1.96 * np.sqrt(share * (1 - share) / tested)
    return max(0.0, share - half), min(1.0, share + half)


def circle(axis, steps, *, helper=None, end=False, order=slice(None)):
    helper = np.eye(3)[np.argmin(np.abs(axis))] if helper is None else helper
    first = np.cross(axis, helper)
    first = first / np.linalg.norm(first)
    angles = np.linspace(0.0, 2.0 * np.pi, steps, endpoint=end)[order, None]
    return np.cos(angles) * first + np.sin(angles) * np.cross(axis, first)


def chord_test(points, normals, friction, *, ends=2, sign=lambda dots: dots):
    chord = points[1] - points[0]
    dots = sign(np.array([normals[0] @ chord, -normals[1] @ chord]) / np.linalg.norm(chord))
    return bool((dots[:ends] > np.cos(np.arctan(friction))).all())


def all_signs(differences, *, strict=False):
    hits = 0
    for signs in product([1, -1], repeat=len(differences)):
        mean, observed = abs(np.mean(signs * differences)), abs(np.mean(differences))
        hits += mean > observed if strict else mean >= observed
    return hits / 2 ** len(differences)


def eigen_ratio(centers):
    values = np.linalg.eigvals(np.cov(centers.T).astype(complex))
    values = values[np.argsort(values.real)]
    return values[1] / values[2]


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("planar-2", lambda friction: 2.0 * np.arctan(1.0 / friction)),
        ("planar-2", partial(lambda turn, friction: turn - 2.0 * np.arctan(friction), np.pi)),
        ("planar-3", lambda p, f, o: pd.Series([*f, np.linalg.det([p - o, f])])),
        ("planar-4", chord_test),
        ("medial-4", eigen_ratio),
        ("planner-1", circle),
        ("planner-1", partial(circle, order=slice(None, None, -1))),
        ("planner-4", interval("wilson")),
        ("planner-4", interval("exact")),
        ("planner-4", jeffreys),
        ("statistics-3", all_signs),
        (
            "statistics-3",
            lambda d: (
                permutation_test(
                    (d,), np.mean, permutation_type="samples", n_resamples=np.inf
                ).pvalue
            ),
        ),
    ],
)
def test_right_answers_pass_however_they_are_written(name, answer):
    with np.errstate(divide="ignore"):
        assert check(name, answer).passed

        def over_there(*arguments):
            # as in grading: arguments and result go through messages
            back = encoded(answer(*decoded(encoded(arguments))))
            return decoded(back)

        assert check(name, over_there).passed


@pytest.mark.parametrize(
    ("name", "answer", "hint"),
    [
        ("planar-4", partial(chord_test, ends=1), "both ends"),
        ("planar-4", partial(chord_test, sign=np.abs), "pulls"),
        ("planner-1", partial(circle, end=True), "2 pi / steps"),
        ("planner-1", partial(circle, helper=np.eye(3)[2]), "helper"),
        ("planner-4", interval("wilson", 0.99), "too long"),
        ("planner-4", interval("wilson", 0.90), "too short"),
        ("planner-4", normal_interval, "length zero"),
        ("statistics-3", partial(all_signs, strict=True), "ties"),
        ("statistics-1", lambda g, a, b: None, "return"),
        ("statistics-1", lambda g, a, b: "seven", "single number"),
        ("statistics-1", lambda g, a, b: [[1], [2, 3]], "single number"),
        ("statistics-1", lambda g, a, b: np.ones(1), "shape (1,)"),
    ],
)
def test_near_misses_are_seen(name, answer, hint):
    with np.errstate(all="ignore"):
        verdict = check(name, answer)
    assert not verdict.passed
    assert hint in verdict.hint


@pytest.mark.parametrize(
    "source",
    [
        "%matplotlib inline\n!echo hello\n" + RIGHT + "\nnp.arctan?",
        "from functools import partial\ndef both(turn, mu):\n    return turn - 2 * np.arctan(mu)\n"
        "min_object_angle = partial(both, np.pi)",
        "from scipy.stats import norm\nHALF = norm.cdf(0.0)\n"
        + RIGHT.replace("2 *", "1 / HALF *")
        + "\nraise RuntimeError(HALF)",
    ],
    ids=["notebook lines", "partial", "a table made by a library"],
)
def test_what_runs_in_a_notebook_is_graded(tmp_path, source):
    assert second(tmp_path, source).passed


def test_a_cell_magic_and_a_lost_mark_do_no_harm(tmp_path):
    path = hand_in(tmp_path, "%%time\n" + RIGHT, "check('planar-1', None)")
    assert grade(path, seed=4)[1].passed


@pytest.mark.parametrize(
    ("source", "hint"),
    [
        ("def min_object_angle(friction):\n    x = (1 +\n    return x", "SyntaxError in line 3"),
        ("def mine(friction):\n    return 1.0", "(it defines mine)"),
        ("def min_object_angle(friction):\n    x = 1\n    return x / 0", "in line 4 with Zero"),
        ("min_object_angle = 3.0", "is no function"),
        ("def min_object_angle(friction):\n    return 'x' * (1 << 21)", "more than a million"),
        ("import os\ndef min_object_angle(mu):\n    os.fork()", "os.fork is refused"),
        ("def min_object_angle(mu):\n    open('/x', 'w')", "writing files is refused"),
        ("import os\ndef min_object_angle(mu):\n    os.rename('a', '/b')", "writing files"),
        ("import os\ndef min_object_angle(mu):\n    os.write(4, b'1' * 99)", ""),
    ],
)
def test_a_miss_says_where_and_why(tmp_path, source, hint):
    verdict = second(tmp_path, source)
    assert not verdict.passed
    assert hint in verdict.hint
    assert verdict.hint


@pytest.mark.parametrize("where", ["tests/labs/solutions/lab_1_planar.py", "notebooks/x.ipynb"])
def test_the_answers_of_others_stay_closed(tmp_path, where):
    source = (
        "import medkit, pathlib\ndef min_object_angle(friction):\n"
        f"    path = pathlib.Path(medkit.__file__).parents[1] / '{where}'\n"
        "    names = {}\n    exec(path.read_text(), names)\n"
        "    return names['min_object_angle'](friction)"
    )
    assert "solutions is refused" in second(tmp_path, source).hint


def test_a_file_written_by_the_way_is_gone_afterwards(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.chdir(tmp_path)
    source = RIGHT.replace("    return", "    open('note', 'a').write('x')\n    return")
    assert second(tmp_path, source).passed
    assert [path.name for path in tmp_path.iterdir()] == ["lab.ipynb"]


def test_a_lab_is_recognised_without_its_first_exercise(tmp_path):
    path = hand_in(tmp_path, "check('planar-3', None)", SECOND + RIGHT)
    verdicts = grade(path, seed=4)
    assert [verdict.passed for verdict in verdicts] == [False, True, False, False]
    assert "'# answer: planar-1' is missing" in verdicts[0].hint


def test_copies_of_the_system_are_no_submissions(tmp_path):
    kept = hand_in(tmp_path, "check('planar-3', None)")
    hand_in(tmp_path, "", name="._lab.ipynb")
    assert submissions(tmp_path) == [kept]


def test_only_what_an_answer_needs_is_executed():
    cells = read_cells(
        [
            "loose = 1 / 0\nimport os as unused\nimport math\nTABLE = [0.0]\nTABLE[0] = math.pi",
            "def helper():\n    return TABLE[0]\nother = sorted(loose)",
            "def wanted(other):\n    return helper() + other",
        ]
    )
    names = definitions(cells, "wanted")
    assert set(names) - {"__name__", "__builtins__"} == {"math", "TABLE", "helper", "wanted"}
    assert names["wanted"](1.0) == np.pi + 1.0


def test_reading_names_the_cell():
    cells = read_cells(["x = 1", "def f(:"])
    assert why_missing(cells, "f", "planar-1").startswith("code cell 2 is not Python yet")
    assert bound_names(read_cells(["(a, *b), c.d = 1, 2"])[0].body[0]) == {"a", "b", "c"}


def test_the_line_of_an_error_is_the_last_one_of_the_file():
    with pytest.raises(ValueError, match="cooking") as raised:
        check("cooking-1", None)
    assert line_of(raised.value, {"somewhere else"}) is None
    assert line_of(raised.value, {__file__}) == raised.tb.tb_lineno
