"""Lab 4, handover ratings: a score, ordinal probabilities, a permutation test, a release force."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from medkit.labs.exercise import Exercise, array, near, number, require

Answer = Callable[..., Any]


def _score(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        good, acceptable, bad = (int(n) for n in rng.integers(0, 5, 3))
        if good + acceptable + bad == 0:
            continue
        value = number(answer(good, acceptable, bad), "the score")
        total = good + acceptable + bad
        require(
            not near(value, (good + 0.5 * acceptable) / 4.0)
            or total == 4
            or good + acceptable == 0,
            "four is not always the number of ratings: divide by how many there are",
        )
        require(
            near(value, (good + 0.5 * acceptable) / total),
            "good counts 1, acceptable 0.5, bad 0, and the mean is taken over all ratings",
        )


def _probabilities(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        predictor = rng.normal(scale=2.0)
        low = rng.normal()
        high = low + rng.uniform(0.2, 3.0)
        shares = array(answer(predictor, low, high), (3,), "the three probabilities")
        require(near(shares.sum(), 1.0), "the three probabilities have to add up to one")
        require(shares >= 0.0, "a probability is negative: subtract the cumulative ones in order")
        cumulative = 1.0 / (1.0 + np.exp(-(np.array([low, high]) - predictor)))
        target = np.diff(np.concatenate([[0.0], cumulative, [1.0]]))
        require(
            not near(shares, target[::-1]) or near(target, target[::-1]),
            "the order is bad, acceptable, good: a larger predictor means a better rating",
        )
        require(near(shares, target), "P(rating <= k) is the logistic of threshold_k - predictor")


def _permutation(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for case in range(max(6, cases // 10)):
        subjects = 3 + case % 6
        # mean scores of four ratings are eighths: their sums are exact, so ties stay ties
        differences = np.round(8.0 * rng.normal(loc=0.6, size=subjects)) / 8.0
        value = number(answer(differences), "the p-value")
        signs = np.array(np.meshgrid(*[[-1, 1]] * subjects)).reshape(subjects, -1).T
        sums, observed = signs @ differences, differences.sum()
        target = float((np.abs(sums) >= abs(observed)).mean())
        require(0.0 <= value <= 1.0, "a p-value lies between 0 and 1")
        require(
            near(value, target) or not near(value, (sums >= observed).mean()),
            "that is the one-sided value: compare absolute means",
        )
        require(
            near(value, target) or not near(value, (np.abs(sums) > abs(observed)).mean()),
            "ties count, and the observed signs are one of the ways: at least as large, not larger",
        )
        require(
            near(value, target),
            "turn the sign of every subject's difference, in all 2^n ways, and count how often the"
            " absolute mean is at least as large as the one observed",
        )


def _release_force(answer: Answer, rng: np.random.Generator, cases: int) -> None:
    for _ in range(cases):
        forces = np.sort(rng.uniform(0.5, 20.0, 9))
        scores = np.sort(rng.uniform(0.05, 0.95, 9))[::-1]
        level = rng.uniform(scores[-1] + 0.01, scores[0] - 0.01)
        force = number(answer(forces, scores, level), "the force")
        require(
            forces[0] - 1e-9 <= force <= forces[-1] + 1e-9, "the force lies outside the data: [N]"
        )
        reached = float(np.interp(force, forces, scores))
        require(
            near(reached, level, 1e-6),
            "at this force the score is not the level: np.interp needs growing x, and scores fall",
        )


EXERCISES = (
    Exercise("statistics-1", "score", _score),
    Exercise("statistics-2", "rating_probabilities", _probabilities),
    Exercise("statistics-3", "permutation_p_value", _permutation),
    Exercise("statistics-4", "release_force", _release_force),
)
