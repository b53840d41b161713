"""Power grasps: lay the hand onto a candidate, back off, close, read the contacts (P13 4.6).

Published procedure, with the errors of algorithm 5 as printed put right; `closing/` holds the
compiled pieces, which other closing strategies build on too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.grasping.closing.body_kernels import Workspace, workspace
from medkit.grasping.closing.contact_kernels import COLUMNS, SPOTS, Reading
from medkit.grasping.closing.hand_tables import ClosingHand, closing_hand, hand_rotation, palm_frame
from medkit.grasping.closing.object_field import ObjectField
from medkit.grasping.closing.whole_kernels import contacts_at, power_grasp
from medkit.robots.hand import Hand

#: A face of the object this near [m] to a link of the closed hand touches it: pads give a little.
CONTACT_TOLERANCE = 0.0005
#: Contacts of one body keep at least this distance [m], and there are at most so many.
CONTACT_SEPARATION, CONTACTS_PER_BODY = 0.005, 4
#: Surfaces of hand and object that oppose each other by less than this touch at an edge only.
MIN_OPPOSITION = float(np.cos(np.radians(60.0)))
#: Largest retreat [m]; a hand that is not free by then never had the object before it.
MAX_RETREAT = 1.0


@dataclass(frozen=True)
class Contacts:
    """Contacts of one closed hand, in the object frame.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Points on the object's surface [m].
    normals : ndarray, shape (n, 3)
        Unit normals there that point into the object, as the finger pushes.
    bodies : ndarray of int, shape (n,)
        Rows of `Hand.bodies`: which body of the hand touches.

    Examples
    --------
    >>> none = Contacts(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    >>> len(none.points)
    0
    """

    points: Floats
    normals: Floats
    bodies: NDArray[np.int64]


class ContactReader:
    """What the kernels need to read contacts, and the contacts that they found.

    Parameters
    ----------
    arrays : ClosingHand
        The hand.
    bodies : ndarray of bool, shape (b,), optional
        Bodies whose contacts count; all when left out.
    """

    def __init__(self, arrays: ClosingHand, bodies: NDArray[np.bool_] | None = None) -> None:
        count = len(arrays.body_link)
        self.reading = Reading(
            np.ones(count, dtype=np.bool_) if bodies is None else bodies,
            CONTACT_TOLERANCE,
            CONTACT_SEPARATION,
            MIN_OPPOSITION,
            CONTACTS_PER_BODY,
            np.zeros((SPOTS, COLUMNS)),
            np.zeros((CONTACTS_PER_BODY * count, COLUMNS)),
        )

    def contacts(self, count: int) -> Contacts:
        """The first `count` contacts that a kernel left."""
        rows = self.reading.contacts[:count]
        return Contacts(rows[:, :3].copy(), rows[:, 3:6].copy(), rows[:, 6].astype(np.int64))


@dataclass(frozen=True)
class ClosedGrasp:
    """One closed hand.

    Attributes
    ----------
    pose : ndarray, shape (4, 4)
        ``T_object_hand`` of the hand base [m].
    q : ndarray, shape (nq,)
        Joint coordinates [rad or m].
    contacts : Contacts
        Where the hand lies on the object.
    retreat : float
        How far the hand was drawn back from the grasp point [m]; negative when it never came
        free.
    stops : ndarray of int, shape (k,)
        How each closing joint stopped: 1 touch, 2 the hand itself, 3 joint limit.
    """

    pose: Floats
    q: Floats
    contacts: Contacts
    retreat: float
    stops: NDArray[np.int64]

    @property
    def started(self) -> bool:
        """Whether the hand came free of the object before it closed."""
        return self.retreat >= 0.0


class PowerCloser:
    """Closes one hand around one object, candidate after candidate.

    Parameters
    ----------
    hand : Hand
        The hand.
    field : ObjectField
        The object, from `object_field`.
    finger_order : tuple of str, optional
        Order in which the fingers close; the hand's own when left out.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping.closing.object_field import object_field
    >>> from medkit.robots import load_hand
    >>> bar = trimesh.creation.cylinder(0.02, 0.2)
    >>> closer = PowerCloser(load_hand("armar3"), object_field(bar.triangles))
    >>> grasp = closer.close(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    >>> len(set(grasp.contacts.bodies)) > 4
    True
    """

    def __init__(
        self, hand: Hand, field: ObjectField, *, finger_order: tuple[str, ...] | None = None
    ) -> None:
        self.hand = hand
        self.field = field
        self.arrays: ClosingHand = closing_hand(hand, finger_order=finger_order)
        self.work: Workspace = workspace(field, self.arrays)
        self._palm = palm_frame(hand.palm_direction, hand.closing_axis)
        self._reader = ContactReader(self.arrays)

    def start_pose(self, grasp_point: Floats, approach: Floats, closing_axis: Floats) -> Floats:
        """``T_object_hand`` with the hand's power frame at the grasp point (P13 4.29)."""
        pose = np.eye(4)
        pose[:3, :3] = hand_rotation(approach, closing_axis, self._palm)
        pose[:3, 3] = grasp_point - pose[:3, :3] @ self.hand.T_hand_power[:3, 3]
        return pose

    def close(self, grasp_point: Floats, approach: Floats, closing_axis: Floats) -> ClosedGrasp:
        """Simulate one power grasp (P13 algorithm 4).

        Parameters
        ----------
        grasp_point : ndarray, shape (3,)
            Where the power frame of the hand goes [m].
        approach, closing_axis : ndarray, shape (3,)
            Unit directions, see `CandidateGrasps`.

        Returns
        -------
        ClosedGrasp
            Pose, joints, contacts, and how the joints stopped.
        """
        pose = self.start_pose(grasp_point, approach, closing_axis)
        return self.close_from(pose, np.ascontiguousarray(approach, dtype=float))

    def close_from(self, pose: Floats, approach: Floats) -> ClosedGrasp:
        """Back off from `pose` (4, 4) against `approach` (3,) until free, then close."""
        base = np.array(pose, dtype=float)
        q = self.arrays.preshape.copy()
        stops = np.zeros(len(self.arrays.joint), dtype=np.int64)
        way, count = power_grasp(
            self.field, self.arrays, q, base, approach, MAX_RETREAT, stops,
            self._reader.reading, self.work,
        )  # fmt: skip
        return ClosedGrasp(base, q, self._reader.contacts(count), float(way), stops)

    def contacts(self, pose: Floats, q: Floats) -> Contacts:
        """Contacts of the hand at a pose (4, 4) and joints (nq,)."""
        at, joints = np.array(pose, dtype=float), np.array(q, dtype=float)
        reading = self._reader.reading
        count = contacts_at(self.field, self.arrays, joints, at, reading, self.work)
        return self._reader.contacts(count)
