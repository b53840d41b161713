"""Ways of grasping in scattered recordings (P13 6.2.5), with the answer "none" allowed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.cluster.hierarchy import fcluster, linkage

from medkit.arguments import generator, whole
from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.similarity.measures import distance_table, fingertip_array
from medkit.similarity.symmetry import SymmetryGroup, rotated_to

#: Prediction strength above which a division counts (Tibshirani and Walther 2005).
STRENGTH = 0.8


@dataclass(frozen=True)
class Clusters:
    """Groups of similar grasps; `count` 1 means that the data have none."""

    labels: np.ndarray  # (m,) from 0, by falling size
    count: int
    gap: Floats  # (k_max,) gap statistic for 1, 2, ... clusters
    gap_error: Floats  # (k_max,) its standard error
    strength: Floats  # (k_max,) prediction strength; 1 for one cluster

    @property
    def found(self) -> bool:
        """Whether the recordings fall into clusters at all."""
        return self.count > 1


def find_clusters(
    fingertips: ArrayLike, *, rng: np.random.Generator, most: int = 6, references: int = 20
) -> Clusters:
    """Divide grasps into clusters, if two criteria agree that there are any (P13 6.2.5).

    The gap statistic (Tibshirani, Walther and Hastie 2001) proposes the smallest number k whose
    gap is not beaten by that of k + 1 by more than its standard error, against data spread evenly
    over the box of their principal axes. The division then has to be repeatable: found again in
    the other half of the data by at least `STRENGTH` of the pairs in every cluster. The first test
    turns down an elongated cloud, the second a ring. If either fails the answer is one cluster.

    Parameters
    ----------
    fingertips : array-like, shape (m, k, 3)
        Recorded grasps [m]; at least ten.
    rng : numpy.random.Generator
        Draws the reference data and the halves.
    most : int
        Largest number of clusters tried.
    references : int
        Reference sets, and divisions into halves.

    Returns
    -------
    Clusters
        Labels by Ward's method, and both criteria for every number.

    Raises
    ------
    InputError
        If there are fewer than ten grasps, or `rng`, `most` or `references` do not fit.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> find_clusters(rng.normal(size=(30, 5, 3)), rng=rng).found
    False
    """
    array = fingertip_array(fingertips, "recordings")
    if len(array) < 10:
        raise InputError(
            f"Expected at least ten grasps to look for clusters, but got {len(array)}; record more."
        )
    data = _principal(array.reshape(len(array), -1))
    most = min(whole(most, "most"), len(data) // 5)
    references = whole(references, "references")
    generator(rng)
    gap, error = _gap_statistic(data, most, references, rng)
    strength = _prediction_strength(data, most, references, rng)
    accepted = [k for k in range(1, most) if gap[k - 1] >= gap[k] - error[k]]
    count = accepted[0] if accepted else most
    if strength[count - 1] < STRENGTH:
        count = 1
    return Clusters(_labels(data, count), count, gap, error, strength)


def aligned(fingertips: ArrayLike, group: SymmetryGroup) -> Floats:
    """Turn recordings by the object's own rotations onto the most central of them, (m, k, 3) [m].

    Without this a cylinder's recordings scatter around its axis though nothing physical differs.
    """
    array = fingertip_array(fingertips, "recordings")
    central = int(np.argmin(np.median(distance_table(array, array, group=group), axis=1)))
    return rotated_to(array[[central]], array, group)[0]


def _principal(vectors: Floats) -> Floats:
    """Coordinates along the principal axes that carry 99 % of the variance."""
    centred = vectors - vectors.mean(axis=0)
    left, sizes, _ = np.linalg.svd(centred, full_matrices=False)
    share = np.cumsum(sizes**2) / max(float(np.sum(sizes**2)), 1e-300)
    return np.asarray((left * sizes)[:, : int(np.searchsorted(share, 0.99)) + 1])


def _labels(data: Floats, count: int) -> np.ndarray:
    raw = fcluster(linkage(data, "ward"), count, criterion="maxclust")
    names, sizes = np.unique(raw, return_counts=True)
    rank = {name: place for place, name in enumerate(names[np.argsort(-sizes, kind="stable")])}
    return np.array([rank[name] for name in raw])


def _scatters(data: Floats, most: int) -> Floats:
    """Logarithm of the scatter within clusters, for 1 to `most` clusters."""
    tree = linkage(data, "ward")
    values = []
    for count in range(1, most + 1):
        labels = fcluster(tree, count, criterion="maxclust")
        parts = [data[labels == name] for name in np.unique(labels)]
        within = sum(float(np.sum((part - part.mean(axis=0)) ** 2)) for part in parts)
        values.append(np.log(max(within, 1e-300)))
    return np.array(values)


def _gap_statistic(
    data: Floats, most: int, references: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    low, high = data.min(axis=0), data.max(axis=0)
    even = np.stack(
        [_scatters(rng.uniform(low, high, size=data.shape), most) for _ in range(references)]
    )
    error = even.std(axis=0) * np.sqrt(1.0 + 1.0 / references)
    return even.mean(axis=0) - _scatters(data, most), error


def _prediction_strength(
    data: Floats, most: int, divisions: int, rng: np.random.Generator
) -> Floats:
    """Mean over halvings of the least share of pairs that the other half also puts together."""
    strengths = np.ones((divisions, most))
    for row in range(divisions):
        order = rng.permutation(len(data))
        one, two = data[order[::2]], data[order[1::2]]
        for count in range(2, most + 1):
            strengths[row, count - 1] = _repeatability(one, two, count)
    return np.asarray(strengths.mean(axis=0))


def _repeatability(learnt: Floats, tried: Floats, count: int) -> float:
    labels, own = _labels(learnt, count), _labels(tried, count)
    centres = np.stack([learnt[labels == name].mean(axis=0) for name in np.unique(labels)])
    predicted = np.argmin(np.linalg.norm(tried[:, None] - centres, axis=2), axis=1)
    shares = []
    for name in np.unique(own):
        members = predicted[own == name]
        if len(members) > 1:
            pairs = members[:, None] == members[None, :]
            shares.append((pairs.sum() - len(members)) / (len(members) * (len(members) - 1)))
    return float(min(shares)) if shares else 0.0
