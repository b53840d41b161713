"""Each hand, put at its grasp point and closed, holds a ball between thumb and fingers."""

import numpy as np
import pytest
import trimesh

from medkit.geometry import transform
from medkit.robots import load_hand
from medkit.robots.collision import MeshCollider

STEP = 0.02  # [rad] or, times 0.05, [m]


def closed_around(hand, radius):
    ball = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    collider = MeshCollider(ball.vertices, ball.faces, hand)
    q = hand.preshapes["power"].copy()
    pose = transform(np.eye(3), -hand.T_hand_power[:3, 3])
    while collider.hand_collides(q, pose):
        pose[:3, 3] -= 0.001 * hand.palm_direction
    assert np.linalg.norm(pose[:3, 3] + hand.T_hand_power[:3, 3]) < 0.06
    for finger in hand.fingers:
        for joint, sign, bodies in zip(
            finger.joints, finger.closing, finger.moved_bodies, strict=True
        ):
            low, high = hand.limits[joint]
            step = sign * (STEP if high - low > 0.2 else 0.05 * STEP)
            while low <= q[joint] + step <= high:
                q[joint] += step
                if collider.hand_collides(q, pose, bodies):
                    q[joint] -= step
                    break
    return collider, q, pose


@pytest.mark.parametrize("share", [0.4, 0.7, 1.0])
@pytest.mark.parametrize("name", ["armar3", "armar3_left", "schunk", "wsg50"])
def test_thumb_and_opposing_fingers_touch_a_ball_from_both_sides(name, share):
    hand = load_hand(name)
    radius = share * hand.max_sphere_radius
    collider, q, pose = closed_around(hand, radius)
    poses = pose @ hand.link_poses(q)
    sides = {}
    for k, finger in enumerate(hand.fingers):
        near = [
            collider.distance(int(b), poses[hand.bodies[b].link]) for b in finger.moved_bodies[0]
        ]
        best = min(near, key=lambda proximity: proximity.distance)
        if 0.0 <= best.distance < 0.004:
            sides[k] = best.point_on_object / radius
    thumb = hand.opposition.thumb
    assert thumb in sides
    touching = [sides[k] for k in hand.opposition.fingers if k in sides]
    assert touching
    assert min(float(sides[thumb] @ side) for side in touching) < -0.3
