"""Laws of surface sampling."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from medkit.datasets import load_object
from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.grasping import sample_surface
from medkit.medial.size import smallest_diagonal
from medkit.medial.surface import corner_normals, facet_depth
from medkit.medial.surface_kernels import ends_along, lay_candidates, thin_samples
from medkit.meshes import repair_mesh

create = trimesh.creation


def test_thinning_equals_its_plain_twin():
    rng = np.random.default_rng(0)
    points = rng.uniform(size=(600, 3))
    normals = rng.normal(size=(600, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    kept = []
    for i in range(len(points)):
        near = [
            j
            for j in kept
            if np.linalg.norm(points[i] - points[j]) < 0.15 and normals[i] @ normals[j] >= 0.5
        ]
        if not near:
            kept.append(i)
    assert thin_samples(points, normals, 0.15, 0.5).tolist() == kept


def test_candidates_equal_their_plain_twin():
    mesh = create.icosphere(1, 0.05)
    rng = np.random.default_rng(3)
    corners, flat = np.asarray(mesh.triangles), np.asarray(mesh.face_normals)
    smooth = flat[:, None] + rng.normal(0.0, 0.2, size=corners.shape)
    smooth[3] = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]  # cancel in the middle
    edges, count, phase, stride = np.cumsum(mesh.area_faces), 500, 0.381966, 309
    got = lay_candidates(edges, count, phase, stride, corners, smooth, flat)
    i = np.arange(count) * stride % count
    faces = np.minimum(np.searchsorted(edges, (i + phase) / count * edges[-1]), len(edges) - 1)
    u, v = (0.5 + i / 1.32471795724474602596) % 1.0, (0.5 + i / 1.32471795724474602596**2) % 1.0
    u, v = np.where(u + v > 1.0, [1.0 - u, 1.0 - v], [u, v])
    weights = np.column_stack([1.0 - u - v, u, v])
    assert np.array_equal(got[0], faces)
    assert set(faces) == set(range(len(flat)))
    assert got[1] == pytest.approx(np.einsum("nk,nkd->nd", weights, corners[faces]), abs=1e-15)
    normals = np.einsum("nk,nkd->nd", weights, smooth[faces])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0.5, normals / length, flat[faces])
    assert np.any(length < 0.5)
    assert got[2] == pytest.approx(normals, abs=1e-14)


def test_the_ends_along_a_direction_equal_their_plain_twin():
    rng = np.random.default_rng(1)
    points, directions = rng.normal(size=(200, 3)), rng.normal(size=(30, 3))
    low, high = ends_along(points, directions)
    along = points @ directions.T
    assert np.array_equal(low, along.argmin(axis=0))
    assert np.array_equal(high, along.argmax(axis=0))


# symmetric shapes are the hard ones: there rounding could choose between equal halves
TURNED = {
    "box": create.box((0.2, 0.1, 0.05)),
    "cube in many faces": create.box((1, 1, 1)).subdivide().subdivide(),
    "ball": create.icosphere(3, 0.05),
    "capsule": create.capsule(0.2, 0.03, count=[24, 24]),
    "torus": create.torus(0.08, 0.02, 48, 24),
    "hexagonal prism": create.cylinder(0.03, 0.1, sections=6),
    "thin wall": create.box((0.2, 0.2, 0.0005)),
    "hammer": load_object("hammer"),
    "giraffe": load_object("giraffe"),
}


@pytest.mark.parametrize("name", TURNED)
def test_samples_move_turn_and_grow_with_the_mesh(name):
    mesh = repair_mesh(TURNED[name]).mesh
    here = sample_surface(mesh)
    rng = np.random.default_rng(7)
    for factor in (1.0, 1000.0, 0.0173):
        R, t = random_rotation(rng), rng.normal(size=3)
        moved = trimesh.Trimesh(factor * (mesh.vertices @ R.T + t), mesh.faces, process=False)
        there = sample_surface(repair_mesh(moved).mesh)
        assert np.array_equal(there.faces, here.faces)
        back = (there.points / factor - t) @ R
        assert np.abs(back - here.points).max() < 1e-9 * here.diagonal
        assert np.abs(there.normals @ R - here.normals).max() < 1e-9
        sizes = [there.diagonal, there.spacing, there.facet_depth]
        expected = [here.diagonal, here.spacing, here.facet_depth]
        assert np.array(sizes) / factor == pytest.approx(expected, rel=1e-9)


def test_the_size_is_the_diagonal_of_the_smallest_box():
    rng = np.random.default_rng(3)
    for extents in ([4.0, 2.0, 1.0], [1.0, 1.0, 1.0], [3.0, 3.0, 1e-3]):
        corners = create.box(extents).vertices @ random_rotation(rng).T
        assert smallest_diagonal(corners) == pytest.approx(np.linalg.norm(extents), rel=1e-12)
    ball = create.icosphere(4, 1.0).vertices
    assert smallest_diagonal(ball) == pytest.approx(2.0 * np.sqrt(3.0), rel=0.02)
    # no box in any of many directions is clearly smaller
    points = rng.normal(size=(300, 3)) * [3.0, 1.0, 1.0]
    boxes = [np.linalg.norm(np.ptp(points @ random_rotation(rng).T, axis=0)) for _ in range(2000)]
    assert smallest_diagonal(points) < 1.01 * min(boxes)


def test_flat_straight_and_single_points_have_a_size_too():
    square = np.array([[0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]], dtype=float)
    assert smallest_diagonal(square) == pytest.approx(5.0)
    line = np.c_[np.linspace(-1, 1, 9), np.zeros((9, 2))]
    assert smallest_diagonal(line) == pytest.approx(2.0)
    assert smallest_diagonal(np.zeros((3, 3))) == 0.0


def test_the_triangulation_changes_neither_size_nor_density():
    coarse = create.box((0.2, 0.1, 0.05))
    fine = coarse.subdivide().subdivide().subdivide()
    slivers = create.box((2.0, 0.1, 0.05)).subdivide_to_size(0.1).apply_scale([0.1, 1.0, 1.0])
    one = sample_surface(coarse)
    for mesh in (fine, slivers):
        other = sample_surface(mesh)
        assert other.diagonal == pytest.approx(one.diagonal, rel=1e-12)
        assert len(other) == pytest.approx(len(one), rel=0.03)
        # every face of the box gets its share, and every sample has one of the others near
        share = np.abs(other.normals).T @ np.ones(len(other)) / len(other)
        assert share == pytest.approx([1 / 7, 2 / 7, 4 / 7], abs=0.01)
        apart = cKDTree(other.points).query(one.points)[0]
        assert apart.max() < 1.1 * one.spacing
        assert apart.mean() == pytest.approx(0.44 * one.spacing, rel=0.15)


@pytest.mark.parametrize(
    "mesh", [create.box((2, 1, 0.5)), create.icosphere(3), create.cylinder(1, 2)]
)
def test_samples_are_even(mesh):
    spacing = 0.05
    sample = sample_surface(mesh, spacing=spacing)
    assert len(sample) == pytest.approx(mesh.area / spacing**2, rel=0.2)
    tree = cKDTree(sample.points)
    probe = mesh.sample(2000, seed=1)
    # no hole wider than the spacing
    assert tree.query(probe)[0].max() < 1.1 * spacing
    nearest = tree.query(sample.points, k=2)[0][:, 1]
    assert np.median(nearest) > 0.75 * spacing


def test_samples_lie_on_their_faces_with_outward_normals():
    mesh = create.icosphere(3, 0.05)
    sample = sample_surface(mesh)
    planes = mesh.face_normals[sample.faces]
    gap = np.einsum("nk,nk->n", sample.points - mesh.triangles[sample.faces, 0], planes)
    assert np.abs(gap).max() < 1e-12
    radial = sample.points / np.linalg.norm(sample.points, axis=1, keepdims=True)
    assert np.linalg.norm(sample.normals, axis=1) == pytest.approx(1.0, abs=1e-12)
    assert np.sum(radial * sample.normals, axis=1).min() > np.cos(np.radians(2.0))


def test_creases_stay_sharp_and_facets_become_smooth():
    box = create.box((1, 1, 1))
    assert corner_normals(box) == pytest.approx(np.repeat(box.face_normals[:, None], 3, axis=1))
    assert facet_depth(box) == 0.0
    ball = create.icosphere(3)
    radial = ball.vertices[ball.faces]
    assert np.sum(corner_normals(ball) * radial, axis=2).min() > np.cos(np.radians(1.0))


def test_facet_depth_is_the_sagitta():
    for sections in (24, 48):
        depth = facet_depth(create.cylinder(1.0, 1.0, sections=sections))
        assert depth == pytest.approx(1.0 - np.cos(np.pi / sections), rel=1.1)


def test_the_seed_is_the_mesh_itself():
    mesh = create.torus(0.1, 0.03)
    a, b = sample_surface(mesh), sample_surface(mesh.copy())
    assert np.array_equal(a.points, b.points)
    assert np.array_equal(a.faces, b.faces)


def test_both_sides_of_a_thin_wall_are_sampled():
    sample = sample_surface(create.box((0.2, 0.2, 0.0005)))
    top, bottom = sample.normals[:, 2] > 0.9, sample.normals[:, 2] < -0.9
    assert np.count_nonzero(top) == pytest.approx(np.count_nonzero(bottom), rel=0.1)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="surface"):
        sample_surface(trimesh.Trimesh())
    with pytest.raises(InputError, match="no area"):
        sample_surface(
            trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
        )
