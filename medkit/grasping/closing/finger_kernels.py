"""Compiled closing of a hand around an object: joint by joint until touch.

`field` is an `ObjectField`, `hand` a `ClosingHand`, `work` a `Workspace`; `base` is the pose
(4, 4) of the hand base in the object's frame, `q` the joint coordinates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import to_link, touches
from medkit.grasping.closing.chain_kernels import place_links, set_joint
from medkit.grasping.closing.kernel_options import inner
from medkit.grasping.closing.self_kernels import (
    SELF_DEPTH,
    forget_rooms,
    runs_into_itself,
    self_clearance,
    self_stride,
)
from medkit.grasping.closing.tree_kernels import meet

#: How a closing joint stopped.
TOUCH, SELF, LIMIT = 1, 2, 3
#: P13 4.6.2: the last stride is halved ten times.
FINEST = 2.0**-10
#: Gaps [m] to the object beyond this are not measured.
HORIZON = 0.08
#: Gaps [m] between the hand's own bodies beyond this are not measured.
SELF_HORIZON = 0.03
#: Longest stride [m] towards the hand's own bodies whose end alone is looked at.
SELF_WINDOW = 0.003


@inner
def advance_joint(
    field: Any, hand: Any, base: np.ndarray, q: np.ndarray, step: int, work: Any
) -> int:
    """Close one joint until a body it moves touches the object or the hand, or to its limit.

    Far from everything the joint moves by clearance over lever arm, which cannot collide; near
    the object a short sweep is confirmed on the triangles. `q` and `work.poses` end at the last
    free value. Returns `TOUCH`, `SELF` or `LIMIT`.
    """
    sign = hand.closing[step]
    joint = hand.joint[step]
    stop = hand.limits[joint, 1] if sign > 0.0 else hand.limits[joint, 0]
    first, last = hand.moved_body_start[step], hand.moved_body_start[step + 1]
    forget_rooms(hand, step, work)
    value = q[joint]
    while sign * (stop - value) > 1e-9:
        stride = abs(stop - value)
        for m in range(first, last):
            body = hand.moved_body[m]
            stride = min(stride, max(work.slack[body], hand.window[body]) / hand.lever[m])
        stride = min(stride, self_stride(hand, step, SELF_WINDOW, SELF_HORIZON, work))
        wanted = value + sign * stride
        end = free_end(field, hand, base, q, step, value, wanted, work)
        if runs_into_itself(hand, step, abs(end - value), SELF_HORIZON, work):
            end = _before_self(hand, base, q, step, value, end, work)
            for m in range(first, last):
                work.slack[hand.moved_body[m]] = 0.0  # known only for the state beyond
            free_end(field, hand, base, q, step, value, end, work)
            return SELF
        value = end
        if value != wanted:
            return TOUCH
    return LIMIT


@inner
def free_end(
    field: Any,
    hand: Any,
    base: np.ndarray,
    q: np.ndarray,
    step: int,
    value: float,
    wanted: float,
    work: Any,
) -> float:
    """How far from the free `value` towards `wanted` one joint gets before a body touches.

    Whatever hits at the end is traced back to its own moment of touch, which becomes the new
    end, until nothing hits there. Leaves the joint at the end and the bodies' slack up to date.
    """
    first, last = hand.moved_body_start[step], hand.moved_body_start[step + 1]
    finest = abs(wanted - value) * FINEST
    end = wanted
    set_joint(hand, q, base, step, end, work)
    m = first
    while m < last:
        body = hand.moved_body[m]
        # A sweep stays well below the body's width, so that no face is jumped over.
        left = work.slack[body] - abs(end - value) * hand.lever[m]
        if left < hand.window[body]:
            pose = work.poses[hand.body_link[body]]
            left = meet(field.tree, hand.hulls, body, pose, hand.window[body], HORIZON, work)
            if work.hit[0] >= 0 and end != value:
                piece = work.hit[0]
                end = _before_piece(
                    field, hand, base, q, step, body, piece, value, end, finest, work
                )
                m = first
                continue
        work.fresh[body] = max(left, 0.0)
        m += 1
    for m in range(first, last):
        work.slack[hand.moved_body[m]] = work.fresh[hand.moved_body[m]]
    return end


@inner
def _before_piece(
    field: Any,
    hand: Any,
    base: np.ndarray,
    q: np.ndarray,
    step: int,
    body: int,
    piece: int,
    free: float,
    end: float,
    finest: float,
    work: Any,
) -> float:
    """Last value before `end` at which a body is free of one piece of the object, by halving."""
    low, high = free, end
    while abs(high - low) > finest:
        middle = 0.5 * (low + high)
        set_joint(hand, q, base, step, middle, work)
        to_link(work.poses[hand.body_link[body]], field.tree.pieces[piece], work.clip.local)
        if touches(hand.hulls, body, work.clip):
            high = middle
        else:
            low = middle
    set_joint(hand, q, base, step, low, work)
    return low


@inner
def _before_self(
    hand: Any, base: np.ndarray, q: np.ndarray, step: int, free: float, end: float, work: Any
) -> float:
    """Halve the last stride until the hand's own bodies no longer overlap."""
    low, high = free, end
    for _ in range(12):
        middle = 0.5 * (low + high)
        set_joint(hand, q, base, step, middle, work)
        if self_clearance(hand, step, 0.0, work) < -SELF_DEPTH:
            high = middle
        else:
            low = middle
    return low


@inner
def close_fingers(
    field: Any, hand: Any, base: np.ndarray, q: np.ndarray, stops: np.ndarray, work: Any
) -> None:
    """Close finger by finger, joint by joint from palm to tip; `stops` (k,) says how each ended.

    Expects ``work`` as `draw_back` left it: with the slack of all bodies at this base and `q`.
    """
    place_links(hand, q, base, work)
    for step in range(hand.joint.shape[0]):
        stops[step] = advance_joint(field, hand, base, q, step, work)
