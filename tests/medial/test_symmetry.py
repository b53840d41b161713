"""Laws and known answers of local symmetry."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from medkit.datasets import load_object
from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.grasping import (
    MedialAxis,
    MedialSphereGrid,
    SymmetryKind,
    filter_object_angle,
    local_symmetry,
    medial_axis,
)
from medkit.medial.grid_kernels import local_moments, principal_axes

create = trimesh.creation


def symmetry_of(centers, radius, **options):
    centers = np.asarray(centers, dtype=float)
    n = len(centers)
    axis = MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 0.01, 1.0)
    return local_symmetry(MedialSphereGrid.from_axis(axis), radius, **options)


def of_object(mesh, radius=0.03):
    axis = filter_object_angle(medial_axis(mesh))
    return axis, local_symmetry(MedialSphereGrid.from_axis(axis), radius)


def test_pca_equals_numpy_for_every_sphere():
    centers = np.random.default_rng(0).normal(size=(200, 3)) * [1.0, 0.5, 0.1] + 1000.0
    result = symmetry_of(centers, 0.8, min_neighbors=3)
    for i in range(len(centers)):
        near = centers[np.linalg.norm(centers - centers[i], axis=1) <= 0.8]
        assert result.counts[i] == len(near)
        assert result.centroid[i] == pytest.approx(near.mean(axis=0), abs=1e-9)
        if len(near) >= 3:
            values, vectors = np.linalg.eigh(np.cov(near.T, bias=True))
            assert result.lambdas[i] == pytest.approx(values[::-1], abs=1e-9)
            assert result.rho[i] == pytest.approx(values[1] / values[2], abs=1e-7)
            assert abs(result.e1[i] @ vectors[:, 2]) == pytest.approx(1.0, abs=1e-6)
            assert abs(result.e2[i] @ vectors[:, 1]) == pytest.approx(1.0, abs=1e-6)


def uneven_sets():
    """Centres in a cube, on a sheet, on a line, on a curved sheet, and many in one place."""
    rng = np.random.default_rng(3)
    cube = rng.uniform(size=(700, 3))
    yield cube
    yield cube * [2.0, 2.0, 1e-3]
    yield cube * [9.0, 1e-3, 1e-3]
    yield np.c_[cube[:, :2], 0.3 * np.sin(6.0 * cube[:, 0])] @ random_rotation(rng)
    yield np.vstack([cube[:300], np.full((300, 3), 0.5), np.round(cube[:100] * 4) / 4])


@pytest.mark.parametrize("density", [0.3, 4.0, 60.0])
@pytest.mark.parametrize("shift", [0.0, 1e4])
def test_moments_equal_brute_force(density, shift):
    """Cells share what is in reach of all their spheres, and nobody can tell."""
    for plain in uneven_sets():
        centers = plain + shift
        n = len(centers)
        axis = MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 0.01, 1.0)
        grid = MedialSphereGrid.from_axis(axis, cell_density=density)
        for radius in (0.25, 0.5):
            number, moments = local_moments(radius, *grid.cells())
            for place in range(0, n, 29):
                offsets = centers - centers[grid.order[place]]
                dx, dy, dz = offsets.T
                near = offsets[dx * dx + dy * dy + dz * dz <= radius * radius]
                assert number[place] == len(near)
                xx, yy, zz, xy, xz, yz = moments[place, 3:]
                expected = np.cov(near.T, bias=True) if len(near) > 1 else np.zeros((3, 3))
                found = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                assert np.abs(found - expected).max() <= 1e-12 * max(np.trace(expected), 1e-3)
                assert np.abs(moments[place, :3] - near.mean(axis=0)).max() < 1e-12 * radius


def test_jacobi_equals_lapack_also_for_repeated_and_zero_eigenvalues():
    rng = np.random.default_rng(2)
    for values in ([3, 2, 1], [1, 1, 0], [1, 0, 0], [2, 2, 2], [0, 0, 0], [1e-12, 1e-13, 0]):
        R = random_rotation(rng)
        m = R @ np.diag(values) @ R.T
        row = np.r_[0, 0, 0, np.diag(m), m[0, 1], m[0, 2], m[1, 2]][None]
        found, vectors = principal_axes(row)
        assert found[0] == pytest.approx(np.sort(values)[::-1], abs=1e-14)
        assert vectors[0] @ vectors[0].T == pytest.approx(np.eye(3), abs=1e-12)
        assert vectors[0].T @ np.diag(found[0]) @ vectors[0] == pytest.approx(m, abs=1e-14)


@pytest.mark.parametrize(
    ("mesh", "along"),
    [(create.capsule(0.2, 0.03), [0, 0, 1]), (create.cylinder(0.02, 0.2), [0, 0, 1])],
)
def test_long_round_objects_have_an_axis(mesh, along):
    axis, result = of_object(mesh)
    middle = np.abs(axis.centers[:, 2] - axis.centers[:, 2].mean()) < 0.04
    assert np.all(result.kind[middle] == SymmetryKind.AXIS)
    assert np.abs(result.e1[middle] @ along).min() > 0.999
    assert result.rho[middle].max() < 1e-3


def test_a_thin_torus_is_an_axis_that_bends():
    axis, result = of_object(create.torus(0.15, 0.015, 128, 32), radius=0.02)
    tangent = np.c_[-axis.centers[:, 1], axis.centers[:, 0], np.zeros(len(axis))]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    assert np.all(result.kind == SymmetryKind.AXIS)
    assert np.abs(np.sum(tangent * result.e1, axis=1)).min() > 0.99


def test_a_plate_has_an_interior_and_a_rim_along_its_edges():
    half = 0.1 - 0.01
    axis, result = of_object(create.box((0.2, 0.2, 0.02)))
    inset = half - np.abs(axis.centers[:, :2])
    inside = inset.min(axis=1) > 0.032
    assert np.all(result.kind[inside] == SymmetryKind.INTERIOR)
    rim = (inset[:, 0] < 0.002) & (inset[:, 1] > 0.035)
    assert np.count_nonzero(rim) > 10
    assert np.all(result.kind[rim] == SymmetryKind.RIM)
    assert np.abs(result.e1[rim, 1]).min() > 0.97
    assert np.abs(result.e2[rim, 0]).min() > 0.97
    # a half disc of neighbours: variance along the rim R^2/4, across it R^2 (1/4 - 16 / 9 pi^2)
    assert np.median(result.rho[rim]) == pytest.approx(1.0 - 64.0 / (9.0 * np.pi**2), abs=0.05)


def test_a_ball_is_a_point():
    _, result = of_object(create.icosphere(4, 0.04))
    assert np.all(result.kind == SymmetryKind.POINT)
    assert np.all(result.rho == 0.0)


def test_lonely_spheres_have_too_few_neighbours():
    centers = np.vstack([np.c_[np.linspace(0, 1, 50), np.zeros((50, 2))], [[9.0, 9.0, 9.0]]])
    result = symmetry_of(centers, 0.2)
    assert result.kind[-1] == SymmetryKind.TOO_FEW
    assert result.counts[-1] == 1
    assert np.all(result.kind[:-1] != SymmetryKind.TOO_FEW)
    assert np.all(np.isfinite(result.rho))
    assert np.all(np.isfinite(result.e1))


def test_rotation_turns_the_axes_and_keeps_the_kinds():
    rng = np.random.default_rng(5)
    centers = rng.normal(size=(300, 3)) * [1.0, 0.4, 0.05]
    R = random_rotation(rng)
    a, b = symmetry_of(centers, 0.6), symmetry_of(centers @ R.T, 0.6)
    assert np.array_equal(a.counts, b.counts)
    assert a.rho == pytest.approx(b.rho, abs=1e-9)
    assert np.array_equal(a.kind, b.kind)
    clear = (a.rho < 0.9) & (a.kind != SymmetryKind.TOO_FEW)
    assert np.abs(np.sum(a.e1[clear] @ R.T * b.e1[clear], axis=1)).min() > 1.0 - 1e-6


MOVED = {
    "box": create.box((0.2, 0.1, 0.05)),
    "capsule": create.capsule(0.2, 0.03, count=[32, 32]),
    "torus": create.torus(0.08, 0.02, 64, 32),
    "hammer": load_object("hammer"),
}


@pytest.mark.parametrize("name", MOVED)
def test_axis_and_symmetry_move_with_the_mesh(name):
    mesh = MOVED[name]
    rng = np.random.default_rng(11)
    R, t = random_rotation(rng), rng.normal(size=3)
    moved = mesh.copy()
    moved.vertices = mesh.vertices @ R.T + t
    (a, sym_a), (b, sym_b) = of_object(mesh), of_object(moved)
    # a sphere that touches more than two samples may stop at another of them
    assert len(a) == pytest.approx(len(b), rel=0.003)
    assert a.diagonal == pytest.approx(b.diagonal, rel=1e-9)
    here = np.c_[a.centers, a.radii]
    there = np.c_[(b.centers - t) @ R, b.radii]
    for one, other in ((here, there), (there, here)):
        assert cKDTree(one).query(other)[0].max() < 0.01 * a.diagonal
        assert np.median(cKDTree(one).query(other)[0]) < 0.01 * a.spacing
    share = [np.bincount(s.kind, minlength=5) / len(s) for s in (sym_a, sym_b)]
    assert share[0] == pytest.approx(share[1], abs=0.01)


def test_thresholds_decide_in_order():
    centers = np.random.default_rng(6).normal(size=(400, 3)) * [1.0, 0.5, 0.0]
    rho = symmetry_of(centers, 1.0).rho
    low, high = np.quantile(rho, [0.3, 0.7])
    kind = symmetry_of(centers, 1.0, rho_axis=low, rho_plane=high, min_neighbors=1).kind
    assert np.array_equal(kind == SymmetryKind.AXIS, rho <= low)
    assert np.array_equal(kind == SymmetryKind.INTERIOR, rho >= high)


@pytest.mark.parametrize("options", [{"rho_axis": 0.5}, {"rho_plane": 0.0}, {"point_spread": -1.0}])
def test_bad_thresholds_are_refused(options):
    with pytest.raises(InputError, match=r"rho_axis|point_spread"):
        symmetry_of(np.eye(3), 1.0, **options)


def test_a_bad_radius_is_refused():
    with pytest.raises(InputError, match="radius"):
        symmetry_of(np.eye(3), -1.0)
