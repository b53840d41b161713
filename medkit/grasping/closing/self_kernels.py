"""Compiled gaps between the hand's own bodies, from samples of each over the other's planes."""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.face_tree import FAN
from medkit.grasping.closing.kernel_options import entry, inner, leaf
from medkit.grasping.closing.sight_kernels import first_child, height_over, look_at, push_near

#: Depth [m] to which samples of two bodies of the hand may overlap before they count as touching.
SELF_DEPTH = 0.0005


@inner
def self_clearance(hand: Any, step: int, enough: float, work: Any) -> float:
    """Least gap [m] between bodies that a closing joint moves and bodies that it does not."""
    best = enough
    for m in range(hand.moved_body_start[step], hand.moved_body_start[step + 1]):
        a = hand.moved_body[m]
        for e in range(hand.partner_start[a], hand.partner_start[a + 1]):
            if not moves_too(hand, step, hand.partner[e]):
                best = pair_gap(hand, a, e, best, work)
    return best


@inner
def forget_rooms(hand: Any, step: int, work: Any) -> None:
    """Let the next `self_stride` of a closing joint measure all its pairs of bodies."""
    for m in range(hand.moved_body_start[step], hand.moved_body_start[step + 1]):
        a = hand.moved_body[m]
        for e in range(hand.partner_start[a], hand.partner_start[a + 1]):
            work.room[e] = -1.0


@inner
def self_stride(hand: Any, step: int, window: float, enough: float, work: Any) -> float:
    """Most [rad or m] that a joint may turn before bodies of the hand need another look.

    That is what each of its pairs surely has room for, and `window` [m] where that is less. A
    pair whose room is used up is measured, gaps beyond `enough` [m] not told apart.
    """
    stride = 1e9
    for m in range(hand.moved_body_start[step], hand.moved_body_start[step + 1]):
        a = hand.moved_body[m]
        for e in range(hand.partner_start[a], hand.partner_start[a + 1]):
            if moves_too(hand, step, hand.partner[e]):
                continue
            if work.room[e] < 0.0:
                work.room[e] = max(pair_gap(hand, a, e, enough, work), 0.0)
            stride = min(stride, max(work.room[e], window) / hand.lever[m])
    return stride


@inner
def runs_into_itself(hand: Any, step: int, turned: float, enough: float, work: Any) -> bool:
    """Whether a joint that has just turned by so much [rad or m] ran into the hand; uses up room.

    Pairs without room for the turn are measured where they are now.
    """
    for m in range(hand.moved_body_start[step], hand.moved_body_start[step + 1]):
        a = hand.moved_body[m]
        for e in range(hand.partner_start[a], hand.partner_start[a + 1]):
            if moves_too(hand, step, hand.partner[e]):
                continue
            work.room[e] -= turned * hand.lever[m]
            if work.room[e] < 0.0:
                gap = pair_gap(hand, a, e, enough, work)
                if gap < -SELF_DEPTH:
                    return True
                work.room[e] = max(gap, 0.0)
    return False


@leaf
def moves_too(hand: Any, step: int, body: int) -> bool:
    """Whether a closing joint moves a body."""
    for m in range(hand.moved_body_start[step], hand.moved_body_start[step + 1]):
        if hand.moved_body[m] == body:
            return True
    return False


@inner
def pair_gap(hand: Any, a: int, e: int, enough: float, work: Any) -> float:
    """Gap [m] between body a and its partner in row e; `enough` when beyond."""
    b = hand.partner[e]
    pose_a, pose_b = work.poses[hand.body_link[a]], work.poses[hand.body_link[b]]
    if balls_gap(hand, a, pose_a, b, pose_b) >= enough:
        return enough
    return bodies_gap(hand, a, pose_a, b, pose_b, enough, work.sight)


@inner
def balls_gap(hand: Any, a: int, pose_a: np.ndarray, b: int, pose_b: np.ndarray) -> float:
    """Gap [m] between the balls around two bodies."""
    squared = 0.0
    for i in range(3):
        d = pose_a[i, 3] - pose_b[i, 3]
        for j in range(3):
            d += pose_a[i, j] * hand.ball_center[a, j] - pose_b[i, j] * hand.ball_center[b, j]
        squared += d * d
    return np.sqrt(squared) - hand.ball_radius[a] - hand.ball_radius[b]


@entry
def least_gap(hand: Any, a: int, b: int, poses: np.ndarray, enough: float, sight: Any) -> float:
    """Least gap [m] between two bodies over link poses (n, l, 4, 4); `enough` when beyond."""
    best = enough
    for row in range(poses.shape[0]):
        pose_a, pose_b = poses[row, hand.body_link[a]], poses[row, hand.body_link[b]]
        best = bodies_gap(hand, a, pose_a, b, pose_b, best, sight)
    return best


@entry
def bodies_gap(
    hand: Any, a: int, pose_a: np.ndarray, b: int, pose_b: np.ndarray, enough: float, sight: Any
) -> float:
    """Least height [m] of samples of each body over the other's planes; `enough` when beyond."""
    best = _samples_over(hand, a, pose_a, b, pose_b, enough, sight)
    return _samples_over(hand, b, pose_b, a, pose_a, best, sight)


@inner
def _samples_over(
    hand: Any, a: int, pose_a: np.ndarray, b: int, pose_b: np.ndarray, enough: float, sight: Any
) -> float:
    """Least height [m] of the samples of body a over the planes of body b."""
    relative, surface, best = sight.relative, hand.surface, enough
    for i in range(3):
        for j in range(4):
            relative[i, j] = 0.0
            for k in range(3):
                offset = pose_a[k, 3] if j == 3 else 0.0
                relative[i, j] += pose_a[k, i] * (pose_b[k, j] - offset)
    sight.stack[0], sight.bounds[0] = 0, -1e9
    top: Any = np.int64(1)
    while top > 0:
        top -= 1
        if sight.bounds[top] >= best:
            continue
        node = sight.stack[top]
        look_at(surface.blocks[surface.root[a] + node], hand.hulls, b, relative, sight)
        if node < surface.first_leaf[a]:
            top = push_near(first_child(surface.fan[a], node), best, sight, top)
        else:
            best = _leaf_over(hand.hulls, b, best, sight)
    return best


@leaf
def _leaf_over(hulls: Any, body: int, enough: float, sight: Any) -> float:
    """Least height [m] of the samples looked at over the planes of a body."""
    best, middle = enough, sight.middle
    for k in range(FAN):
        if sight.gap[k] < best:
            x, y, z = middle[k], middle[FAN + k], middle[2 * FAN + k]
            best = min(best, _height(hulls, body, x, y, z, best))
    return best


@inner
def _height(hulls: Any, body: int, x: float, y: float, z: float, enough: float) -> float:
    """Largest height [m] of a point over the planes of a body, in its link's frame."""
    top = -1e9
    for f in range(hulls.plane_start[body], hulls.plane_start[body + 1]):
        height = height_over(hulls.planes, f, x, y, z)
        if height > top:
            top = height
            if top >= enough:
                return top
    return top
