"""Laws of precision grasps: parallel pads, a thumb that keeps its place, honest contacts."""

import igl
import numpy as np
import pytest
import trimesh

from medkit.geometry import random_rotation, rotation_about
from medkit.grasping.closing import pad_kernels
from medkit.grasping.closing.kernel_options import entry
from medkit.grasping.closing.object_field import object_field
from medkit.grasping.closing.self_kernels import SELF_DEPTH, least_gap
from medkit.grasping.closing.sight_kernels import sight
from medkit.grasping.precision import PrecisionCloser, PrecisionTester
from medkit.grasping.precision_grip import opposing_fingers, precision_grip
from medkit.grasping.testers import Quality
from medkit.meshes import mass_properties
from medkit.robots import load_hand


@entry
def call_close_pads(field, hand, grip, follow, base, q, amounts, touched, slack, work):
    """Let Python call `close_pads`."""
    return pad_kernels.close_pads(
        field, hand, grip, follow, base, q, amounts, touched, slack, work
    )  # fmt: skip


HANDS = {name: load_hand(name) for name in ("armar3", "wsg50")}
BALL = trimesh.creation.icosphere(3, 0.02)
BAR = trimesh.creation.cylinder(0.015, 0.16, sections=48)
X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def bar_closer():
    return PrecisionCloser(HANDS["armar3"], object_field(BAR.triangles))


@pytest.mark.parametrize("name", HANDS)
def test_pads_stay_parallel_and_face_each_other_while_both_joints_can_move(name):
    hand = HANDS[name]
    grip = precision_grip(hand)
    fingers = opposing_fingers(hand)
    for amount in np.linspace(0.0, 0.5, 6) * grip.end.min():
        q = grip.configuration(hand, np.array([amount]))[0]
        normals = [hand.pads(q)[finger.name][1] for finger in fingers]
        assert normals[0] @ grip.grip_axis == pytest.approx(1.0, abs=1e-6)
        assert all(n @ grip.grip_axis == pytest.approx(-1.0, abs=1e-6) for n in normals[1:])


@pytest.mark.parametrize("name", HANDS)
def test_the_thumb_faces_the_middle_of_the_fingers_within_a_millimetre(name):
    grip = precision_grip(HANDS[name])
    assert np.abs(grip.offsets).max() < 1e-3
    assert np.all(np.diff(grip.openings) < 0.0)


@pytest.mark.parametrize("radius", [0.006, 0.012, 0.02])
def test_the_preshape_opens_to_twice_the_sphere_and_is_centred_on_it(bar_closer, radius):
    amount, center = bar_closer.preshape(radius)
    hand = bar_closer.hand
    pads = hand.pads(bar_closer.grip.configuration(hand, np.array([amount]))[0])
    thumb, *others = [pads[finger.name][0] for finger in opposing_fingers(hand)]
    opening = (np.mean(others, axis=0) - thumb) @ bar_closer.grip.grip_axis
    assert opening == pytest.approx(4.0 * radius, abs=1e-4)
    # The nearest point of the thumb's pad is half an opening away, straight before it.
    assert center - thumb == pytest.approx(0.5 * opening * bar_closer.grip.grip_axis, abs=1e-4)


@pytest.mark.parametrize("name", HANDS)
def test_a_ball_between_the_pads_is_touched_by_every_finger(name):
    closer = PrecisionCloser(HANDS[name], object_field(BALL.triangles))
    grasp = closer.close(np.zeros(3), -Z, X, 0.02)
    assert grasp.started
    assert grasp.touched.all()
    tips = {finger.tip_link for finger in opposing_fingers(closer.hand)}
    assert {closer.hand.bodies[b].link for b in grasp.contacts.bodies} <= tips


def test_the_hand_keeps_its_thumb_s_pad_at_one_depth_until_the_first_touch(bar_closer):
    grasp = bar_closer.close(np.zeros(3), X, Z, 0.015)
    hand = bar_closer.hand
    thumb = opposing_fingers(hand)[0].name

    def pad(pose, q):
        point = hand.pads(q)[thumb][0]
        return pose[:3, :3] @ point + pose[:3, 3]

    amount, _ = bar_closer.preshape(0.015)
    before = pad(grasp.start_pose, bar_closer.grip.configuration(hand, np.array([amount]))[0])
    # Only the thumb's last way, alone on the object, is not followed by the hand.
    assert abs((pad(grasp.pose, grasp.q) - before) @ X) < 0.004
    assert np.allclose(grasp.pose[:3, :3], grasp.start_pose[:3, :3])


@pytest.mark.parametrize("seed", range(4))
def test_contacts_lie_on_the_mesh_and_nothing_penetrates(bar_closer, seed):
    rng = np.random.default_rng(seed)
    turn = rotation_about(Z, rng.uniform(0.0, 2.0 * np.pi))
    grasp = bar_closer.close(rng.uniform(-0.03, 0.03) * Z, turn @ X, Z, 0.015)
    assert grasp.touched.all()
    squared, face, _ = igl.point_mesh_squared_distance(
        grasp.contacts.points, np.asarray(BAR.vertices), np.asarray(BAR.faces, dtype=np.int64)
    )
    assert np.sqrt(squared.max()) < 1e-3
    cosine = np.einsum("ij,ij->i", -BAR.face_normals[face], grasp.contacts.normals)
    assert cosine.min() > np.cos(np.deg2rad(15.0))
    links = bar_closer.hand.link_meshes(grasp.q)
    points = np.vstack([mesh.vertices for mesh in links.values()])
    points = points @ grasp.pose[:3, :3].T + grasp.pose[:3, 3]
    signed = igl.signed_distance(points, np.asarray(BAR.vertices), np.asarray(BAR.faces))[0]
    assert signed.min() > -1e-3


def test_a_hand_inside_the_object_is_a_start_collision():
    block = trimesh.creation.box((0.5, 0.5, 0.5))
    closer = PrecisionCloser(HANDS["armar3"], object_field(block.triangles))
    body = mass_properties(block)
    tester = PrecisionTester(closer, Quality(0.5, body.center_mass, body.torque_scale))
    grasp, _ = tester.test(np.zeros(3), X, Z, 0.02)
    assert grasp.outcome == "start_collision"
    assert len(grasp.points) == 0


def test_a_hand_that_overlaps_itself_does_not_start(bar_closer):
    """Far from the object, thumb in index: refused; the same with the fingers apart: not."""
    hand, arrays, path = bar_closer.hand, bar_closer.arrays, bar_closer.path
    base = np.eye(4)
    base[:3, 3] = 5.0

    def starts(q):
        return call_close_pads(
            bar_closer.field, arrays, path, X, base.copy(), q.copy(), np.array(path.end),
            np.zeros(len(path.end), dtype=np.bool_), np.zeros(len(hand.bodies)), bar_closer.work,
        )  # fmt: skip

    opposing = opposing_fingers(hand)
    thumb, index = (finger.moved_bodies[-1][0] for finger in opposing[:2])

    def gap(q):
        poses = np.ascontiguousarray(hand.link_poses(q)[None])
        return least_gap(arrays, thumb, index, poses, 0.1, sight())

    used = [int(joint) for finger in opposing[:2] for joint in finger.joints]
    rng = np.random.default_rng(0)
    tried = np.repeat(bar_closer.grip.q[None], 300, axis=0)
    tried[:, used] = rng.uniform(hand.limits[used, 0], hand.limits[used, 1], (300, len(used)))
    gaps = [gap(q) for q in tried]
    crossed = tried[int(np.argmin(gaps))]
    assert min(gaps) < -4.0 * SELF_DEPTH
    assert not starts(crossed)
    assert starts(bar_closer.grip.q)


def test_the_result_moves_with_the_object():
    rng = np.random.default_rng(5)
    R, shift = random_rotation(rng), np.array([0.3, -0.2, 0.1])
    hand = HANDS["armar3"]
    moved = BAR.copy()
    moved.vertices = BAR.vertices @ R.T + shift
    one = PrecisionCloser(hand, object_field(BAR.triangles)).close(np.zeros(3), X, Z, 0.015)
    two = PrecisionCloser(hand, object_field(moved.triangles)).close(shift, R @ X, R @ Z, 0.015)
    assert two.pose[:3, :3] == pytest.approx(R @ one.pose[:3, :3], abs=1e-9)
    assert two.q == pytest.approx(one.q, abs=2e-3)


def test_a_bar_between_the_pads_is_held():
    body = mass_properties(BAR)
    closer = PrecisionCloser(HANDS["armar3"], object_field(BAR.triangles))
    tester = PrecisionTester(closer, Quality(0.5, body.center_mass, body.torque_scale))
    grasp, _ = tester.test(np.zeros(3), X, Z, 0.015)
    assert grasp.outcome == "force_closure"
    assert grasp.epsilon > 0.0
    again, _ = PrecisionTester.from_parts(tester.parts()).test(np.zeros(3), X, Z, 0.015)
    assert again.epsilon == grasp.epsilon
