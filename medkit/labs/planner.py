"""Lab 3, the planner: directions around an axis, across a rim, the hand's rotation, a yield."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import binom

from medkit.geometry import perpendicular, random_rotation
from medkit.labs.exercise import Exercise, array, near, require, something

Answer = Callable[..., Any]


def _axis_approaches(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    # the axes of the frame come first: a helper vector that is always the same is along one of them
    along = np.concatenate([np.eye(3), -np.eye(3)])
    for case in range(len(along) + cases):
        axis = along[case] if case < len(along) else random_rotation(rng)[0]
        steps = 3 + case % 6
        with np.errstate(all="ignore"):
            came = something(answer(axis, steps))
        require(
            case >= len(along) or np.isfinite(np.asarray(came, dtype=float)).all(),
            f"for the axis {axis} the directions are no numbers: the cross product with a vector"
            " along the axis is zero, so choose the helper by the axis",
        )
        approaches = array(came, (steps, 3), "the approach directions")
        require(near(np.linalg.norm(approaches, axis=1), 1.0), "a direction has to have length one")
        require(near(approaches @ axis, 0.0), "a direction has to be at right angles to the axis")
        across = np.cross(axis, approaches[0])
        turns = np.sort(np.arctan2(approaches @ across, approaches @ approaches[0]) % (2.0 * np.pi))
        gaps = np.diff(np.append(turns, turns[0] + 2.0 * np.pi))
        require(
            near(gaps, 2.0 * np.pi / steps, 1e-5),
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
    def interval(found: int, tested: int) -> Any:
        return array(answer(found, tested), (2,), "the interval (low, high)")

    drawn = [int(n) for n in rng.integers(5, 400, cases)]
    pairs = [(int(rng.integers(0, tested + 1)), tested) for tested in drawn]
    for found, tested in [(0, 30), (30, 30), (1, 12), *pairs]:
        low, high = interval(found, tested)
        # an equal-tailed Jeffreys interval leaves out a yield of 0 by 0.0005 of a candidate
        slack = 0.01 / tested
        require(
            low <= found / tested + slack and high >= found / tested - slack,
            f"the interval misses the yield itself (found {found}, tested {tested})",
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
    covered = _mean_coverage(np.array([interval(found, 40) for found in range(41)]))
    # Wilson 0.952, Jeffreys 0.949, Agresti-Coull 0.957, Clopper-Pearson 0.969, normal 0.925
    require(covered > 0.94, "the interval is too short: it misses the truth too often")
    require(covered < 0.98, "the interval is too long: 95 % is what is asked for")


def _mean_coverage(intervals: Any) -> float:
    """How often intervals for 0 to n found of n hold the true yield, averaged over yields."""
    count = len(intervals) - 1
    truth = np.linspace(0.05, 0.95, 181)[:, None]
    chance = binom.pmf(np.arange(count + 1), count, truth)
    return float((chance * ((intervals[:, 0] <= truth) & (truth <= intervals[:, 1]))).sum(1).mean())


EXERCISES = (
    Exercise("planner-1", "axis_approaches", _axis_approaches),
    Exercise("planner-2", "rim_approach", _rim_approach),
    Exercise("planner-3", "hand_rotation", _hand_rotation),
    Exercise("planner-4", "yield_interval", _yield_interval),
)
