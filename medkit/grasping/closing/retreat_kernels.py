"""Compiled retreat: draw the open hand back along its approach until it is free of the object.

`field` is an `ObjectField`, `hand` a `ClosingHand`, `work` a `Workspace`; `base` is the pose
(4, 4) of the hand base in the object's frame, `q` the joint coordinates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.body_kernels import (
    apart,
    clip_to_body,
    to_link,
)
from medkit.grasping.closing.chain_kernels import place_links
from medkit.grasping.closing.face_tree import FAN
from medkit.grasping.closing.inside_kernels import is_inside, way_out_of_inside
from medkit.grasping.closing.kernel_options import inner, leaf
from medkit.grasping.closing.sight_kernels import first_child, height_over, look_at
from medkit.grasping.closing.tree_kernels import meet

#: A retreat ends this far [m] from touching, so that the pose itself is free.
CLEAR = 1e-6
#: A body that slides along the object leaves it by a hair at a time, each hit giving way to the
#: next. Its steps grow up to this [m]: a free pose shorter than that may be passed over.
COARSEST = 5e-5
#: Gaps [m] beyond this need not be known: the hand draws back no further at once.
FAR = 0.05
#: Pieces clipped before the hand draws back by what they tell: the others may be settled by then.
BUDGET = 24


@inner
def draw_back(
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
    passed over but for slivers below `COARSEST`. Returns the way [m], -1 when beyond `limit`.
    """
    x, y, z = base[0, 3], base[1, 3], base[2, 3]
    place_links(hand, q, base, work)
    bodies = hand.body_link.shape[0]
    way = 0.0
    for body in range(bodies):
        pose = work.poses[hand.body_link[body]]
        way = way_out_of_inside(field, hand, body, pose, approach, way)
        _set_slopes(hand, body, pose, approach, work)
        work.slack[body] = 0.0
    # a plain 0 is a type of its own, for which all kernels below would be compiled once more
    clean, turn, need, extra = 0, np.int64(0), way, CLEAR
    while clean < bodies:
        if need > 0.0:
            base[0, 3] = x - way * approach[0]
            base[1, 3] = y - way * approach[1]
            base[2, 3] = z - way * approach[2]
            place_links(hand, q, base, work)
            for body in range(bodies):
                work.slack[body] -= need
            clean = 0
        need = _way_out(field, hand, turn, need > 0.0, approach, work)
        if need > 0.0:
            need += extra
            extra = min(1.5 * extra, COARSEST)
            way += need
            if way > limit:
                return -1.0
        else:
            clean += 1
            extra = CLEAR
            turn = (turn + 1) % bodies
    return way


@inner
def _set_slopes(hand: Any, body: int, pose: np.ndarray, approach: np.ndarray, work: Any) -> None:
    """How fast a body's planes leave the object behind as the hand draws back."""
    planes = hand.hulls.planes
    for f in range(hand.hulls.plane_start[body], hand.hulls.plane_start[body + 1]):
        work.slope[f] = 0.0
        for a in range(3):
            along = pose[0, a] * approach[0] + pose[1, a] * approach[1] + pose[2, a] * approach[2]
            work.slope[f] += planes[f, a] * along


@inner
def _way_out(
    field: Any, hand: Any, body: int, again: bool, approach: np.ndarray, work: Any
) -> float:
    """Least further retreat [m] that a body needs, as far as its present hits tell; 0 if free.

    A body that was hit before (`again`) is asked for hits first, else for its gap.
    """
    if work.slack[body] > 0.0:
        return 0.0
    pose = work.poses[hand.body_link[body]]
    if again:
        way = _way_of_hits(field.tree, hand.hulls, body, pose, work)
        if way >= 0.0:
            return way + CLEAR
    work.slack[body] = max(0.0, meet(field.tree, hand.hulls, body, pose, 0.0, FAR, work))
    if work.hit[0] >= 0:
        return max(_way_of_hits(field.tree, hand.hulls, body, pose, work), 0.0) + CLEAR
    if is_inside(field, hand, body, pose):
        return way_out_of_inside(field, hand, body, pose, approach, 0.0) + CLEAR
    return 0.0


@inner
def _way_of_hits(tree: Any, hulls: Any, body: int, pose: np.ndarray, work: Any) -> float:
    """Retreat [m] that points of the object now in a body need at the least; -1 without any."""
    sight, clip = work.sight, work.clip
    stack = sight.stack
    need, exit_plane = -1.0, np.int64(-1)
    stack[0] = 0
    top, clipped = 1, 0
    while top > 0 and clipped < BUDGET:
        top -= 1
        node = stack[top]
        look_at(tree.blocks[node], hulls, body, pose, sight)
        radii = tree.blocks[node, 3 * FAN :]
        if node < tree.first_leaf:
            child = first_child(tree.fan, node)
            for k in range(FAN - 1, -1, -1):
                if not _is_settled(hulls, k, radii[k], need, exit_plane, work):
                    stack[top] = child + k
                    top += 1
            continue
        first = tree.starts[node - tree.first_leaf]
        for k in range(FAN):
            if _is_settled(hulls, k, radii[k], need, exit_plane, work):
                continue
            to_link(pose, tree.pieces[first + k], clip.local)
            if apart(hulls, body, 0.0, clip.local):
                continue
            corners = clip_to_body(hulls, body, 0.0, clip)
            clipped += 1 if corners > 0 else 0
            for v in range(corners):
                need, exit_plane = _way_of_corner(hulls, body, v, need, exit_plane, work)
    return need


@leaf
def _is_settled(hulls: Any, k: int, radius: float, need: float, exit_plane: int, work: Any) -> bool:
    """Whether ball k looked at is apart from a body, or leaves it before `need` as is known."""
    if work.sight.gap[k] > 0.0:
        return True
    if exit_plane < 0:
        return False
    middle = work.sight.middle
    x, y, z = middle[k], middle[FAN + k], middle[2 * FAN + k]
    height = height_over(hulls.planes, exit_plane, x, y, z)
    return radius - height <= need * work.slope[exit_plane]


@inner
def _way_of_corner(
    hulls: Any, body: int, v: int, need: float, exit_plane: int, work: Any
) -> tuple[float, int]:
    """`need` [m] and `exit_plane`, or what corner v of the part in a body needs where more."""
    polygon, planes = work.clip.polygon, hulls.planes
    x, y, z = polygon[v, 0], polygon[v, 1], polygon[v, 2]
    # most corners leave through the same plane as the one that needs most
    if (
        exit_plane >= 0
        and -height_over(planes, exit_plane, x, y, z) <= need * work.slope[exit_plane]
    ):
        return need, exit_plane
    way = 1e9
    plane: Any = np.int64(-1)
    for f in range(hulls.plane_start[body], hulls.plane_start[body + 1]):
        if work.slope[f] > 1e-9:
            depth = -height_over(planes, f, x, y, z)
            if depth <= need * work.slope[f]:
                return need, exit_plane
            if depth < way * work.slope[f]:
                way, plane = max(depth, 0.0) / work.slope[f], f
    return way, plane
