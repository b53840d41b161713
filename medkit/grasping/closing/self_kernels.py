"""Compiled gaps between the hand's own bodies, from samples of each over the other's planes."""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import height_over, moved, sure_height
from medkit.grasping.closing.kernel_options import entry, inner

#: Depth [m] to which samples of two bodies of the hand may overlap before they count as touching.
SELF_DEPTH = 0.0005


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
def least_gap(
    hand: Any, a: int, b: int, poses: np.ndarray, enough: float, relative: np.ndarray
) -> float:
    """Least gap [m] between two bodies over link poses (n, l, 4, 4); `enough` when beyond."""
    best = enough
    for row in range(poses.shape[0]):
        pose_a, pose_b = poses[row, hand.body_link[a]], poses[row, hand.body_link[b]]
        best = bodies_gap(hand, a, pose_a, b, pose_b, best, relative)
    return best


@inner
def bodies_gap(
    hand: Any,
    a: int,
    pose_a: np.ndarray,
    b: int,
    pose_b: np.ndarray,
    enough: float,
    relative: np.ndarray,
) -> float:
    """Least height [m] of samples of each body over the other's planes; `enough` when beyond.

    `relative` (3, 4) or larger is scratch.
    """
    best = _samples_over(hand, a, pose_a, b, pose_b, enough, relative)
    return _samples_over(hand, b, pose_b, a, pose_a, best, relative)


@inner
def _samples_over(
    hand: Any,
    a: int,
    pose_a: np.ndarray,
    b: int,
    pose_b: np.ndarray,
    enough: float,
    relative: np.ndarray,
) -> float:
    """Least height [m] of the samples of body a over the planes of body b."""
    best = enough
    for i in range(3):
        for j in range(4):
            relative[i, j] = 0.0
            for k in range(3):
                offset = pose_b[k, 3] if j == 3 else 0.0
                relative[i, j] += pose_b[k, i] * (pose_a[k, j] - offset)
    for g in range(hand.group_start[a], hand.group_start[a + 1]):
        x, y, z = moved(relative, hand.group_center, g)
        if sure_height(hand.hulls, b, x, y, z) >= best + hand.group_radius[g]:
            continue
        for s in range(hand.sample_start[g], hand.sample_start[g + 1]):
            x, y, z = moved(relative, hand.samples, s)
            # one plane tells of most samples that they are too high to count
            if sure_height(hand.hulls, b, x, y, z) < best:
                best = min(best, _height(hand.hulls, b, x, y, z, best))
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
