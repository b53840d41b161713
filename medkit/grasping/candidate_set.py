"""Candidate grasps as a struct of arrays, and what became of the sphere that each is from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats

Ints = NDArray[np.int64]


class SphereFate(IntEnum):
    """What became of a medial sphere on the way to candidate grasps (P13 4.2 to 4.4).

    Attributes
    ----------
    AXIS : 0
        On a local symmetry axis: candidates around it (4.4.1).
    RIM : 1
        On the rim of a symmetry sheet: candidates across it (4.4.2).
    INSIDE_SHEET : 2
        Inside a sheet: out of reach, no candidates (4.4.3).
    TOO_FEW_NEIGHBORS : 3
        No symmetry to be read from so few spheres.
    OBJECT_ANGLE_TOO_SMALL : 4
        Of an edge or corner rather than of thickness (4.2.3).
    BELOW_RADIUS_RATIO : 5
        Surface detail, against the largest sphere (4.2.4).
    TOO_LARGE_FOR_HAND : 6
        Wider than the hand's largest ball.
    TOO_SMALL_FOR_HAND : 7
        Thinner than the hand's smallest ball.
    BALL : 8
        A single ball: directions from all around (4.4.4).
    DOMINANT_SPHERE : 9
        Touches opposing faces: directions across its chords (4.4.4).
    REPRESENTED : 10
        Coincides with a ball or dominant sphere that stands for it.

    Examples
    --------
    >>> SphereFate(1).name, int(SphereFate.BALL)
    ('RIM', 8)
    """

    AXIS = 0
    RIM = 1
    INSIDE_SHEET = 2
    TOO_FEW_NEIGHBORS = 3
    OBJECT_ANGLE_TOO_SMALL = 4
    BELOW_RADIUS_RATIO = 5
    TOO_LARGE_FOR_HAND = 6
    TOO_SMALL_FOR_HAND = 7
    BALL = 8
    DOMINANT_SPHERE = 9
    REPRESENTED = 10


@dataclass(frozen=True)
class CandidateGrasps:
    """Candidates as a struct of arrays, and the fate of every medial sphere.

    Attributes
    ----------
    grasp_point : ndarray, shape (n, 3)
        Point that the hand reaches for, in the object frame [m].
    approach : ndarray, shape (n, 3)
        Unit direction in which the hand moves, towards the object.
    closing_axis : ndarray, shape (n, 3)
        Unit axis about which the fingers close, at right angles to the approach.
    sphere : ndarray of int, shape (n,)
        Row of the medial axis that the candidate is from, -1 for none.
    kind : ndarray of int8, shape (n,)
        `SphereFate` of that sphere.
    radius : ndarray, shape (n,)
        Its radius [m].
    fate : ndarray of int8, shape (s,)
        `SphereFate` of every sphere of the medial axis.
    """

    grasp_point: Floats
    approach: Floats
    closing_axis: Floats
    sphere: Ints
    kind: NDArray[np.int8]
    radius: Floats
    fate: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.grasp_point)

    def select(self, rows: NDArray) -> CandidateGrasps:
        """The candidates in `rows` (indices or mask); the fates stay."""
        return replace(
            self,
            **{
                name: getattr(self, name)[rows]
                for name in ("grasp_point", "approach", "closing_axis", "sphere", "kind", "radius")
            },
        )

    def rows(self) -> list[tuple[Floats, Floats, Floats, float]]:
        """Point, approach, closing axis and radius of each candidate, as testers take them."""
        return [
            (self.grasp_point[k], self.approach[k], self.closing_axis[k], float(self.radius[k]))
            for k in range(len(self))
        ]

    def fate_counts(self) -> dict[str, int]:
        """How many spheres had each fate, by name in small letters; they add up to all spheres."""
        counted = Counter(self.fate.tolist())
        return {SphereFate(value).name.lower(): n for value, n in sorted(counted.items())}
