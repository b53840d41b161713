"""The object's triangles as a tree of balls: halved along the longest side, over and over."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.grasping.closing.ball_kernels import longest_edges, node_balls
from medkit.grasping.closing.halving_kernels import halve

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
    order = halved(balls[:, :3], depth)
    # three halvings make a level of the tree; what is left over comes first
    levels = [0, *range((depth - 1) % 3 + 1, depth + 1, 3)] if depth else [0]
    ordered = np.ascontiguousarray(corners[order])
    blocks = []
    for above, below in itertools.pairwise(levels):
        children = np.zeros((2**below, 4))
        node_balls(ordered, below, children)
        blocks.append(packed(children, np.arange(2**above + 1) * 2 ** (below - above)))
    starts = _starts(len(corners), depth)
    first_leaf = sum(len(level) for level in blocks)
    blocks.append(packed(balls[order], starts))
    return BallTree(order, np.vstack(blocks), 2 ** levels[1] if depth else FAN, first_leaf, starts)


def halved(points: Floats, depth: int) -> NDArray[np.int64]:
    """Order of points (p, 3) in which halves of halves, and so on, are neighbours in space."""
    order = np.arange(len(points))
    axes = np.full((2 ** (depth + 1), 3), -1, dtype=np.int64)
    halve(np.array(points, order="C"), order, depth, axes)
    return order


def packed(balls: Floats, starts: NDArray[np.int64]) -> NDArray[np.float32]:
    """Blocks (n, 4 * FAN) of the balls ``starts[k]:starts[k + 1]`` in single precision."""
    node = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    lane = np.arange(len(balls)) - starts[node]
    blocks = np.zeros((len(starts) - 1, 4, FAN), dtype=np.float32)
    blocks[:, 3] = NOTHING
    moved = np.zeros(len(balls))
    for axis in range(3):  # one column after the other: rows of three are slow
        middle = balls[:, axis].astype(np.float32)
        blocks[node, axis, lane] = middle
        moved += (middle - balls[:, axis]) ** 2
    radius = (balls[:, 3] + np.sqrt(moved)).astype(np.float32)
    blocks[node, 3, lane] = np.nextafter(radius, np.float32(1e9))
    return blocks.reshape(-1, 4 * FAN)


def _starts(count: int, level: int) -> NDArray[np.int64]:
    """First pieces of the nodes of one level; halves of halves differ by one piece at most."""
    return (count * np.arange(2**level + 1, dtype=np.int64)) // 2**level


def smallest_balls(triangles: Floats) -> Floats:
    """Smallest balls (n, 4) around triangles (n, 3, 3): middle and radius [m]."""
    rows, first = np.arange(len(triangles)), measured(triangles)[1]
    a, b, c = (triangles[rows, (first + shift) % 3] for shift in range(3))
    # The longest side's middle serves obtuse triangles; the others need the circumcentre.
    u, v = b - a, c - a
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    cross = uu * vv - uv**2
    acute = (vv + _dot(c - b, c - b) > uu) & (cross > 1e-12 * uu**2)
    safe = np.where(acute, 2.0 * cross, 1.0)
    s = np.where(acute, vv * (uu - uv) / safe, 0.5)
    t = np.where(acute, uu * (vv - uv) / safe, 0.0)
    middle = a + s[:, None] * u + t[:, None] * v
    reach = [_dot(corner - middle, corner - middle) for corner in (a, b, c)]
    return np.column_stack([middle, np.sqrt(np.maximum(np.maximum(*reach[:2]), reach[2]))])


def _dot(one: Floats, other: Floats) -> Floats:
    """Products (n,) of vectors (n, 3), column by column, since numpy sums rows of three slowly."""
    x, y, z = (one[:, a] * other[:, a] for a in range(3))
    return np.asarray(x + y + z)


def measured(triangles: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Length (n,) [m] of the longest edge of triangles (n, 3, 3), and which edge it is (n,)."""
    length, edge = np.empty(len(triangles)), np.empty(len(triangles), dtype=np.int64)
    longest_edges(triangles, length, edge)
    return length, edge
