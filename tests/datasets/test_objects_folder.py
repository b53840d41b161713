"""A folder of the user's meshes: everything in it is read or named in a refusal."""

import pytest
import trimesh

from medkit.datasets.folder import load_folder
from medkit.datasets.printed import load_printed, printed_names
from medkit.errors import InputError


def test_meshes_come_in_order_scaled_and_other_files_are_passed_over(tmp_path):
    for name, edge in [("b", 2.0), ("a", 1.0)]:
        trimesh.creation.box(3 * (edge,)).export(tmp_path / f"{name}.stl")
    (tmp_path / "notes.txt").write_text("not a mesh")
    found = {name: mesh.extents.max() for name, mesh in load_folder(tmp_path, scale=0.1)}
    assert list(found) == ["a", "b"]
    assert list(found.values()) == pytest.approx([0.1, 0.2])


def test_a_broken_mesh_file_is_named_and_not_skipped(tmp_path):
    (tmp_path / "broken.stl").write_bytes(b"no triangles here")
    with pytest.raises(InputError, match=r"broken\.stl"):
        list(load_folder(tmp_path))


def test_a_missing_or_empty_folder_is_refused_at_once(tmp_path):
    with pytest.raises(InputError, match="not one"):
        load_folder(tmp_path / "nowhere")
    with pytest.raises(InputError, match="holds none"):
        load_folder(tmp_path)


def test_two_formats_of_one_name_are_refused(tmp_path):
    box = trimesh.creation.box()
    box.export(tmp_path / "box.stl")
    box.export(tmp_path / "box.off")
    with pytest.raises(InputError, match="twin"):
        load_folder(tmp_path)


@pytest.mark.parametrize("name", printed_names())
def test_printed_tables_are_there_with_their_source(name):
    table = load_printed(name)
    assert len(table) > 0
    assert table.attrs["source"].startswith("P13 table")


def test_printed_averages_follow_from_the_printed_columns():
    averages = load_printed("yield_printed_averages")
    hand = load_printed("yield_power_handsized_mat")
    means = hand.groupby(["r_N_m", "r_o_min_ratio"]).yield_pct.mean()
    printed = averages[averages.table.isin([5.2, 5.3])].set_index(["r_N_m", "r_o_min_ratio"])
    assert (means - printed.printed_avg_pct).abs().max() < 0.06


def test_an_unknown_table_is_refused():
    with pytest.raises(InputError, match="yield_power_large"):
        load_printed("yield")
