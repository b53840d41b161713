"""Compiled closing of a precision grasp: pads stay parallel, the hand follows its thumb.

`field`, `hand`, `work` and `base` are those of `finger_kernels`; `grip` is a `GripPath`. The amount
of finger f says how far its pad has come along its path.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.body_kernels import moved, to_link, touches
from medkit.grasping.closing.chain_kernels import place_links
from medkit.grasping.closing.finger_kernels import FINEST, HORIZON
from medkit.grasping.closing.inside_kernels import is_inside
from medkit.grasping.closing.kernel_options import inner
from medkit.grasping.closing.self_kernels import SELF_DEPTH, self_clearance
from medkit.grasping.closing.tree_kernels import meet

FREE, HIT, OWN = 0, 1, 2


class GripPath(NamedTuple):
    """Pads' paths of a hand: finger f at amount s has its joints at start + rate s, in limits.

    Attributes
    ----------
    proximal, distal : ndarray, shape (f,)
        Rows of the closing steps of `ClosingHand`; distal -1 for a finger with one joint.
    start, rate : ndarray, shape (f, 2)
        Coordinates of the two joints at amount 0, and their change per amount [rad or m].
    end : ndarray, shape (f,)
        Amount at which the finger can go no further.
    tip_link : ndarray, shape (f,)
        Link with the pad; the first finger is the thumb.
    tip_point : ndarray, shape (f, 3)
        Pad's contact point in that link's frame [m].
    lever : ndarray, shape (f, b)
        Most that each body of the hand travels per amount of finger f [m].
    follow : float
        Most that the hand has to follow its thumb per amount [m].
    """

    proximal: np.ndarray
    distal: np.ndarray
    start: np.ndarray
    rate: np.ndarray
    end: np.ndarray
    tip_link: np.ndarray
    tip_point: np.ndarray
    lever: np.ndarray
    follow: float


@inner
def set_finger(hand: Any, grip: Any, f: int, amount: float, q: np.ndarray) -> None:
    """Write the joint coordinates of finger `f` at an amount into `q`."""
    for row, step in enumerate((grip.proximal[f], grip.distal[f])):
        if step >= 0:
            joint = hand.joint[step]
            value = grip.start[f, row] + grip.rate[f, row] * amount
            q[joint] = min(max(value, hand.limits[joint, 0]), hand.limits[joint, 1])


@inner
def _move(
    hand: Any,
    grip: Any,
    only: int,
    amounts: np.ndarray,
    change: float,
    follow: np.ndarray,
    free_base: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    work: Any,
) -> float:
    """Bring the fingers (one, or all with the hand following) to amounts + change; the shift.

    With all fingers, the hand is shifted so that the thumb's pad keeps its place along `follow`,
    counted from `free_base`, at which `amounts` hold.
    """
    # copied by hand: assigning a slice would need reference counts
    for row in range(3):
        for column in range(4):
            base[row, column] = free_base[row, column]
    if only >= 0:
        set_finger(hand, grip, only, min(amounts[only] + change, grip.end[only]), q)
        place_links(hand, q, base, work)
        return 0.0
    before = 0.0
    set_finger(hand, grip, 0, amounts[0], q)
    place_links(hand, q, base, work)
    pad = moved(work.poses[grip.tip_link[0]], grip.tip_point, 0)
    for a in range(3):
        before += follow[a] * pad[a]
    for f in range(grip.end.shape[0]):
        set_finger(hand, grip, f, min(amounts[f] + change, grip.end[f]), q)
    place_links(hand, q, base, work)
    pad = moved(work.poses[grip.tip_link[0]], grip.tip_point, 0)
    shift = -before
    for a in range(3):
        shift += follow[a] * pad[a]
    for a in range(3):
        base[a, 3] -= shift * follow[a]
        for link in range(work.poses.shape[0]):
            work.poses[link, a, 3] -= shift * follow[a]
    return abs(shift)


@inner
def _travel(grip: Any, only: int, body: int) -> float:
    """Most that a body travels per amount of the fingers that close."""
    if only >= 0:
        return grip.lever[only, body]
    way = grip.follow  # the hand follows its thumb
    for f in range(grip.end.shape[0]):
        way += grip.lever[f, body]
    return way


@inner
def _stride(hand: Any, grip: Any, only: int, slack: np.ndarray) -> float:
    """Amount after which no body can have jumped over anything."""
    sure = 1e9
    for body in range(hand.body_link.shape[0]):
        travel = _travel(grip, only, body)
        if travel > 0.0:
            sure = min(sure, max(slack[body], hand.window[body]) / travel)
    return sure


@inner
def _own(hand: Any, grip: Any, only: int, work: Any) -> bool:
    """Whether a closing finger runs into the hand it belongs to."""
    for f in range(grip.end.shape[0]):
        if (only < 0 or f == only) and (
            self_clearance(hand, grip.proximal[f], 0.0, work) < -SELF_DEPTH
        ):
            return True
    return False


@inner
def _free_change(
    field: Any,
    hand: Any,
    grip: Any,
    only: int,
    amounts: np.ndarray,
    change: float,
    follow: np.ndarray,
    here: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    slack: np.ndarray,
    work: Any,
) -> float:
    """How much of a change of the amounts is free of the object; see `finger_kernels.free_end`."""
    finest = change * FINEST
    _move(hand, grip, only, amounts, change, follow, here, base, q, work)
    body: Any = np.int64(0)
    while body < hand.body_link.shape[0]:
        travel = _travel(grip, only, body) * change
        left = slack[body] - travel
        if travel > 0.0 and left < hand.window[body]:
            pose = work.poses[hand.body_link[body]]
            left = meet(field.tree, hand.hulls, body, pose, hand.window[body], HORIZON, work)
            if work.hit[0] >= 0 and change > 0.0:
                low, high, piece = 0.0, change, work.hit[0]
                while high - low > finest:
                    middle = 0.5 * (low + high)
                    _move(hand, grip, only, amounts, middle, follow, here, base, q, work)
                    pose = work.poses[hand.body_link[body]]
                    to_link(pose, field.tree.pieces[piece], work.clip.local)
                    if touches(hand.hulls, body, work.clip):
                        high = middle
                    else:
                        low = middle
                change = low
                _move(hand, grip, only, amounts, change, follow, here, base, q, work)
                body = np.int64(0)
                continue
        work.fresh[body] = max(left, 0.0)
        body += 1
    for body in range(hand.body_link.shape[0]):
        slack[body] = work.fresh[body]
    return change


@inner
def _change_before_own(
    hand: Any,
    grip: Any,
    only: int,
    amounts: np.ndarray,
    change: float,
    follow: np.ndarray,
    here: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    work: Any,
) -> float:
    """Halve a change of the amounts until the hand's own bodies no longer overlap."""
    low, high = 0.0, change
    while high - low > change * FINEST:
        middle = 0.5 * (low + high)
        _move(hand, grip, only, amounts, middle, follow, here, base, q, work)
        if _own(hand, grip, only, work):
            high = middle
        else:
            low = middle
    return low


@inner
def close_until_touch(
    field: Any,
    hand: Any,
    grip: Any,
    only: int,
    follow: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    amounts: np.ndarray,
    slack: np.ndarray,
    work: Any,
) -> int:
    """Close one finger, or with `only` = -1 all of them with the hand following, until a touch.

    `base`, `q`, `amounts` and `work.poses` end at the last free state that was found, within
    2^-10 of a step of the touch. Returns `HIT`, `OWN`, or `FREE` when the paths end untouched.
    """
    here = work.here
    while True:
        left = 0.0
        for f in range(grip.end.shape[0]):
            if only < 0 or f == only:
                left = max(left, grip.end[f] - amounts[f])
        if left <= 1e-9:
            return FREE
        for row in range(3):
            for column in range(4):
                here[row, column] = base[row, column]
        wanted = min(_stride(hand, grip, only, slack), left)
        change = _free_change(
            field, hand, grip, only, amounts, wanted, follow, here, base, q, slack, work
        )
        met = FREE if change == wanted else HIT
        if _own(hand, grip, only, work):
            met = OWN
            for body in range(hand.body_link.shape[0]):
                slack[body] = 0.0  # known only for the state beyond the touch
            change = _change_before_own(
                hand, grip, only, amounts, change, follow, here, base, q, work
            )
            change = _free_change(
                field, hand, grip, only, amounts, change, follow, here, base, q, slack, work
            )
        for f in range(grip.end.shape[0]):
            if only < 0 or f == only:
                amounts[f] = min(amounts[f] + change, grip.end[f])
        if met != FREE:
            return met


@inner
def close_pads(
    field: Any,
    hand: Any,
    grip: Any,
    follow: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    amounts: np.ndarray,
    touched: np.ndarray,
    slack: np.ndarray,
    work: Any,
) -> bool:
    """Precision closing from a start pose (P13 algorithms 6 and 7); False if that hits anything.

    `base`, `q`, `amounts` (f,) are changed in place; `touched` (f,) says which fingers ended at
    the object.
    """
    place_links(hand, q, base, work)
    for f in range(grip.end.shape[0]):
        touched[f] = False
    for body in range(hand.body_link.shape[0]):
        pose = work.poses[hand.body_link[body]]
        gap = meet(field.tree, hand.hulls, body, pose, hand.window[body], HORIZON, work)
        if work.hit[0] >= 0 or is_inside(field, hand, body, pose):
            return False
        slack[body] = max(gap, 0.0)
    if _own(hand, grip, np.int64(-1), work):
        return False
    for turn in range(grip.end.shape[0] + 1):
        only = turn - 1
        met = close_until_touch(field, hand, grip, only, follow, base, q, amounts, slack, work)
        if only >= 0:
            touched[only] = met == HIT
    return True
