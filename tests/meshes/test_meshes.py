"""Laws of the mesh checks: what is sound stays as it is, what is damaged is mended or refused."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.meshes import load_mesh, mass_properties, refuse_wrong_scale, repair_mesh


def ball(radius=0.05, at=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    mesh.apply_translation(at)
    return mesh


def box(size=(0.1, 0.06, 0.04), at=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(at)
    return mesh.subdivide().subdivide()


def half(mesh):
    mesh.update_faces(mesh.triangles_center[:, 2] < 0.0)
    return mesh


def figure_of_eight(around=96, across=24, radius=0.012):
    """A closed tube along a figure of eight that runs through itself at the crossing."""
    t = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)[:, None]
    u = np.linspace(0.0, 2.0 * np.pi, across, endpoint=False)[None, :, None]
    path = 0.05 * np.column_stack([np.sin(t), np.sin(2 * t), 0 * t])
    along = np.column_stack([np.cos(t), 2 * np.cos(2 * t), 0 * t])
    side = np.cross(along / np.linalg.norm(along, axis=1, keepdims=True), [0.0, 0.0, 1.0])
    rings = path[:, None] + radius * (np.cos(u) * side[:, None] + np.sin(u) * [0.0, 0.0, 1.0])
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = i * across + (j + 1) % across, (i + 1) % around * across + (j + 1) % across
    faces = np.vstack(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([b, d, c], -1).reshape(-1, 3)]
    )
    return trimesh.Trimesh(rings.reshape(-1, 3), faces, process=False)


def joined(*meshes):
    return trimesh.util.concatenate(meshes)


@pytest.mark.parametrize("mesh", [ball(), box(), trimesh.creation.torus(0.05, 0.01)])
def test_a_sound_mesh_is_left_alone(mesh):
    result = repair_mesh(mesh)
    assert result.repairs == ()
    assert len(result.mesh.faces) == len(mesh.faces)
    assert result.mesh.volume == pytest.approx(mesh.volume)


@settings(derandomize=True, max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1e-6, 1e-3, 1.0, 1e3, 1e6]))
def test_the_verdict_knows_no_unit_and_no_frame(seed, scale):
    rng = np.random.default_rng(seed)
    damaged = box()
    damaged.faces[::7] = damaged.faces[::7, ::-1]
    moved = damaged.copy()
    moved.vertices = scale * (damaged.vertices @ random_rotation(rng).T + rng.normal(size=3))
    here, there = repair_mesh(damaged), repair_mesh(moved)
    assert here.repairs == there.repairs
    assert there.mesh.volume == pytest.approx(here.mesh.volume * scale**3, rel=1e-6)


@settings(derandomize=True, max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.02, 0.45))
def test_any_set_of_turned_faces_is_turned_back(seed, share):
    rng = np.random.default_rng(seed)
    damaged = ball()
    turned = rng.random(len(damaged.faces)) < share
    damaged.faces[turned] = damaged.faces[turned, ::-1]
    result = repair_mesh(damaged)
    assert result.mesh.is_watertight
    assert result.mesh.volume == pytest.approx(ball().volume)


def test_an_inside_out_surface_is_turned_outwards():
    mesh = ball()
    mesh.invert()
    result = repair_mesh(mesh)
    assert result.mesh.volume == pytest.approx(ball().volume)
    assert any("inside-out" in repair for repair in result.repairs)


def test_a_cavity_stays_and_a_swallowed_shell_goes():
    hollow = ball(0.02)
    hollow.invert()
    cavity = repair_mesh(joined(ball(0.05), hollow))
    assert cavity.mesh.volume == pytest.approx(ball(0.05).volume - ball(0.02).volume)
    swallowed = repair_mesh(joined(ball(0.05), ball(0.02)))
    assert swallowed.mesh.volume == pytest.approx(ball(0.05).volume)


def test_overlapping_bodies_become_their_union():
    lens = joined(ball(0.05), ball(0.05, at=(0.05, 0.0, 0.0)))
    result = repair_mesh(lens)
    exact = trimesh.boolean.union([ball(0.05), ball(0.05, at=(0.05, 0.0, 0.0))]).volume
    assert result.mesh.volume == pytest.approx(exact, rel=1e-6)
    assert result.mesh.is_watertight


def test_small_holes_are_closed():
    mesh = box()
    kept = np.ones(len(mesh.faces), dtype=bool)
    kept[[3, 40, 90]] = False
    mesh.update_faces(kept)
    result = repair_mesh(mesh)
    assert result.mesh.is_watertight
    assert result.mesh.volume == pytest.approx(box().volume, rel=1e-3)


def test_duplicate_vertices_and_faces_and_slivers_go():
    mesh = ball()
    soup = trimesh.Trimesh(
        mesh.triangles.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False
    )
    sliver = [[0, 0, 1], [2, 2, 2]]
    soup = trimesh.Trimesh(
        soup.vertices, np.vstack([soup.faces, soup.faces[:5], sliver]), process=False
    )
    result = repair_mesh(soup)
    assert result.mesh.is_watertight
    assert len(result.mesh.faces) == len(mesh.faces)


def test_a_self_intersecting_surface_is_remeshed():
    tube = figure_of_eight()
    result = repair_mesh(tube)
    assert result.mesh.is_watertight
    assert any("winding number" in repair for repair in result.repairs)
    assert 0.6 * abs(tube.volume) < result.mesh.volume < abs(tube.volume)


def test_a_vertex_that_no_face_uses_changes_nothing():
    mesh = box()
    stray = trimesh.Trimesh(
        np.vstack([mesh.vertices, [900.0, 0.0, 0.0]]), mesh.faces, process=False
    )
    result = repair_mesh(stray)
    assert result.repairs == ()
    assert result.mesh.volume == pytest.approx(mesh.volume)
    refuse_wrong_scale(stray)


def test_crumbs_are_dropped():
    result = repair_mesh(joined(ball(0.05), ball(0.002, at=(0.2, 0.0, 0.0))))
    assert result.mesh.volume == pytest.approx(ball(0.05).volume)


@pytest.mark.parametrize(
    ("mesh", "word"),
    [
        (trimesh.Trimesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "empty"),
        (trimesh.Trimesh(np.eye(3), [[0, 1, 2]], process=False), "zero volume"),
        (
            trimesh.Trimesh([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False),
            "NaN",
        ),
        (joined(ball(0.05), ball(0.05, at=(0.3, 0.0, 0.0))), "2 separate"),
        (half(box()), "open"),
    ],
    ids=["empty", "triangle", "nan", "two bodies", "half a box"],
)
def test_what_cannot_be_mended_is_refused_in_one_sentence(mesh, word):
    with pytest.raises(InputError, match=word) as caught:
        repair_mesh(mesh)
    assert "\n" not in str(caught.value)
    assert str(caught.value).count(". ") == 0


def test_mass_properties_of_a_box():
    mass = mass_properties(box((0.2, 0.2, 0.2), at=(1.0, 2.0, 3.0)))
    assert mass.center_mass == pytest.approx([1.0, 2.0, 3.0])
    assert mass.volume == pytest.approx(0.008)
    assert mass.torque_scale == pytest.approx(0.1 * np.sqrt(3.0))


@pytest.mark.parametrize("share", [0.3, 0.5, 0.99])
def test_a_file_that_was_cut_off_is_said_to_be_cut_off(tmp_path, share):
    path = tmp_path / "cut.stl"
    ball().export(path)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(InputError, match=r"1280 triangles.*ends after \d+.*copy or export"):
        load_mesh(path)


@pytest.mark.parametrize("ending", ["stl", "obj", "off", "ply", "glb"])
def test_every_format_gives_the_same_body(tmp_path, ending):
    box().export(tmp_path / f"box.{ending}")
    body = repair_mesh(load_mesh(tmp_path / f"box.{ending}", scale=2.0))
    assert body.mesh.volume == pytest.approx(8.0 * box().volume, rel=1e-5)


@pytest.mark.parametrize(("ending", "package"), [("3mf", "lxml"), ("dae", "pycollada")])
def test_a_format_whose_reader_is_not_installed_names_the_package(
    tmp_path, monkeypatch, ending, package
):
    def missing(*_args, **_options):
        raise ImportError(package)

    monkeypatch.setattr(trimesh, "load_scene", missing)
    path = tmp_path / f"thing.{ending}"
    path.write_text("whole")
    with pytest.raises(InputError, match=f"pip install {package}, or convert"):
        load_mesh(path)


def test_files_that_are_no_meshes(tmp_path):
    (tmp_path / "text.stl").write_text("once upon a time")
    (tmp_path / "cut.stl").write_bytes(ball().export(file_type="stl")[:5000])
    (tmp_path / "empty.obj").write_text("")
    (tmp_path / "note.txt").write_text("")
    (tmp_path / "points.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n"
    )
    for name in ("text.stl", "cut.stl", "empty.obj", "note.txt", "points.ply", "gone.stl", "."):
        with pytest.raises(InputError, match="Expected"):
            load_mesh(tmp_path / name)


@pytest.mark.parametrize("ending", ["stl", "obj", "off", "ply", "glb"])
def test_nan_in_a_file_is_named_and_not_dropped_in_silence(tmp_path, ending):
    mesh = trimesh.Trimesh(box().vertices.copy(), box().faces, process=False)
    mesh.vertices[0, 0] = np.nan
    mesh.export(tmp_path / f"nan.{ending}")
    with pytest.raises(InputError, match="NaN"):
        load_mesh(tmp_path / f"nan.{ending}")


@pytest.mark.parametrize(
    ("edge", "advice"), [(80.0, "0.001"), (12.0, "0.01"), (6.0, "0.0254"), (1e-4, "--scale")]
)
def test_a_wrong_unit_is_noticed(edge, advice):
    with pytest.raises(InputError, match=advice):
        refuse_wrong_scale(box((edge, edge, edge)))


def test_a_chair_and_a_marble_are_no_wrong_unit():
    refuse_wrong_scale(box((0.8, 0.5, 0.5)))
    refuse_wrong_scale(ball(0.005))
