"""Precision grasps: preshape, start pose, closing with the hand following its thumb, contacts.

After P13 4.7, algorithms 6 and 7, on the closing kernels of power grasps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.grasping.closing.body_kernels import workspace
from medkit.grasping.closing.hand_tables import ClosingHand, closing_hand, hand_rotation, palm_frame
from medkit.grasping.closing.object_field import ObjectField, object_field
from medkit.grasping.closing.whole_kernels import precision_grasp, retreat
from medkit.grasping.opposition import OPENING_FACTOR
from medkit.grasping.pad_ways import opposing_fingers
from medkit.grasping.power import MAX_RETREAT, ContactReader, Contacts
from medkit.grasping.precision_grip import grip_path, precision_grip
from medkit.grasping.testers import GraspTester, Quality
from medkit.robots.hand import Hand

#: P13 5.1.6: how far the baseline's palm stands off [m], and fingers without a part stay open.
STANDOFF = 0.05
IDLE = "power"


@dataclass(frozen=True)
class ClosedPrecisionGrasp:
    """One hand closed for a precision grasp.

    Attributes
    ----------
    start_pose, pose : ndarray, shape (4, 4)
        ``T_object_hand`` before and after closing [m].
    q : ndarray, shape (nq,)
        Joint coordinates after closing [rad or m].
    contacts : Contacts
        Where the pads' links lie on the object.
    started : bool
        Whether the start pose was free of the object.
    touched : ndarray of bool, shape (f,)
        Which fingers ended at the object; the thumb is first.
    """

    start_pose: Floats
    pose: Floats
    q: Floats
    contacts: Contacts
    started: bool
    touched: NDArray[np.bool_]


class PrecisionCloser:
    """Closes the pads of one hand on one object, candidate after candidate.

    Parameters
    ----------
    hand : Hand
        Any hand with a thumb and opposing fingers.
    field : ObjectField
        The object, from `object_field`.
    opening_factor : float
        Opening of the preshape over the diameter of the sphere, P13's k [1].
    standoff : float
        For candidates that are from no sphere (the surface-normal baseline of P13 5.1.6): the
        hand, as wide open as its pads go, is drawn back from the grasp point until it is free
        and then so much further [m]. P13 takes 50 and 70 mm; 50 serves this hand better.
    idle : str
        Preshape of the fingers that take no part, see `precision_grip`. Open, as in P13 5.1.6:
        a folded finger's knuckle stands before the palm.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> ball = trimesh.creation.icosphere(3, 0.015)
    >>> closer = PrecisionCloser(load_hand("wsg50"), object_field(ball.triangles))
    >>> grasp = closer.close(np.zeros(3), np.array([0, 0, -1.0]), np.array([0, 1.0, 0]), 0.015)
    >>> grasp.started, grasp.touched.tolist()
    (True, [True, True])
    """

    def __init__(
        self,
        hand: Hand,
        field: ObjectField,
        *,
        opening_factor: float = OPENING_FACTOR,
        standoff: float = STANDOFF,
        idle: str = IDLE,
    ) -> None:
        self.hand = hand
        self.field = field
        self.opening_factor = opening_factor
        self.standoff = standoff
        self.idle = idle
        self.grip = precision_grip(hand, idle=idle)
        self.arrays: ClosingHand = closing_hand(hand, preshape="precision")
        self.path = grip_path(hand, self.grip, self.arrays)
        self.work = workspace(field, self.arrays)
        self._palm = palm_frame(self.grip.approach, hand.closing_axis)
        # A URDF often hangs a rounded tip of its own on the last phalanx by a fixed joint.
        tips = [hand.tree.rigid_links(finger.tip_link) for finger in opposing_fingers(hand)]
        has_pad = np.isin(self.arrays.body_link, np.concatenate(tips))
        self._reader = ContactReader(self.arrays, has_pad)

    def preshape(self, radius: float) -> tuple[float, Floats]:
        """Amount along the grip for a sphere of `radius` [m], and the grasp centre (3,) [m].

        The opening is ``2 k r``, at most as wide as the pads go (P13 4.30); the centre is half
        of it in front of the thumb's pad, hand base frame (P13 4.31). The thumb keeps its depth
        while the hand closes, so the centre is as deep as the middle between the pads is when
        they touch the sphere. As wide as the pads go without a sphere.
        """
        grip = self.grip
        wanted = 2.0 * self.opening_factor * radius if radius > 0.0 else grip.widest
        amount = float(grip.amount_for(np.array([wanted]))[0])
        opening = np.interp(amount, grip.amounts, grip.openings)
        pad = [np.interp(amount, grip.amounts, column) for column in grip.thumb_pads.T]
        touch = np.interp(2.0 * radius, grip.openings[::-1], grip.offsets[::-1])
        return amount, np.asarray(
            pad + 0.5 * opening * grip.grip_axis + 0.5 * touch * grip.approach
        )

    def close(
        self, grasp_point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> ClosedPrecisionGrasp:
        """Simulate one precision grasp.

        Parameters
        ----------
        grasp_point : ndarray, shape (3,)
            Centre of the sphere that is grasped, or point of the surface with a standoff [m].
        approach, closing_axis : ndarray, shape (3,)
            Unit directions, see `CandidateGrasps`.
        radius : float
            Radius of the sphere [m]; 0 for a candidate that is from none: stand off.

        Returns
        -------
        ClosedPrecisionGrasp
            Start and end pose, joints, contacts of the pads.
        """
        amount, center = self.preshape(radius)
        base = np.eye(4)
        base[:3, :3] = hand_rotation(approach, closing_axis, self._palm)
        base[:3, 3] = grasp_point - base[:3, :3] @ center
        q = self.grip.configuration(self.hand, np.array([amount]))[0]
        forwards = base[:3, :3] @ self.grip.approach
        if radius <= 0.0 and not self._stand_off(grasp_point, base, q, forwards):
            return self._failed(base, q)
        start = base.copy()
        amounts = np.minimum(amount, self.path.end)
        touched = np.zeros(len(amounts), dtype=np.bool_)
        count = precision_grasp(
            self.field, self.arrays, self.path, forwards, base, q, amounts, touched,
            self._reader.reading, self.work,
        )  # fmt: skip
        if count < 0:
            return self._failed(start, q)
        return ClosedPrecisionGrasp(start, base, q, self._reader.contacts(count), True, touched)

    def _stand_off(self, point: Floats, base: Floats, q: Floats, forwards: Floats) -> bool:
        """Put the palm at `point`, draw back until free and by the standoff; False if never."""
        base[:3, 3] = point - base[:3, :3] @ self.hand.T_hand_power[:3, 3]
        way = retreat(self.field, self.arrays, q, base, forwards, MAX_RETREAT, self.work)
        base[:3, 3] -= self.standoff * forwards
        return bool(way >= 0.0)

    def _failed(self, base: Floats, q: Floats) -> ClosedPrecisionGrasp:
        nothing = Contacts(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
        touched = np.zeros(len(self.path.end), dtype=np.bool_)
        return ClosedPrecisionGrasp(base, base, q, nothing, False, touched)


class PrecisionTester(GraspTester):
    """Precision grasps (P13 4.7)."""

    def closed(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> ClosedPrecisionGrasp:
        """Start with the sphere between the pads, then close them while the hand follows."""
        done: ClosedPrecisionGrasp = self.closer.close(point, approach, closing_axis, radius)
        return done

    def options(self) -> dict[str, Any]:
        """Opening, standoff and idle fingers of the closer."""
        names = ("opening_factor", "standoff", "idle")
        return {name: getattr(self.closer, name) for name in names}

    @classmethod
    def build(
        cls, hand: Hand, triangles: Floats, quality: Quality, **options: Any
    ) -> PrecisionTester:
        """Prepare a hand and an object of triangles (n, 3, 3) [m]."""
        return cls(PrecisionCloser(hand, object_field(triangles), **options), quality)


def precision_tester(hand: Hand, triangles: Floats, quality: Quality) -> PrecisionTester:
    """Prepare the published precision grasps of one hand on one object for the planners."""
    return PrecisionTester.build(hand, triangles, quality)
