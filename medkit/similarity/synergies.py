"""Postural synergies: principal components of the joint angles of many grasps (P13 2.4)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats

#: The fifteen angles of Santello, Flanders and Soechting (1998), fingers index to little.
JOINTS = (
    "thumb_rotation", "thumb_abduction", "thumb_mcp", "thumb_ip",
    "index_mcp", "index_pip", "middle_mcp", "middle_pip",
    "ring_mcp", "ring_pip", "little_mcp", "little_pip",
    "index_middle_abduction", "middle_ring_abduction", "ring_little_abduction",
)  # fmt: skip


@dataclass(frozen=True)
class Synergies:
    """Principal components of hand postures."""

    joints: tuple[str, ...]
    mean: Floats  # (d,) [rad]
    components: Floats  # (d, d) rows of length one, by falling variance
    variance: Floats  # (d,) [rad^2] along them

    @property
    def share(self) -> Floats:
        """Share of the whole variance that the first 1, 2, ... components carry, shape (d,)."""
        return np.asarray(np.cumsum(self.variance) / np.sum(self.variance))

    def weights(self, postures: ArrayLike) -> Floats:
        """Coordinates (n, d) [rad] of postures (n, d) [rad] along the components."""
        return np.asarray((np.asarray(postures, dtype=float) - self.mean) @ self.components.T)

    def posture(self, weights: ArrayLike) -> Floats:
        """Postures (n, d) [rad] from weights (n, k) [rad] of the first k components."""
        array = np.atleast_2d(np.asarray(weights, dtype=float))
        return np.asarray(self.mean + array @ self.components[: array.shape[1]])


def synergies_from_postures(postures: ArrayLike, *, joints: tuple[str, ...] = JOINTS) -> Synergies:
    """Principal component analysis of joint angles, as Santello et al. did (P13 2.4).

    Parameters
    ----------
    postures : array-like, shape (n, d)
        Joint angles of n grasps [rad].
    joints : tuple of str
        Names of the d joints.

    Returns
    -------
    Synergies
        Components with signs such that the largest entry of each is positive.

    Raises
    ------
    InputError
        If there are no more grasps than joints, an angle is not finite, or all are equal.

    Examples
    --------
    >>> angles = np.random.default_rng(1).normal(size=(40, 2)) * [1.0, 0.1]
    >>> synergies_from_postures(angles, joints=("a", "b")).share.round(2)
    array([0.99, 1.  ])
    """
    array = np.asarray(postures, dtype=float)
    if array.ndim != 2 or array.shape[1] != len(joints) or len(array) <= array.shape[1]:
        raise InputError(
            f"Expected more grasps than joints, shape (n, {len(joints)}) with n > {len(joints)},"
            f" but got {array.shape}; record more grasps."
        )
    if not np.all(np.isfinite(array)) or np.ptp(array) == 0.0:
        raise InputError(
            "Expected finite joint angles that differ, but they do not; leave such grasps out."
        )
    mean = array.mean(axis=0)
    _, sizes, components = np.linalg.svd(array - mean, full_matrices=False)
    largest = components[np.arange(len(components)), np.argmax(np.abs(components), axis=1)]
    return Synergies(tuple(joints), mean, components * np.sign(largest)[:, None],
                     sizes**2 / (len(array) - 1))  # fmt: skip


def load_postures(path: str | os.PathLike[str], *, angle_unit: str) -> pd.DataFrame:
    """Read recorded joint angles: columns subject, object, trial and one per joint.

    Parameters
    ----------
    path : path-like
        CSV file.
    angle_unit : {"rad", "deg"}
        Unit in the file; it must be said.

    Returns
    -------
    pandas.DataFrame
        The same table with angles [rad].

    Raises
    ------
    InputError
        If the file cannot be read, has no joint columns, or an angle is beyond a full turn.
    """
    factors = {"rad": 1.0, "deg": np.pi / 180.0}
    if angle_unit not in factors:
        raise InputError(f"Expected the angle unit rad or deg, but got {angle_unit!r}.")
    try:
        table = pd.read_csv(path)
        labels = table[["subject", "object", "trial"]]
        angles = table.drop(columns=list(labels.columns)).astype(float) * factors[angle_unit]
    except (OSError, ValueError, KeyError) as error:
        raise InputError(
            f"Expected a CSV of joint angles with columns subject, object, trial in"
            f" {Path(path).name}, but reading it failed ({' '.join(str(error).split())})."
        ) from error
    if angles.shape[1] == 0 or float(np.nanmax(np.abs(angles.to_numpy()), initial=0.0)) > 6.3:
        raise InputError(
            "Expected at least one joint and no angle beyond a full turn, but came"
            f" {angles.shape[1]} joints; check the unit ({angle_unit})."
        )
    return pd.concat([labels, angles], axis=1)


def simulate_postures(
    count: int, *, rng: np.random.Generator, spread: float = 0.10, subjects: int = 5
) -> pd.DataFrame:
    """SIMULATE joint angles of hands that close around cylinders, balls and plates.

    No synergy is put in: each finger's links lie tangent to the object's cross-section in its own
    plane, which fixes the flexion angles in closed form; subjects differ in hand size, and every
    joint deviates by chance. Whatever few components come out, geometry made them.

    Parameters
    ----------
    count : int
        Grasps per subject.
    rng : numpy.random.Generator
        Source of chance.
    spread : float
        Standard deviation of every joint's own deviation [rad].
    subjects : int
        Number of hands.

    Returns
    -------
    pandas.DataFrame
        subject, object, trial, the fifteen `JOINTS` [rad], simulated (True).

    Examples
    --------
    >>> simulate_postures(4, rng=np.random.default_rng(1)).shape
    (20, 19)
    """
    rows = []
    for subject in range(subjects):
        size = rng.normal(1.0, 0.06)
        for trial in range(count):
            kind = ("cylinder", "ball", "plate")[int(rng.integers(3))]
            radius = rng.uniform(0.015, 0.055)
            angles = _wrapped(kind, radius, size) + rng.normal(scale=spread, size=len(JOINTS))
            rows.append((f"S{subject + 1}", kind, trial + 1, *angles, True))
    return pd.DataFrame(rows, columns=["subject", "object", "trial", *JOINTS, "simulated"])


def _wrapped(kind: str, radius: float, size: float) -> Floats:
    """Angles (15,) [rad] of a hand around an object of a radius [m]."""
    across = np.array([-0.030, -0.010, 0.010, 0.028]) * size  # finger planes, index to little
    lengths = np.array([0.045, 0.050, 0.046, 0.036]) * size  # proximal links
    section = np.full(4, radius)
    if kind == "ball":
        section = np.sqrt(np.maximum(radius**2 - 0.5 * across**2, (0.5 * radius) ** 2))
    palm = 0.5 * lengths
    mcp = np.pi - 2.0 * np.arctan(section / palm) if kind != "plate" else np.full(4, 1.1)
    pip = np.pi - 2.0 * np.arctan(section / (lengths - palm))
    if kind == "plate":  # a thin thing between straight fingers and the thumb
        mcp, pip = np.full(4, 1.25) - 8.0 * radius, np.full(4, 0.45)
    opened = (1.2 if kind == "ball" else 0.2) * radius / 0.055 * 0.25
    thumb = np.array([0.9, 0.3 + 8.0 * radius, 0.6 - 6.0 * radius, 0.7 - 7.0 * radius])
    fingers = np.column_stack([np.clip(mcp, 0.0, 1.6), np.clip(pip, 0.0, 1.8)]).ravel()
    return np.concatenate([thumb, fingers, np.full(3, opened)])
