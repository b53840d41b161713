"""Laws of the object zoo: closed, outward, of the stated size, the same every time."""

import numpy as np
import pytest
import trimesh

from medkit.datasets import objects
from medkit.datasets.objects import load_object, make_object, object_info, object_names
from medkit.errors import InputError


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path_factory.getbasetemp() / "objects"))


@pytest.mark.parametrize("name", object_names())
def test_every_object_is_one_closed_body_with_normals_outwards(name):
    mesh = make_object(name, triangles=7000)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 0.0
    assert mesh.extents.max() == pytest.approx(object_info(name).longest_edge, rel=1e-9)
    assert np.allclose(mesh.bounds.sum(axis=0), 0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["glasses", "seal", "mug", "salt_box"])
def test_a_loaded_object_has_the_promised_number_of_triangles_without_needles(name):
    mesh = load_object(name)
    assert 5000 <= len(mesh.faces) <= 20000
    assert mesh.area_faces.min() > 0.0
    assert mesh.is_watertight
    assert mesh.body_count == 1


def test_both_sets_of_the_thesis_have_ten_objects_of_their_size():
    large, hand = object_names("large"), object_names("hand")
    assert (len(large), len(hand)) == (10, 10)
    assert all(object_info(name).longest_edge == 0.8 for name in large)
    assert all(0.10 <= object_info(name).longest_edge <= 0.27 for name in hand)
    assert (object_info("dog").longest_edge, object_info("gnome").longest_edge) == (0.22, 0.27)


def test_loading_twice_gives_equal_meshes_that_do_not_share_memory():
    first, second = load_object("cereal_box"), load_object("cereal_box")
    assert np.array_equal(first.vertices, second.vertices)
    first.vertices[:] = 0.0
    assert load_object("cereal_box").volume == pytest.approx(second.volume)


def test_the_cache_gives_what_the_recipe_makes(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path))
    objects._arrays.cache_clear()
    made = load_object("star")
    assert len(list((tmp_path / "objects").glob("star-*.npz"))) == 1
    objects._arrays.cache_clear()
    cached = load_object("star")
    assert np.array_equal(made.vertices, cached.vertices)
    assert np.array_equal(made.faces, cached.faces)


def test_a_broken_or_missing_cache_is_no_obstacle(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDKIT_CACHE", str(tmp_path))
    path = objects._cache_path("salt_box")
    path.write_bytes(b"not a mesh")
    objects._arrays.cache_clear()
    assert load_object("salt_box").is_watertight
    blocked = tmp_path / "a file"
    blocked.write_text("in the way")
    monkeypatch.setenv("MEDKIT_CACHE", str(blocked))
    objects._arrays.cache_clear()
    assert load_object("salt_box").is_watertight


def test_scale_changes_lengths_and_nothing_else():
    whole, quarter = load_object("salt_box"), load_object("salt_box", scale=0.25)
    assert np.allclose(quarter.vertices, 0.25 * whole.vertices)
    assert np.array_equal(quarter.faces, whole.faces)


def test_exact_objects_have_their_exact_volumes():
    assert load_object("cereal_box").volume == pytest.approx(0.19 * 0.06 * 0.28)
    assert load_object("salt_box").volume == pytest.approx(np.pi * 0.045**2 * 0.14, rel=1e-3)


def test_an_unknown_object_and_a_bad_scale_are_refused_with_a_reason():
    with pytest.raises(InputError, match="teapot"):
        load_object("tea pot")
    with pytest.raises(InputError, match="size class"):
        object_names("huge")
    with pytest.raises(InputError, match="scale"):
        load_object("mug", scale=0.0)


def test_loading_does_not_change_with_the_file_round_trip(tmp_path):
    mesh = load_object("star")
    mesh.export(tmp_path / "star.stl")
    assert trimesh.load_mesh(tmp_path / "star.stl").is_watertight
