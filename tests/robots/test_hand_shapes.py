"""Convex bodies: as large as they say, closed, and light enough."""

import itertools

import igl
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.robots import load_hand
from medkit.robots.shapes import (
    MOST_VERTICES,
    convex_body,
    cylinder_points,
    rounded_box,
    sphere_points,
)

sizes = st.tuples(*[st.floats(0.005, 0.2)] * 3).map(np.array)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(half=sizes, share=st.tuples(*[st.floats(0.0, 1.5)] * 3).map(np.array))
def test_a_rounded_box_just_reaches_its_corners_bounds(half, share):
    vertices, faces = convex_body(rounded_box(-half, half, share * half))
    np.testing.assert_allclose(vertices.min(axis=0), -half, atol=1e-8)
    np.testing.assert_allclose(vertices.max(axis=0), half, atol=1e-8)
    mesh = trimesh.Trimesh(vertices, faces)
    assert mesh.is_watertight
    assert 0.0 < mesh.volume <= 8.0 * np.prod(half) * (1 + 1e-6)


def test_more_rounding_leaves_less_volume():
    volumes = [
        trimesh.Trimesh(*convex_body(rounded_box([-1, -1, -1], [1, 1, 1], r))).volume
        for r in (0.0, 0.2, 0.5, 1.0)
    ]
    assert volumes[0] == pytest.approx(8.0)
    assert all(a > b for a, b in itertools.pairwise(volumes))


def test_spheres_and_cylinders_have_their_radius():
    points = sphere_points([1, 2, 3], 0.5)
    np.testing.assert_allclose(np.linalg.norm(points - [1, 2, 3], axis=1), 0.5, atol=1e-8)
    points = cylinder_points(0.3, 2.0)
    np.testing.assert_allclose(np.linalg.norm(points[:, :2], axis=1), 0.3)
    assert set(points[:, 2]) == {-1.0, 1.0}


def test_a_fine_body_becomes_light_and_stays_almost_as_large():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.02)
    vertices, faces = convex_body(ball.vertices)
    assert len(vertices) <= MOST_VERTICES
    light = trimesh.Trimesh(vertices, faces)
    assert light.is_watertight
    np.testing.assert_allclose(light.extents, ball.extents, rtol=2e-3)
    squared = igl.point_mesh_squared_distance(ball.vertices, vertices, faces)[0]
    assert np.sqrt(squared.max()) < 0.02 / 40


def test_flat_bodies_are_refused():
    with pytest.raises(InputError, match="some thickness"):
        convex_body(np.eye(3))


def test_armar3_bodies_fill_the_published_bounds():
    hand = load_hand("armar3")
    bounds = {
        "Hand Palm 1 R": [(-52.8, -23.8, -12.5), (20.6, 68.5, 33.5)],
        "Hand Palm 2 R": [(-4.3, -11.9, -2.9), (2.3, 78.0, 42.6)],
        "Thumb R J1": [(-58.8, -10.0, -12.8), (2.6, 10.0, 4.3)],
        "Index R J0": [(-3.8, -5.0, -2.4), (2.3, 5.0, 42.3)],
        "Ring R J1": [(-4.3, -10.0, -2.6), (12.7, 10.0, 51.3)],
        "Pinky R J1": [(-4.3, -10.0, -5.5), (13.5, 10.0, 43.8)],
    }
    shown = {hand.link_names[b.link]: b.vertices for b in hand.bodies}
    assert len(shown) == len(hand.bodies) == 12
    for name, (low, high) in bounds.items():
        np.testing.assert_allclose(1000 * shown[name].min(axis=0), low, atol=1e-5)
        np.testing.assert_allclose(1000 * shown[name].max(axis=0), high, atol=1e-5)
