"""Lab 3, the planner: directions around an axis, across a rim, the hand's rotation, a yield."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from medkit.geometry import perpendicular, random_rotation
from medkit.labs.exercise import Exercise, array, near, require

Answer = Callable[..., Any]


def _axis_approaches(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for case in range(cases):
        axis = random_rotation(rng)[0]
        steps = 3 + case % 6
        approaches = array(answer(axis, steps), (steps, 3), "the approach directions")
        require(near(np.linalg.norm(approaches, axis=1), 1.0), "a direction has to have length one")
        require(near(approaches @ axis, 0.0), "a direction has to be at right angles to the axis")
        step = np.arccos(
            np.clip(np.einsum("ij,ij->i", approaches, np.roll(approaches, -1, 0)), -1, 1)
        )
        require(
            near(step, 2.0 * np.pi / steps, 1e-5),
            "neighbours have to be 2 pi / steps apart, all the way round (first and last included)",
        )


def _rim_approach(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        along, across, _ = random_rotation(rng)
        center = rng.normal(size=3)
        inwards = rng.choice([-1.0, 1.0])
        centroid = center + inwards * rng.uniform(0.2, 1.0) * across + 0.3 * rng.normal() * along
        approach = array(answer(center, centroid, across), (3,), "the approach direction")
        require(near(np.linalg.norm(approach), 1.0), "a direction has to have length one")
        require(
            near(np.abs(approach @ across), 1.0),
            "the hand comes across the rim: along e2, not towards the centroid itself",
        )
        require(
            approach @ (centroid - center) > 0.0,
            "the hand would come out of the object: it moves from outside towards the centroid",
        )


def _hand_rotation(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        hand, target = random_rotation(rng), random_rotation(rng)
        palm, axis = hand[:, 0], hand[:, 1]
        approach, closing = target[:, 0], target[:, 1]
        rotation = array(answer(palm, axis, approach, closing), (3, 3), "the rotation")
        require(near(rotation @ rotation.T, np.eye(3), 1e-6), "the matrix is not orthonormal")
        require(
            np.linalg.det(rotation) > 0.0, "that is a reflection: the third axes differ in sign"
        )
        backwards = near(rotation.T @ palm, approach, 1e-6)
        require(
            not backwards or near(rotation @ palm, approach, 1e-6),
            "that is the inverse: the rotation has to map the hand's axes onto the object's",
        )
        require(near(rotation @ palm, approach, 1e-6), "the palm direction misses the approach")
        require(near(rotation @ axis, closing, 1e-6), "the hand axis misses the closing axis")
    helper = perpendicular(np.eye(3)[0])
    array(answer(np.eye(3)[0], helper, np.eye(3)[0], helper), (3, 3), "the rotation")


def _yield_interval(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        tested = int(rng.integers(5, 400))
        found = int(rng.integers(0, tested + 1))
        low, high = array(answer(found, tested), (2,), "the interval (low, high)")
        share = found / tested
        require(
            low <= share + 1e-9 and high >= share - 1e-9, "the interval misses the yield itself"
        )
        require(
            low >= -1e-12 and high <= 1.0 + 1e-12,
            "a yield below 0 or above 1: the normal interval p +- 1.96 s fails near the ends, take"
            " Wilson's",
        )
        require(
            high > low,
            "an interval of length zero says nothing is left to learn: take Wilson's near 0 and 1",
        )
    for share in (0.5, 0.9):
        hits, draws = 0, 400
        for found in rng.binomial(40, share, draws):
            low, high = answer(int(found), 40)
            hits += int(low <= share <= high)
        require(hits > 0.90 * draws, "the interval is too short: it misses the truth too often")
        require(hits < 0.998 * draws, "the interval is too long: 95 % is what is asked for")


EXERCISES = (
    Exercise("planner-1", "axis_approaches", _axis_approaches),
    Exercise("planner-2", "rim_approach", _rim_approach),
    Exercise("planner-3", "hand_rotation", _hand_rotation),
    Exercise("planner-4", "yield_interval", _yield_interval),
)
