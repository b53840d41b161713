"""Laws of a whole plan: it moves with the object, it adds up, and repeats itself."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from medkit.geometry import transform
from medkit.grasping import plan_grasps
from medkit.grasping.planners import radii_for
from medkit.robots import load_hand


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module")
def mallet():
    head = trimesh.creation.box([0.05, 0.09, 0.04])
    head.apply_translation([0.0, 0.01, 0.09])
    return trimesh.boolean.union([trimesh.creation.cylinder(0.015, 0.15, sections=24), head])


def plan(mesh, hand, **options):
    return plan_grasps(
        mesh, hand, max_candidates=16, rng=np.random.default_rng(5), min_radius_ratio=0.3, **options
    )


@pytest.fixture(scope="module")
def found(mallet, hand):
    return plan(mallet, hand)


def test_the_plan_moves_with_the_object_when_its_axes_change_places(mallet, hand, found):
    # any other turn changes the bounding box, and with it the spacing of the surface samples
    pose = transform(np.eye(3)[[1, 2, 0]], [0.2, -0.1, 0.3])
    moved = mallet.copy()
    moved.apply_transform(pose)
    other = plan(moved, hand)
    assert other.sphere_counts == found.sphere_counts
    assert other.candidates_found == found.candidates_found
    # an axis has two signs, so the two candidates of a direction may change places
    first = sorted(grasp.outcome for grasp in found.grasps)
    second = sorted(grasp.outcome for grasp in other.grasps)
    assert first == second
    np.testing.assert_allclose(
        sorted(g.epsilon for g in other.grasps), sorted(g.epsilon for g in found.grasps), atol=2e-3
    )


def test_outcomes_add_up(found):
    assert sum(found.outcomes.values()) == len(found) == 16


def test_the_same_seed_gives_the_same_plan(mallet, hand, found):
    again = plan(mallet, hand)
    np.testing.assert_array_equal([g.pose for g in again.grasps], [g.pose for g in found.grasps])
    assert [g.epsilon for g in again.grasps] == [g.epsilon for g in found.grasps]


def test_pads_hold_thinner_things_than_a_fist(hand):
    assert radii_for(hand, "power") == hand.sphere_radii
    assert radii_for(hand, "precision") == (0.0, hand.max_sphere_radius)
