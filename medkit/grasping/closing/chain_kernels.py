"""Compiled forward kinematics of a hand whose base stands somewhere in the object's frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.kernel_options import entry, inner
from medkit.robots.kernels import joint_motion


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
def set_joint(
    hand: Any, q: np.ndarray, base: np.ndarray, step: int, value: float, work: Any
) -> None:
    """Move one closing joint and the links it carries."""
    q[hand.joint[step]] = value
    for m in range(hand.moved_link_start[step], hand.moved_link_start[step + 1]):
        _place_link(hand, q, base, hand.moved_link[m], work)
