"""Compiled closing of a hand around an object: retreat, then joint by joint until touch.

`field` is an `ObjectField`, `hand` a `ClosingHand`, `work` a `Workspace`; `base` is the pose
(4, 4) of the hand base in the object's frame, `q` the joint coordinates. Other closing
strategies build on `place_links`, `retreat`, `advance_joint` and `body_hits_object`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import (
    balls_gap,
    bodies_gap,
    clip_to_body,
    collect_part,
    near_part,
    parted,
    to_link,
    way_out_of_inside,
)
from medkit.grasping.closing.kernel_options import entry, inner
from medkit.robots.kernels import joint_motion

#: How a closing joint stopped.
TOUCH, SELF, LIMIT = 1, 2, 3
#: Depth [m] to which samples of two bodies of the hand may overlap before they count as touching.
SELF_DEPTH = 0.0005
#: Longest sweep [m] that is confirmed on the triangles in one go.
WINDOW = 0.008
#: A prime, for walking through a list in scattered order.
SCATTER = 7919
#: P13 4.6.2: how often the last stride is halved.
HALVINGS = 10
#: Gaps [m] between the hand's own bodies beyond this are not measured.
SELF_HORIZON = 0.03
#: A retreat ends this far [m] from touching, so that the pose itself is free.
CLEAR = 1e-6


@entry
def place_links(hand: Any, q: np.ndarray, base: np.ndarray, work: Any) -> None:
    """Write the poses of all links at `q` with the hand's base at `base` into `work.poses`."""
    for link in range(hand.parent.shape[0]):
        _place_link(hand, q, base, link, work)


@inner
def _place_link(hand: Any, q: np.ndarray, base: np.ndarray, link: int, work: Any) -> None:
    # One fused product, since this runs a thousand times a grasp: parent, placement, motion.
    parent = hand.parent[link]
    at = work.at_joint
    for i in range(3):
        for j in range(4):
            at[i, j] = 0.0
        for k in range(3):
            above = base[i, k] if parent < 0 else work.poses[parent, i, k]
            for j in range(4):
                at[i, j] += above * hand.placement[link, k, j]
        at[i, 3] += base[i, 3] if parent < 0 else work.poses[parent, i, 3]
    value = hand.offset[link]
    if hand.coordinate[link] >= 0:
        value += hand.multiplier[link] * q[hand.coordinate[link]]
    joint_motion(hand.kind[link], hand.axis[link], value, work.motion)
    for i in range(3):
        for j in range(4):
            total = at[i, 3] if j == 3 else 0.0
            for k in range(3):
                total += at[i, k] * work.motion[k, j]
            work.poses[link, i, j] = total


@inner
def _set_joint(
    hand: Any, q: np.ndarray, base: np.ndarray, step: int, value: float, work: Any
) -> None:
    """Move one closing joint and the links it carries."""
    q[hand.joint[step]] = value
    for m in range(hand.moved_link_start[step], hand.moved_link_start[step + 1]):
        _place_link(hand, q, base, hand.moved_link[m], work)


@inner
def self_clearance(hand: Any, step: int, enough: float, work: Any) -> float:
    """Least gap [m] between bodies that a closing joint moves and bodies that it does not."""
    best = enough
    first, last = hand.moved_body_start[step], hand.moved_body_start[step + 1]
    for m in range(first, last):
        a = hand.moved_body[m]
        pose_a = work.poses[hand.body_link[a]]
        for e in range(hand.partner_start[a], hand.partner_start[a + 1]):
            b = hand.partner[e]
            moves_too = False
            for other in range(first, last):
                moves_too = moves_too or hand.moved_body[other] == b
            if moves_too:
                continue
            pose_b = work.poses[hand.body_link[b]]
            if balls_gap(hand, a, pose_a, b, pose_b) < best:
                best = min(best, bodies_gap(hand, a, pose_a, b, pose_b, best, work.at_joint))
    return best


@inner
def sweep_faces(
    field: Any,
    hand: Any,
    base: np.ndarray,
    q: np.ndarray,
    step: int,
    body: int,
    free: float,
    end: float,
    reach: float,
    work: Any,
) -> float:
    """Last value between `free` and `end` at which a body, swept by one joint, is still free.

    Each face near the sweep is tried at the best end so far; only where it hits is its own
    moment of touch found by halving. On entry the links stand at `free` and `near_part` has been
    called there; on exit they stand anywhere.
    """
    link = hand.body_link[body]
    found = collect_part(field, body, work.poses[link], reach, work)
    best = end
    _set_joint(hand, q, base, step, best, work)
    # Faces lie in the list in the order of the lattice; in a scattered order the best end
    # improves a few times instead of at every face.
    scatter = SCATTER if found % SCATTER != 0 else 1
    for e in range(found):
        face = work.faces[(e * scatter) % found]
        if parted(field, hand, body, face, work.poses[link], 0.0, work):
            continue
        if clip_to_body(hand, body, work.local, 0.0, work) == 0:
            continue
        low, high = free, best
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            _set_joint(hand, q, base, step, middle, work)
            to_link(work.poses[link], field.triangles[face], work.local)
            if clip_to_body(hand, body, work.local, 0.0, work) > 0:
                high = middle
            else:
                low = middle
        best = low
        _set_joint(hand, q, base, step, best, work)
    return best


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
    longest = 0.0
    for m in range(first, last):
        longest = max(longest, hand.lever[m])
    value = q[joint]
    budget = 0.0
    while sign * (stop - value) > 1e-9:
        stride = abs(stop - value)
        anything_near = False
        for m in range(first, last):
            body = hand.moved_body[m]
            pose = work.poses[hand.body_link[body]]
            # A sweep stays well below the body's width, so that no face is jumped over.
            window = min(WINDOW, 0.6 * hand.width[body])
            gap = near_part(field, hand, body, pose, window, stride * hand.lever[m], work)
            work.near[body] = gap < window
            anything_near = anything_near or work.near[body]
            stride = min(stride, max(gap, window) / hand.lever[m])
        # What is known to be free of the hand itself is used up before it is looked at again.
        if budget < SELF_DEPTH:
            budget = max(self_clearance(hand, step, SELF_HORIZON, work), SELF_DEPTH)
        stride = min(stride, budget / longest)
        end = value + sign * stride
        touched = False
        if anything_near:
            for m in range(first, last):
                body = hand.moved_body[m]
                if not work.near[body]:
                    continue
                _set_joint(hand, q, base, step, value, work)
                reach = abs(end - value) * hand.lever[m]
                reached = sweep_faces(field, hand, base, q, step, body, value, end, reach, work)
                touched = touched or reached != end
                end = reached
        _set_joint(hand, q, base, step, end, work)
        budget -= abs(end - value) * longest
        if budget < SELF_DEPTH and self_clearance(hand, step, 0.0, work) < -SELF_DEPTH:
            _stop_before_self(hand, base, q, step, value, end, work)
            return SELF
        value = end
        if touched:
            return TOUCH
    return LIMIT


@inner
def _stop_before_self(
    hand: Any, base: np.ndarray, q: np.ndarray, step: int, free: float, end: float, work: Any
) -> None:
    """Halve the last stride until the hand's own bodies no longer overlap."""
    low, high = free, end
    for _ in range(12):
        middle = 0.5 * (low + high)
        _set_joint(hand, q, base, step, middle, work)
        if self_clearance(hand, step, 0.0, work) < -SELF_DEPTH:
            high = middle
        else:
            low = middle
    _set_joint(hand, q, base, step, low, work)


@entry
def retreat(
    field: Any,
    hand: Any,
    q: np.ndarray,
    base: np.ndarray,
    approach: np.ndarray,
    limit: float,
    work: Any,
) -> float:
    """Draw the hand back along `approach` to the first pose at which no body hits the object.

    `base` is moved. A triangle that lies in a body has to leave it through the planes that it
    moves towards, so each hit tells how far to draw back at the least, and no free pose is
    passed over. Returns the way [m], -1 when it would exceed `limit`.
    """
    x, y, z = base[0, 3], base[1, 3], base[2, 3]
    place_links(hand, q, base, work)
    bodies = hand.body_link.shape[0]
    way = 0.0
    for body in range(bodies):
        pose = work.poses[hand.body_link[body]]
        way = way_out_of_inside(field, hand, body, pose, approach, way)
    base[0, 3], base[1, 3], base[2, 3] = (
        x - way * approach[0],
        y - way * approach[1],
        z - way * approach[2],
    )
    place_links(hand, q, base, work)
    # a plain 0 is a type of its own, for which all kernels below would be compiled once more
    clean, turn = 0, np.int64(0)
    while clean < bodies:
        need = _way_out(field, hand, turn, approach, work)
        if need > 0.0:
            way += need + CLEAR
            if way > limit:
                return -1.0
            base[0, 3] = x - way * approach[0]
            base[1, 3] = y - way * approach[1]
            base[2, 3] = z - way * approach[2]
            place_links(hand, q, base, work)
            clean = 0
        else:
            clean += 1
            turn = (turn + 1) % bodies
    return way


@inner
def _way_out(field: Any, hand: Any, body: int, approach: np.ndarray, work: Any) -> float:
    """Least further retreat [m] that a body needs, as far as its present hits tell; 0 if free."""
    pose = work.poses[hand.body_link[body]]
    if near_part(field, hand, body, pose, 0.0, 1e-3, work) > 0.0:
        return way_out_of_inside(field, hand, body, pose, approach, 0.0)
    need = 0.0
    found = collect_part(field, body, pose, 0.0, work)
    first, last = hand.plane_start[body], hand.plane_start[body + 1]
    for f in range(first, last):
        work.slope[f] = 0.0
        for a in range(3):
            along = pose[0, a] * approach[0] + pose[1, a] * approach[1] + pose[2, a] * approach[2]
            work.slope[f] += hand.planes[f, a] * along
    for e in range(found):
        if parted(field, hand, body, work.faces[e], pose, 0.0, work):
            continue
        corners = clip_to_body(hand, body, work.local, 0.0, work)
        for v in range(corners):
            way = 1e9
            for f in range(first, last):
                if work.slope[f] > 1e-9:
                    height = hand.planes[f, 3]
                    for a in range(3):
                        height -= hand.planes[f, a] * work.polygon[v, a]
                    way = min(way, height / work.slope[f])
            need = max(need, max(way, 0.0) + CLEAR)
    return need


@entry
def close_fingers(
    field: Any, hand: Any, base: np.ndarray, q: np.ndarray, stops: np.ndarray, work: Any
) -> None:
    """Close finger by finger, joint by joint from palm to tip; `stops` (k,) says how each ended."""
    place_links(hand, q, base, work)
    for step in range(hand.joint.shape[0]):
        stops[step] = advance_joint(field, hand, base, q, step, work)
