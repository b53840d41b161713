"""The shipped recordings, and files that cannot be used."""

import numpy as np
import pandas as pd
import pytest

from medkit.datasets import human_grasps_folder, load_human_grasps, load_human_objects
from medkit.datasets.human_grasps import COLUMNS, SENSORS
from medkit.errors import InputError
from medkit.similarity.shipped import write_simulated

ROWS = ",".join(COLUMNS) + "\nA,box,1,0.0,wrist,0.1,,0.2,0\n"


def test_shipped_files_follow_the_protocol_and_say_that_they_are_simulated():
    table = load_human_grasps()
    assert list(table.columns) == list(COLUMNS)
    assert table["simulated"].all()
    assert set(table["sensor"]) == set(SENSORS)
    counts = table.groupby(["subject", "object"])["trial"].nunique()
    assert counts.shape == (10,)
    assert (counts == 10).all()
    for file in human_grasps_folder().glob("*.csv.gz"):
        assert file.name.startswith("simulated_")
        assert file.stat().st_size < 1_500_000
    assert "SIMULATED" in (human_grasps_folder() / "README.md").read_text()


def test_shipped_files_are_what_the_generator_writes(tmp_path):
    written = write_simulated(tmp_path)
    assert {file.name for file in written} == {
        "simulated_box.csv.gz", "simulated_cylinder.csv.gz", "objects.csv",
    }  # fmt: skip
    ours, theirs = load_human_grasps(), load_human_grasps(tmp_path)
    labels = ["subject", "object", "trial", "sensor"]
    pd.testing.assert_frame_equal(ours[labels], theirs[labels])
    for column in ("t", "x", "y", "z"):  # the last digit may round differently elsewhere
        np.testing.assert_allclose(ours[column], theirs[column], atol=1.5e-4)
    assert load_human_objects(tmp_path).equals(load_human_objects())


def test_a_laboratorys_own_file_or_folder_drops_in(tmp_path):
    file = tmp_path / "mine.csv"
    file.write_text(ROWS)
    for path in (file, tmp_path):
        table = load_human_grasps(path)
        assert not table["simulated"].any()
        assert np.isnan(table["y"][0])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("simulated\n", "other\n", "simulated is missing"),
        (",0.1,", ",near,", "'near'"),
        (",1,0.0", ",1.5,0.0", "trial numbers"),
        (",0\n", ",maybe\n", "'maybe'"),
    ],
)
def test_unreadable_tables_are_refused(tmp_path, old, new, words):
    (tmp_path / "mine.csv").write_text(ROWS.replace(old, new))
    with pytest.raises(InputError, match=words):
        load_human_grasps(tmp_path)


def test_missing_places_are_refused(tmp_path):
    with pytest.raises(InputError, match="at least one table"):
        load_human_grasps(tmp_path)
    with pytest.raises(InputError, match="is not there"):
        load_human_grasps(tmp_path / "none")
    with pytest.raises(InputError, match=r"objects\.csv"):
        load_human_objects(tmp_path)
    (tmp_path / "broken.csv.gz").write_bytes(b"no archive")
    with pytest.raises(InputError, match="reading it failed"):
        load_human_grasps(tmp_path / "broken.csv.gz")
