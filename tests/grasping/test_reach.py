"""What a hand meets on its way: known bodies, invariances, and plain twins of the kernels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from medkit.geometry import apply, random_rotation, transform
from medkit.grasping import medial_axis, medial_axis_from_surface, sample_surface
from medkit.grasping.reach import blocked, local_thickness, way_out

WAYS = np.vstack([np.eye(3), -np.eye(3)])


@pytest.fixture(scope="module")
def plate():
    return medial_axis(trimesh.creation.box((0.1, 0.2, 0.02)))


@pytest.fixture(scope="module")
def pair():
    """Two plates in one plane, with a gap of 4 cm between their rims."""
    one = trimesh.creation.box((0.1, 0.2, 0.02))
    other = one.copy()
    other.apply_translation([0.14, 0.0, 0.0])
    return medial_axis_from_surface(sample_surface(trimesh.util.concatenate([one, other])))


def chord_of_balls(axis, point, way):
    """Where a line is inside any ball, as sorted intervals, in plain numpy."""
    away = axis.centers - point
    along = away @ way
    left = axis.radii**2 - (away**2).sum(axis=1) + along**2
    met = left > 0.0
    half = np.sqrt(left[met])
    spans = np.stack([along[met] - half, along[met] + half], axis=1)
    return spans[np.argsort(spans[:, 0])][spans[np.argsort(spans[:, 0]), 1] > 0.0]


def test_a_way_out_of_a_box_is_as_long_as_the_box(plate):
    depth, room = way_out(plate, np.zeros((6, 3)), WAYS)
    assert np.isinf(room).all()
    np.testing.assert_allclose(depth, [0.05, 0.1, 0.01] * 2, atol=plate.spacing)


def test_a_way_into_another_part_is_free_for_the_gap_alone(pair):
    depth, room = way_out(pair, np.zeros((2, 3)), np.array([[1.0, 0, 0], [-1.0, 0, 0]]))
    assert room[0] == pytest.approx(0.04, abs=pair.spacing)
    assert room[1] == np.inf
    np.testing.assert_allclose(depth, 0.05, atol=pair.spacing)


def test_ways_are_those_of_the_intervals_merged_one_by_one(pair):
    rng = np.random.default_rng(0)
    points = pair.centers[rng.integers(0, len(pair), 40)]
    ways = rng.normal(size=(40, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    depth, room = way_out(pair, points, ways)
    for k in range(40):
        end, next_part = 0.0, np.inf
        for enter, leave in chord_of_balls(pair, points[k], ways[k]):
            if enter > end + pair.spacing:
                next_part = enter - end
                break
            end = max(end, leave)
        assert depth[k] == pytest.approx(end, abs=1e-12)
        assert room[k] == pytest.approx(next_part, abs=1e-12)
    assert np.isinf(room).any()
    assert not np.isinf(room).all()


def test_thickness_is_that_of_the_largest_ball_around_a_point(plate):
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.06, 0.06, size=(60, 3)) * [1.0, 2.0, 0.2]
    away = np.linalg.norm(plate.centers[None] - points[:, None], axis=2)
    twin = np.where(away <= plate.radii, plate.radii, 0.0).max(axis=1)
    np.testing.assert_array_equal(local_thickness(plate, points), twin)
    assert (twin == 0.0).any()
    assert twin.max() == pytest.approx(0.01, abs=1e-3)


def test_one_place_inside_is_enough_to_be_blocked(plate):
    inside, outside = np.zeros(3), np.array([0.0, 0.0, 0.05])
    places = np.array([[outside, inside], [outside, outside]])
    assert blocked(plate, places).tolist() == [True, False]


def test_reach_turns_and_grows_with_the_object(pair):
    pose = transform(random_rotation(np.random.default_rng(2)), [0.3, -0.1, 0.2])
    turned = replace(pair, centers=2.0 * apply(pose, pair.centers), radii=2.0 * pair.radii,
                     spacing=2.0 * pair.spacing)  # fmt: skip
    points = np.repeat(pair.centers[::100], 6, axis=0)
    ways = np.tile(WAYS, (len(points) // 6, 1))
    moved, led = 2.0 * apply(pose, points), ways @ pose[:3, :3].T
    depth, room = way_out(pair, points, ways)
    again, gap = way_out(turned, moved, led)
    np.testing.assert_allclose(again, 2.0 * depth, atol=1e-7)
    # a way along a face may go either way by rounding
    assert np.isclose(gap, 2.0 * room, atol=1e-7).mean() > 0.99
    thick = local_thickness(pair, 0.999 * points)
    np.testing.assert_allclose(local_thickness(turned, 2.0 * apply(pose, 0.999 * points)),
                               2.0 * thick, atol=1e-9)  # fmt: skip
