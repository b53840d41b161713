"""Collision queries between link bodies, and of link bodies against an object."""

from __future__ import annotations

import coal
import numpy as np

from medkit.geometry import Floats
from medkit.robots.hand import Hand, Ints, LinkBody


def convex_geometry(body: LinkBody) -> coal.ConvexBase:
    """Return a link body as coal's convex polytope."""
    points = coal.StdVec_Vec3s()
    for vertex in body.vertices:
        points.append(np.asarray(vertex))
    return coal.Convex.convexHull(points, True, "Qt")


def coal_pose(pose: Floats) -> coal.Transform3s:
    """Return a pose (4, 4) as coal's transform."""
    return coal.Transform3s(np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]))


def self_collision_pairs(hand: Hand, samples: int = 64) -> Ints:
    """Pairs of bodies that can touch.

    Left out are bodies of one rigid group, bodies of neighbouring groups (their joint holds them
    together), and pairs that touch in all of the `samples` configurations (fixed, spread over
    the limits).

    Returns
    -------
    ndarray, shape (p, 2)
        Indices into ``hand.bodies``.
    """
    candidates = np.array(
        [
            (i, j)
            for i in range(len(hand.bodies))
            for j in range(i + 1, len(hand.bodies))
            if not _neighbours(hand, hand.bodies[i].link, hand.bodies[j].link)
        ],
        dtype=np.int64,
    ).reshape(-1, 2)
    rng = np.random.default_rng(0)
    low, high = hand.limits.T
    configurations = low + rng.random((samples, len(low))) * (high - low)
    touching = SelfCollision(hand, candidates).touching(configurations)
    return candidates[~touching.all(axis=0)]


def _group(hand: Hand, link: int) -> int:
    """Return the first link of the rigid group of `link`."""
    while hand.tree.kind[link] == 0 and hand.tree.parent[link] >= 0:
        link = int(hand.tree.parent[link])
    return link


def _neighbours(hand: Hand, first: int, second: int) -> bool:
    a, b = _group(hand, first), _group(hand, second)

    def above(link: int) -> int:
        parent = int(hand.tree.parent[link])
        return -1 if parent < 0 else _group(hand, parent)

    return a == b or above(a) == b or above(b) == a


class SelfCollision:
    """Tests pairs of a hand's bodies for contact.

    Parameters
    ----------
    hand : Hand
        The hand.
    pairs : ndarray, shape (p, 2), optional
        Pairs of bodies; the hand's own when left out.
    """

    def __init__(self, hand: Hand, pairs: Ints | None = None) -> None:
        self.hand = hand
        self.pairs = hand.self_collision_pairs if pairs is None else pairs
        self._shapes = [convex_geometry(body) for body in hand.bodies]
        self._request = coal.CollisionRequest()
        self._result = coal.CollisionResult()

    def touching(self, q: Floats) -> np.ndarray:
        """Whether each pair touches, (B, p) for `q` (B, nq)."""
        poses = self.hand.link_poses(np.atleast_2d(q))
        flags = np.zeros((len(poses), len(self.pairs)), dtype=bool)
        for row, links in enumerate(poses):
            placed = [coal_pose(links[body.link]) for body in self.hand.bodies]
            for column, (i, j) in enumerate(self.pairs):
                self._result.clear()
                coal.collide(
                    self._shapes[i], placed[i], self._shapes[j], placed[j],
                    self._request, self._result,
                )  # fmt: skip
                flags[row, column] = self._result.isCollision()
        return flags
