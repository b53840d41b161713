"""Lab 1, planar force closure: cones, the bound, wrenches, and a test of one's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from medkit.labs.exercise import Exercise, array, near, number, require, something

Answer = Callable[..., Any]


def _direction(angle: float) -> Any:
    return np.array([np.cos(angle), np.sin(angle)])


def _cone_edges(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        normal = _direction(rng.uniform(0.0, 2.0 * np.pi))
        friction = rng.uniform(0.05, 2.0)
        edges = array(answer(normal, friction), (2, 2), "the two edges")
        along = edges @ normal
        require(along > 0.0, "an edge points out of the object: the normal points inwards")
        across = edges[:, 0] * normal[1] - edges[:, 1] * normal[0]
        opening = np.abs(across) / along
        require(
            not near(opening, np.tan(friction)),
            "the half-angle is not the friction coefficient itself: its tangent is",
        )
        require(near(opening, friction), "tan(half-angle) has to be the friction coefficient")
        require(across.prod() < 0.0, "both edges lie on the same side of the normal")


def _min_object_angle(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for friction in np.concatenate([[0.0, 1.0], rng.uniform(0.0, 3.0, cases)]):
        bound = number(answer(friction), "the bound")
        target = np.pi - 2.0 * np.arctan(friction)
        require(
            not (bound > 3.2 and near(np.radians(bound), target)),
            "that looks like degrees: medkit computes in radians",
        )
        require(
            bound < target + 1e-9,
            "the bound is too large: the chord has to lie inside both cones, so the half-angle"
            " counts twice",
        )
        require(near(bound, target), "the bound is too small: check it at friction 1 (90 deg)")


def _wrench(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        point, force, origin = rng.normal(size=(3, 2))
        wrench = array(answer(point, force, origin), (3,), "the wrench")
        require(near(wrench[:2], force), "the first two numbers are the force itself")
        arm = point - origin
        torque = arm[0] * force[1] - arm[1] * force[0]
        require(
            not near(wrench[2], -torque) or abs(torque) < 1e-6,
            "the torque has the wrong sign: counter-clockwise is positive",
        )
        require(
            not near(wrench[2], point[0] * force[1] - point[1] * force[0]),
            "the torque is taken about (0, 0): take it about the origin that is passed",
        )
        require(near(wrench[2], torque), "the torque is arm_x force_y - arm_y force_x")


def _two_contacts(tilts: Any, rng: np.random.Generator) -> tuple[Any, Any]:
    """Two contacts somewhere whose normals lean away from the chord by `tilts` [rad]."""
    turn = rng.uniform(0.0, 2.0 * np.pi)
    chord = rng.uniform(0.5, 2.0) * _direction(turn)
    normals = np.array([_direction(turn + tilts[0]), _direction(turn + np.pi + tilts[1])])
    return rng.normal(size=2) + np.array([-0.5, 0.5])[:, None] * chord, normals


def _is_force_closure(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    def verdict(points: Any, normals: Any, friction: float) -> bool:
        return bool(something(answer(points, normals, friction)))

    for case in range(cases):
        friction = rng.uniform(0.1, 1.2)
        bound = np.arctan(friction)
        # in turn the first contact slips, the second, neither, and sometimes both
        inside = np.array([case % 3 != 0, case % 3 != 1]) & (case % 7 != 6)
        share = np.where(inside, rng.uniform(0.0, 0.97, 2), rng.uniform(1.03, 1.5, 2))
        points, normals = _two_contacts(rng.choice([-1.0, 1.0], 2) * share * bound, rng)
        held = verdict(points, normals, friction)
        require(
            held or not inside.all(),
            "a grasp above the bound is called open: test both ends of the chord against the cones",
        )
        require(
            not held or inside.all(),
            "a grasp is called closed that slips out: the chord has to lie in the cones at both"
            " ends",
        )
        # turning both would push apart inside a hole, which holds as well: nobody asks for it
        turned = verdict(points, normals * [[1.0], [-1.0]], friction)
        require(not turned, "a finger that pulls is called closed: normals point inwards")
    # not quite opposite: on one line rounding would decide, and differently on other processors
    points, normals = _two_contacts([0.01, -0.01], rng)
    require(not verdict(points, normals, 0.0), "without friction two contacts never suffice")


EXERCISES = (
    Exercise("planar-1", "cone_edges", _cone_edges),
    Exercise("planar-2", "min_object_angle", _min_object_angle),
    Exercise("planar-3", "wrench", _wrench),
    Exercise("planar-4", "is_force_closure", _is_force_closure),
)
