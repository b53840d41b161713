"""Distances between planned and human grasps: the two of P13 6.2.3 and the two it asks for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from medkit.arguments import number_array
from medkit.errors import InputError
from medkit.geometry import Floats, positive
from medkit.similarity.symmetry import SymmetryGroup, rotated_to, trivial_group

#: Fingers of the published measures; with fewer, sums are scaled up to this number.
FINGER_COUNT = 5


@dataclass(frozen=True)
class NearestHuman:
    """For each planned grasp the nearest recording."""

    distance: Floats  # (n,) [m]
    index: np.ndarray  # (n,) row of the recording


def d_eucl(planned: ArrayLike, human: ArrayLike) -> Floats:
    """Euclidean distance of all fingertip coordinates (P13 6.2.3, equation 6.4).

    Parameters
    ----------
    planned : array-like, shape (n, k, 3) or (k, 3)
        Fingertips of planned grasps [m], in the object's frame, k = 5 in the published form.
    human : array-like, shape (k, 3) or (m, k, 3)
        Fingertips of one grasp [m], or of the trials of one subject, which are averaged first.

    Returns
    -------
    ndarray, shape (n,) or ()
        Distances [m]. With k < 5 fingers the sum is scaled by 5 / k, so that hands compare.

    Raises
    ------
    InputError
        If shapes do not fit or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> float(d_eucl(np.zeros((5, 3)), np.full((5, 3), 0.01)).round(6))
    0.03873
    """
    grasps, mean, single = _pair(planned, human)
    return _result(np.sum((grasps - mean) ** 2, axis=(1, 2)), grasps.shape[1], single)


def d_z(planned: ArrayLike, human: ArrayLike) -> Floats:
    """Distance of the heights alone (P13 6.2.3, equation 6.5); z points up from the table.

    Parameters
    ----------
    planned : array-like, shape (n, k, 3) or (k, 3)
        Fingertips of planned grasps [m], in the object's frame.
    human : array-like, shape (k, 3) or (m, k, 3)
        Fingertips of one grasp [m], or of the trials of one subject, which are averaged first.

    Returns
    -------
    ndarray, shape (n,) or ()
        Distances [m].

    Raises
    ------
    InputError
        If shapes do not fit or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> float(d_z(np.zeros((5, 3)), np.ones((5, 3)) * [1.0, 2.0, 0.0]))
    0.0
    """
    grasps, mean, single = _pair(planned, human)
    return _result(np.sum((grasps[..., 2] - mean[..., 2]) ** 2, axis=1), grasps.shape[1], single)


def d_symmetric(planned: ArrayLike, human: ArrayLike, *, group: SymmetryGroup) -> Floats:
    """Least `d_eucl` over the rotations that map the object onto itself (answers P13 6.2.5).

    Parameters
    ----------
    planned : array-like, shape (n, k, 3) or (k, 3)
        Fingertips of planned grasps [m], in the object's frame.
    human : array-like, shape (k, 3) or (m, k, 3)
        Fingertips of one grasp [m], or of the trials of one subject, which are averaged first.
    group : SymmetryGroup
        From `symmetry_group_from_mesh`, or one of the groups of `medkit.similarity.symmetry`.

    Returns
    -------
    ndarray, shape (n,) or ()
        Distances [m]: unchanged when either grasp is turned by any element of the group.

    Raises
    ------
    InputError
        If shapes do not fit or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from medkit.similarity.symmetry import revolution_group
    >>> grasp = np.random.default_rng(1).normal(size=(5, 3))
    >>> turned = grasp @ np.diag([-1.0, -1.0, 1.0])  # half a turn about z
    >>> bool(d_symmetric(grasp, turned, group=revolution_group([0, 0, 1])) < 1e-12)
    True
    """
    grasps, mean, single = _pair(planned, human)
    turned = rotated_to(grasps, mean[None], group)[:, 0]
    return _result(np.sum((grasps - turned) ** 2, axis=(1, 2)), grasps.shape[1], single)


def nearest_human(
    planned: ArrayLike, recordings: ArrayLike, *, group: SymmetryGroup | None = None
) -> NearestHuman:
    """Distance to the nearest recorded grasp: no average, so scattered data do no harm.

    Parameters
    ----------
    planned : array-like, shape (n, k, 3) or (k, 3)
        Fingertips of planned grasps [m], in the object's frame.
    recordings : array-like, shape (m, k, 3)
        Fingertips of the recorded grasps [m], of one subject or of all.
    group : SymmetryGroup, optional
        Rotations that change nothing; none if left out.

    Returns
    -------
    NearestHuman
        Distances (n,) [m] and rows (n,) of the nearest recordings.

    Raises
    ------
    InputError
        If shapes do not fit, a number is not finite, or there is no recording.

    Examples
    --------
    >>> import numpy as np
    >>> nearest_human(np.zeros((1, 5, 3)), [np.ones((5, 3)), np.zeros((5, 3))]).index
    array([1])
    """
    distances = distance_table(planned, recordings, group=group)
    index = np.argmin(distances, axis=1)
    return NearestHuman(distances[np.arange(len(distances)), index], index)


def share_within(
    planned: ArrayLike, recordings: ArrayLike, *, radius: float, group: SymmetryGroup | None = None
) -> Floats:
    """Share of the recordings within a distance of each planned grasp (P13 6.2.5).

    Parameters
    ----------
    planned : array-like, shape (n, k, 3) or (k, 3)
        Fingertips of planned grasps [m].
    recordings : array-like, shape (m, k, 3)
        Fingertips of the recorded grasps [m].
    radius : float
        Distance [m].
    group : SymmetryGroup, optional
        Rotations that change nothing; none if left out.

    Returns
    -------
    ndarray, shape (n,)
        Shares between 0 and 1.

    Raises
    ------
    InputError
        If shapes do not fit, a number is not finite, or the radius is not above zero.

    Examples
    --------
    >>> import numpy as np
    >>> share_within(np.zeros((1, 5, 3)), [np.ones((5, 3)), np.zeros((5, 3))], radius=0.1)
    array([0.5])
    """
    limit = positive(radius, "radius", " m")
    return np.asarray((distance_table(planned, recordings, group=group) <= limit).mean(axis=1))


def distance_table(
    planned: ArrayLike, recordings: ArrayLike, *, group: SymmetryGroup | None = None
) -> Floats:
    """Distances (n, m) [m] of every planned grasp to every recording, reduced by `group`."""
    grasps = fingertip_array(planned, "planned grasps")
    people = fingertip_array(recordings, "recordings")
    _same_fingers(grasps, people)
    turned = rotated_to(grasps, people, group if group is not None else trivial_group())
    squared = np.sum((grasps[:, None] - turned) ** 2, axis=(2, 3))
    return np.asarray(np.sqrt(squared * FINGER_COUNT / grasps.shape[1]))


def fingertip_array(fingertips: ArrayLike, name: str) -> Floats:
    """Check fingertips and return them as an array of shape (n, k, 3) [m].

    Raises
    ------
    InputError
        If the shape is another, there is no grasp, or a number is not finite.
    """
    remedy = "pass one row of three coordinates per finger"
    array = number_array(fingertips, f"fingertips of {name}", remedy)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[2] != 3 or 0 in array.shape:
        raise InputError(
            f"Expected fingertips of {name} of shape (n, fingers, 3), but got shape"
            f" {np.shape(fingertips)}; {remedy}."
        )
    spoilt = np.flatnonzero(~np.isfinite(array).all(axis=(1, 2)))
    if spoilt.size:
        raise InputError(
            f"Expected finite fingertips of {name}, but grasp {spoilt[0]} is not;"
            " leave it out, or compare fewer fingers."
        )
    return array


def _pair(planned: ArrayLike, human: ArrayLike) -> tuple[Floats, Floats, bool]:
    grasps = fingertip_array(planned, "planned grasps")
    people = fingertip_array(human, "human grasps")
    _same_fingers(grasps, people)
    return grasps, people.mean(axis=0), np.ndim(planned) == 2


def _same_fingers(grasps: Floats, people: Floats) -> None:
    if grasps.shape[1] != people.shape[1]:
        raise InputError(
            f"Expected the same fingers on both sides, but the planned grasps have"
            f" {grasps.shape[1]} and the human ones {people.shape[1]};"
            " use medkit.similarity.correspondence."
        )


def _result(squared: Floats, fingers: int, single: bool) -> Floats:
    distances = np.sqrt(squared * FINGER_COUNT / fingers)
    return np.asarray(distances[0] if single else distances)
