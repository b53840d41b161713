"""Known answers and laws of the medial axis transform."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from medkit.datasets import load_object
from medkit.errors import InputError
from medkit.geometry import apply, random_rotation, transform
from medkit.grasping import filter_object_angle, medial_axis, sample_surface
from medkit.medial.axis import SLACK, medial_axis_from_surface

create = trimesh.creation


def segment_distance(points, half):
    """Distance from the segment along z of half length `half`."""
    nearest = np.zeros_like(points)
    nearest[:, 2] = np.clip(points[:, 2], -half, half)
    return np.linalg.norm(points - nearest, axis=1)


def ellipsoid_sheet_distance(points, a, b, c):
    """Distance from the ellipse region that is the medial axis for half axes a >= b > c."""
    p, q = (a * a - c * c) / a, (b * b - c * c) / b
    outside = np.maximum(np.hypot(points[:, 0] / p, points[:, 1] / q) - 1.0, 0.0)
    return np.maximum(np.abs(points[:, 2]), outside * max(p, q))


def two_balls():
    """Two balls of one radius whose union has a waist."""
    left, right = create.icosphere(4, 0.05), create.icosphere(4, 0.05)
    left.apply_translation([-0.03, 0.0, 0.0])
    right.apply_translation([0.03, 0.0, 0.0])
    return trimesh.boolean.union([left, right], engine="manifold")


def ellipsoid():
    mesh = create.icosphere(5, 1.0)
    mesh.apply_scale([0.10, 0.07, 0.04])
    return mesh


# every centre of at least 120 deg lies this far from the true medial axis, and has this radius
KNOWN = {
    "ball": (create.icosphere(4, 0.05), lambda c: (np.linalg.norm(c, axis=1), 0.05)),
    "capsule": (
        create.capsule(0.2, 0.03, count=[48, 48]),
        lambda c: (segment_distance(c, 0.1), 0.03),
    ),
    "box": (
        create.box((0.2, 0.1, 0.05)),
        lambda c: (np.abs(c[:, 2]), 0.025),
    ),
    "cube": (create.box((0.1, 0.1, 0.1)), lambda c: (np.linalg.norm(c, axis=1), 0.05)),
    "torus": (
        create.torus(0.08, 0.02, 96, 48),
        lambda c: (np.hypot(np.hypot(c[:, 0], c[:, 1]) - 0.08, c[:, 2]), 0.02),
    ),
    "ellipsoid": (
        ellipsoid(),
        lambda c: (
            ellipsoid_sheet_distance(c, 0.10, 0.07, 0.04),
            0.04
            * np.sqrt(
                np.clip(
                    1.0
                    - c[:, 0] ** 2 / (0.10**2 - 0.04**2)
                    - c[:, 1] ** 2 / (0.07**2 - 0.04**2),
                    0.0,
                    1.0,
                )
            ),
        ),
    ),
    "two balls": (
        two_balls(),
        lambda c: (np.hypot(np.hypot(c[:, 1], c[:, 2]), np.maximum(np.abs(c[:, 0]) - 0.03, 0)),
                   None),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_centres_and_radii_are_known_within_one_percent_of_the_diagonal(name):
    mesh, truth = KNOWN[name]
    axis = filter_object_angle(medial_axis(mesh))
    distance, radius = truth(axis.centers)
    assert len(axis) > 0
    assert distance.max() < 0.01 * axis.diagonal
    if radius is not None:
        assert np.abs(axis.radii - radius).max() < 0.01 * axis.diagonal


def test_a_cylinder_has_an_axis_and_two_cones():
    radius, half = 0.03, 0.1
    axis = filter_object_angle(medial_axis(create.cylinder(radius, 2 * half, sections=64)))
    lateral = np.hypot(axis.centers[:, 0], axis.centers[:, 1])
    to_cap = half - np.abs(axis.centers[:, 2])
    # on the axis the wall is nearest; on the cone of an end, cap and wall are equally near
    on_axis = lateral
    on_cone = np.abs(to_cap - (radius - lateral)) / np.sqrt(2.0)
    assert np.minimum(on_axis, on_cone).max() < 0.01 * axis.diagonal
    assert np.mean(on_axis < 1e-3 * axis.diagonal) > 0.9


def test_the_spheres_off_the_axis_of_a_cylinder_are_those_of_its_two_rims():
    """The exact axis has a cone of 90 deg spheres from each rim to the axis, and nothing else."""
    radius, half = 0.03, 0.1
    axis = medial_axis(create.cylinder(radius, 2 * half, sections=128), spacing=0.003)
    lateral = np.hypot(axis.centers[:, 0], axis.centers[:, 1])
    to_cap = half - np.abs(axis.centers[:, 2])
    cone = (lateral > 2.0 * axis.spacing) & (axis.radii > 2.0 * axis.spacing)
    assert np.count_nonzero(cone) > 100
    # cap and wall are equally far, and the sphere touches both at a right angle
    assert np.abs(to_cap - (radius - lateral))[cone].max() < 0.01 * axis.diagonal
    assert np.abs(axis.radii - to_cap)[cone].max() < 0.01 * axis.diagonal
    assert np.degrees(axis.object_angles[cone]) == pytest.approx(90.0, abs=3.0)


def test_a_prism_keeps_only_the_sheet_towards_its_sharpest_edge():
    # triangle with angles 30, 75, 75 deg: bisectors have object angles 150, 105, 105 deg
    half = 0.1 * np.tan(np.radians(15.0))
    outline = np.array([[0.0, 0.0], [0.1, -half], [0.1, half]])
    faces = [[0, 2, 1], [3, 4, 5]]
    for k in range(3):
        a, b = k, (k + 1) % 3
        faces += [[a, b, b + 3], [a, b + 3, a + 3]]
    corners = np.vstack([np.c_[outline, np.full(3, z)] for z in (-0.15, 0.15)])
    axis = medial_axis(trimesh.Trimesh(corners, faces), spacing=0.002)
    middle = np.abs(axis.centers[:, 2]) < 0.05
    inradius = 0.1 * half / (half + np.hypot(0.1, half))
    wedge = middle & (axis.radii < inradius - 0.006) & (np.abs(axis.centers[:, 1]) < 1e-4)
    assert np.count_nonzero(wedge) > 100
    assert np.allclose(np.degrees(axis.object_angles[wedge]), 150.0, atol=0.1)
    corner = middle & (np.abs(axis.centers[:, 1]) > 0.006) & (axis.radii > 0.004)
    assert np.allclose(np.degrees(axis.object_angles[corner]), 105.0, atol=0.1)


def test_the_central_sphere_of_a_cube_touches_opposite_faces():
    axis = medial_axis(create.box((0.1, 0.1, 0.1)))
    widest = np.argmax(axis.object_angles)
    assert np.degrees(axis.object_angles[widest]) == pytest.approx(180.0, abs=1e-6)
    assert np.linalg.norm(axis.centers[widest]) < axis.spacing
    # balls smaller than the spacing, close to an edge, are not resolved by the samples
    away = (np.linalg.norm(axis.centers, axis=1) > 2.0 * axis.spacing) & (
        axis.radii > 2.0 * axis.spacing
    )
    assert np.degrees(axis.object_angles[away]).max() == pytest.approx(90.0, abs=1e-6)


@pytest.mark.parametrize("name", KNOWN)
def test_no_sample_is_inside_a_sphere_and_two_are_on_it(name):
    mesh = KNOWN[name][0]
    sample = sample_surface(mesh)
    axis = medial_axis_from_surface(sample)
    some = np.arange(0, len(axis), max(1, len(axis) // 400))
    gap = (
        np.linalg.norm(sample.points[None] - axis.centers[some, None], axis=2)
        - axis.radii[some, None]
    )
    # the search allows one slack, a ball taken over from a neighbour's another
    assert gap.min() > -2.0 * max(SLACK * sample.spacing, sample.facet_depth)
    touching = np.sum(gap < np.maximum(sample.spacing**2 / axis.radii[some], 1e-9)[:, None], axis=1)
    assert touching.min() >= 2


def exact_ellipsoid_sample(spacing):
    """Samples of an ellipsoid with exact normals: no facets limit the accuracy."""
    axes = np.array([0.10, 0.07, 0.04])
    ball = sample_surface(create.icosphere(4, 1.0), spacing=spacing / 0.07)
    on_ball = ball.points / np.linalg.norm(ball.points, axis=1, keepdims=True)
    normals = on_ball / axes
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(
        ball, points=on_ball * axes, normals=normals, spacing=spacing, facet_depth=0.0,
        diagonal=float(2.0 * np.linalg.norm(axes)),
    )  # fmt: skip


def exact_torus_sample(spacing):
    sample = sample_surface(KNOWN["torus"][0], spacing=spacing)
    ring = sample.points * [1.0, 1.0, 0.0]
    ring *= 0.08 / np.linalg.norm(ring, axis=1, keepdims=True)
    return on_tube(sample, ring, 0.02)


def exact_capsule_sample(spacing):
    sample = sample_surface(KNOWN["capsule"][0], spacing=spacing)
    middle = np.zeros_like(sample.points)
    middle[:, 2] = np.clip(sample.points[:, 2], -0.1, 0.1)
    return on_tube(sample, middle, 0.03)


def on_tube(sample, middle, radius):
    """Samples moved to a distance from their middles, with exact normals."""
    normals = sample.points - middle
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(sample, points=middle + radius * normals, normals=normals, facet_depth=0.0)


def errors_at(make, name, spacing):
    """Median and 95 % quantile of the errors of centres and of radii from 120 deg on [m]."""
    axis = filter_object_angle(medial_axis_from_surface(make(spacing)))
    off, radius = KNOWN[name][1](axis.centers)
    # a centre may lie anywhere in the sheet of an ellipsoid, whose rim it need not reach
    off = np.abs(axis.centers[:, 2]) if name == "ellipsoid" else off
    wrong = np.abs(axis.radii - radius)
    return np.concatenate([np.quantile(off, [0.5, 0.95]), np.quantile(wrong, [0.5, 0.95])])


SPACINGS = np.array([0.008, 0.004, 0.002])


def test_centres_and_radii_of_an_ellipsoid_converge_with_the_square_of_the_spacing():
    """A sample stands in for the touch point with an error of the second order."""
    errors = np.array([errors_at(exact_ellipsoid_sample, "ellipsoid", h) for h in SPACINGS])
    order = np.polyfit(np.log(SPACINGS), np.log(errors), 1)[0]
    assert np.all((order > 1.8) & (order < 2.3))
    assert np.all(errors < 0.01 * SPACINGS[:, None])


def test_centres_and_radii_of_a_torus_converge():
    errors = np.array([errors_at(exact_torus_sample, "torus", h) for h in SPACINGS])
    order = np.polyfit(np.log(SPACINGS), np.log(errors), 1)[0]
    # balls taken over from a neighbour keep a share of the slack, which is of the first order
    assert np.all(order[[0, 2]] > 1.5)
    assert np.all(order[[1, 3]] > 0.7)
    assert np.all(errors < 0.005 * SPACINGS[:, None])


def test_a_capsule_with_exact_normals_is_exact_at_every_spacing():
    for spacing in SPACINGS:
        assert errors_at(exact_capsule_sample, "capsule", spacing).max() < 1e-12


@pytest.mark.parametrize("name", ["capsule", "box", "torus", "hammer"])
def test_rigid_motion_moves_each_sphere_with_the_mesh(name):
    mesh = load_object(name) if name == "hammer" else KNOWN[name][0]
    T = transform(random_rotation(np.random.default_rng(4)), [0.3, -2.0, 1.0])
    moved = mesh.copy()
    moved.apply_transform(T)
    here, there = medial_axis(mesh), medial_axis(moved)
    assert len(here) == len(there)
    off = np.linalg.norm(apply(T, here.centers) - there.centers, axis=1) / here.diagonal
    # rounding may decide between equally good samples, and round shapes are full of them
    assert np.median(off) < 1e-9
    assert np.quantile(off, 0.99) < 1e-3
    assert np.quantile(np.abs(here.radii - there.radii), 0.99) < 1e-3 * here.diagonal


def test_scale_scales_everything():
    mesh = KNOWN["box"][0]
    # powers of two leave every rounding as it was
    for factor in (2.0**-20, 2.0**13):
        scaled = medial_axis_from_surface(sample_surface(mesh.copy().apply_scale(factor)))
        plain = medial_axis_from_surface(sample_surface(mesh))
        assert len(scaled) == len(plain)
        assert scaled.radii / factor == pytest.approx(plain.radii, rel=1e-6, abs=1e-9)


def test_the_triangulation_does_not_matter():
    coarse = create.box((0.2, 0.1, 0.05))
    fine = coarse.subdivide().subdivide().subdivide()
    one, two = medial_axis(coarse), medial_axis(fine)
    for axis in (one, two):
        sheet = filter_object_angle(axis)
        assert np.abs(sheet.centers[:, 2]).max() < 0.01 * axis.diagonal
    assert len(filter_object_angle(one)) == pytest.approx(len(filter_object_angle(two)), rel=0.15)


def test_the_same_mesh_gives_the_same_spheres():
    mesh = KNOWN["torus"][0]
    a, b = medial_axis(mesh), medial_axis(mesh)
    assert np.array_equal(a.centers, b.centers)
    assert np.array_equal(a.object_angles, b.object_angles)


def test_touch_points_span_the_object_angle_and_lie_on_the_sphere():
    axis = medial_axis(KNOWN["ellipsoid"][0])
    arms = axis.touch_points - axis.centers[:, None]
    lengths = np.linalg.norm(arms, axis=2)
    assert lengths == pytest.approx(np.repeat(axis.radii[:, None], 2, axis=1), rel=1e-9)
    cosine = np.einsum("nk,nk->n", arms[:, 0], arms[:, 1]) / lengths.prod(axis=1)
    assert np.arccos(np.clip(cosine, -1, 1)) == pytest.approx(axis.object_angles, abs=1e-6)


def test_thin_walls_are_seen_however_thin():
    wall = medial_axis(create.box((0.2, 0.2, 0.0005)))
    inner = np.abs(wall.centers[:, :2]).max(axis=1) < 0.09
    assert wall.radii[inner] == pytest.approx(0.00025, rel=1e-6)


def test_the_exterior_of_a_bowl_has_spheres_and_that_of_a_ball_has_none():
    assert len(medial_axis(create.icosphere(4, 0.05), side="exterior")) == 0
    ring = medial_axis(create.torus(0.08, 0.02, 64, 32), side="exterior")
    hole = np.linalg.norm(ring.centers, axis=1) < 0.004
    assert np.count_nonzero(hole) > 20
    assert ring.radii[hole] == pytest.approx(0.06, abs=0.002)


def test_union_of_spheres_covers_the_surface():
    for name in ("box", "ellipsoid", "two balls"):
        mesh = KNOWN[name][0]
        axis = medial_axis(mesh)
        # points of their own: every sample has a sphere through it
        some = trimesh.sample.sample_surface(mesh, 300, seed=1)[0]
        some = np.vstack([some, mesh.vertices[:: max(1, len(mesh.vertices) // 100)]])
        gap = np.linalg.norm(some[:, None] - axis.centers[None], axis=2) - axis.radii[None]
        assert gap.min(axis=1).max() < 0.02 * axis.diagonal


@pytest.mark.parametrize("side", ["inside", None])
def test_an_unknown_side_is_refused(side):
    with pytest.raises(InputError, match="interior"):
        medial_axis(KNOWN["box"][0], side=side)


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, "wide"])
def test_a_bad_tolerance_is_refused(tolerance):
    with pytest.raises(InputError, match="touch_tolerance"):
        medial_axis(KNOWN["box"][0], touch_tolerance=tolerance)
