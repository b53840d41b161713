"""Where a finger's pad comes while its last joint keeps it facing along a grip axis (P13 4.7.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from medkit.geometry import Floats, rotation_about, unit
from medkit.robots.hand import Finger, Hand

#: Samples of a finger's way.
SAMPLES = 33


@dataclass(frozen=True)
class PadWays:
    """Ways of one finger's pad, sampled: `t` tilts, `n` places of its first joint.

    Attributes
    ----------
    travel : ndarray, shape (n,)
        How far the first joint has come from its preshape [rad or m].
    along, deep : ndarray, shape (t, n)
        Place of the pad along the grip axis and along the approach [m].
    askew : ndarray, shape (t, n)
        Squared sine of the angle between the pad's normal and the grip axis, 1 for a pad that
        looks away [1].
    joints : ndarray, shape (t, n, 2)
        Coordinates of first and last joint, the last one as if it had no limits [rad or m].
    q : ndarray, shape (nq,)
        All coordinates, with the middle joints bent.
    """

    travel: Floats
    along: Floats
    deep: Floats
    askew: Floats
    joints: Floats
    q: Floats


def opposing_fingers(hand: Hand) -> list[Finger]:
    """Return the thumb and the fingers that oppose it, the thumb first."""
    opposition = hand.opposition
    return [hand.fingers[row] for row in (opposition.thumb, *opposition.fingers)]


def grip_joints(finger: Finger) -> list[int]:
    """Flexion joints that bring the pad forwards in parallel: the first and the last."""
    joints = [int(joint) for joint in finger.joints]
    return joints if len(joints) == 1 else [joints[0], joints[-1]]


def grip_directions(hand: Hand, q: Floats, tilts: Floats) -> tuple[Floats, Floats]:
    """Grip axes and approaches, each (t, 3), for `tilts` (t,) [rad]; the pads at `q` give the sign.

    The grip axis runs from the thumb's pad to the fingers', the approach is the palm's direction
    across it, both turned about the hand's closing axis; hand base frame.
    """
    side = unit(hand.closing_axis)
    palm = unit(hand.palm_direction - (hand.palm_direction @ side) * side)
    across = np.cross(palm, side)
    thumb, *others = (hand.pads(q)[finger.name][0] for finger in opposing_fingers(hand))
    turns = [rotation_about(side, float(tilt)) for tilt in tilts]
    axes = np.array([turn @ across for turn in turns])
    gaps = axes @ (np.mean(others, axis=0) - thumb)
    return np.where(gaps < 0.0, -1.0, 1.0)[:, None] * axes, np.array(
        [turn @ palm for turn in turns]
    )


def pad_ways(
    hand: Hand, q: Floats, row: int, axes: Floats, approaches: Floats, bend: float
) -> PadWays:
    """Follow the pad of opposing finger `row` while its last joint keeps it along the grip axis.

    Parameters
    ----------
    hand : Hand
        The hand.
    q : ndarray, shape (nq,)
        The preshape [rad or m].
    row : int
        0 for the thumb.
    axes, approaches : ndarray, shape (t, 3)
        From `grip_directions`.
    bend : float
        See `PadSetting`.

    Returns
    -------
    PadWays
        Up to the limit of the first joint; of two joints at most by a right angle.
    """
    finger = opposing_fingers(hand)[row]
    first, *last = grip_joints(finger)
    q = q.copy()
    for joint, sign in list(zip(finger.joints, finger.closing, strict=True))[1:-1]:
        q[joint] += bend * sign * min(_room(hand, q, int(joint), sign), np.pi / 2.0)
    room = _room(hand, q, first, finger.closing[0])
    travel = np.linspace(0.0, min(room, np.pi / 2.0) if last else room, SAMPLES)
    shape = (len(axes), SAMPLES)
    many = np.tile(q, (*shape, 1))
    many[..., first] += finger.closing[0] * travel
    wanted = (axes if row == 0 else -axes)[:, None]
    free = np.full(shape, q[last[0]] if last else 0.0)
    if last:
        free = _turned(hand, finger, many, last[0], wanted)
        many[..., last[0]] = np.clip(free, *hand.limits[last[0]])
    points, normals = _pads(hand, finger, many)
    facing = np.einsum("tnk,tmk->tn", normals, wanted)
    return PadWays(
        travel,
        np.einsum("tnk,tk->tn", points, axes),
        np.einsum("tnk,tk->tn", points, approaches),
        np.where(facing > 0.0, 1.0 - np.minimum(facing, 1.0) ** 2, 1.0),
        np.stack([many[..., first], free], axis=-1),
        q,
    )


def _room(hand: Hand, q: Floats, joint: int, sign: float) -> float:
    """How far a joint can close from `q` on [rad or m]."""
    lower, upper = hand.limits[joint]
    return float(upper - q[joint] if sign > 0 else q[joint] - lower)


def _pads(hand: Hand, finger: Finger, q: Floats) -> tuple[Floats, Floats]:
    """Points [m] and normals (..., 3) of a finger's pad at `q` (..., nq)."""
    point, normal = hand.pads(q.reshape(-1, q.shape[-1]))[finger.name]
    return point.reshape(*q.shape[:-1], 3), normal.reshape(*q.shape[:-1], 3)


def _turned(hand: Hand, finger: Finger, q: Floats, joint: int, wanted: Floats) -> Floats:
    """Values (t, n) of a joint, limits aside, at which the pad's normal is as `wanted` (t, 1, 3).

    As near as the joint can turn it; a joint that does not turn the pad keeps its value.
    """
    side = unit(hand.closing_axis)
    q = q.copy()
    probe = q[:1, :1].copy()
    _, before = _pads(hand, finger, probe)
    probe[..., joint] += 1e-6
    change = (_pads(hand, finger, probe)[1] - before)[0, 0]
    rate = float(change @ np.cross(side, before[0, 0])) / 1e-6
    if abs(rate) < 1e-3:
        return q[..., joint]
    for _ in range(3):
        _, normals = _pads(hand, finger, q)
        sine = np.cross(normals, wanted) @ side
        angle = np.arctan2(sine, np.einsum("tnk,tmk->tn", normals, wanted))
        q[..., joint] += angle / rate
    return np.asarray(np.unwrap(q[..., joint] * rate, axis=1) / rate)
