"""Collision queries against known solids, and of the hand with itself."""

import numpy as np
import pytest
import trimesh

from medkit.geometry import random_rotation, transform
from medkit.robots import load_hand
from medkit.robots.collision import MeshCollider
from medkit.robots.kernels import boxes_apart
from medkit.robots.self_collision import SelfCollision

HAND = load_hand("wsg50")
BODY = next(k for k, b in enumerate(HAND.bodies) if HAND.link_names[b.link] == "left finger")
REACH = HAND.bodies[BODY].vertices.max(axis=0)
DEPTH = HAND.bodies[BODY].vertices.min(axis=0)


def box_collider(divisions=0):
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    for _ in range(divisions):
        box = box.subdivide()
    return MeshCollider(box.vertices, box.faces, HAND)


def at(x):
    """Pose that puts the body's largest x at `x`, near the middle of the box's face."""
    middle = 0.5 * (REACH + DEPTH)
    return transform(np.eye(3), [x - REACH[0], -middle[1], -middle[2]])


@pytest.mark.parametrize("divisions", [0, 3])
def test_the_gap_to_a_box_is_exact_and_free_of_the_triangulation(divisions):
    collider = box_collider(divisions)
    for gap in (0.1, 0.02, 0.001):
        near = collider.distance(BODY, at(-0.1 - gap))
        assert near.distance == pytest.approx(gap, abs=1e-9)
        assert near.point_on_object[0] == pytest.approx(-0.1, abs=1e-9)
        assert near.point_on_body[0] == pytest.approx(-0.1 - gap, abs=1e-9)
        assert not collider.collides(BODY, at(-0.1 - gap))


@pytest.mark.parametrize("divisions", [0, 3])
def test_depth_into_a_box_is_signed_and_exact(divisions):
    collider = box_collider(divisions)
    for depth in (0.001, 0.005, 0.008):
        near = collider.distance(BODY, at(-0.1 + depth))
        assert near.distance == pytest.approx(-depth, abs=1e-9)
        gap = np.linalg.norm(near.point_on_object - near.point_on_body)
        assert gap == pytest.approx(depth, abs=1e-9)


def test_a_body_wholly_inside_collides():
    collider = box_collider()
    assert collider.collides(BODY, at(0.0))
    assert collider.distance(BODY, at(0.0)).distance < -0.04


def test_an_object_wholly_inside_a_body_collides():
    housing = next(k for k, b in enumerate(HAND.bodies) if HAND.link_names[b.link] == "housing")
    ball = trimesh.creation.icosphere(radius=0.005)
    collider = MeshCollider(ball.vertices, ball.faces, HAND)
    pose = transform(np.eye(3), [0.0, 0.0, -0.035])
    assert collider.collides(housing, pose)
    assert collider.distance(housing, pose).distance < -0.02


def test_rigid_motions_of_both_change_nothing():
    rng = np.random.default_rng(5)
    box = trimesh.creation.box((0.2, 0.1, 0.05))
    pose = at(-0.11)
    before = MeshCollider(box.vertices, box.faces, HAND).distance(BODY, pose)
    motion = transform(random_rotation(rng), rng.normal(size=3))
    moved = box.copy().apply_transform(motion)
    after = MeshCollider(moved.vertices, moved.faces, HAND).distance(BODY, motion @ pose)
    assert after.distance == pytest.approx(before.distance, abs=1e-9)


def test_the_hand_collides_when_one_of_its_bodies_does():
    collider = box_collider()
    q = HAND.preshapes["power"]
    clear = transform(np.eye(3), [0.0, 0.0, -0.1 - 0.158])
    assert not collider.hand_collides(q, clear)
    touching = transform(np.eye(3), [0.0, 0.0, -0.1 - 0.157])
    assert collider.hand_collides(q, touching)
    assert not collider.hand_collides(q, touching, bodies=[0])


def test_boxes_that_are_apart_share_no_point():
    rng = np.random.default_rng(0)
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    seen = set()
    for _ in range(80):
        halves = rng.uniform(0.1, 0.5, (2, 3))
        poses = [transform(random_rotation(rng), rng.uniform(-0.8, 0.8, 3)) for _ in range(2)]
        apart = boxes_apart(poses[0], poses[1], halves[0], halves[1])
        hulls = [
            trimesh.Trimesh(*box_mesh(corners * half, pose))
            for half, pose in zip(halves, poses, strict=True)
        ]
        manager = trimesh.boolean.intersection(hulls, engine="manifold")
        assert apart == (len(manager.faces) == 0)
        seen.add(apart)
    assert seen == {True, False}


def box_mesh(points, pose):
    hull = trimesh.Trimesh(points @ pose[:3, :3].T + pose[:3, 3]).convex_hull
    return hull.vertices, hull.faces


@pytest.mark.parametrize("name", ["armar3", "armar3_left", "schunk", "wsg50"])
def test_hands_are_free_of_self_collision_at_their_preshapes(name):
    hand = load_hand(name)
    for q in hand.preshapes.values():
        touching = SelfCollision(hand).touching(q)
        assert touching.size == 0, [
            [hand.link_names[hand.bodies[k].link] for k in pair] for pair in touching
        ]


def test_a_fist_touches_itself():
    hand = load_hand("armar3")
    check = SelfCollision(hand)
    q = np.full(11, 2.5)
    q[0] = 0.0
    assert check.collides(q)
    assert len(check.touching(q)) > 0


def test_boxes_first_finds_the_same_pairs_as_asking_for_every_hull():
    hand = load_hand("schunk")
    check = SelfCollision(hand)
    rng = np.random.default_rng(1)
    low, high = hand.limits.T
    found = 0
    for q in low + rng.random((30, len(low))) * (high - low):
        links = hand.link_poses(q)
        every = [tuple(p) for k, p in enumerate(check.pairs) if check._touch(links, k)]
        assert [tuple(p) for p in check.touching(q)] == every
        assert check.collides(q) == bool(every)
        found += len(every)
    assert found > 0
