"""Which bodies of a hand touch each other."""

from __future__ import annotations

import coal
import numpy as np
from numpy.typing import ArrayLike

from medkit.geometry import Floats
from medkit.robots.collision import coal_pose, convex_geometry
from medkit.robots.hand import Hand, Ints
from medkit.robots.kernels import near_pairs_kernel


class SelfCollision:
    """Tests pairs of a hand's bodies for contact: boxes first (compiled), then the hulls.

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
        self._owner = np.array([body.link for body in hand.bodies], dtype=np.int64)
        low = np.array([body.vertices.min(axis=0) for body in hand.bodies]).reshape(-1, 3)
        high = np.array([body.vertices.max(axis=0) for body in hand.bodies]).reshape(-1, 3)
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self._near = np.zeros(len(self.pairs), dtype=np.bool_)
        self._request = coal.CollisionRequest()
        self._result = coal.CollisionResult()

    def collides(self, q: ArrayLike) -> bool:
        """Whether any pair touches at `q` (nq,)."""
        links = self.hand.link_poses(q)
        return any(self._touch(links, row) for row in self._near_rows(links))

    def touching(self, q: ArrayLike) -> Ints:
        """Pairs of bodies (k, 2) that touch at `q` (nq,)."""
        links = self.hand.link_poses(q)
        rows = [row for row in self._near_rows(links) if self._touch(links, row)]
        return np.asarray(self.pairs[rows])

    def _near_rows(self, links: Floats) -> list[int]:
        near_pairs_kernel(links, self._owner, self._middle, self._half, self.pairs, self._near)
        return [int(row) for row in np.flatnonzero(self._near)]

    def _touch(self, links: Floats, row: int) -> bool:
        i, j = self.pairs[row]
        self._result.clear()
        coal.collide(
            self._shapes[i], coal_pose(links[self._owner[i]]),
            self._shapes[j], coal_pose(links[self._owner[j]]),
            self._request, self._result,
        )  # fmt: skip
        return bool(self._result.isCollision())


def self_collision_pairs(hand: Hand, samples: int = 48) -> Ints:
    """Pairs of bodies that can touch.

    Left out are bodies of one rigid group, bodies of neighbouring groups (their joint holds them
    together), and pairs that touch in all of the `samples` configurations (fixed, spread over
    the limits).

    Parameters
    ----------
    hand : Hand
        The hand.
    samples : int
        Number of configurations that are tried.

    Returns
    -------
    ndarray, shape (p, 2)
        Indices into ``hand.bodies``.
    """
    count = len(hand.bodies)
    candidates = np.array(
        [
            (i, j)
            for i in range(count)
            for j in range(i + 1, count)
            if not _neighbours(hand, hand.bodies[i].link, hand.bodies[j].link)
        ],
        dtype=np.int64,
    ).reshape(-1, 2)
    rng = np.random.default_rng(0)
    low, high = hand.limits.T
    always = np.ones(len(candidates), dtype=bool)
    for q in low + rng.random((samples, len(low))) * (high - low):
        still = SelfCollision(hand, candidates[always]) if always.any() else None
        if still is None:
            break
        rows = np.flatnonzero(always)
        links = hand.link_poses(q)
        always[:] = False
        always[[rows[k] for k in still._near_rows(links) if still._touch(links, k)]] = True
    return candidates[~always]


def _neighbours(hand: Hand, first: int, second: int) -> bool:
    a, b = _group(hand, first), _group(hand, second)
    return a == b or _above(hand, a) == b or _above(hand, b) == a


def _group(hand: Hand, link: int) -> int:
    """Return the first link of the rigid group of `link`."""
    while hand.tree.kind[link] == 0 and hand.tree.parent[link] >= 0:
        link = int(hand.tree.parent[link])
    return link


def _above(hand: Hand, group: int) -> int:
    """Return the group that carries `group`, -1 for the base."""
    parent = int(hand.tree.parent[group])
    return -1 if parent < 0 else _group(hand, parent)
