"""Each hand, put with its palm on a ball and closed, holds it: thumb, fingers and palm together."""

import numpy as np
import pytest
import trimesh

from medkit.geometry import transform, unit
from medkit.quality import is_force_closure
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
    # it comes free about where the ball lies in the corner of thumb and fingers
    assert np.linalg.norm(pose[:3, 3] + hand.T_hand_power[:3, 3]) < 1.6 * radius
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
def test_thumb_and_opposing_fingers_hold_a_ball(name, share):
    hand = load_hand(name)
    radius = share * hand.max_sphere_radius
    collider, q, pose = closed_around(hand, radius)
    poses = pose @ hand.link_poses(q)
    near = [collider.distance(k, poses[body.link]) for k, body in enumerate(hand.bodies)]
    touching = [k for k, proximity in enumerate(near) if 0.0 <= proximity.distance < 0.004]
    thumb, fingers = hand.opposition.thumb, hand.opposition.fingers
    reached = [k for k, f in enumerate(hand.fingers) if set(f.moved_bodies[0]) & set(touching)]
    assert thumb in reached
    assert set(fingers) & set(reached)
    points = np.array([near[k].point_on_object for k in touching])
    assert is_force_closure(points, -unit(points), friction=0.5)
