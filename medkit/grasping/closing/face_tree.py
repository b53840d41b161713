"""The object's triangles as a tree of balls: halved along the longest side, over and over."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats

#: Children of a node and pieces of a leaf, at most: a block of balls that is looked at as one.
FAN = 8
#: Radius [m] of what does not exist.
NOTHING = -1e30


class FaceTree(NamedTuple):
    """A balanced tree over pieces of triangles (arrays only, so that kernels take it).

    Nodes are numbered by level from the root, node 0, which has `fan` children; all others have
    FAN. The leaves come last.

    Attributes
    ----------
    blocks : ndarray, shape (n, 4 * FAN), float32
        Balls around what is below each child of a node, for a leaf around each of its pieces:
        FAN numbers x of the middles, then y, z and the radii [m], rounded upwards.
    fan : int
        Children of the root.
    first_leaf : int
        The first leaf's number.
    starts : ndarray of int, shape (l + 1,)
        Leaf k, node ``first_leaf + k``, holds the pieces ``starts[k]:starts[k + 1]``.
    pieces : ndarray, shape (p, 3, 3)
        Corners of the pieces [m].
    faces : ndarray of int, shape (p,)
        The triangle of the object that each piece is from.
    """

    blocks: NDArray[np.float32]
    fan: int
    first_leaf: int
    starts: NDArray[np.int64]
    pieces: Floats
    faces: NDArray[np.int64]


class BallTree(NamedTuple):
    """The order in which things are leaves of a tree, and the tree, see `FaceTree`."""

    order: NDArray[np.int64]
    blocks: NDArray[np.float32]
    fan: int
    first_leaf: int
    starts: NDArray[np.int64]


def face_tree(pieces: Floats, faces: NDArray[np.int32]) -> FaceTree:
    """Build the tree of triangles `pieces` (p, 3, 3) that are parts of the object's `faces` (p,).

    Examples
    --------
    >>> corners = np.eye(3)[None] + np.arange(9.0)[:, None, None]
    >>> tree = face_tree(corners, np.arange(9, dtype=np.int32))
    >>> len(tree.starts) - 1, tree.blocks.shape
    (2, (3, 32))
    """
    order, blocks, fan, first_leaf, starts = ball_tree(pieces, smallest_balls(pieces))
    ordered = np.ascontiguousarray(pieces[order], dtype=float)
    return FaceTree(blocks, fan, first_leaf, starts, ordered, faces[order].astype(np.int64))


def ball_tree(corners: Floats, balls: Floats) -> BallTree:
    """Build the tree of things that are given by their corners (p, c, 3) and balls (p, 4)."""
    depth = max(int(np.ceil(np.log2(len(corners) / FAN))), 0)
    order = _halved(balls[:, :3], depth)
    # three halvings make a level of the tree; what is left over comes first
    levels = [0, *range((depth - 1) % 3 + 1, depth + 1, 3)] if depth else [0]
    blocks = []
    for above, below in itertools.pairwise(levels):
        children = _node_balls(corners[order], _starts(len(corners), below))
        blocks.append(_blocks(children, np.arange(2**above + 1) * 2 ** (below - above)))
    starts = _starts(len(corners), depth)
    first_leaf = sum(len(level) for level in blocks)
    blocks.append(_blocks(balls[order], starts))
    return BallTree(order, np.vstack(blocks), 2 ** levels[1] if depth else FAN, first_leaf, starts)


def _halved(points: Floats, depth: int) -> NDArray[np.int64]:
    """Order of points (p, 3) in which halves of halves, and so on, are neighbours in space."""
    order = np.arange(len(points))
    for level in range(depth + 1):
        starts = _starts(len(points), level)
        ordered = points[order]
        low = np.minimum.reduceat(ordered, starts[:-1])
        longest = (np.maximum.reduceat(ordered, starts[:-1]) - low).argmax(axis=1)
        node = np.repeat(np.arange(len(longest)), np.diff(starts))
        along = ordered[np.arange(len(points)), longest[node]]
        order = order[np.lexsort((along, node))]
    return order


def _blocks(balls: Floats, starts: NDArray[np.int64]) -> NDArray[np.float32]:
    """Blocks (n, 4 * FAN) of the balls ``starts[k]:starts[k + 1]`` in single precision."""
    node = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    lane = np.arange(len(balls)) - starts[node]
    blocks = np.zeros((len(starts) - 1, 4, FAN), dtype=np.float32)
    blocks[:, 3] = NOTHING
    blocks[node, :3, lane] = balls[:, :3]
    moved = np.linalg.norm(blocks[node, :3, lane] - balls[:, :3], axis=1)
    blocks[node, 3, lane] = np.nextafter((balls[:, 3] + moved).astype(np.float32), np.float32(1e9))
    return blocks.reshape(-1, 4 * FAN)


def _starts(count: int, level: int) -> NDArray[np.int64]:
    """First pieces of the nodes of one level; halves of halves differ by one piece at most."""
    return (count * np.arange(2**level + 1, dtype=np.int64)) // 2**level


def _node_balls(pieces: Floats, starts: NDArray[np.int64]) -> Floats:
    """Balls (n, 4) around the boxes' middles of consecutive pieces."""
    low = np.minimum.reduceat(pieces.min(axis=1), starts[:-1])
    high = np.maximum.reduceat(pieces.max(axis=1), starts[:-1])
    middle = 0.5 * (low + high)
    way = pieces - np.repeat(middle, np.diff(starts), axis=0)[:, None]
    radius = np.maximum.reduceat(np.linalg.norm(way, axis=2).max(axis=1), starts[:-1])
    return np.column_stack([middle, radius])


def smallest_balls(triangles: Floats) -> Floats:
    """Smallest balls (n, 4) around triangles (n, 3, 3): middle and radius [m]."""
    rows = np.arange(len(triangles))
    sides = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    first = sides.argmax(axis=1)
    a, b, c = (triangles[rows, (first + shift) % 3] for shift in range(3))
    # The longest side's middle serves obtuse triangles; the others need the circumcentre.
    u, v = b - a, c - a
    uu, vv, uv = ((x * y).sum(axis=1) for x, y in ((u, u), (v, v), (u, v)))
    cross = uu * vv - uv**2
    acute = (vv + ((c - b) ** 2).sum(axis=1) > uu) & (cross > 1e-12 * uu**2)
    safe = np.where(acute, 2.0 * cross, 1.0)
    s = np.where(acute, vv * (uu - uv) / safe, 0.5)
    t = np.where(acute, uu * (vv - uv) / safe, 0.0)
    middle = a + s[:, None] * u + t[:, None] * v
    radius = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return np.column_stack([middle, radius])
