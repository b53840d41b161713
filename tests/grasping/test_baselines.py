"""Laws of the baseline generators: normals at the hits, boxes that hold the object."""

import igl
import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.geometry import rotation_about
from medkit.grasping.baselines import (
    carried_axes,
    joined_candidates,
    surface_normal_candidates,
)
from medkit.grasping.box_baseline import fitted_box_candidates, fitted_boxes
from medkit.grasping.strategies import CANDIDATE_SOURCES, looked_up
from medkit.robots import load_hand

BALL = trimesh.creation.icosphere(4, 0.05)
CYLINDER = trimesh.creation.cylinder(0.03, 0.2, sections=64)
ANGLE = trimesh.util.concatenate(
    [
        trimesh.creation.box((0.2, 0.04, 0.04)),
        trimesh.creation.box((0.04, 0.04, 0.16)).apply_translation([-0.08, 0.0, 0.1]),
    ]
)


@pytest.mark.parametrize("wanted", [100, 300, 500])
def test_about_as_many_candidates_as_asked_in_groups_of_rolls(wanted):
    found = surface_normal_candidates(BALL, candidates=wanted)
    assert 0.75 * wanted <= len(found) <= 1.3 * wanted
    assert len(found) % 4 == 0


def test_the_hand_approaches_against_the_normal_at_points_on_the_surface():
    found = surface_normal_candidates(CYLINDER, candidates=200)
    squared, face, _ = igl.point_mesh_squared_distance(
        found.grasp_point, np.asarray(CYLINDER.vertices), np.asarray(CYLINDER.faces)
    )
    assert squared.max() < 1e-16
    cosine = np.einsum("ij,ij->i", found.approach, -CYLINDER.face_normals[face])
    assert np.median(cosine) == pytest.approx(1.0)
    assert cosine.min() > 0.99  # at an edge, the neighbouring facet


@pytest.mark.parametrize("make", [surface_normal_candidates, fitted_box_candidates])
def test_four_rolls_are_a_right_angle_apart_and_across_the_approach(make):
    found = make(CYLINDER)
    axes = found.closing_axis.reshape(-1, 4, 3)
    assert np.allclose(np.linalg.norm(axes, axis=2), 1.0)
    assert np.allclose(np.einsum("ij,ij->i", found.closing_axis, found.approach), 0.0, atol=1e-9)
    assert np.allclose(np.einsum("nij,nij->ni", axes, np.roll(axes, 1, axis=1)), 0.0, atol=1e-9)


def test_hits_on_a_ball_look_at_its_middle():
    found = surface_normal_candidates(BALL, candidates=200)
    assert np.linalg.norm(found.grasp_point, axis=1).max() <= 0.05 + 1e-9
    cosine = np.einsum("ij,ij->i", found.approach, -found.grasp_point) / 0.05
    assert cosine.min() > 0.99


def test_a_cylinder_is_one_box_so_its_mantle_has_only_four_directions():
    # P13 3.1: the box leaves four approach directions where a hand could come from all around.
    found = fitted_box_candidates(CYLINDER)
    mantle = np.abs(found.approach @ [0.0, 0.0, 1.0]) < 0.1
    assert len(np.unique(found.approach[mantle].round(3), axis=0)) == 4


def test_an_angle_is_split_into_its_two_arms():
    boxes = fitted_boxes(ANGLE)
    assert 2 <= len(boxes) <= 3
    volume = 0.04 * 0.04 * (0.2 + 0.16)
    assert sum(8.0 * np.prod(half) for _, half in boxes) == pytest.approx(volume, rel=0.15)


def test_boxes_turn_with_the_object():
    turned = ANGLE.copy()
    turned.apply_transform(np.block([
        [rotation_about([0, 0, 1], 0.4), np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))],
    ]))  # fmt: skip
    volumes = [sum(np.prod(half) for _, half in fitted_boxes(m)) for m in (ANGLE, turned)]
    assert volumes[1] == pytest.approx(volumes[0], rel=0.1)


@pytest.mark.parametrize("name", ["normals", "boxes"])
def test_baselines_are_known_to_the_planner_by_name(name):
    source = looked_up(CANDIDATE_SOURCES, name, "planner")
    assert len(source(CYLINDER, load_hand("wsg50"), grasp="power")) > 0


def test_joining_keeps_every_candidate_and_its_place():
    one = surface_normal_candidates(BALL, candidates=40)
    both = joined_candidates([one, one])
    assert len(both) == 2 * len(one)
    assert len(np.unique(both.sphere)) == 2 * len(np.unique(one.sphere))


def test_nothing_asked_for_is_refused():
    with pytest.raises(InputError, match="at least 1"):
        surface_normal_candidates(BALL, candidates=0)


def test_a_hand_is_turned_from_one_approach_to_the_next_by_the_shortest_way():
    rng = np.random.default_rng(0)
    ways = rng.normal(size=(30, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    axes = carried_axes(ways)
    for k in range(1, len(ways)):
        turn = np.cross(ways[k - 1], ways[k])
        angle = np.arctan2(np.linalg.norm(turn), ways[k - 1] @ ways[k])
        shortest = rotation_about(turn / np.linalg.norm(turn), angle)
        np.testing.assert_allclose(axes[k], shortest @ axes[k - 1], atol=1e-9)


def test_a_hand_does_not_turn_while_the_approach_stays_or_is_reversed():
    ways = np.array([[0.0, 0.6, 0.8]] * 4 + [[0.0, -0.6, -0.8]])
    axes = carried_axes(ways)
    np.testing.assert_allclose(axes, np.repeat(axes[:1], 5, axis=0), atol=1e-12)


def test_around_the_corner_of_a_box_the_hand_ends_up_turned_by_a_right_angle():
    # the octant of a ball has an excess of a right angle: what a hand carried around it gains
    axes = carried_axes(np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]))
    assert abs(axes[3] @ axes[0]) < 1e-12
