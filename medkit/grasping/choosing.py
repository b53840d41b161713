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

    P13 5.1.3 tests about 300 candidates an object. Spheres are numbered by their distance from
    the middle of all, so that the same ones are drawn however the object lies in its frame.

    Parameters
    ----------
    candidates : CandidateGrasps
        All n candidates.
    most : int or None
        How many to keep at most; None for all. The last sphere may lose some of its candidates.
    rng : numpy.random.Generator
        Draws the spheres; untouched when nothing has to be left out.

    Returns
    -------
    CandidateGrasps
        Those kept, in their order.

    Raises
    ------
    InputError
        If `most` is below 1.

    Examples
    --------
    >>> from medkit.grasping.candidate_set import CandidateGrasps
    >>> x = np.array([0.0, 0.0, 0.1, 0.1, 0.3, 0.3])
    >>> points = np.stack([x, 0 * x, 0 * x], axis=1)
    >>> sphere, kind = np.array([7, 7, 2, 2, 5, 5]), np.zeros(6, dtype=np.int8)
    >>> six = CandidateGrasps(points, points, points, sphere, kind, np.full(6, 0.01), kind)
    >>> choose_candidates(six, 4, np.random.default_rng(0)).sphere.tolist()
    [2, 2, 5, 5]
    """
    if _few_enough(candidates, most):
        return candidates
    number = sphere_numbers(candidates)
    place = np.argsort(rng.permutation(number.max() + 1))
    order = np.argsort(place[number], kind="stable")
    return candidates.select(np.sort(order[:most]))


def sphere_numbers(candidates: CandidateGrasps) -> NDArray[np.int64]:
    """Number of each candidate's sphere, counted by distance from the middle of all.

    Parameters
    ----------
    candidates : CandidateGrasps
        At least one candidate; those of one sphere share `sphere`.

    Returns
    -------
    ndarray of int, shape (n,)
        0 for the sphere whose grasp point is nearest to the mean of all spheres' grasp points;
        spheres at equal distance are in the order of their rows.

    Examples
    --------
    >>> from medkit.grasping.candidate_set import CandidateGrasps
    >>> x = np.array([0.0, 0.0, 0.1, 0.1, 0.3, 0.3])
    >>> points = np.stack([x, 0 * x, 0 * x], axis=1)
    >>> sphere, kind = np.array([7, 7, 2, 2, 5, 5]), np.zeros(6, dtype=np.int8)
    >>> six = CandidateGrasps(points, points, points, sphere, kind, np.full(6, 0.01), kind)
    >>> sphere_numbers(six).tolist()
    [1, 1, 0, 0, 2, 2]
    """
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

    Parameters
    ----------
    candidates : CandidateGrasps
        All n candidates.
    most : int or None
        How many to keep at most; None for all.
    rng : numpy.random.Generator
        Draws them; untouched when nothing has to be left out.

    Returns
    -------
    CandidateGrasps
        Those kept, in their order.

    Raises
    ------
    InputError
        If `most` is below 1.

    Examples
    --------
    >>> from medkit.grasping.candidate_set import CandidateGrasps
    >>> x = np.array([0.0, 0.0, 0.1, 0.1, 0.3, 0.3])
    >>> points = np.stack([x, 0 * x, 0 * x], axis=1)
    >>> sphere, kind = np.array([7, 7, 2, 2, 5, 5]), np.zeros(6, dtype=np.int8)
    >>> six = CandidateGrasps(points, points, points, sphere, kind, np.full(6, 0.01), kind)
    >>> len(spread_candidates(six, 4, np.random.default_rng(0)))
    4
    """
    if _few_enough(candidates, most):
        return candidates
    order = np.argsort(sphere_numbers(candidates), kind="stable")
    drawn = order[rng.permutation(len(candidates))[:most]]
    return candidates.select(np.sort(drawn))


def _few_enough(candidates: CandidateGrasps, most: int | None) -> bool:
    """Whether nothing has to be left out; `InputError` where nothing could be kept."""
    if most is not None and most < 1:
        raise InputError(f"Expected at least one candidate, but got {most}; give a larger number.")
    return most is None or len(candidates) <= most
