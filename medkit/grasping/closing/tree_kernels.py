"""Compiled walks down the object's tree: how far a body is from it, and which faces are near.

`tree` is a `FaceTree`, `hulls` a `HullTable`, `work` a `Workspace`; poses are (4, 4) maps from a
link's frame into the object's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import (
    hint_at,
    lowest_corner,
    sure_height,
    to_link,
    touches,
)
from medkit.grasping.closing.kernel_options import inner, leaf

#: Share of the gap that is worth knowing: the rest would take a walk to every face in sight.
SHARE = 0.7
#: A hit is passed over for another that may reach so much deeper [m].
DEEPER = 0.003


@leaf
def ball_in_link(pose: np.ndarray, balls: np.ndarray, row: int) -> tuple[float, float, float]:
    """Middle of one of many balls (n, 4), in a link's frame."""
    dx = balls[row, 0] - pose[0, 3]
    dy = balls[row, 1] - pose[1, 3]
    dz = balls[row, 2] - pose[2, 3]
    return (
        pose[0, 0] * dx + pose[1, 0] * dy + pose[2, 0] * dz,
        pose[0, 1] * dx + pose[1, 1] * dy + pose[2, 1] * dz,
        pose[0, 2] * dx + pose[1, 2] * dy + pose[2, 2] * dz,
    )


@leaf
def ball_gap(hulls: Any, body: int, pose: np.ndarray, balls: np.ndarray, row: int) -> float:
    """Gap [m] between one of many balls (n, 4) and a body at the least."""
    x, y, z = ball_in_link(pose, balls, row)
    return sure_height(hulls, body, x, y, z) - balls[row, 3]


@leaf
def _horizon(best: float, window: float) -> float:
    """Gap [m] from which on a part of the tree does not change what is asked for."""
    if best > window:
        return SHARE * best
    # once a hit is known, only one that reaches much deeper is worth the way
    return best - DEEPER if best < 0.0 else 0.0


@inner
def meet(
    tree: Any, hulls: Any, body: int, pose: np.ndarray, window: float, enough: float, work: Any
) -> float:
    """Gap [m] that a body surely keeps from the object; not above 0 with a piece in ``work.hit``.

    Gaps below `window` are given as 0 and above `enough` not told apart. ``work.hit`` is -1 when
    no triangle meets the body, else a piece that reaches deep: which one is a matter of
    speed, whether one is, is exact.
    """
    best = enough
    work.hit[0] = -1
    stack, bounds = work.stack, work.bounds
    leaves = tree.starts.shape[0] - 1
    stack[0], bounds[0] = 0, -1e9
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] >= _horizon(best, window):
            continue
        node = stack[top]
        if node >= leaves - 1:
            best = _meet_leaf(tree, hulls, body, pose, window, node - leaves + 1, best, work)
            continue
        first = 2 * node + 1
        one = ball_gap(hulls, body, pose, tree.balls, first)
        other = ball_gap(hulls, body, pose, tree.balls, first + 1)
        # the nearer child goes on top
        swap = 1 if one < other else 0
        stack[top], bounds[top] = first + swap, max(one, other)
        stack[top + 1], bounds[top + 1] = first + 1 - swap, min(one, other)
        top += 2
    if best > window:
        return SHARE * best
    return min(best, 0.0)


@leaf
def _meet_leaf(
    tree: Any,
    hulls: Any,
    body: int,
    pose: np.ndarray,
    window: float,
    node: int,
    best: float,
    work: Any,
) -> float:
    """Bring the pieces of one leaf to account; the smaller gap."""
    for piece in range(tree.starts[node], tree.starts[node + 1]):
        x, y, z = ball_in_link(pose, tree.piece_balls, piece)
        if sure_height(hulls, body, x, y, z) - tree.piece_balls[piece, 3] >= _horizon(best, window):
            continue
        to_link(pose, tree.pieces[piece], work.clip.local)
        f = hint_at(hulls, body, x, y, z)
        height = lowest_corner(hulls.planes, max(f, -1 - f), work.clip.local)
        if height > 0.0:
            best = min(best, height)
        elif height < best:
            if touches(hulls, body, work.clip):
                work.hit[0] = piece
                best = height
            else:
                best = min(best, 0.0)
    return best


@inner
def collect_faces(
    tree: Any, hulls: Any, body: int, pose: np.ndarray, margin: float, work: Any
) -> int:
    """Faces that may come within `margin` [m] of a body, into ``work.faces``; how many."""
    stack = work.stack
    leaves = tree.starts.shape[0] - 1
    work.stamp[0] += 1
    found = 0
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if ball_gap(hulls, body, pose, tree.balls, node) > margin:
            continue
        if node < leaves - 1:
            stack[top], stack[top + 1] = 2 * node + 2, 2 * node + 1
            top += 2
            continue
        leaf_row = node - leaves + 1
        for piece in range(tree.starts[leaf_row], tree.starts[leaf_row + 1]):
            face = tree.faces[piece]
            if work.stamps[face] == work.stamp[0]:
                continue
            if ball_gap(hulls, body, pose, tree.piece_balls, piece) > margin:
                continue
            work.stamps[face] = work.stamp[0]
            work.faces[found] = face
            found += 1
    return found
