"""The expanding polytope in plain numpy and Qhull, step by step: for pictures, and as a twin.

It does what the compiled kernel does, slowly: the hull is built anew at every step. Use `epsilon`
for numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from medkit.geometry import Floats, positive
from medkit.quality.space import wrench_rows


@dataclass(frozen=True)
class ExpansionStep:
    """The polytope before one expansion.

    Attributes
    ----------
    points : ndarray, shape (k, D)
        Its vertices, wrenches of the contacts.
    simplices : ndarray, shape (f, D)
        Its facets by vertex numbers.
    nearest : int
        The facet with the smallest signed distance from the origin.
    direction : ndarray, shape (D,)
        Outward unit normal of that facet.
    lower : float
        Its signed distance from the origin; negative while the origin is outside.
    upper : float
        How far the wrench space reaches in its direction.
    support : ndarray, shape (D,)
        The wrench that reaches that far, to be added next.
    """

    points: Floats
    simplices: NDArray[np.int_]
    nearest: int
    direction: Floats
    lower: float
    upper: float
    support: Floats


def expansion_steps(
    wrenches: ArrayLike, *, tolerance: float = 1e-9, limit: int = 200
) -> list[ExpansionStep]:
    """Expand a polytope of primitive wrenches until its nearest facet is final.

    Parameters
    ----------
    wrenches : array-like, shape (n, m, D) or (n, D)
        Primitive wrenches, for example from `Contacts.wrenches`.
    tolerance : float
        The bounds of the last step meet this closely [N].
    limit : int
        Steps after which to stop anyway.

    Returns
    -------
    list of ExpansionStep
        Empty when the wrenches do not span the space. Ends early, with an upper bound of at most
        `tolerance`, when a plane keeps the origin outside.

    Examples
    --------
    >>> corners = [[1, 1], [1, -1], [-1, 1], [-1, -1]]
    >>> [round(step.lower, 3) for step in expansion_steps(corners)]
    [0.0, 1.0]
    """
    rows = wrench_rows(wrenches)
    tolerance, most = positive(tolerance, "tolerance"), positive(limit, "limit")
    chosen = _first_simplex(rows)
    steps: list[ExpansionStep] = []
    while chosen and len(steps) < most:
        points = rows[chosen]
        hull = ConvexHull(points)
        nearest = int(np.argmax(hull.equations[:, -1]))
        direction = hull.equations[nearest, :-1]
        heights = rows @ direction
        lower, best = -float(hull.equations[nearest, -1]), int(np.argmax(heights))
        upper = float(heights[best])
        steps.append(
            ExpansionStep(points, hull.simplices, nearest, direction, lower, upper, rows[best])
        )
        if upper <= tolerance or upper - lower <= tolerance:
            break
        chosen.append(best)
    return steps


def _first_simplex(rows: Floats) -> list[int]:
    """Numbers of D + 1 rows, each as far as possible from the flat of those before it."""
    if len(rows) == 0:
        return []
    chosen = [int(np.argmax(np.linalg.norm(rows, axis=1)))]
    left = rows - rows[chosen[0]]
    for _ in range(rows.shape[1]):
        lengths = np.linalg.norm(left, axis=1)
        furthest = int(np.argmax(lengths))
        if lengths[furthest] < 1e-9:
            return []
        chosen.append(furthest)
        axis = left[furthest] / lengths[furthest]
        left = left - np.outer(left @ axis, axis)
    return chosen
