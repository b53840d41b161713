"""The search of the guided planner: what it tries, in which order, and that it never loses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from medkit.datasets.objects import load_object
from medkit.geometry import random_rotation
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.choosing import spread_candidates
from medkit.grasping.improved import improved_candidates
from medkit.grasping.local_search import SHIFT, SearchingTester
from medkit.grasping.precision import precision_tester
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.testers import Quality, Try, power_tester
from medkit.meshes import mass_properties
from medkit.robots import load_hand


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module")
def plate():
    return trimesh.creation.box([0.02, 0.16, 0.22])


@pytest.fixture(scope="module")
def found(plate, hand) -> CandidateGrasps:
    return improved_candidates(
        plate, hand, watch=Stopwatch(), grasp="power", search_radius=0.03, min_radius_ratio=0.5
    )


class Scripted:
    """Stands for a tester: holds at the tries that the script names, and counts them."""

    def __init__(self, tester, holds):
        self.closer, self.holds, self.tries = tester.closer, holds, []
        self.like = tester.test(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 0.01)[0]

    def test(self, point, approach, closing_axis, radius):
        self.tries.append((point, approach, closing_axis))
        held = float(len(self.tries) in self.holds)
        return replace(self.like, approach=approach, grasp_point=point, epsilon=held), 0.5


def scripted_search(hand, mesh, holds):
    body = mass_properties(mesh)
    quality = Quality(0.5, body.center_mass, body.torque_scale)
    search = SearchingTester.around(
        precision_tester(hand, np.asarray(mesh.triangles), quality), hand
    )
    search.tester = search.other = Scripted(search.tester, holds)
    return search


ROW = (np.array([0.01, 0.02, 0.03]), np.array([0.0, 1.0, 0]), np.array([0, 0, 1.0]), 0.01)


@pytest.mark.parametrize(
    ("holds", "tries"), [({1}, 4), ({3}, 4), ({5}, 5), ({9, 10}, 9), (set(), 13)]
)
def test_beside_a_candidate_is_only_looked_until_one_holds(hand, plate, holds, tries):
    search = scripted_search(hand, plate, holds)
    best, spent = search.test(*ROW)
    assert len(search.tester.tries) == search.closings == tries
    assert spent == 0.5 * tries
    assert best.epsilon == float(bool(holds))
    np.testing.assert_array_equal(best.grasp_point, ROW[0])
    if holds:
        np.testing.assert_array_equal(best.approach, search.tester.tries[min(holds) - 1][1])


def test_what_is_tried_beside_a_candidate_is_a_hand_pose_near_it(hand, plate):
    search = scripted_search(hand, plate, set())
    begin = Try(None, *ROW[:3])
    ways = list(search._beside(begin))
    for _, point, ahead, along in ways:
        np.testing.assert_allclose(
            [ahead @ ahead, along @ along, ahead @ along], [1, 1, 0], atol=1e-12
        )
        assert np.degrees(np.arccos(ahead @ ROW[1])) < 30.001
        assert np.linalg.norm(point - ROW[0]) <= SHIFT * hand.max_sphere_radius + 1e-12
    # each way and back: together they stand about the candidate
    np.testing.assert_allclose(np.mean([way.point for way in ways], axis=0), ROW[0], atol=1e-12)
    turned = np.mean([way.approach for way in ways], axis=0)
    np.testing.assert_allclose(np.cross(turned, ROW[1]), 0.0, atol=1e-12)


def test_what_is_tried_turns_with_the_candidate(hand, plate):
    search = scripted_search(hand, plate, set())
    turn = random_rotation(np.random.default_rng(2))
    for one, other in zip(
        search._beside(Try(None, *ROW[:3])),
        search._beside(Try(None, *(turn @ v for v in ROW[:3]))),
        strict=True,
    ):
        for a, b in zip(one[1:], other[1:], strict=True):
            np.testing.assert_allclose(turn @ a, b, atol=1e-12)


def test_a_leg_between_legs_is_held_more_often_with_a_look_beside(hand):
    dog = load_object("dog")
    body = mass_properties(dog)
    quality = Quality(0.5, body.center_mass, body.torque_scale)
    found = improved_candidates(
        dog, hand, watch=Stopwatch(), grasp="power", search_radius=0.03, min_radius_ratio=0.7
    )
    tester = power_tester(hand, np.asarray(dog.triangles), quality)
    search = SearchingTester.around(tester, hand)
    chosen = spread_candidates(found, 20, np.random.default_rng(0))
    rows = list(
        zip(chosen.grasp_point, chosen.approach, chosen.closing_axis, chosen.radius, strict=True)
    )
    plain = sum(tester.test(*row)[0].epsilon > 0.0 for row in rows)
    searched = sum(search.test(*row)[0].epsilon > 0.0 for row in rows)
    assert searched >= plain + 4


def test_the_search_is_never_worse_than_the_candidate_itself(found, plate, hand):
    body = mass_properties(plate)
    tester = power_tester(hand, plate.triangles, Quality(0.5, body.center_mass, body.torque_scale))
    search = SearchingTester.around(tester, hand)
    chosen = spread_candidates(found, 5, np.random.default_rng(0))
    columns = (chosen.grasp_point, chosen.approach, chosen.closing_axis, chosen.radius)
    for row in zip(*columns, strict=True):
        plain, searched = tester.test(*row)[0], search.test(*row)[0]
        assert searched.epsilon >= plain.epsilon
        np.testing.assert_array_equal(searched.grasp_point, row[0])


def test_the_search_stands_back_from_the_object_and_not_from_the_grasp_point(plate, hand):
    # in the middle of a thick body the hand is drawn back far: every step has to start from there
    body = mass_properties(plate)
    tester = power_tester(hand, plate.triangles, Quality(0.5, body.center_mass, body.torque_scale))
    search = SearchingTester.around(tester, hand)
    row = (np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), 0.01)
    first = tester.test(*row)[0]
    heights = [first.pose[2, 3]]
    for step in search._steps(first):
        heights.append(tester.test(row[0] + step * row[1], *row[1:])[0].pose[2, 3])
    np.testing.assert_allclose(-np.diff(heights), hand.max_sphere_radius / 3.0, atol=1e-9)


def test_the_search_of_precision_grasps_is_never_worse_and_opens_wider(hand):
    rod = trimesh.creation.capsule(0.12, 0.012)
    body = mass_properties(rod)
    quality = Quality(0.5, body.center_mass, body.torque_scale)
    tester = precision_tester(hand, np.asarray(rod.triangles), quality)
    search = SearchingTester.around(tester, hand)
    assert search.other.closer.opening_factor > tester.closer.opening_factor
    held = 0
    for height in (-0.04, 0.0, 0.04):
        row = (np.array([0.0, 0.0, height]), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 0.012)
        plain, searched = tester.test(*row)[0], search.test(*row)[0]
        assert searched.epsilon >= plain.epsilon
        held += searched.epsilon > 0.0
    assert held > 0


def test_a_finger_that_another_bars_may_close_first(hand):
    # around a bar the thumb bars index and middle finger: in the other order they close
    bar = trimesh.creation.capsule(0.16, 0.012)
    body = mass_properties(bar)
    quality = Quality(0.5, body.center_mass, body.torque_scale)
    search = SearchingTester.around(power_tester(hand, np.asarray(bar.triangles), quality), hand)
    row = (np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 0.012)
    first = search.tester.test(*row)[0]
    other = search.other.test(*row)[0]
    touching = [len({name.split()[0] for name in grasp.links}) for grasp in (first, other)]
    assert touching[1] > touching[0]
    begin = Try(search.tester, *row[:3])
    assert search.other in [way.tester for way in search._ways(begin, first)]


def test_what_a_search_settles_on_gives_its_grasp_in_one_closing(found, plate, hand):
    body = mass_properties(plate)
    quality = Quality(0.5, body.center_mass, body.torque_scale)
    search = SearchingTester.around(power_tester(hand, plate.triangles, quality), hand)
    for row in spread_candidates(found, 6, np.random.default_rng(4)).rows():
        best, settled = search.test(*row)[0], search.settled(*row)
        again = settled.tester.test(*settled[1:], row[3])[0]
        assert again.epsilon == best.epsilon
        np.testing.assert_array_equal(again.pose, best.pose)
        np.testing.assert_array_equal(again.q, best.q)
