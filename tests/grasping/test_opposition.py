"""Laws of opposed pads, for hands whose thumb is no mirror image of their fingers."""

import numpy as np
import pytest
import trimesh
import yaml

from medkit.grasping.closing.object_field import object_field
from medkit.grasping.opposition import (
    FRICTION,
    OPENING_FACTOR,
    PadSetting,
    best_setting,
    use_shares,
)
from medkit.grasping.pad_ways import grip_directions, grip_joints, opposing_fingers, pad_ways
from medkit.grasping.precision import PrecisionCloser, PrecisionTester
from medkit.grasping.precision_grip import precision_grip
from medkit.grasping.testers import Quality
from medkit.meshes import mass_properties
from medkit.robots import load_hand

Z, X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def capsule(name, parent, xyz, end, joint=None, radius=8.0):
    link = {"name": name, "xyz": xyz, "body": [{"spheres": [[0, 0, 0, radius], [*end, radius]]}]}
    if parent:
        link["parent"] = parent
    if joint:
        link["joint"] = joint
    return link


def uneven_hand(folder, lengths=(54.0, 38.0, 27.0), thumb=(51.0, 30.0), base=(45.0, 0.0, 15.0)):
    """Two fingers of three joints along z, and a shorter thumb of two joints along x [mm]."""
    fixed_tip = {"tip_point": [8, 0, 0], "tip_normal": [1, 0, 0], "end_point": [0, 0, 8]}
    block = {"box": [[-20, -35, 0], [12, 35, 78]], "round": [6, 6, 6]}
    links, fingers = [{"name": "block", "body": [block]}], []
    for finger, y in (("index", 22.0), ("middle", -22.0)):
        parent, place = "block", [0.0, y, 95.0]
        for k, length in enumerate(lengths):
            name = f"{finger} {k}"
            joint = {"name": name, "axis": [0, 1, 0], "limits": [-10, 95]}
            links.append(capsule(name, parent, place, [0, 0, length - 2.0], joint))
            parent, place = name, [0.0, 0.0, length]
        # As many URDFs have it: a round tip of its own, fixed to the last phalanx.
        links.append(capsule(f"{finger} tip", parent, place, [0, 0, 0.1]))
        joints = [f"{finger} {k}" for k in range(len(lengths))]
        fingers.append({"name": finger, "joints": joints, "tip_link": f"{finger} tip", **fixed_tip})
    parent, place = "block", list(base)
    for k, length in enumerate(thumb):
        joint = {"name": f"thumb {k}", "axis": [0, -1, 0], "limits": [-10, 95]}
        links.append(capsule(f"thumb {k}", parent, place, [length - 2.0, 0, 0], joint))
        parent, place = f"thumb {k}", [length, 0.0, 0.0]
    links.append(capsule("thumb tip", parent, place, [0.1, 0, 0]))
    pad = {"tip_point": [0, 0, 8], "tip_normal": [0, 0, 1], "end_point": [8, 0, 0]}
    joints = [f"thumb {k}" for k in range(len(thumb))]
    fingers.insert(0, {"name": "thumb", "joints": joints, "tip_link": "thumb tip", **pad})
    document = {
        "schema": "medkit.hand/1", "name": "uneven", "source": "made up for the tests",
        "units": {"length": "mm", "angle": "deg"}, "base": "palm", "links": links,
        "palm_direction": [1, 0, 0], "closing_axis": [0, -1, 0],
        "power_frame": {"xyz": [40, 0, 50]}, "sphere_radius": {"min": 4, "max": 40},
        "fingers": fingers, "opposition": {"thumb": "thumb", "fingers": ["index", "middle"]},
    }  # fmt: skip
    path = folder / "uneven.yaml"
    path.write_text(yaml.safe_dump(document))
    return load_hand(path)


@pytest.fixture(scope="module")
def uneven(tmp_path_factory):
    return uneven_hand(tmp_path_factory.mktemp("hand"))


def share(hand, setting):
    """Share of use of one setting."""
    q = np.array(hand.preshapes["precision"])
    axes, approaches = grip_directions(hand, q, np.array([setting.tilt]))
    ways = [
        pad_ways(hand, q, row, axes, approaches, setting.bends[min(row, 1)])
        for row in range(len(opposing_fingers(hand)))
    ]
    late, ratio = np.array([setting.late]), np.array([setting.ratio])
    return float(use_shares(ways[0], ways[1:], late, ratio, hand.max_sphere_radius)[0, 0])


@pytest.mark.parametrize("name", ["armar3", "armar3_left", "wsg50"])
def test_a_thumb_that_mirrors_its_fingers_moves_as_published(name):
    hand = load_hand(name)
    setting = best_setting(hand, np.array(hand.preshapes["precision"]))
    assert setting == PadSetting(setting.tilt)


@pytest.mark.parametrize("scale", [0.7, 1.0, 1.3])
@pytest.mark.parametrize("thumb", [(51.0, 30.0), (35.0, 45.0), (60.0, 40.0)])
def test_pads_of_uneven_fingers_face_each_other_wherever_balls_are_held(tmp_path, thumb, scale):
    lengths = tuple(scale * length for length in (54.0, 38.0, 27.0))
    hand = uneven_hand(tmp_path, lengths, thumb)
    grip = precision_grip(hand)
    held = np.linspace(0.1, 1.0, 10) * 2.0 * hand.max_sphere_radius
    assert grip.openings[-1] <= held[0]
    assert grip.widest >= held[-1]
    misses = np.interp(held, grip.openings[::-1], grip.offsets[::-1])
    assert np.all(np.abs(misses) < FRICTION * held)


def test_the_chosen_setting_is_never_worse_than_the_published_one(uneven):
    hand = uneven
    best = best_setting(hand, np.array(hand.preshapes["precision"]))
    tilts = np.deg2rad(np.linspace(-80.0, 80.0, 33))
    assert all(share(hand, best) >= share(hand, PadSetting(tilt)) for tilt in tilts)


def test_shares_are_one_for_pads_that_always_face_each_other():
    """The gripper's fingers slide along the grip axis: what it misses is what it cannot reach."""
    hand = load_hand("wsg50")
    largest, widest = hand.max_sphere_radius, precision_grip(hand).widest
    r = np.linspace(0.0, largest, 2001)
    passed = np.clip(widest, 2.0 * r, 2.0 * OPENING_FACTOR * r) - np.maximum(2.0 * r, 0.0054)
    whole = (OPENING_FACTOR - 1.0) * largest**2
    expected = np.trapezoid(np.maximum(passed, 0.0), r) / whole
    assert share(hand, PadSetting(0.0)) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("name", ["armar3", "schunk", "wsg50"])
def test_pads_are_parallel_wherever_their_last_joints_are_free(name):
    """Also where the last joint takes another one along, as in the Schunk hand."""
    hand = load_hand(name)
    grip = precision_grip(hand)
    free_somewhere = False
    for amount in np.linspace(0.0, grip.amounts[-1], 15):
        pads = hand.pads(grip.configuration(hand, np.array([amount]))[0])
        for row, finger in enumerate(opposing_fingers(hand)):
            joints = grip_joints(finger)
            wanted = grip.start[row] + grip.rate[row] * min(amount, grip.end[row])
            lower, upper = hand.limits[joints[-1]]
            if len(joints) > 1 and not lower <= wanted[1] <= upper:
                continue
            free_somewhere = True
            facing = pads[finger.name][1] @ grip.grip_axis
            assert facing == pytest.approx(1.0 if row == 0 else -1.0, abs=1e-6)
    assert free_somewhere


@pytest.mark.parametrize("radius", [0.02, 0.025, 0.03])
def test_balls_are_held_by_pads_of_tips_that_are_fixed_to_their_phalanx(uneven, radius):
    ball = trimesh.creation.icosphere(3, radius)
    body = mass_properties(ball)
    closer = PrecisionCloser(uneven, object_field(ball.triangles))
    tester = PrecisionTester(closer, Quality(0.5, body.center_mass, body.torque_scale))
    grasp, _ = tester.test(np.zeros(3), -Z, X, radius)
    assert grasp.outcome == "force_closure"


@pytest.mark.parametrize("shift", [-0.012, 0.0, 0.012])
def test_a_ball_that_is_nearer_to_one_side_is_still_touched_by_all(shift):
    """The side that is farther away has more than half of the way to go."""
    closer = PrecisionCloser(
        load_hand("armar3"), object_field(trimesh.creation.icosphere(3, 0.01).triangles)
    )
    grasp = closer.close(np.array([0.0, shift, 0.0]), -Z, X, 0.015)
    assert grasp.started
    assert grasp.touched.all()


def test_the_grasp_centre_is_midway_between_the_pads_at_the_touch(uneven):
    closer = PrecisionCloser(uneven, object_field(trimesh.creation.icosphere(2, 0.02).triangles))
    grip, radius = closer.grip, 0.02
    amount, center = closer.preshape(radius)
    touch = grip.amount_for(np.array([2.0 * radius]))
    pads = uneven.pads(grip.configuration(uneven, touch)[0])
    thumb, *others = (pads[finger.name][0] for finger in opposing_fingers(uneven))
    start = uneven.pads(grip.configuration(uneven, np.array([amount]))[0])["thumb"][0]
    middle = 0.5 * (np.mean(others, axis=0) + thumb)
    assert (center - start) @ grip.approach == pytest.approx(
        (middle - thumb) @ grip.approach, abs=1e-4
    )
