"""How a hand brings its pads together in parallel: initial opposition, preshape, grasp centre.

After P13 4.7.1. The hand's own geometry decides everything; no hand is known by name.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, unit
from medkit.grasping.closing.hand_tables import ClosingHand
from medkit.grasping.closing.pad_kernels import GripPath
from medkit.grasping.opposition import FRICTION, PadSetting, best_setting, side_speeds
from medkit.grasping.pad_ways import grip_directions, grip_joints, opposing_fingers, pad_ways
from medkit.robots.hand import Hand

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
        Coordinates of the proximal and distal joint of each finger at amount 0 (limits aside),
        their change, and the amount at which the finger can go no further; the thumb is first.
    q : ndarray, shape (nq,)
        All coordinates at amount 0.
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

    def faces(self, openings: ArrayLike) -> NDArray[np.bool_]:
        """Whether the pads oppose each other at `openings` (n,) [m]; False outside the range.

        Opposed means that the line between the pads lies within a friction cone of 0.5 around
        the grip axis.
        """
        at = np.asarray(openings, dtype=float)
        misses = np.interp(at, self.openings[::-1], self.offsets[::-1])
        within = (at >= self.openings[-1]) & (at <= self.widest)
        return np.asarray(within & (np.abs(misses) <= FRICTION * at), dtype=np.bool_)

    def configuration(self, hand: Hand, amounts: Floats) -> Floats:
        """Joint coordinates (n, nq) with every finger at `amounts` (n,)."""
        q = np.repeat(self.q[None], len(amounts), axis=0)
        for row, finger in enumerate(opposing_fingers(hand)):
            reached = np.minimum(amounts, self.end[row])
            for column, joint in enumerate(grip_joints(finger)):
                value = self.start[row, column] + self.rate[row, column] * reached
                q[:, joint] = np.clip(value, *hand.limits[joint])
        return q


def precision_grip(hand: Hand, *, idle: str = "precision") -> PrecisionGrip:
    """Find a hand's initial opposition and the path of its parallel pads (P13 4.7.1).

    The last flexion joint of each finger turns against the first, so that the pad keeps facing
    along the grip axis; at its limit it stays while the other goes on. A finger with a single
    joint just moves that. P13 solves the opposition at the widest opening; where pads would pass
    each other further on, tilt of the axis, speeds and middle joints are chosen for all openings
    that balls need, see `medkit.grasping.opposition.best_setting`. Joints in no finger stay as
    the preshape ``"precision"`` has them.

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
    q = np.array(hand.preshapes["precision"])
    used = {int(joint) for finger in opposing_fingers(hand) for joint in finger.joints}
    for joint in {int(joint) for finger in hand.fingers for joint in finger.joints} - used:
        q[joint] = hand.preshapes[idle][joint]
    return _tabulated(hand, _paths(hand, q, best_setting(hand, q)))


def grip_path(hand: Hand, grip: PrecisionGrip, prepared: ClosingHand) -> GripPath:
    """Arrays of a grip for the closing kernels; `prepared` is the hand as they take it."""
    fingers = opposing_fingers(hand)
    steps = [[_step(prepared, joint) for joint in grip_joints(finger)] for finger in fingers]
    amounts = np.linspace(0.0, grip.end.max(), TABLE)
    thumb = hand.pads(grip.configuration(hand, amounts))[fingers[0].name][0]
    follow = np.abs(np.diff(thumb @ grip.approach)).max() / amounts[1]
    return GripPath(
        np.array([row[0] for row in steps], dtype=np.int64),
        np.array([row[1] if len(row) > 1 else -1 for row in steps], dtype=np.int64),
        grip.start.copy(),
        grip.rate.copy(),
        grip.end.copy(),
        np.array([finger.tip_link for finger in fingers], dtype=np.int64),
        np.array([finger.tip_point for finger in fingers]),
        np.array([_speeds(hand, grip, row) for row in range(len(fingers))]),
        MARGIN * float(follow),
    )


def _speeds(hand: Hand, grip: PrecisionGrip, row: int) -> Floats:
    """Most that a point of each body travels per amount of one finger along its path [m]."""
    amounts = np.linspace(0.0, grip.end[row], 60)
    still = np.zeros_like(amounts)
    q = grip.configuration(hand, still)
    for joint in grip_joints(opposing_fingers(hand)[row]):
        q[:, joint] = grip.configuration(hand, amounts)[:, joint]
    poses = hand.link_poses(q)
    speeds = np.zeros(len(hand.bodies))
    for b, body in enumerate(hand.bodies):
        turns, places = poses[:, body.link, :3, :3], poses[:, body.link, :3, 3]
        points = np.einsum("nij,vj->nvi", turns, body.vertices) + places[:, None]
        way = np.linalg.norm(np.diff(points, axis=0), axis=2).max()
        speeds[b] = MARGIN * float(way) / max(amounts[1], 1e-12)
    speeds[speeds < 1e-9] = 0.0
    return speeds


def _step(prepared: ClosingHand, joint: int) -> int:
    return int(np.flatnonzero(prepared.joint == joint)[0])


def _paths(hand: Hand, q: Floats, setting: PadSetting) -> PrecisionGrip:
    """Start, change and end of each finger's two joints, without a table of openings."""
    q = q.copy()
    axes, approaches = grip_directions(hand, q, np.array([setting.tilt]))
    fingers = opposing_fingers(hand)
    sides = [min(row, 1) for row in range(len(fingers))]
    bends = [setting.bends[side] for side in sides]
    ways = [pad_ways(hand, q, row, axes, approaches, bend) for row, bend in enumerate(bends)]
    speeds = side_speeds(np.array([setting.ratio]))[0]
    start, rate = np.zeros((len(fingers), 2)), np.zeros((len(fingers), 2))
    end = np.zeros(len(fingers))
    rooms = [ways[0].travel[-1], max(way.travel[-1] for way in ways[1:])]
    for row, (finger, side, way) in enumerate(zip(fingers, sides, ways, strict=True)):
        first, last = way.joints[0, 0], way.joints[0, -1]
        slope = (last - first) / max(way.travel[-1], 1e-12)
        late = setting.late[side] * rooms[side]
        count = len(grip_joints(finger))
        start[row, :count] = (first + late * slope)[:count]
        rate[row, :count] = (speeds[side] * slope)[:count]
        end[row] = max(way.travel[-1] - late, 0.0) / speeds[side]
        q[finger.joints] = way.q[finger.joints]
    grip = PrecisionGrip(
        axes[0], approaches[0], unit(hand.closing_axis), np.zeros(0), np.zeros(0),
        np.zeros((0, 3)), np.zeros(0), start, rate, end, q,
    )  # fmt: skip
    return replace(grip, q=grip.configuration(hand, np.zeros(1))[0])


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
    return replace(
        grip,
        amounts=amounts[:count],
        openings=openings[:count],
        thumb_pads=thumb[:count],
        offsets=(gap @ grip.approach)[:count],
    )
