"""The guided planner: what it promises about directions, spread and search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from medkit.datasets.objects import load_object
from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.grasping import SphereFate, candidates_from_axis, medial_axis, plan_grasps
from medkit.grasping.choosing import spread_candidates
from medkit.grasping.improved import (
    DETAIL,
    MOST,
    conditions_met,
    depth_of_object,
    finger_places,
    improved_candidates,
    straddle,
)
from medkit.grasping.reach import blocked, local_thickness
from medkit.grasping.stopwatch import Stopwatch
from medkit.robots import load_hand

SETTINGS = {"grasp": "power", "search_radius": 0.03, "min_radius_ratio": 0.5}


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module")
def plate():
    return trimesh.creation.box([0.02, 0.16, 0.22])


@pytest.fixture(scope="module")
def found(plate, hand):
    return improved_candidates(plate, hand, watch=Stopwatch(), **SETTINGS)


def test_directions_are_unit_and_at_right_angles(found):
    for vectors in (found.approach, found.closing_axis):
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0, atol=1e-9)
    across = np.einsum("ij,ij->i", found.approach, found.closing_axis)
    np.testing.assert_allclose(across, 0.0, atol=1e-9)


def test_fingers_close_across_the_thin_side_of_a_plate(found):
    rim = found.kind == SphereFate.RIM
    assert rim.sum() > 20
    across = np.cross(found.approach[rim], found.closing_axis[rim])
    assert np.median(np.abs(across[:, 0])) > 0.99


def test_no_candidate_has_more_object_before_the_palm_than_the_hand_encloses(found, plate, hand):
    # an independent look: the ray from the grasp point back along the approach
    inside = found.grasp_point
    way = np.full(len(found), np.inf)
    half = plate.extents / 2.0
    for axis in range(3):
        back = -found.approach[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            exit_ = (np.sign(back) * half[axis] - inside[:, axis]) / back
        way = np.minimum(way, np.where(back == 0.0, np.inf, exit_))
    # samples are as far apart as the surface's spacing
    assert way.max() < hand.max_sphere_radius + 0.01


def test_published_candidates_reach_deeper_into_the_plate_than_guided_ones_may(plate):
    # a law of the filter, not of the plate: nothing is free behind a wall
    wall = plate.copy()
    points = np.asarray(wall.sample(2000, seed=1))
    middle = np.zeros((1, 3))
    along, across = np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]])
    assert depth_of_object(points, middle, along, width=0.02)[0] > 0.1
    assert depth_of_object(points, middle, across, width=0.02)[0] == pytest.approx(0.01)


def test_an_object_whose_every_candidate_is_blocked_still_has_some(hand):
    found = improved_candidates(
        load_object("star"), hand, watch=Stopwatch(),
        grasp="power", search_radius=0.03, min_radius_ratio=0.7,
    )  # fmt: skip
    assert len(found) > 0


def test_depth_turns_with_the_object():
    rng = np.random.default_rng(4)
    points, centers = rng.normal(size=(300, 3)), rng.normal(size=(5, 3))
    approach = np.eye(3)[[0, 1, 2, 0, 1]]
    turn = random_rotation(rng)
    first = depth_of_object(points, centers, approach, width=0.5)
    second = depth_of_object(points @ turn.T, centers @ turn.T, approach @ turn.T, width=0.5)
    assert first.max() > 0.5
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_straddling_leaves_candidates_around_axes_alone():
    axis = medial_axis(trimesh.creation.capsule(0.2, 0.02))
    published = candidates_from_axis(axis, search_radius=0.03)
    assert len(published)
    np.testing.assert_array_equal(straddle(published, axis).approach, published.approach)


def test_candidates_are_drawn_evenly_from_all(found):
    rng = np.random.default_rng(0)
    taken = np.zeros(3)
    numbered = replace(found, radius=np.arange(len(found)) * 3.0 / len(found))
    for _ in range(200):
        drawn = spread_candidates(numbered, 12, rng).radius
        assert len(np.unique(drawn)) == 12
        taken += np.bincount(drawn.astype(int), minlength=3)
    # a third of 2400 each, with a deviation of 23
    assert np.abs(taken - 800.0).max() < 100.0


def test_the_draw_does_not_depend_on_the_order_of_the_spheres(found):
    rows = np.argsort(-found.sphere, kind="stable")
    turned = replace(found.select(rows), sphere=found.sphere.max() - found.sphere[rows])
    first = spread_candidates(found, 12, np.random.default_rng(5))
    second = spread_candidates(turned, 12, np.random.default_rng(5))
    one = np.hstack([first.grasp_point, first.approach, first.closing_axis])
    two = np.hstack([second.grasp_point, second.approach, second.closing_axis])
    np.testing.assert_array_equal(one[np.lexsort(one.T)], two[np.lexsort(two.T)])


def test_all_candidates_are_taken_when_enough_are_asked_for(found):
    chosen = spread_candidates(found, len(found), np.random.default_rng(0))
    assert len(chosen) == len(found)
    almost = spread_candidates(found, len(found) - 1, np.random.default_rng(0))
    assert len(almost) == len(found) - 1
    with pytest.raises(InputError, match="at least one"):
        spread_candidates(found, 0, np.random.default_rng(0))


def test_the_plan_is_the_same_twice_and_in_two_processes(plate, hand):
    plans = [
        plan_grasps(
            plate, hand, planner="medial-plus", max_candidates=5, jobs=jobs,
            rng=np.random.default_rng(3),
        )
        for jobs in (1, 1, 2)
    ]  # fmt: skip
    assert len(plans[0]) == 5
    assert sum(plans[0].sphere_counts.values()) == len(medial_axis(plate))
    for other in plans[1:]:
        assert [g.epsilon for g in other.grasps] == [g.epsilon for g in plans[0].grasps]
        np.testing.assert_array_equal([g.q for g in other.grasps], [g.q for g in plans[0].grasps])


@pytest.fixture(scope="module")
def fork():
    """Two thin bars side by side along z, joined at one end."""
    bars = [trimesh.creation.capsule(0.16, 0.008) for _ in range(2)]
    bars[0].apply_translation([0.015, 0.0, 0.0])
    bars[1].apply_translation([-0.015, 0.0, 0.0])
    bridge = trimesh.creation.box([0.03, 0.016, 0.016])
    bridge.apply_translation([0.0, 0.0, 0.08])
    return medial_axis(trimesh.boolean.union([*bars, bridge], engine="manifold"))


def test_no_candidate_is_a_detail_or_has_its_fingers_in_the_object(fork, hand):
    published = candidates_from_axis(fork, search_radius=0.02)
    room = hand.max_sphere_radius
    met = conditions_met(published, fork, fork.touch_points[:, 0], room=room)
    kept = published.select(np.flatnonzero(met))
    assert 0.2 < met.mean() < 0.9
    assert (local_thickness(fork, kept.grasp_point) <= DETAIL * kept.radius).all()
    assert not blocked(fork, finger_places(kept, room)).any()


def test_no_palm_comes_from_between_two_bars(fork, hand):
    published = candidates_from_axis(fork, search_radius=0.02)
    bars = np.abs(published.grasp_point[:, 2]) < 0.05
    # a way that slants by more than 15 degrees passes the other bar
    across = published.approach[:, 0] * np.sign(published.grasp_point[:, 0])
    surface = fork.touch_points[:, 0]
    met = conditions_met(published, fork, surface, room=hand.max_sphere_radius)
    assert (bars & (across > 0.97)).sum() > 50
    assert not met[bars & (across > 0.97)].any()
    assert met[bars & (across < -0.97)].mean() > 0.9


def test_a_wider_hand_finds_room_at_some_of_the_places_of_a_narrow_one(fork, hand):
    published = candidates_from_axis(fork, search_radius=0.02)
    room = hand.max_sphere_radius
    narrow, wide = (
        conditions_met(published, fork, fork.touch_points[:, 0], room=room, width=width)
        for width in (0.0, 0.4)
    )
    assert not (wide & ~narrow).any()
    assert 0 < wide.sum() < narrow.sum()


def test_many_candidates_are_thinned_by_whole_spheres(hand):
    bar = trimesh.creation.capsule(0.2, 0.02)
    found = improved_candidates(bar, hand, watch=Stopwatch(), **SETTINGS)
    assert 0.5 * MOST < len(found) <= MOST
    assert np.ptp(found.grasp_point[:, 2]) > 0.18
    assert np.unique(np.bincount(found.sphere)).tolist() == [0, 16]


def test_details_of_parts_much_too_thick_for_the_hand_have_no_candidates(hand):
    # a bottle of 80 cm: what is left of its sheets lies in a body that no hand encloses
    big = load_object("bottle")
    big.apply_scale(0.8 / big.extents.max())
    found = improved_candidates(
        big, hand, watch=Stopwatch(), grasp="power", search_radius=0.06, min_radius_ratio=0.0
    )
    axis = medial_axis(big)
    assert axis.radii.max() > 2.0 * hand.max_sphere_radius
    assert (local_thickness(axis, found.grasp_point) <= DETAIL * hand.max_sphere_radius).all()
