"""Which of all candidates are tested: draws that know neither the mesh's frame nor its order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.grasping.candidate_set import CandidateGrasps


def choose_candidates(
    candidates: CandidateGrasps, most: int | None, rng: np.random.Generator
) -> CandidateGrasps:
    """At most so many candidates: all those of spheres drawn without replacement, in order.

    Spheres are numbered by their distance from the middle of all, so that the same ones are
    drawn however the object lies in its frame.
    """
    if most is not None and most < 1:
        raise InputError(f"Expected at least one candidate, but got {most}; give a larger number.")
    if most is None or len(candidates) <= most:
        return candidates
    number = sphere_numbers(candidates)
    place = np.argsort(rng.permutation(number.max() + 1))
    order = np.argsort(place[number], kind="stable")
    return candidates.select(np.sort(order[:most]))


def sphere_numbers(candidates: CandidateGrasps) -> NDArray[np.int64]:
    """Number (n,) of each candidate's sphere, counted by distance from the middle of all."""
    _, first, group = np.unique(candidates.sphere, return_index=True, return_inverse=True)
    points = candidates.grasp_point[first]
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return np.argsort(np.argsort(away, kind="stable"), kind="stable")[group]


def spread_candidates(
    candidates: CandidateGrasps, most: int | None, rng: np.random.Generator
) -> CandidateGrasps:
    """At most so many candidates, drawn one by one and evenly from all.

    The published planner draws spheres and takes all candidates of each: few spheres, many alike.
    Spheres are numbered by their distance from the middle of all, so that the same ones are drawn
    in whatever order they come.
    """
    if most is not None and most < 1:
        raise InputError(f"Expected at least one candidate, but got {most}; give a larger number.")
    if most is None or len(candidates) <= most:
        return candidates
    order = np.argsort(sphere_numbers(candidates), kind="stable")
    drawn = order[rng.permutation(len(candidates))[:most]]
    return candidates.select(np.sort(drawn))
