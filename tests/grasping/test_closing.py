"""Closing: known angles, monotony, independence of the triangulation and of the frame."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq

from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.grasping import PowerCloser, object_field
from medkit.grasping.closing.face_tree import FAN, face_tree, smallest_balls
from medkit.grasping.closing.finger_kernels import TOUCH
from medkit.grasping.closing.object_field import split_long_edges
from medkit.robots import load_hand

APPROACH, ALONG = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


def closed(hand, mesh, **options):
    closer = PowerCloser(hand, object_field(mesh.triangles, **options))
    return closer.close(np.zeros(3), APPROACH, ALONG)


def test_lattice_never_overstates_the_distance():
    mesh = trimesh.creation.torus(0.04, 0.01)
    field = object_field(mesh.triangles, spacing=0.006)
    nodes = np.stack(np.unravel_index(np.arange(field.distances.size), field.distances.shape), 1)
    nodes = nodes[::97]
    at = field.origin + nodes * field.spacing
    squared = igl.point_mesh_squared_distance(
        at, np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    )[0]
    assert (field.distances[tuple(nodes.T)] <= np.sqrt(squared) + 1e-7).all()


def test_inside_flags_agree_with_a_ball():
    field = object_field(trimesh.creation.icosphere(4, 0.05).triangles, spacing=0.004)
    nodes = field.origin + np.argwhere(field.inside) * field.spacing
    assert len(nodes) > 500
    assert np.linalg.norm(nodes, axis=1).max() < 0.05


def test_splitting_keeps_the_area():
    triangles = trimesh.creation.box([1.0, 2.0, 3.0]).triangles
    pieces, source = split_long_edges(np.array(triangles), 0.3)
    area = 0.5 * np.linalg.norm(
        np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]), axis=1
    )
    assert area.sum() == pytest.approx(22.0)
    assert (np.diff(source) >= 0).all()


def test_a_thinner_bar_lets_the_thumb_close_further(hand):
    joint = hand.joint_names.index(hand.joint_names[int(hand.fingers[0].joints[0])])
    angles = [
        closed(hand, trimesh.creation.cylinder(r, 0.3, sections=96)).q[joint]
        for r in (0.035, 0.028, 0.021)
    ]
    assert angles == sorted(angles)


def test_the_result_does_not_depend_on_the_triangulation(hand):
    coarse = trimesh.creation.box([0.05, 0.06, 0.2])
    fine = coarse.subdivide().subdivide().subdivide()
    first, second = closed(hand, coarse), closed(hand, fine)
    assert first.retreat == pytest.approx(second.retreat, abs=1e-5)
    np.testing.assert_allclose(first.q, second.q, atol=2e-3)


def test_the_spacing_of_the_lattice_changes_nothing(hand):
    mesh = trimesh.creation.cylinder(0.03, 0.2, sections=64)
    first, second = closed(hand, mesh, spacing=0.003), closed(hand, mesh, spacing=0.007)
    np.testing.assert_allclose(first.q, second.q, atol=2e-3)


def test_a_finger_stops_at_a_plane_where_geometry_says(hand):
    """Whatever stopped by touch has its links within a hair of the surface."""
    mesh = trimesh.creation.box([0.06, 0.06, 0.3])
    grasp = closed(hand, mesh)
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    gaps = []
    for link in hand.link_meshes(grasp.q).values():
        link.apply_transform(grasp.pose)
        kind = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
        points = np.vstack([link.vertices, trimesh.sample.sample_surface(link, 2000, seed=0)[0]])
        gaps.append(igl.signed_distance(points, vertices, faces, kind)[0].min())
    assert min(gaps) > -1e-5
    assert sum(gap < 2e-4 for gap in gaps) >= 3


def test_parallel_jaws_stop_at_half_the_width_of_a_box():
    """The WSG-50's jaws are flat and slide: the joint values follow from the width alone."""
    hand = load_hand("wsg50")
    for width in (0.02, 0.05, 0.08):
        closer = PowerCloser(hand, object_field(trimesh.creation.box([width, 0.1, 0.1]).triangles))
        pose = closer.start_pose(np.zeros(3), np.array([0, 0, -1.0]), np.array([0, 1.0, 0]))
        grasp = closer.close_from(pose, np.array([0, 0, -1.0]))
        assert (grasp.stops == TOUCH).all()
        for finger in hand.fingers:
            point, inwards = hand.pads(grasp.q)[finger.name]
            point = grasp.pose[:3, :3] @ point + grasp.pose[:3, 3]
            inwards = grasp.pose[:3, :3] @ inwards
            assert inwards @ point == pytest.approx(-0.5 * width, abs=2e-5)


def test_a_finger_stops_where_its_lowest_corner_reaches_a_plane(hand):
    """A flat wall before the fingers: the angle is the root of the corners' height over it."""
    grasp, pose, level = _closed_on_a_wall(hand)
    for k, finger in enumerate(hand.fingers[1:], start=1):
        joint, bodies = int(finger.joints[0]), finger.moved_bodies[0]

        def lowest(angle, joint=joint, bodies=bodies):
            q = np.array(hand.preshapes["power"])
            q[joint] = angle
            links = pose @ hand.link_poses(q)
            corners = [
                hand.bodies[b].vertices @ links[hand.bodies[b].link][:3, :3].T
                + links[hand.bodies[b].link][:3, 3]
                for b in bodies
            ]
            return level - np.vstack(corners)[:, 0].max()

        angles = np.linspace(0.0, np.pi, 400)
        heights = np.array([lowest(angle) for angle in angles])
        assert heights[0] > 0.0
        first = int(np.argmax(heights < 0.0))
        wanted = brentq(lowest, angles[first - 1], angles[first])
        assert grasp.stops[2 * k] == TOUCH
        assert grasp.q[joint] == pytest.approx(wanted, abs=3e-4)


def _closed_on_a_wall(hand, level=0.03):
    """The hand, palm away from a wall at x = level, closes its fingers against it."""
    wall = trimesh.creation.box([0.1, 1.0, 1.0])
    wall.apply_translation([level + 0.05, 0.0, 0.0])
    closer = PowerCloser(hand, object_field(wall.triangles))
    pose = closer.start_pose(np.zeros(3), APPROACH, ALONG)
    return closer.close_from(pose, APPROACH), closer.close_from(pose, APPROACH).pose, level


@pytest.mark.parametrize("seed", range(3))
def test_moving_hand_and_object_together_changes_nothing(hand, seed):
    rng = np.random.default_rng(seed)
    R, shift = random_rotation(rng), rng.uniform(-0.5, 0.5, 3)
    mesh = trimesh.creation.capsule(0.12, 0.025, count=[24, 24])
    moved = mesh.copy()
    moved.vertices = mesh.vertices @ R.T + shift
    one = PowerCloser(hand, object_field(mesh.triangles)).close(np.zeros(3), APPROACH, ALONG)
    two = PowerCloser(hand, object_field(moved.triangles)).close(shift, R @ APPROACH, R @ ALONG)
    np.testing.assert_allclose(two.pose[:3, :3], R @ one.pose[:3, :3], atol=1e-9)
    np.testing.assert_allclose(two.pose[:3, 3], R @ one.pose[:3, 3] + shift, atol=1e-5)
    np.testing.assert_allclose(two.q, one.q, atol=1e-3)
    assert (one.stops == two.stops).all()


@pytest.mark.parametrize("size", [0.008, 0.02, 0.05])
@pytest.mark.parametrize("shift", [0.0, 100.0])
def test_the_tree_holds_every_piece_once_and_its_balls_hold_what_is_below(size, shift):
    """Also far from the origin, where single precision is coarse: radii make up for it."""
    mesh = trimesh.creation.torus(0.05, 0.02, major_sections=24, minor_sections=12)
    pieces, faces = split_long_edges(np.array(mesh.triangles) + shift, size)
    tree = face_tree(pieces, faces)
    assert sorted(tree.faces) == sorted(faces)
    held: dict[int, np.ndarray] = {}
    seen = 0
    for node in range(len(tree.blocks) - 1, -1, -1):
        balls = tree.blocks[node].reshape(4, FAN).T.astype(float)
        if node >= tree.first_leaf:
            leaf = node - tree.first_leaf
            parts = list(tree.pieces[tree.starts[leaf] : tree.starts[leaf + 1]])
        else:
            first = max(FAN * node + tree.fan + 1 - FAN, 1)
            parts = [held[first + k] for k in range(FAN if node else tree.fan)]
            seen += len(parts)
        for points, ball in zip(parts, balls, strict=False):
            assert np.linalg.norm(points - ball[:3], axis=1).max() <= ball[3] + 1e-12 * (1 + shift)
        assert (balls[len(parts) :, 3] < 0.0).all()
        held[node] = np.concatenate(parts)
    assert seen == len(tree.blocks) - 1


def test_the_smallest_ball_of_a_triangle_holds_it_and_no_smaller_one_does():
    triangles = np.random.default_rng(3).normal(size=(200, 3, 3))
    balls = smallest_balls(triangles)
    way = np.linalg.norm(triangles - balls[:, None, :3], axis=2)
    assert (way <= balls[:, None, 3] + 1e-12).all()
    # Two corners across the middle, or three around it: the ball cannot shrink.
    on = np.isclose(way, balls[:, None, 3], rtol=1e-9).sum(axis=1)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    assert ((on == 3) | np.isclose(longest, 2.0 * balls[:, 3])).all()


def test_an_empty_or_broken_object_is_refused():
    with pytest.raises(InputError, match="triangles"):
        object_field(np.zeros((0, 3, 3)))
    with pytest.raises(InputError, match="finite"):
        object_field(np.full((1, 3, 3), np.nan))
