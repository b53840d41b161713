"""Damaged meshes: a correct medial axis, or one clear sentence that says what is wrong."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from medkit.errors import InputError
from medkit.grasping import filter_object_angle, medial_axis

create = trimesh.creation
SIZE = (0.2, 0.1, 0.05)


def box(subdivisions=3):
    mesh = create.box(SIZE)
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    return mesh.vertices.copy(), mesh.faces.copy()


def holes():
    v, f = box()
    return v, np.delete(f, [3, 200, 500], axis=0)


def flipped_faces():
    v, f = box()
    f[::5] = f[::5, ::-1]
    return v, f


def inside_out():
    v, f = box()
    return v, f[:, ::-1]


def duplicate_vertices():
    v, f = box()
    return v[f.ravel()], np.arange(3 * len(f)).reshape(-1, 3)


def duplicate_faces():
    v, f = box()
    return v, np.vstack([f, f[:20], f[7:8]])


def slivers():
    v, f = box(0)
    v = np.vstack([v, v[f[0]].mean(axis=0, keepdims=True)])
    n = len(v) - 1
    a, b, c = f[0]
    f = np.vstack([f[1:], [[a, b, n], [b, c, n], [c, a, n], [a, a, b], [a, b, a]]])
    return v, f


def unused_vertices():
    v, f = box()
    return np.vstack([v, [[0.3, 0.1, 0.05]]]), f


def self_intersection():
    one, two = create.box(SIZE), create.box((0.12, 0.1, 0.05))
    two.apply_translation([0.02, 0.0, 0.0])
    joined = trimesh.util.concatenate([one, two])
    return joined.vertices, joined.faces


def overlapping_bodies():
    one, two = box(), box()
    return np.vstack([one[0], two[0] * [0.5, 1.3, 0.9]]), np.vstack([one[1], two[1] + len(one[0])])


def a_body_within_a_body():
    v, f = box()
    return np.vstack([v, v * 0.4]), np.vstack([f, f + len(v)])


def a_crumb_beside_it():
    v, f = box()
    return np.vstack([v, 0.02 * v + [0.2, 0.0, 0.0]]), np.vstack([f, f + len(v)])


def folded_faces():
    """Some vertices of the top moved past their neighbours: the surface lies on itself."""
    v, f = box()
    top = np.flatnonzero((v[:, 2] > 0.0249) & (np.abs(v[:, 0]) < 0.08) & (np.abs(v[:, 1]) < 0.04))
    v[top[::3], 0] += 0.03
    return v, f


def far_away():
    v, f = box()
    return v + np.array([1e3, -2e3, 5e2]), f


REPAIRED = [
    holes, flipped_faces, inside_out, duplicate_vertices, duplicate_faces, slivers,
    unused_vertices, self_intersection, a_body_within_a_body, a_crumb_beside_it,
    far_away,
]  # fmt: skip


@pytest.mark.parametrize("damage", REPAIRED)
def test_a_damaged_box_still_has_its_middle_sheet(damage):
    vertices, faces = damage()
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    axis = filter_object_angle(medial_axis(mesh, spacing=0.004))
    middle = vertices[np.unique(faces)].mean(axis=0)[2] if damage is far_away else 0.0
    assert np.abs(axis.centers[:, 2] - middle).max() < 0.01 * axis.diagonal
    assert axis.radii == pytest.approx(0.025, abs=0.01 * axis.diagonal)
    assert np.count_nonzero(axis.radii > 0.024) > 500


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_tiny_and_huge_objects_have_the_same_axis(factor):
    vertices, faces = box()
    plain = medial_axis(trimesh.Trimesh(vertices, faces, process=False))
    scaled = medial_axis(trimesh.Trimesh(vertices * factor, faces, process=False))
    assert len(scaled) == pytest.approx(len(plain), rel=0.02)
    ours, theirs = filter_object_angle(plain), filter_object_angle(scaled)
    assert np.median(theirs.radii) / factor == pytest.approx(np.median(ours.radii), rel=1e-3)


def test_a_shell_within_a_shell_is_a_cavity():
    outer, inner = create.icosphere(4, 0.05), create.icosphere(4, 0.03)
    inner.invert()
    axis = medial_axis(trimesh.util.concatenate([outer, inner]))
    assert axis.radii == pytest.approx(0.01, abs=0.001)
    assert np.linalg.norm(axis.centers, axis=1) == pytest.approx(0.04, abs=0.001)


def test_a_surface_that_folds_over_itself_is_remeshed():
    vertices, faces = folded_faces()
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    axis = filter_object_angle(medial_axis(mesh, spacing=0.004))
    off = np.maximum(np.abs(axis.centers[:, 2]), np.abs(axis.radii - 0.025))
    # remeshing blunts the edges a little, and a few small spheres appear there
    assert np.mean(off < 0.01 * axis.diagonal) > 0.95
    assert np.count_nonzero(axis.radii > 0.024) > 500


def test_bodies_that_overlap_become_one():
    """A plate through a box, as two closed shells: the spheres are those of the union."""
    vertices, faces = overlapping_bodies()
    axis = medial_axis(trimesh.Trimesh(vertices, faces, process=False), spacing=0.004)
    union = trimesh.boolean.union(
        [create.box(SIZE), create.box(np.array(SIZE) * [0.5, 1.3, 0.9])], engine="manifold"
    )
    exact = medial_axis(union, spacing=0.004)
    ours, theirs = filter_object_angle(axis), filter_object_angle(exact)
    apart = cKDTree(theirs.centers).query(ours.centers)[0]
    # two sets of samples of one surface: centres agree to within the distance of two samples
    assert np.quantile(apart, 0.99) < 0.75 * axis.spacing
    assert ours.radii.max() == pytest.approx(theirs.radii.max(), rel=0.02)


def a_wall_within():
    """A wall inside a box, sewn to it: edges with three faces, and an inside that is cut in two."""
    v, f = box(0)
    return v, np.vstack([f, [[0, 2, 5], [0, 5, 7]]])


def several_bodies():
    one, two = create.icosphere(2, 0.05), create.icosphere(2, 0.03)
    two.apply_translation([0.2, 0.0, 0.0])
    joined = trimesh.util.concatenate([one, two])
    return joined.vertices, joined.faces


def boxes_that_share_an_edge():
    one, two = create.box((0.1, 0.1, 0.04)), create.box((0.1, 0.1, 0.04))
    two.apply_translation([0.1, 0.0, 0.04])
    joined = trimesh.util.concatenate([one, two])
    joined.merge_vertices()
    return joined.vertices, joined.faces


def one_triangle():
    return [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]


def no_faces():
    return np.zeros((0, 3)), np.zeros((0, 3), int)


def flat_square():
    return [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]]


def all_in_one_point():
    return np.zeros((4, 3)), [[0, 1, 2], [1, 2, 3]]


def not_a_number():
    v, f = box()
    v[5] = np.nan
    return v, f


REFUSED = [
    one_triangle, no_faces, flat_square, all_in_one_point, not_a_number, several_bodies,
    boxes_that_share_an_edge, a_wall_within,
]  # fmt: skip


@pytest.mark.parametrize("damage", REFUSED)
def test_what_is_not_one_body_is_refused_in_one_sentence(damage):
    vertices, faces = damage()
    with pytest.raises(InputError) as refusal:
        medial_axis(trimesh.Trimesh(vertices, faces, process=False))
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) > 30


def test_the_refusal_names_the_defect_and_the_remedy():
    vertices, faces = several_bodies()
    with pytest.raises(InputError, match=r"one body, .* 2 separate ones; keep the one you mean"):
        medial_axis(trimesh.Trimesh(vertices, faces, process=False))
    vertices, faces = one_triangle()
    with pytest.raises(InputError, match=r"volume|open"):
        medial_axis(trimesh.Trimesh(vertices, faces, process=False))


def test_absurd_spacings_are_refused_or_served():
    mesh = create.box(SIZE)
    with pytest.raises(InputError, match="larger"):
        medial_axis(mesh, spacing=1e-7)
    for spacing in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="spacing"):
            medial_axis(mesh, spacing=spacing)
    assert len(medial_axis(mesh, spacing=10.0)) >= 0
