"""Symmetry groups found from meshes whose groups are known."""

import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.geometry import random_rotation, transform
from medkit.similarity.symmetry_group import symmetry_group_from_mesh

create = trimesh.creation
SHAPES = {
    "Dinf": (create.cylinder(0.04, 0.12, sections=64), np.inf, 2),
    "Cinf": (create.cone(0.04, 0.1, sections=64), np.inf, 1),
    "K": (create.icosphere(3, 0.05), np.inf, 1),
    "D2": (create.box((0.1, 0.06, 0.15)), 4, 3),
    "D4": (create.box((0.06, 0.06, 0.15)), 8, 5),
    "D6": (create.cylinder(0.05, 0.1, sections=6), 12, 7),
    "O": (create.box((0.1, 0.1, 0.1)), 24, 9),
    "I": (create.icosahedron(), 60, 15),
}


def moved(mesh: trimesh.Trimesh, seed: int) -> tuple[trimesh.Trimesh, np.ndarray]:
    rng = np.random.default_rng(seed)
    pose = transform(random_rotation(rng), rng.normal(size=3))
    copy = mesh.copy()
    copy.apply_transform(pose)
    return copy, pose


@pytest.mark.parametrize("name", SHAPES)
def test_known_groups_are_found_in_any_pose(name):
    mesh, order, mirrors = SHAPES[name]
    posed, pose = moved(mesh, 7)
    group = symmetry_group_from_mesh(posed)
    assert (group.name, group.order, len(group.mirrors)) == (name, order, mirrors)
    np.testing.assert_allclose(group.center, pose[:3] @ [*mesh.center_mass, 1.0], atol=1e-6)
    assert group.residual < 0.005


def lone(mesh: trimesh.Trimesh, arm: tuple[float, float, float]) -> trimesh.Trimesh:
    side = create.box(np.abs(arm) * 0.6 + 0.012)
    side.apply_translation(arm)
    return trimesh.util.concatenate([mesh, side])


def test_a_handle_takes_the_symmetry_of_a_mug_away_but_for_its_mirror():
    mug = lone(SHAPES["Dinf"][0], (0.055, 0.0, 0.01))
    group = symmetry_group_from_mesh(mug)
    assert (group.name, len(group.mirrors)) == ("C1", 1)
    assert abs(group.mirrors[0] @ [0.0, 1.0, 0.0]) > 0.999


def scanned(mesh: trimesh.Trimesh, rng: np.random.Generator, noise: float) -> trimesh.Trimesh:
    fine = mesh
    while len(fine.faces) < 2500:
        fine = fine.subdivide()
    fine = fine.copy()
    fine.vertices = fine.vertices + rng.normal(scale=noise, size=fine.vertices.shape)
    fine.update_faces(rng.random(len(fine.faces)) > 0.05)  # holes
    return fine


@pytest.mark.parametrize("name", ["Dinf", "D2", "D6"])
def test_noise_and_holes_of_a_scan_do_not_hide_a_group(name):
    mesh = scanned(SHAPES[name][0], np.random.default_rng(3), noise=0.0005)
    group = symmetry_group_from_mesh(mesh)
    assert group.name == name
    assert 0.0 < group.residual < 0.02


def test_the_answer_does_not_depend_on_the_triangles():
    coarse, _ = moved(create.box((0.1, 0.06, 0.15)), 2)
    fine = coarse.subdivide().subdivide()
    a, b = symmetry_group_from_mesh(coarse), symmetry_group_from_mesh(fine)
    for rotation in a.rotations:
        assert b.contains(rotation, tolerance=0.01)


def test_tolerance_decides_whether_a_twelve_sided_prism_is_round():
    prism = create.cylinder(0.05, 0.1, sections=12)
    assert symmetry_group_from_mesh(prism, tolerance=0.02).name == "Dinf"
    assert symmetry_group_from_mesh(prism, tolerance=0.004).name == "D6"  # 12 is not looked for


def test_a_mesh_without_area_is_refused():
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
    with pytest.raises(InputError, match="area"):
        symmetry_group_from_mesh(flat)
    with pytest.raises(InputError, match="tolerance"):
        symmetry_group_from_mesh(SHAPES["D2"][0], tolerance=0.0)
