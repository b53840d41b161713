"""Compiled walks down the object's tree: how far a body is from it, and which faces are near.

`tree` is a `FaceTree`, `hulls` a `HullTable`, `work` a `Workspace`; poses are (4, 4) maps from a
link's frame into the object's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import lowest_corner, to_link, touches
from medkit.grasping.closing.face_tree import FAN
from medkit.grasping.closing.kernel_options import inner, leaf
from medkit.grasping.closing.sight_kernels import first_child, look_at, push_near

#: Share of the gap that is worth knowing: the rest would take a walk to every face in sight.
SHARE = 0.7
#: A hit is passed over for another that may reach so much deeper [m].
DEEPER = 0.003


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
    sight = work.sight
    sight.stack[0], sight.bounds[0] = 0, -1e9
    top: Any = np.int64(1)
    while top > 0:
        top -= 1
        if sight.bounds[top] >= _horizon(best, window):
            continue
        node = sight.stack[top]
        look_at(tree.blocks[node], hulls, body, pose, sight)
        if node >= tree.first_leaf:
            best = _meet_leaf(tree, hulls, body, pose, window, node, best, work)
        else:
            top = push_near(first_child(tree.fan, node), _horizon(best, window), sight, top)
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
    """Bring the pieces of the leaf looked at to account; the smaller gap."""
    first, sight = tree.starts[node - tree.first_leaf], work.sight
    for k in range(FAN):
        if sight.gap[k] >= _horizon(best, window):
            continue
        to_link(pose, tree.pieces[first + k], work.clip.local)
        f = sight.plane[k]
        height = lowest_corner(hulls.planes, max(f, -1 - f), work.clip.local)
        if height > 0.0:
            best = min(best, height)
        elif height < best:
            if touches(hulls, body, work.clip):
                work.hit[0] = first + k
                best = height
            else:
                best = min(best, 0.0)
    return best


@inner
def collect_faces(
    tree: Any, hulls: Any, body: int, pose: np.ndarray, margin: float, work: Any
) -> int:
    """Faces that may come within `margin` [m] of a body, into ``work.faces``; how many."""
    work.stamp[0] += 1
    found = 0
    sight = work.sight
    sight.stack[0] = 0
    top: Any = np.int64(1)
    while top > 0:
        top -= 1
        node = sight.stack[top]
        look_at(tree.blocks[node], hulls, body, pose, sight)
        if node < tree.first_leaf:
            top = push_near(first_child(tree.fan, node), margin, sight, top)
            continue
        first = tree.starts[node - tree.first_leaf]
        for k in range(FAN):
            if sight.gap[k] > margin or work.stamps[tree.faces[first + k]] == work.stamp[0]:
                continue
            # one plane tells of most pieces that they are too far
            f = sight.plane[k]
            to_link(pose, tree.pieces[first + k], work.clip.local)
            if lowest_corner(hulls.planes, max(f, -1 - f), work.clip.local) <= margin:
                work.stamps[tree.faces[first + k]] = work.stamp[0]
                work.faces[found] = tree.faces[first + k]
                found += 1
    return found
