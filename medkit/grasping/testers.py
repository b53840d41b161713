"""Testing one candidate: close the hand on it, then judge the contacts, whatever the closing."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from medkit.geometry import Floats
from medkit.grasping.closing.object_field import object_field
from medkit.grasping.grasp_set import (
    FORCE_CLOSURE,
    NOT_FORCE_CLOSURE,
    START_COLLISION,
    TOO_FEW_CONTACTS,
    Grasp,
)
from medkit.grasping.power import Contacts, PowerCloser
from medkit.quality import epsilon
from medkit.robots.hand import Hand

#: Hard point contacts below this number cannot hold a body against every wrench.
MIN_CONTACTS = 3
#: How far [m] the hand stands off in the pose before the grasp.
PREGRASP_WAY = 0.1


@dataclass(frozen=True)
class Quality:
    """What epsilon needs besides the contacts: friction, centre (3,) [m], torque scale [m]."""

    friction: float
    center: Floats
    torque_scale: float

    def epsilon(self, contacts: Contacts) -> float:
        """L1 epsilon of 8-edge cones [N]; 0 when not force-closure (P13 4.6.2)."""
        return epsilon(
            contacts.points,
            contacts.normals,
            friction=self.friction,
            torque_origin=self.center,
            torque_scale=self.torque_scale,
        ).lower


def judge(contacts: Contacts, quality: Quality, *, started: bool = True) -> tuple[float, str]:
    """Epsilon and outcome of a closed hand (P13 4.6.2 and 5.1.3).

    Parameters
    ----------
    contacts : Contacts
        Where the hand lies on the object, object frame.
    quality : Quality
        Friction, torque origin and torque scale.
    started : bool
        Whether the hand was free of the object before it closed.

    Returns
    -------
    epsilon : float
        Quality [N], 0 when not force-closure.
    outcome : str
        One of `medkit.grasping.grasp_set.OUTCOMES`.

    Examples
    --------
    >>> quality = Quality(0.5, np.zeros(3), 1.0)
    >>> corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
    >>> four = Contacts(corners, -corners, np.arange(4))
    >>> judge(four, quality)[1], judge(four, quality, started=False)
    ('force_closure', (0.0, 'start_collision'))
    >>> judge(Contacts(corners[:2], -corners[:2], np.arange(2)), quality)
    (0.0, 'too_few_contacts')
    """
    if not started:
        return 0.0, START_COLLISION
    if len(contacts.points) < MIN_CONTACTS:
        return 0.0, TOO_FEW_CONTACTS
    value = quality.epsilon(contacts)
    return (value, FORCE_CLOSURE) if value > 0.0 else (0.0, NOT_FORCE_CLOSURE)


def warm_quality() -> None:
    """Load the kernels of epsilon, with contacts at the corners of a tetrahedron."""
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
    epsilon(corners, -corners, friction=0.5, torque_origin=np.zeros(3), torque_scale=1.0)


class ClosedHand(Protocol):
    """What a closing strategy returns, whatever else it tells."""

    @property
    def start_pose(self) -> Floats:
        """``T_object_hand`` before closing, shape (4, 4) [m]."""

    @property
    def pose(self) -> Floats:
        """``T_object_hand`` after closing, shape (4, 4) [m]."""

    @property
    def q(self) -> Floats:
        """Joint coordinates (nq,) after closing [rad or m]."""

    @property
    def contacts(self) -> Contacts:
        """Where the hand lies on the object."""

    @property
    def started(self) -> bool:
        """Whether the hand was free of the object before it closed."""


class Try(NamedTuple):
    """One way to test a candidate: who tests it, and where the hand goes.

    Attributes
    ----------
    tester : object
        A `GraspTester`.
    point, approach, closing_axis : ndarray, shape (3,)
        See `CandidateGrasps` [m, 1, 1].
    """

    tester: Any
    point: Floats
    approach: Floats
    closing_axis: Floats


class GraspTester(ABC):
    """Closes the hand on a candidate and judges the result; one for each closing strategy.

    Parameters
    ----------
    closer : object
        The closing strategy, prepared for a hand and an object.
    quality : Quality
        What the contacts are judged by.
    """

    def __init__(self, closer: Any, quality: Quality) -> None:
        self.closer = closer
        self.quality = quality

    @abstractmethod
    def closed(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> ClosedHand:
        """Close the hand on a candidate."""

    def options(self) -> dict[str, Any]:
        """Keyword arguments of the closer that are not hand and object."""
        return {}

    @classmethod
    @abstractmethod
    def build(cls, hand: Hand, triangles: Floats, quality: Quality, **options: Any) -> GraspTester:
        """Prepare a hand and an object of triangles (n, 3, 3) [m]."""

    def parts(self) -> dict[str, Any]:
        """What another process needs to build the same tester."""
        return {
            "hand": self.closer.hand,
            "triangles": self.closer.field.triangles,
            "quality": self.quality,
            **self.options(),
        }

    @classmethod
    def from_parts(cls, parts: Mapping[str, Any]) -> GraspTester:
        """Build a tester from `parts`."""
        return cls.build(**parts)

    def settled(self, point: Floats, approach: Floats, closing_axis: Floats, radius: float) -> Try:
        """The way in which `test` tests a candidate; a search has others to choose from."""
        return Try(self, point, approach, closing_axis)

    def test(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> tuple[Grasp, float]:
        """The tested grasp, and the time that its quality took [s]."""
        closed = self.closed(point, approach, closing_axis, radius)
        begin = time.perf_counter()
        value, outcome = judge(closed.contacts, self.quality, started=closed.started)
        spent = time.perf_counter() - begin
        pregrasp = closed.start_pose.copy()
        pregrasp[:3, 3] -= PREGRASP_WAY * approach
        hand, contacts = self.closer.hand, closed.contacts
        links = tuple(hand.link_names[hand.bodies[b].link] for b in contacts.bodies)
        grasp = Grasp(
            outcome, closed.pose, pregrasp, closed.q, approach, closing_axis, point, radius,
            contacts.points, contacts.normals, links, value,
        )  # fmt: skip
        return grasp, spent


@dataclass(frozen=True)
class _ClosedPower:
    """A power grasp, which closes without moving on."""

    start_pose: Floats
    pose: Floats
    q: Floats
    contacts: Contacts
    started: bool


class PowerTester(GraspTester):
    """Power grasps (P13 4.6)."""

    def closed(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> ClosedHand:
        """Back off until free, then close finger by finger."""
        done = self.closer.close(point, approach, closing_axis)
        return _ClosedPower(done.pose, done.pose, done.q, done.contacts, done.started)

    @classmethod
    def build(cls, hand: Hand, triangles: Floats, quality: Quality, **options: Any) -> PowerTester:
        """Prepare a hand and an object of triangles (n, 3, 3) [m]."""
        return cls(PowerCloser(hand, object_field(triangles), **options), quality)


def power_tester(hand: Hand, triangles: Floats, quality: Quality) -> PowerTester:
    """The closing strategy of power grasps (P13 4.6, algorithm 4), as the planners call it.

    Parameters
    ----------
    hand : Hand
        The hand.
    triangles : ndarray, shape (n, 3, 3)
        Corners of the object's triangles, outward when seen anticlockwise [m].
    quality : Quality
        What the contacts are judged by.

    Returns
    -------
    PowerTester
        Ready for `PowerTester.test`.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> bar = trimesh.creation.cylinder(0.02, 0.2).triangles
    >>> tester = power_tester(load_hand("armar3"), bar, Quality(0.5, np.zeros(3), 0.1))
    >>> grasp, _ = tester.test(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 0.02)
    >>> grasp.outcome
    'force_closure'
    """
    return PowerTester.build(hand, triangles, quality)
