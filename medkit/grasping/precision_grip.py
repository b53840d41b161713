"""How a hand brings its pads together in parallel: initial opposition, preshape, grasp centre.

After P13 4.7.1. The hand's own geometry decides everything; no hand is known by name.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats, rotation_about, unit
from medkit.grasping.closing.hand_tables import ClosingHand
from medkit.grasping.closing.pad_kernels import GripPath
from medkit.robots.hand import Finger, Hand

#: Opening of the preshape over the diameter of the sphere (P13 5.1.6: k = 2 in 4.30).
OPENING_FACTOR = 2.0
#: Configurations in the table of openings.
TABLE = 241
#: Allowance on speeds taken from finite differences.
MARGIN = 1.1


@dataclass(frozen=True)
class PrecisionGrip:
    """How a hand closes its pads in parallel: one configuration for every opening.

    Attributes
    ----------
    grip_axis, approach, closing_axis : ndarray, shape (3,)
        Unit vectors in the hand base frame: from the thumb's pad to the fingers', the way the
        hand moves towards the object, and along what is grasped.
    amounts : ndarray, shape (m,)
        How far the pads have come along their paths, from the widest opening on [rad or m].
    openings : ndarray, shape (m,)
        Opening between the pads there [m], falling.
    thumb_pads : ndarray, shape (m, 3)
        The thumb's contact point there, hand base frame [m].
    offsets : ndarray, shape (m,)
        How much deeper along the approach the fingers' pads are than the thumb's [m].
    start, rate, end : ndarrays, shape (f, 2), (f, 2), (f,)
        Coordinates of the proximal and distal joint of each finger at amount 0, their change,
        and the amount at which the finger can go no further; the thumb is first.
    q : ndarray, shape (nq,)
        All coordinates at amount 0: the initial opposition.
    """

    grip_axis: Floats
    approach: Floats
    closing_axis: Floats
    amounts: Floats
    openings: Floats
    thumb_pads: Floats
    offsets: Floats
    start: Floats
    rate: Floats
    end: Floats
    q: Floats

    @property
    def widest(self) -> float:
        """Widest opening between the pads [m]."""
        return float(self.openings[0])

    def amount_for(self, opening: Floats) -> Floats:
        """Amounts (n,) at which the pads are `opening` (n,) [m] apart, clipped to the range."""
        return np.interp(opening, self.openings[::-1], self.amounts[::-1])

    def configuration(self, hand: Hand, amounts: Floats) -> Floats:
        """Joint coordinates (n, nq) with every finger at `amounts` (n,)."""
        q = np.repeat(self.q[None], len(amounts), axis=0)
        for row, finger in enumerate(opposing_fingers(hand)):
            reached = np.minimum(amounts, self.end[row])
            for column, joint in enumerate(_grip_joints(finger)):
                value = self.start[row, column] + self.rate[row, column] * reached
                q[:, joint] = np.clip(value, *hand.limits[joint])
        return q


def opposing_fingers(hand: Hand) -> list[Finger]:
    """Return the thumb and the fingers that oppose it, the thumb first."""
    opposition = hand.opposition
    return [hand.fingers[row] for row in (opposition.thumb, *opposition.fingers)]


def precision_grip(hand: Hand, *, idle: str = "precision") -> PrecisionGrip:
    """Find a hand's initial opposition and the path of its parallel pads (P13 4.7.1).

    In the initial opposition the pads' normals are parallel and lie in the plane of the contact
    points: the thumb's pad faces the middle of the fingers' pads. From there on the two flexion
    joints of each finger move by opposite angles, so the pads stay parallel; a joint at its limit
    stays there while the other goes on. A finger with a single joint just moves that.

    Parameters
    ----------
    hand : Hand
        Any hand with a thumb and at least one opposing finger.
    idle : str
        Preshape of the fingers that take no part: ``"precision"``, or ``"power"`` to leave them
        open (P13 5.1.6 leaves them open for the baseline).

    Returns
    -------
    PrecisionGrip
        Configurations by opening.

    Raises
    ------
    InputError
        If the pads cannot be brought to face each other.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> grip = precision_grip(load_hand("wsg50"))
    >>> round(grip.widest, 3), grip.grip_axis.round(6).tolist()
    (0.11, [1.0, 0.0, 0.0])
    """
    side = unit(hand.closing_axis)
    palm = unit(hand.palm_direction - (hand.palm_direction @ side) * side)
    tilts = np.deg2rad(np.linspace(-80.0, 80.0, 65))
    offsets = np.array([_opposition(hand, palm, side, tilt, idle)[1] for tilt in tilts])
    tilt = _root(tilts, offsets)
    q, _, axis, approach = _opposition(hand, palm, side, tilt, idle)
    start, rate, end = _paths(hand, q)
    grip = PrecisionGrip(
        axis, approach, side, np.zeros(0), np.zeros(0), np.zeros((0, 3)), np.zeros(0),
        start, rate, end, q,
    )  # fmt: skip
    return _tabulated(hand, grip)


def grip_path(hand: Hand, grip: PrecisionGrip, prepared: ClosingHand) -> GripPath:
    """Arrays of a grip for the closing kernels; `prepared` is the hand as they take it."""
    fingers = opposing_fingers(hand)
    steps = [[_step(prepared, joint) for joint in _grip_joints(finger)] for finger in fingers]
    depth = grip.thumb_pads @ grip.approach
    return GripPath(
        np.array([row[0] for row in steps], dtype=np.int64),
        np.array([row[1] if len(row) > 1 else -1 for row in steps], dtype=np.int64),
        grip.start.copy(),
        grip.rate.copy(),
        grip.end.copy(),
        np.array([finger.tip_link for finger in fingers], dtype=np.int64),
        np.array([finger.tip_point for finger in fingers]),
        np.array([_speeds(hand, grip, row) for row in range(len(fingers))]),
        MARGIN * float(np.max(np.abs(np.diff(depth) / np.diff(grip.amounts)))),
    )


def _speeds(hand: Hand, grip: PrecisionGrip, row: int) -> Floats:
    """Most that a point of each body travels per amount of one finger along its path [m]."""
    amounts = np.linspace(0.0, grip.end[row], 60)
    still = np.zeros_like(amounts)
    q = grip.configuration(hand, still)
    for joint in _grip_joints(opposing_fingers(hand)[row]):
        q[:, joint] = grip.configuration(hand, amounts)[:, joint]
    poses = hand.link_poses(q)
    speeds = np.zeros(len(hand.bodies))
    for b, body in enumerate(hand.bodies):
        turns, places = poses[:, body.link, :3, :3], poses[:, body.link, :3, 3]
        points = np.einsum("nij,vj->nvi", turns, body.vertices) + places[:, None]
        way = np.linalg.norm(np.diff(points, axis=0), axis=2).max()
        speeds[b] = MARGIN * float(way) / amounts[1]
    speeds[speeds < 1e-9] = 0.0
    return speeds


def _step(prepared: ClosingHand, joint: int) -> int:
    return int(np.flatnonzero(prepared.joint == joint)[0])


def _grip_joints(finger: Finger) -> list[int]:
    """Flexion joints that bring the pad forwards in parallel: the first and the last."""
    joints = [int(joint) for joint in finger.joints]
    return joints if len(joints) == 1 else [joints[0], joints[-1]]


def _opposition(
    hand: Hand, palm: Floats, side: Floats, tilt: float, idle: str
) -> tuple[Floats, float, Floats, Floats]:
    """Coordinates with pads along a tilted grip axis; the depth by which they miss each other."""
    q = np.array(hand.preshapes["precision"])
    used = {int(joint) for finger in opposing_fingers(hand) for joint in finger.joints}
    for finger in hand.fingers:
        for joint in finger.joints:
            if int(joint) not in used:
                q[joint] = hand.preshapes[idle][joint]
    turn = rotation_about(side, tilt)
    axis, approach = turn @ np.cross(palm, side), turn @ palm
    fingers = opposing_fingers(hand)
    points = [hand.pads(q)[finger.name][0] for finger in fingers]
    if (np.mean(points[1:], axis=0) - points[0]) @ axis < 0.0:
        axis = -axis
    for row, finger in enumerate(fingers):
        _turn_pad(hand, finger, q, side, axis if row == 0 else -axis)
    pads = hand.pads(q)
    thumb = pads[fingers[0].name][0]
    middle = np.mean([pads[finger.name][0] for finger in fingers[1:]], axis=0)
    return q, float((middle - thumb) @ approach), axis, approach


def _turn_pad(hand: Hand, finger: Finger, q: Floats, side: Floats, wanted: Floats) -> None:
    """Turn the last flexion joint, and at its limit the first, until the pad faces `wanted`."""
    for joint in reversed(_grip_joints(finger)):
        for _ in range(4):
            normal = hand.pads(q)[finger.name][1]
            probe = q.copy()
            probe[joint] += 1e-6
            rate = (hand.pads(probe)[finger.name][1] - normal) @ np.cross(side, normal) / 1e-6
            if abs(rate) < 1e-3:  # the joint does not turn the pad: it slides
                break
            angle = np.arctan2(np.cross(normal, wanted) @ side, normal @ wanted)
            q[joint] = np.clip(q[joint] + angle / rate, *hand.limits[joint])


def _root(at: Floats, values: Floats) -> float:
    """Where a sampled function is zero, nearest to the middle; its least size without a root."""
    cross = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    if len(cross) == 0:
        flat = np.flatnonzero(np.abs(values) <= np.abs(values).min() + 1e-9)
        return float(at[flat[np.argmin(np.abs(at[flat]))]])
    k = cross[np.argmin(np.abs(at[cross]))]
    return float(at[k] - values[k] * (at[k + 1] - at[k]) / (values[k + 1] - values[k]))


def _paths(hand: Hand, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Start, change and end of each finger's two joints from the initial opposition on."""
    start, rate, end = [], [], []
    for finger in opposing_fingers(hand):
        joints = _grip_joints(finger)
        signs = [finger.closing[0], -finger.closing[-1]][: len(joints)]
        room = [
            (hand.limits[joint, 1] - q[joint] if sign > 0 else q[joint] - hand.limits[joint, 0])
            for joint, sign in zip(joints, signs, strict=True)
        ]
        start.append([q[joint] for joint in joints] + [0.0] * (2 - len(joints)))
        rate.append([*signs] + [0.0] * (2 - len(joints)))
        # The first joint may go on when the last is stretched; at most a right angle further.
        end.append(min(room[0], np.pi / 2.0) if len(joints) > 1 else room[0])
    return np.array(start, dtype=float), np.array(rate, dtype=float), np.array(end, dtype=float)


def _tabulated(hand: Hand, grip: PrecisionGrip) -> PrecisionGrip:
    """Openings and thumb positions along the paths, up to where the pads meet."""
    amounts = np.linspace(0.0, grip.end.max(), TABLE)
    fingers = opposing_fingers(hand)
    pads = hand.pads(grip.configuration(hand, amounts))
    thumb = pads[fingers[0].name][0]
    gap = np.mean([pads[finger.name][0] for finger in fingers[1:]], axis=0) - thumb
    openings = gap @ grip.grip_axis
    falling = np.concatenate([[True], np.diff(openings) < -1e-9]) & (openings > 0.0)
    count = int(np.argmin(falling)) if not falling.all() else len(falling)
    if count < 2:
        raise InputError(
            f"Expected pads of {hand.name} that face each other and come closer as the fingers"
            " close, but they do not; check tip normals, closing signs and opposition."
        )
    return PrecisionGrip(
        grip.grip_axis, grip.approach, grip.closing_axis, amounts[:count], openings[:count],
        thumb[:count], (gap @ grip.approach)[:count], grip.start, grip.rate,
        np.minimum(grip.end, amounts[count - 1]), grip.q,
    )  # fmt: skip
