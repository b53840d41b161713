"""The object's triangles as a tree of balls: halved along the longest side, over and over."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats

#: Most pieces of triangles in one leaf.
LEAF = 4


class FaceTree(NamedTuple):
    """A balanced binary tree over pieces of triangles (arrays only, so that kernels take it).

    Node n has the children 2 n + 1 and 2 n + 2; the last ``len(starts) - 1`` nodes are leaves.

    Attributes
    ----------
    balls : ndarray, shape (2 l - 1, 4)
        A ball around all that a node holds: middle and radius [m].
    starts : ndarray of int, shape (l + 1,)
        Leaf k holds the pieces ``starts[k]:starts[k + 1]``.
    pieces : ndarray, shape (p, 3, 3)
        Corners of the pieces [m].
    piece_balls : ndarray, shape (p, 4)
        The smallest ball around each piece [m].
    faces : ndarray of int, shape (p,)
        The triangle of the object that each piece is from.
    """

    balls: Floats
    starts: NDArray[np.int64]
    pieces: Floats
    piece_balls: Floats
    faces: NDArray[np.int64]


def face_tree(pieces: Floats, faces: NDArray[np.int32]) -> FaceTree:
    """Build the tree of triangles `pieces` (p, 3, 3) that are parts of the object's `faces` (p,).

    Examples
    --------
    >>> corners = np.eye(3)[None] + np.arange(9.0)[:, None, None]
    >>> tree = face_tree(corners, np.arange(9, dtype=np.int32))
    >>> len(tree.starts) - 1, len(tree.balls)
    (4, 7)
    """
    depth = max(int(np.ceil(np.log2(len(pieces) / LEAF))), 0)
    balls = smallest_balls(pieces)
    order = np.arange(len(pieces))
    for level in range(depth):
        starts = _starts(len(pieces), level)
        points = balls[order, :3]
        low = np.minimum.reduceat(points, starts[:-1])
        longest = (np.maximum.reduceat(points, starts[:-1]) - low).argmax(axis=1)
        node = np.repeat(np.arange(len(longest)), np.diff(starts))
        along = points[np.arange(len(points)), longest[node]]
        order = order[np.lexsort((along, node))]
    sorted_pieces = np.ascontiguousarray(pieces[order], dtype=float)
    nodes = [_node_balls(sorted_pieces, _starts(len(pieces), level)) for level in range(depth + 1)]
    return FaceTree(
        np.vstack(nodes),
        _starts(len(pieces), depth),
        sorted_pieces,
        balls[order],
        faces[order].astype(np.int64),
    )


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
