"""The search of ``medial-plus``: try a candidate in a few ways, then beside it where none holds."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from medkit.geometry import Floats
from medkit.grasping.grasp_set import START_COLLISION, Grasp
from medkit.grasping.power import PowerCloser
from medkit.grasping.testers import PowerTester, Try
from medkit.robots.hand import Hand

#: How far a power grasp stands back from where the palm meets the object, as shares of the
#: largest radius that the hand encloses.
STAND_BACK = (1.0 / 3.0, 2.0 / 3.0, 1.0)
#: How much wider the pads open than published, beside thin parts they need room; and how far they
#: stand back, as a share of that radius.
WIDE, PAD_BACK = 1.5, 0.2
#: Where nothing holds: how far the hand is turned about its closing axis and about the axis across
#: it [rad], and shifted along these, as a share of that radius.
TILT, SHIFT = np.radians(30.0), 0.5


class SearchingTester:
    """Tests each candidate in a few ways and keeps the best (no published source).

    Parameters
    ----------
    tester : object
        What tests one of them: `PowerTester` or `PrecisionTester`.
    room : float
        Largest radius that the hand encloses [m].

    Attributes
    ----------
    closings : int
        How often the hand was closed so far, over all candidates.
    """

    def __init__(self, tester: Any, room: float) -> None:
        self.tester = tester
        self.room = room
        self.closings = 0
        self.power = isinstance(tester, PowerTester)
        self.other = _fingers_reversed(tester) if self.power else _wider_open(tester)
        self._finger_of = tester.closer.hand.finger_of_link()

    @classmethod
    def around(cls, tester: Any, hand: Hand) -> SearchingTester:
        """Search with a hand's own room."""
        return cls(tester, hand.max_sphere_radius)

    def parts(self) -> dict[str, Any]:
        """What another process needs to build the same tester."""
        return {"type": type(self.tester), "parts": self.tester.parts(), "room": self.room}

    @classmethod
    def from_parts(cls, parts: Mapping[str, Any]) -> SearchingTester:
        """Build a tester from `parts`."""
        return cls(parts["type"].from_parts(parts["parts"]), parts["room"])

    def test(
        self, point: Floats, approach: Floats, closing_axis: Floats, radius: float
    ) -> tuple[Grasp, float]:
        """The best of the tried grasps, the first among equals, and the time of all qualities.

        All ways at the candidate itself are tried; those beside it only until one holds, where
        none at the candidate does.

        Parameters
        ----------
        point, approach, closing_axis : ndarray, shape (3,)
            The candidate in the object frame, see `CandidateGrasps` [m, 1, 1].
        radius : float
            Radius of its sphere [m].

        Returns
        -------
        Grasp
            The best; its approach and closing axis are those of the way that gave it, its grasp
            point is the candidate's.
        float
            Time of all qualities [s].
        """
        _, best, spent = self._search(Try(self.tester, point, approach, closing_axis), radius)
        return replace(best, grasp_point=point), spent

    def settled(self, point: Floats, approach: Floats, closing_axis: Floats, radius: float) -> Try:
        """The way that `test` settles on, to be tested alone; arguments as for `test`."""
        return self._search(Try(self.tester, point, approach, closing_axis), radius)[0]

    def _search(self, begin: Try, radius: float) -> tuple[Try, Grasp, float]:
        """The best way, its grasp, and the time of all qualities."""
        best, spent = self._tested(begin, radius)
        settled = begin
        ways = self._ways(begin, best)
        for number, way in enumerate(itertools.chain(ways, self._beside(begin))):
            if number >= len(ways) and best.epsilon > 0.0:
                break
            grasp, more = self._tested(way, radius)
            spent += more
            if grasp.epsilon > best.epsilon:
                settled, best = way, grasp
        return settled, best, spent

    def _tested(self, way: Try, radius: float) -> tuple[Grasp, float]:
        self.closings += 1
        tested: tuple[Grasp, float] = way.tester.test(*way[1:], radius)
        return tested

    def _ways(self, begin: Try, first: Grasp) -> list[Try]:
        """What to try at the candidate after the published grasp `first`."""
        other = begin._replace(tester=self.other)
        if not self.power:
            back = begin.point - PAD_BACK * self.room * begin.approach
            return [other, begin._replace(point=back), other._replace(point=back)]
        if first.outcome == START_COLLISION:
            return []
        ways = [
            begin._replace(point=begin.point + step * begin.approach) for step in self._steps(first)
        ]
        touching = {self._finger_of.get(name) for name in first.links}
        idle = len(touching - {None}) < len(self.tester.closer.hand.fingers)
        return [*ways, other] if idle else ways

    def _steps(self, first: Grasp) -> list[float]:
        """How far to move the point along the approach [m] to stand back from the object.

        A power grasp ends with the palm on the object: a deeper point ends there as well, and one
        less deep only counts from where the hand was drawn back to.
        """
        palm = (first.pose @ self.tester.closer.hand.T_hand_power)[:3, 3]
        drawn_back = float((first.grasp_point - palm) @ first.approach)
        return [-drawn_back - share * self.room for share in STAND_BACK]

    def _beside(self, begin: Try) -> Iterator[Try]:
        """The candidate turned and shifted a little, each way and back, and by half a turn."""
        _, point, ahead, along = begin
        side = np.cross(ahead, along)
        for sine in (np.sin(TILT), -np.sin(TILT)):
            cosine = np.sqrt(1.0 - sine**2)
            yield begin._replace(approach=cosine * ahead + sine * side)
            turned = cosine * ahead + sine * along, cosine * along - sine * ahead
            yield begin._replace(approach=turned[0], closing_axis=turned[1])
        for way in (side, -side, along, -along):
            yield begin._replace(point=point + SHIFT * self.room * way)
        yield begin._replace(closing_axis=-along)


def _fingers_reversed(tester: PowerTester) -> PowerTester:
    """The same tests with the fingers closing in reverse order: one may have barred another."""
    closer = tester.closer
    order = tuple(finger.name for finger in closer.hand.fingers)[::-1]
    return PowerTester(PowerCloser(closer.hand, closer.field, finger_order=order), tester.quality)


def _wider_open(tester: Any) -> Any:
    """The same precision tests with the pads further apart."""
    wide = copy(tester)
    wide.closer = copy(tester.closer)
    wide.closer.opening_factor = WIDE * tester.closer.opening_factor
    return wide
