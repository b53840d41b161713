"""Laws that the forward kinematics of every hand obeys."""

import numpy as np
import pinocchio as pin
import pytest

from medkit.errors import InputError
from medkit.geometry import rotation_about, transform
from medkit.robots import hand_names, load_hand
from medkit.robots.kernels import REVOLUTE, forward_kinematics_kernel
from medkit.robots.pinocchio_model import pinocchio_configuration, pinocchio_model


@pytest.fixture(params=hand_names())
def hand(request):
    return load_hand(request.param)


def spread(hand, count=5):
    low, high = hand.limits.T
    return low + np.random.default_rng(3).random((count, len(low))) * (high - low)


def plain_link_poses(tree, q):
    """The numpy twin of the compiled kernel."""
    poses = []
    for k, parent in enumerate(tree.parent):
        value = tree.multiplier[k] * q[tree.coordinate[k]] + tree.offset[k]
        motion = np.eye(4)
        if tree.coordinate[k] >= 0 and tree.kind[k] == REVOLUTE:
            motion = transform(rotation_about(tree.axis[k], value), np.zeros(3))
        elif tree.coordinate[k] >= 0:
            motion = transform(np.eye(3), value * tree.axis[k])
        start = np.eye(4) if parent < 0 else poses[parent]
        poses.append(start @ tree.placement[k] @ motion)
    return np.array(poses)


def test_the_compiled_kinematics_equal_the_plain_ones(hand):
    for q in spread(hand):
        np.testing.assert_allclose(hand.link_poses(q), plain_link_poses(hand.tree, q), atol=1e-13)
        poses = np.empty((len(hand.link_names), 4, 4))
        forward_kinematics_kernel(*hand.tree.arrays, q, poses)
        np.testing.assert_array_equal(poses, hand.link_poses(q))


def test_pinocchio_puts_every_link_at_the_same_place(hand):
    model = pinocchio_model(hand)
    data = model.createData()
    for q in spread(hand, 3):
        pin.framesForwardKinematics(model, data, pinocchio_configuration(hand, q))
        for name, pose in zip(hand.link_names, hand.link_poses(q), strict=True):
            placed = data.oMf[model.getFrameId(name)].homogeneous
            np.testing.assert_allclose(placed, pose, atol=1e-12)


def test_a_batch_is_its_rows(hand):
    batch = spread(hand)
    poses = hand.link_poses(batch)
    tips, pads = hand.fingertips(batch), hand.pads(batch)
    for k, q in enumerate(batch):
        np.testing.assert_array_equal(poses[k], hand.link_poses(q))
        for name, tip in hand.fingertips(q).items():
            np.testing.assert_allclose(tips[name][k], tip, atol=1e-15)
            np.testing.assert_allclose(pads[name][1][k], hand.pads(q)[name][1], atol=1e-15)


def test_a_joint_moves_the_links_it_names_and_no_others(hand):
    q = hand.preshapes["power"]
    for finger in hand.fingers:
        for joint, links in zip(finger.joints, finger.moved_links, strict=True):
            shifted = q.copy()
            shifted[joint] += 0.01
            changed = np.abs(hand.link_poses(shifted) - hand.link_poses(q)).max(axis=(1, 2)) > 1e-9
            assert set(np.flatnonzero(changed)) == set(links)
        assert finger.tip_link in finger.moved_links[-1]


def test_pads_lie_on_their_bodies_and_face_outwards(hand):
    for finger in hand.fingers:
        bodies = [body for body in hand.bodies if body.link == finger.tip_link]
        reach = max(
            ((body.vertices - finger.tip_point) @ finger.tip_normal).max() for body in bodies
        )
        assert abs(reach) < 1.5e-3


def test_links_that_have_a_body_have_a_watertight_mesh(hand):
    meshes = hand.link_meshes(hand.preshapes["power"])
    assert set(meshes) == {hand.link_names[body.link] for body in hand.bodies}
    assert all(mesh.is_watertight and mesh.volume > 0 for mesh in meshes.values())


def test_preshapes_keep_the_limits(hand):
    for q in hand.preshapes.values():
        assert np.all(q >= hand.limits[:, 0] - 1e-9)
        assert np.all(q <= hand.limits[:, 1] + 1e-9)


def test_closing_turns_the_pads_towards_each_other(hand):
    q = hand.preshapes["power"].copy()
    before = pad_spread(hand, q)
    for finger in hand.fingers:
        room = hand.limits[finger.joints, 1] - q[finger.joints]
        q[finger.joints] += finger.closing * 0.25 * np.minimum(room, 2.0)
    assert pad_spread(hand, q) < before


def pad_spread(hand, q):
    pads = hand.pads(q)
    names = [finger.name for finger in hand.fingers]
    thumb = pads[names[hand.opposition.thumb]][0]
    others = [pads[names[k]][0] for k in hand.opposition.fingers]
    return np.linalg.norm(thumb - np.mean(others, axis=0))


def test_coordinates_by_name_come_back(hand):
    q = spread(hand, 1)[0]
    np.testing.assert_array_equal(hand.coordinates(hand.joint_values(q)), q)
    with pytest.raises(InputError, match="Expected a joint of"):
        hand.coordinates({"no such joint": 0.0})


@pytest.mark.parametrize("q", [np.zeros(3), np.zeros((2, 2, 11)), np.full(11, np.nan)])
def test_wrong_configurations_are_refused(q):
    with pytest.raises(InputError, match="Expected"):
        load_hand("armar3").link_poses(q)


def test_coupled_joints_of_the_schunk_hand_turn_alike():
    hand = load_hand("schunk")
    q = hand.preshapes["power"].copy()
    bend = 0.6
    q[hand.joint_names.index("J8")] = bend
    poses = hand.link_poses(q)
    for child, parent in (("index middle", "index proximal"), ("index distal", "index middle")):
        a, b = hand.link_names.index(parent), hand.link_names.index(child)
        turn = poses[a, :3, :3].T @ poses[b, :3, :3]
        np.testing.assert_allclose(turn, rotation_about([0, 1, 0], bend), atol=1e-12)
    assert len(hand.joint_names) == 13


def test_the_thumb_of_the_schunk_hand_starts_in_front_of_the_palm():
    hand = load_hand("schunk")
    place = hand.link_poses(hand.preshapes["power"])[hand.link_names.index("thumb base")]
    np.testing.assert_allclose(1000 * place[:3, 3], [84.0, 33.1, 97.0], atol=0.05)
    aside = hand.coordinates({"J10": 0.0})
    place = hand.link_poses(aside)[hand.link_names.index("thumb base")]
    np.testing.assert_allclose(1000 * place[:3, 3], [-9.0, 114.1, 97.0], atol=0.05)
