"""The table of handover trials: as printed, in the schema, and clear words about a bad row."""

import json

import pandas as pd
import pytest

from medkit.datasets.handover_schema import KEY, RATINGS, handover_schema, table_problems
from medkit.datasets.handover_trials import (
    handover_anomalies,
    handover_folder,
    human_references,
    load_handover_table,
)
from medkit.errors import InputError

GOOD_ROW = {"pose": "P1", "mode": "position", "force_N": "2", "weight_g": "100", "subject": "A"}
GOOD_ROW |= {"good": "2", "acceptable": "1", "bad": "1"}


def written(tmp_path, rows):
    path = tmp_path / "lab.csv"
    pd.DataFrame(rows).to_csv(path, index=False)
    return path


def test_raw_table_is_the_full_crossing_as_printed():
    table = load_handover_table()
    assert table.columns.tolist() == [*KEY, *RATINGS, "sum_ok"]
    assert not table.duplicated(list(KEY)).any()
    weights = {"P1": [24, 100, 200, 300, 400, 600, 800, 1000], "P2": [24, 100, 300, 600]}
    for pose, part in table.groupby("pose"):
        assert sorted(part["weight_g"].unique()) == weights[pose]
        assert len(part) == 2 * 9 * 4 * len(weights[pose])
    assert sorted(table["force_N"].unique()) == [0.5, 1, 2, 5, 7, 10, 12, 15, 20]


def test_sum_ok_says_what_the_printed_column_says():
    raw = pd.read_csv(handover_folder() / "trials.csv")
    pd.testing.assert_series_equal(load_handover_table()["sum_ok"], raw["sum_ok"])


def test_anomalies_are_exactly_the_cells_that_do_not_add_up():
    table, listed = load_handover_table(), handover_anomalies()
    columns = [*KEY, *RATINGS]
    found = table.loc[~table["sum_ok"], columns].reset_index(drop=True)
    order = list(KEY)
    pd.testing.assert_frame_equal(
        found.sort_values(order).reset_index(drop=True),
        listed[columns].sort_values(order).reset_index(drop=True),
        check_dtype=False,
    )


def test_shipped_schema_is_the_packages():
    shipped = json.loads((handover_folder() / "schema.json").read_text(encoding="utf-8"))
    assert shipped == handover_schema()


@pytest.mark.parametrize(
    ("change", "column"),
    [
        ({"force_N": "0"}, "force_N"),
        ({"force_N": "two"}, "force_N"),
        ({"force_N": "inf"}, "force_N"),
        ({"weight_g": ""}, "weight_g"),
        ({"weight_g": "-5"}, "weight_g"),
        ({"good": "1.5"}, "good"),
        ({"bad": "-1"}, "bad"),
        ({"subject": " "}, "subject"),
        ({"good": "0", "acceptable": "0", "bad": "0"}, "good"),
    ],
)
def test_a_bad_row_is_named(tmp_path, change, column):
    rows = [GOOD_ROW, GOOD_ROW | {"subject": "B"} | change, GOOD_ROW | {"subject": "C"}]
    with pytest.raises(InputError, match=rf"line 3, column {column}: expected .* 1 line is bad"):
        load_handover_table(written(tmp_path, rows))


def test_the_first_bad_line_and_their_number_are_said(tmp_path):
    rows = [GOOD_ROW | {"subject": s, "force_N": f} for s, f in zip("ABCD", "1x3y", strict=True)]
    with pytest.raises(InputError, match=r"line 3, .*2 lines are bad"):
        load_handover_table(written(tmp_path, rows))


def test_a_cell_given_twice_is_refused_however_it_is_written():
    problems = table_problems(pd.DataFrame([GOOD_ROW, GOOD_ROW | {"force_N": "2.0"}]))
    assert [problem.line for problem in problems] == [3]


def test_a_missing_column_and_an_empty_table_are_refused(tmp_path):
    short = {key: value for key, value in GOOD_ROW.items() if key != "mode"}
    with pytest.raises(InputError, match="column named mode"):
        load_handover_table(written(tmp_path, [short]))
    empty = tmp_path / "empty.csv"
    empty.write_text(",".join(GOOD_ROW) + "\n")
    with pytest.raises(InputError, match="at least one row"):
        load_handover_table(empty)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00bad", b'a,b\n1,2,3\n"'])
def test_a_file_that_is_no_table_gives_one_sentence(tmp_path, content):
    path = tmp_path / "noise.csv"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_handover_table(path)
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_and_spaces_do_no_harm(tmp_path):
    path = tmp_path / "bom.csv"
    text = ", ".join(GOOD_ROW) + "\n" + ", ".join(GOOD_ROW.values()) + "\n"
    path.write_text(text, encoding="utf-8-sig")
    assert load_handover_table(path).loc[0, "force_N"] == 2.0


def test_an_absent_file_gives_one_sentence(tmp_path):
    with pytest.raises(InputError, match="absent"):
        load_handover_table(tmp_path / "absent.csv")


def test_five_steps_and_single_ratings_become_the_same_table(tmp_path):
    scale = {"5": "good", "4": "good", "3": "acceptable", "2": "bad", "1": "bad"}
    key = {name: GOOD_ROW[name] for name in KEY}
    single = written(tmp_path, [key | {"rating": step} for step in ("5", "4", "3", "1")])
    one = load_handover_table(single, ratings=scale)
    wide = written(tmp_path, [key | {"5": 1, "4": 1, "3": 1, "2": 0, "1": 1}])
    two = load_handover_table(wide, ratings=scale)
    pd.testing.assert_frame_equal(one, two)
    assert one.loc[0, list(RATINGS)].tolist() == [2, 1, 1]


def test_an_unknown_step_of_the_scale_is_named(tmp_path):
    key = {name: GOOD_ROW[name] for name in KEY}
    path = written(tmp_path, [key | {"rating": "good"}, key | {"rating": "superb"}])
    with pytest.raises(InputError, match=r"line 3, column rating: .*'superb'"):
        load_handover_table(path, ratings={"good": "good"})
    with pytest.raises(InputError, match="good, acceptable and bad"):
        load_handover_table(path, ratings={"good": "great"})


def test_references_are_ordered_times_with_a_source():
    table = human_references()
    known = table.dropna(subset="high")
    assert (known["low"] <= known["high"]).all()
    assert set(table["unit"]) == {"s"}
    assert table["source"].str.contains("L14 2.7").all()
