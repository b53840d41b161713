"""All tested grasps of one object with one hand, failed ones included."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats

FORCE_CLOSURE = "force_closure"
NOT_FORCE_CLOSURE = "not_force_closure"
START_COLLISION = "start_collision"
TOO_FEW_CONTACTS = "too_few_contacts"
#: Outcomes of a power grasp; other closing strategies may add their own.
OUTCOMES = (FORCE_CLOSURE, NOT_FORCE_CLOSURE, START_COLLISION, TOO_FEW_CONTACTS)


@dataclass(frozen=True)
class Grasp:
    """One tested candidate, in the object frame.

    Attributes
    ----------
    outcome : str
        ``"force_closure"``, or why it is none.
    pose, pregrasp : ndarray, shape (4, 4)
        ``T_object_hand`` of the closed hand, and of the hand before it comes near [m].
    q : ndarray, shape (nq,)
        Joint coordinates [rad or m].
    approach, closing_axis, grasp_point : ndarray, shape (3,)
        The candidate [1, 1, m].
    sphere_radius : float
        Radius of its medial sphere [m]; 0 for candidates that are from no sphere.
    points, normals : ndarray, shape (c, 3)
        Contacts [m] and inward unit normals.
    links : tuple of str, length c
        Link of each contact.
    epsilon : float
        Quality [N], 0 when not force-closure.
    """

    outcome: str
    pose: Floats
    pregrasp: Floats
    q: Floats
    approach: Floats
    closing_axis: Floats
    grasp_point: Floats
    sphere_radius: float
    points: Floats
    normals: Floats
    links: tuple[str, ...]
    epsilon: float


@dataclass(frozen=True)
class ObjectRecord:
    """Which object was planned for: file, hash, scale, extents (3,) [m], centre (3,) [m]."""

    path: str
    sha256: str
    scale: float
    extents: Floats
    center_mass: Floats
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True)
class GraspSet:
    """The result of planning.

    Attributes
    ----------
    object : ObjectRecord
        The object.
    hand, planner, grasp : str
        Names of the hand, the planner, and the kind of grasp.
    joint_names : tuple of str
        Names of the joint coordinates.
    parameters : mapping
        Everything else that the result depends on.
    seed : int or None
        Seed of the choice among candidates, where it is known.
    sphere_counts : mapping of str to int
        Fates of the medial spheres, or of what else the planner starts from.
    candidates_found : int
        Candidates before the limit on their number.
    timing : mapping of str to float
        Wall time of each of `stopwatch.STAGES` [s].
    grasps : tuple of Grasp
        All tested candidates.
    """

    object: ObjectRecord
    hand: str
    planner: str
    grasp: str
    joint_names: tuple[str, ...]
    parameters: Mapping[str, Any]
    seed: int | None
    sphere_counts: Mapping[str, int]
    candidates_found: int
    timing: Mapping[str, float]
    grasps: tuple[Grasp, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.grasps)

    @property
    def outcomes(self) -> dict[str, int]:
        """How many candidates had each outcome, most frequent first."""
        return dict(Counter(grasp.outcome for grasp in self.grasps).most_common())

    @property
    def force_closure(self) -> NDArray[np.bool_]:
        """Which grasps are force-closure, shape (n,)."""
        return np.array([grasp.outcome == FORCE_CLOSURE for grasp in self.grasps], dtype=bool)

    @property
    def epsilons(self) -> Floats:
        """Quality of each grasp, shape (n,) [N]."""
        return np.array([grasp.epsilon for grasp in self.grasps], dtype=float)

    @property
    def yield_share(self) -> float:
        """Share of the tested candidates that are force-closure [1]; NaN when none was tested."""
        return float(self.force_closure.mean()) if self.grasps else float("nan")

    def best(self, count: int = 1) -> tuple[Grasp, ...]:
        """The `count` force-closure grasps of largest epsilon, best first."""
        order = np.argsort(-self.epsilons, kind="stable")
        closed = [self.grasps[k] for k in order if self.grasps[k].outcome == FORCE_CLOSURE]
        return tuple(closed[:count])
