"""Voronoi poles against shrinking balls, and the laws of the filters."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from medkit.errors import InputError
from medkit.grasping import (
    filter_lambda,
    filter_object_angle,
    filter_radius_ratio,
    filter_scale_axis,
    medial_axis,
    medial_axis_by_poles,
    sample_surface,
)
from medkit.medial.filters import touch_circumradii, uncovered
from medkit.medial.poles import poles_from_surface

create = trimesh.creation
BOX = create.box((0.2, 0.1, 0.05))


@pytest.mark.parametrize("name", ["box", "torus", "capsule"])
def test_poles_and_shrinking_balls_agree(name):
    mesh = {
        "box": BOX,
        "torus": create.torus(0.08, 0.02, 96, 48),
        "capsule": create.capsule(0.2, 0.03, count=[48, 48]),
    }[name]
    balls, poles = filter_object_angle(medial_axis(mesh)), medial_axis_by_poles(mesh)
    distance, nearest = cKDTree(poles.centers).query(balls.centers)
    wrong = np.abs(balls.radii - poles.radii[nearest])
    assert np.median(wrong) < 0.05 * balls.spacing
    assert np.quantile(wrong, 0.95) < 0.25 * balls.spacing
    # along a sheet poles are as far apart as the samples are on the surface; lines they fill
    assert np.quantile(distance, 0.95) < (1.0 if name == "box" else 0.15) * balls.spacing


def test_inside_the_sheet_of_a_box_balls_are_exact_and_poles_leave_it_by_little():
    """What is left of the difference is where on the sheet a pole lies, and the sheet's rim."""
    off = []
    for axis in (filter_object_angle(medial_axis(BOX)), medial_axis_by_poles(BOX)):
        axis = filter_object_angle(axis)
        inside = np.all(np.abs(axis.centers[:, :2]) < [0.07, 0.02], axis=1)
        assert np.count_nonzero(inside) > 800
        off.append(np.abs(axis.centers[inside, 2]))
    assert off[0].max() < 1e-12
    assert off[1].max() < 0.04 * axis.spacing


def test_no_sample_is_inside_a_polar_ball():
    sample = sample_surface(BOX)
    axis = poles_from_surface(sample)
    nearest = cKDTree(sample.points).query(axis.centers)[0]
    assert nearest == pytest.approx(axis.radii, rel=1e-6)


def test_the_angle_filter_is_monotone_and_removes_edges():
    axis = medial_axis(BOX)
    sizes = [len(filter_object_angle(axis, np.radians(a))) for a in (0, 60, 100, 120, 170)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == len(axis)
    assert np.abs(filter_object_angle(axis).centers[:, 2]).max() < 0.01 * axis.diagonal


def test_the_radius_filter_keeps_the_largest():
    axis = medial_axis(BOX)
    for ratio in (0.0, 0.3, 0.5, 0.7, 1.0):
        kept = filter_radius_ratio(axis, ratio)
        assert kept.radii.max() == axis.radii.max()
        assert kept.radii.min() >= ratio * axis.radii.max()


def test_lambda_is_half_the_distance_of_the_touch_points():
    axis = medial_axis(BOX)
    apart = np.linalg.norm(axis.touch_points[:, 0] - axis.touch_points[:, 1], axis=1)
    assert touch_circumradii(axis) == pytest.approx(0.5 * apart, abs=1e-9)
    assert touch_circumradii(filter_lambda(axis, 0.01)).min() >= 0.01


def test_uncovered_equals_its_plain_twin():
    rng = np.random.default_rng(3)
    centers, radii = rng.uniform(size=(200, 3)), rng.uniform(0.01, 0.4, size=200)
    apart = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    inside = (apart + radii[None, :] <= radii[:, None]) & ~np.eye(200, dtype=bool)
    assert uncovered(centers, radii).tolist() == np.flatnonzero(~inside.any(axis=0)).tolist()


def test_the_scale_axis_thins_out_and_keeps_the_volume_of_a_noisy_box():
    rng = np.random.default_rng(0)
    noisy = BOX.subdivide().subdivide().subdivide().subdivide()
    noisy = trimesh.Trimesh(noisy.vertices + rng.normal(0, 4e-4, noisy.vertices.shape), noisy.faces)
    axis = medial_axis(noisy)
    small = [len(filter_scale_axis(axis, s)) for s in (1.0, 1.1, 1.3)]
    assert small[0] > small[1] > small[2] > 0
    assert filter_scale_axis(axis, 1.3).radii.max() == axis.radii.max()


def test_bad_thresholds_are_refused():
    axis = medial_axis(BOX)
    with pytest.raises(InputError, match="scale of at least 1"):
        filter_scale_axis(axis, 0.9)
    with pytest.raises(InputError, match="min_angle"):
        filter_object_angle(axis, -1.0)
    with pytest.raises(InputError, match="min_lambda"):
        filter_lambda(axis, np.nan)
    with pytest.raises(InputError, match="ratio"):
        filter_radius_ratio(axis, "half")
