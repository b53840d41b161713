"""Laws of surface sampling."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from medkit.errors import InputError
from medkit.grasping import sample_surface
from medkit.medial.surface import corner_normals, facet_depth
from medkit.medial.surface_kernels import thin_samples

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
    assert np.flatnonzero(thin_samples(points, normals, 0.15, 0.5)).tolist() == kept


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
