"""Each fault of a foreign file is noticed, said, and not mended."""

import numpy as np
import pandas as pd
import pytest

from medkit.datasets import load_human_objects
from medkit.similarity.simulation import Protocol, simulate_recordings
from medkit.similarity.validate import validate

TABLE = simulate_recordings(
    rng=np.random.default_rng(8), protocol=Protocol(subjects=1, trials=2)
).query("object == 'box'")
XYZ = ["x", "y", "z"]


def first(table):
    return table["trial"] == 1


def millimetres(table):
    table[XYZ] *= 1000.0


def missing_finger(table):
    return table[~(first(table) & (table.sensor == "ring"))]


def elsewhere(table):
    table.loc[first(table), "y"] += 1.0


def upside_down(table):
    table.loc[first(table), "z"] -= 0.3


def backwards(table):
    table.loc[first(table) & (table.sensor == "index"), "t"] *= -1.0


def unknown_sensor(table):
    table.loc[table.sensor == "little", "sensor"] = "pinky"


def milliseconds(table):
    table["t"] *= 1000.0


def unknown_object(table):
    table["object"] = "teapot"


def mixed(table):
    table.loc[table.index[5], "simulated"] = False


FAULTS = [
    (millimetres, "millimetres"),
    (missing_finger, "no rows of ring"),
    (elsewhere, "never come nearer"),
    (upside_down, "below the table"),
    (backwards, "backwards"),
    (unknown_sensor, "pinky"),
    (milliseconds, "milliseconds"),
    (unknown_object, "not in objects.csv"),
    (mixed, "mixed"),
]


def test_a_sound_table_gives_no_finding():
    assert len(validate(TABLE, load_human_objects())) == 0


@pytest.mark.parametrize(("spoil", "words"), FAULTS)
def test_a_fault_is_named_and_the_table_left_alone(spoil, words):
    table = TABLE.copy()
    changed = spoil(table)
    table = table if changed is None else changed
    before = table.copy()
    findings = validate(table, load_human_objects())
    errors = findings[findings["severity"] == "error"]
    assert errors["problem"].str.contains(words).any()
    assert errors["rows"].str.contains("trial 1").any()
    assert table.equals(before)


def test_a_trial_that_occurs_twice_is_named():
    copy = TABLE[TABLE.trial == 1].assign(trial=9)
    both = pd.concat([TABLE, copy], ignore_index=True)
    findings = validate(both)
    assert findings["rows"].tolist() == ["subject S1, object box, trial 9"]
    assert "same numbers as subject S1, object box, trial 1" in findings["problem"][0]


def test_long_dropouts_and_jumps_are_warnings():
    table = TABLE.copy()
    rows = table[first(table) & (table.sensor == "index")].index
    table.loc[rows[: len(rows) // 2], XYZ] = np.nan
    thumb = table[first(table) & (table.sensor == "thumb")].index
    table.loc[thumb[30:], "x"] += 0.2
    findings = validate(table, load_human_objects())
    assert set(findings["severity"]) == {"warning"}
    assert findings["problem"].str.contains("not seen").any()
    assert findings["problem"].str.contains("jumps").any()


def test_missing_columns_end_the_check():
    findings = validate(TABLE.drop(columns=["simulated"]))
    assert findings["problem"].tolist() == ["the columns simulated are missing"]
