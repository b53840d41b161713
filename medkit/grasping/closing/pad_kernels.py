"""Compiled closing of a precision grasp: pads stay parallel, the hand follows its thumb.

`field`, `hand`, `work` and `base` are those of `finger_kernels`; `grip` is a `GripPath`. The amount
of finger f says how far its pad has come along its path.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from medkit.grasping.closing.body_kernels import (
    body_clearance,
    body_hits_object,
    deepest_inside,
    inner,
    moved,
)
from medkit.grasping.closing.finger_kernels import SELF_DEPTH, place_links, self_clearance

#: A step may carry a body at most this share of its least width, so that nothing is jumped over.
SHARE = 0.6
#: Halvings of the step in which a touch happened.
HALVINGS = 8
#: Clearance beyond this need not be known [m].
ENOUGH = 0.012
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
def _meets(field: Any, hand: Any, body: int, slack: np.ndarray, work: Any) -> bool:
    """Whether a body whose known clearance is used up hits the object; renews its clearance."""
    pose = work.poses[hand.body_link[body]]
    if slack[body] >= 0.0:
        slack[body] = body_clearance(field, hand, body, pose, ENOUGH)
        if slack[body] > 0.0:
            return False
    return body_hits_object(field, hand, body, pose, work)


@inner
def _is_inside(field: Any, hand: Any, body: int, clearance: float, work: Any) -> bool:
    """Whether a body that meets no face lies within the object."""
    pose = work.poses[hand.body_link[body]]
    if clearance <= 0.0:
        return deepest_inside(field, hand, body, pose) > 0.0
    # Well away from the surface all of the body is on one side: one sample tells.
    x, y, z = moved(pose, hand.samples, hand.sample_start[hand.group_start[body]])
    i = round((x - field.origin[0]) / field.spacing)
    j = round((y - field.origin[1]) / field.spacing)
    k = round((z - field.origin[2]) / field.spacing)
    shape = field.distances.shape
    within = 0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2]
    return within and field.inside[i, j, k]


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
    """Amount that surely hits nothing, or at least the small step that jumps over nothing."""
    sure, small = 1e9, 1e9
    for body in range(hand.body_link.shape[0]):
        travel = _travel(grip, only, body)
        if travel > 0.0:
            small = min(small, SHARE * hand.width[body] / travel)
            sure = min(sure, max(slack[body], 0.0) / travel)
    return max(sure, small)


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
def _test(
    field: Any,
    hand: Any,
    grip: Any,
    only: int,
    change: float,
    asked: int,
    slack: np.ndarray,
    work: Any,
) -> int:
    """What the moved hand meets: `FREE`, `HIT` the object, or its `OWN` bodies.

    Asked with `FREE`, every body that travelled is tried and those that hit are marked in
    `work.near`; asked with what was met before, only that is tried again.
    """
    if asked == OWN:
        return OWN if _own(hand, grip, only, work) else FREE
    state = FREE
    for body in range(hand.body_link.shape[0]):
        if asked == HIT:
            trial = work.near[body] and state == FREE
            slack[body] = -1.0
        else:
            travel = _travel(grip, only, body) * change
            slack[body] -= travel
            trial = travel > 0.0 and slack[body] <= 0.0
            slack[body] = max(slack[body], 0.0)
            work.near[body] = False
        if trial and _meets(field, hand, body, slack, work):
            state = HIT
            work.near[body] = True
    if state == FREE and asked == FREE and _own(hand, grip, only, work):
        return OWN
    return state


@njit(cache=True)
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
    2^-8 of a step of the touch. Returns `HIT`, `OWN`, or `FREE` when the paths end untouched.
    """
    here = base.copy()
    while True:
        left = 0.0
        for f in range(grip.end.shape[0]):
            if only < 0 or f == only:
                left = max(left, grip.end[f] - amounts[f])
        if left <= 1e-9:
            return FREE
        change = min(_stride(hand, grip, only, slack), left)
        low, high = 0.0, change
        here[:] = base
        met = FREE
        for halving in range(HALVINGS + 1):
            middle = change if halving == 0 else 0.5 * (low + high)
            _move(hand, grip, only, amounts, middle, follow, here, base, q, work)
            state = _test(field, hand, grip, only, middle, met, slack, work)
            if halving == 0:
                met = state
            if state == FREE:
                low = middle
            else:
                high = middle
            if met == FREE:
                break
        if met != FREE:
            _move(hand, grip, only, amounts, low, follow, here, base, q, work)
            slack[:] = 0.0  # known only for the state beyond the touch
        for f in range(grip.end.shape[0]):
            if only < 0 or f == only:
                amounts[f] = min(amounts[f] + low, grip.end[f])
        if met != FREE:
            return met


@njit(cache=True)
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
    """Precision closing from a start pose (P13 algorithms 6 and 7); False if that hits the object.

    `base`, `q`, `amounts` (f,) are changed in place; `touched` (f,) says which fingers ended at
    the object.
    """
    touched[:] = False
    slack[:] = 0.0
    place_links(hand, q, base, work)
    for body in range(hand.body_link.shape[0]):
        if _meets(field, hand, body, slack, work):
            return False
        if _is_inside(field, hand, body, slack[body], work):
            return False
        slack[body] = max(slack[body], 0.0)
    for turn in range(grip.end.shape[0] + 1):
        only = turn - 1
        met = close_until_touch(field, hand, grip, only, follow, base, q, amounts, slack, work)
        if only >= 0:
            touched[only] = met == HIT
    return True
