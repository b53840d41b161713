"""Which joints close a hand, in which order, and what each of them moves and how far."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.robots.hand import Hand

Ints = NDArray[np.int64]


def starts(counts: list[int]) -> Ints:
    """Where each of consecutive stretches begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def closing_steps(hand: Hand, finger_order: tuple[str, ...] | None) -> dict[str, NDArray]:
    """Joints in closing order with what they move and how far."""
    fingers = [hand.finger(name) for name in finger_order] if finger_order else hand.fingers
    rows = [
        (int(joint), float(sign), links, bodies)
        for finger in fingers
        for joint, sign, links, bodies in zip(
            finger.joints, finger.closing, finger.moved_links, finger.moved_bodies, strict=True
        )
    ]
    levers = [[_lever(hand, joint, int(b)) for b in bodies] for joint, _, _, bodies in rows]
    return {
        "joint": np.array([row[0] for row in rows], dtype=np.int64),
        "closing": np.array([row[1] for row in rows]),
        "moved_link_start": starts([len(row[2]) for row in rows]),
        "moved_link": np.concatenate([row[2] for row in rows]).astype(np.int64),
        "moved_body_start": starts([len(row[3]) for row in rows]),
        "moved_body": np.concatenate([row[3] for row in rows]).astype(np.int64),
        "lever": np.concatenate(levers).astype(float),
    }


def _lever(hand: Hand, joint: int, body: int) -> float:
    """Most that a point of a body travels per unit of a coordinate, over all configurations.

    Along the chain the distance from a joint's axis to the body is at most the sum of the
    lengths between the links.
    """
    tree, part = hand.tree, hand.bodies[body]
    reach = float(np.linalg.norm(part.vertices, axis=1).max())
    lever = 0.0
    for link in tree.ancestors(part.link):
        if tree.coordinate[link] == joint:
            rate = abs(float(tree.multiplier[link]))
            lever += rate if tree.kind[link] == 2 else rate * reach
        reach += float(np.linalg.norm(tree.placement[link][:3, 3]))
        if tree.kind[link] == 2 and tree.coordinate[link] >= 0:
            low, high = hand.limits[tree.coordinate[link]]
            reach += abs(float(tree.multiplier[link])) * max(abs(low), abs(high))
    return max(lever, 1e-6)
