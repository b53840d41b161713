"""Lab 2, the medial axis: object angle, the ball through two points, shrinking it, symmetry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from medkit.labs.exercise import Exercise, array, near, number, require

Answer = Callable[..., Any]


def _units(rng: np.random.Generator, count: int) -> Any:
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _object_angle(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for case in range(cases):
        center, radius = rng.normal(size=3), rng.uniform(0.1, 2.0)
        directions = _units(rng, 2 + case % 5)
        if case % 4 == 0:
            directions[1] = -directions[0]
        angle = number(answer(center, center + radius * directions), "the angle")
        cosines = np.clip(directions @ directions.T, -1.0, 1.0)
        target = float(np.arccos(cosines.min()))
        require(angle <= np.pi + 1e-9, "an angle above pi looks like degrees: use radians")
        first = float(np.arccos(cosines[0, 1]))
        require(
            near(angle, target, 1e-5) or not near(angle, first, 1e-5),
            "only the first two touch points are used: take the largest angle over all pairs",
        )
        require(
            near(angle, target, 1e-5), "the angle is measured at the centre, between touch points"
        )


def _ball_radius(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        point, center = rng.normal(size=(2, 3))
        target = float(np.linalg.norm(center - point))
        normal = (point - center) / target
        other = center + target * _units(rng, 1)[0]
        radius = number(answer(point, normal, other), "the radius")
        require(
            not near(radius, -target),
            "the radius is negative: the normal points outwards, the centre lies against it",
        )
        require(
            not near(radius, 2.0 * target),
            "that is the diameter: the distance enters squared over two",
        )
        require(
            near(radius, target, 1e-5 * max(1.0, target)),
            "the centre point - r normal has to be as far from other as from point",
        )


def _surface(rng: np.random.Generator, count: int = 300) -> tuple[Any, Any]:
    """Points of an ellipsoid (1, 0.7, 0.5) with outward normals."""
    axes = np.array([1.0, 0.7, 0.5])
    directions = _units(rng, count)
    gradient = directions / axes
    return directions * axes, gradient / np.linalg.norm(gradient, axis=1, keepdims=True)


def _shrink(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(max(3, cases // 10)):
        points, normals = _surface(rng)
        start = int(rng.integers(len(points)))
        center = array(answer(points[start], normals[start], points), (3,), "the centre")
        radius = np.linalg.norm(center - points[start])
        away = points[start] - center
        require(
            near(np.cross(away, normals[start]), 0.0, 1e-5) and away @ normals[start] > 0.0,
            "the centre has to lie on the inward normal of the point",
        )
        distance = np.linalg.norm(points - center, axis=1)
        require(
            distance.min() > radius - 1e-6,
            "a point lies inside the ball: shrink again until the nearest point is on it",
        )
        others = np.delete(distance, start)
        require(
            others.min() < radius + 1e-5,
            "the ball touches only its first point: it was shrunk too far",
        )


def _symmetry_ratio(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for case in range(cases):
        spread = np.array([[1.0, 0.05, 0.02], [1.0, 0.8, 0.05], [1.0, 0.3, 0.3]])[case % 3]
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        centers = rng.normal(size=(60, 3)) * spread @ turn.T + 10.0 * rng.normal(size=3)
        ratio = number(answer(centers), "the ratio")
        values = np.sort(np.linalg.eigvalsh(np.cov(centers.T)))[::-1]
        target = values[1] / values[0]
        require(
            not near(ratio, np.sqrt(target), 1e-9),
            "that is the ratio of standard deviations: eigenvalues are variances",
        )
        require(0.0 <= ratio <= 1.0, "the ratio is the second largest over the largest eigenvalue")
        require(
            near(ratio, target, 1e-6),
            "subtract the mean before the covariance, then divide the second eigenvalue by the"
            " first",
        )


EXERCISES = (
    Exercise("medial-1", "object_angle", _object_angle),
    Exercise("medial-2", "ball_radius", _ball_radius),
    Exercise("medial-3", "shrink", _shrink),
    Exercise("medial-4", "symmetry_ratio", _symmetry_ratio),
)
