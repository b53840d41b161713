"""A seeded generator of reaches to grasp that follow P13's protocol; everything in it is SIMULATED.

P13 prints no raw data. What the generator does, and after whom, is said at each parameter of
`Protocol`; `data/human_grasps/README.md` repeats it as a table.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from medkit.datasets.human_grasps import COLUMNS, SENSORS
from medkit.geometry import Floats
from medkit.similarity.paths import trial_paths
from medkit.similarity.protocol import SEED as SEED
from medkit.similarity.protocol import SHAPES, STYLES, Habit, Protocol, Shape, checked_protocol


def simulate_recordings(
    *,
    rng: np.random.Generator,
    protocol: Protocol | None = None,
    shapes: tuple[Shape, ...] = SHAPES,
) -> pd.DataFrame:
    """Simulate the whole experiment: subjects, objects, trials (P13 6.2.2).

    Parameters
    ----------
    rng : numpy.random.Generator
        The only source of chance; one child per subject and trial.
    protocol : Protocol, optional
        The numbers of the experiment.
    shapes : tuple of Shape
        What is grasped.

    Returns
    -------
    pandas.DataFrame
        Tidy table as `medkit.datasets.load_human_grasps` returns it, ``simulated`` all True.

    Raises
    ------
    InputError
        If a number of the protocol is not usable.

    Examples
    --------
    >>> short = Protocol(subjects=1, trials=2)
    >>> table = simulate_recordings(rng=np.random.default_rng(1), protocol=short)
    >>> table.groupby("object")["trial"].nunique().to_dict()
    {'box': 2, 'cylinder': 2}
    """
    numbers = checked_protocol(protocol or Protocol())
    tables = []
    for name, shape, trial, habit, chance in _trials(numbers, shapes, rng):
        hand, wrist = end_posture(shape, habit, numbers, chance)
        times, paths = trial_paths(shape, habit, hand, wrist, numbers, chance)
        tables.append(_tidy(name, shape.name, trial, times, paths))
    return pd.concat(tables, ignore_index=True)


def _trials(
    numbers: Protocol, shapes: tuple[Shape, ...], rng: np.random.Generator
) -> Iterator[tuple[str, Shape, int, Habit, np.random.Generator]]:
    """Subject, object, trial, the subject's habit, and the trial's own source of chance."""
    for subject, own in enumerate(rng.spawn(numbers.subjects)):
        habit = _habit(subject, numbers, own)
        for shape in shapes:
            for trial, chance in enumerate(own.spawn(numbers.trials), start=1):
                yield f"S{subject + 1}", shape, trial, habit, chance


def simulate_fingertips(
    shape: Shape,
    *,
    rng: np.random.Generator,
    count: int = 50,
    azimuths: ArrayLike = (0.0,),
    protocol: Protocol | None = None,
) -> Floats:
    """Simulate end positions alone, for subjects who were told nothing about the side.

    Parameters
    ----------
    shape : Shape
        What is grasped.
    rng : numpy.random.Generator
        Source of chance.
    count : int
        Number of grasps.
    azimuths : array-like, shape (k,)
        Directions [rad] from which the object is taken, one drawn per grasp, relative to the
        side asked for in P13's protocol.
    protocol : Protocol, optional
        The numbers of the experiment.

    Returns
    -------
    ndarray, shape (count, 5, 3)
        Fingertip positions [m] in the object's frame. Simulated.

    Raises
    ------
    InputError
        If a number of the protocol is not usable.

    Examples
    --------
    >>> simulate_fingertips(SHAPES[0], rng=np.random.default_rng(1), count=4).shape
    (4, 5, 3)
    """
    numbers = checked_protocol(protocol or Protocol())
    base = _habit(0, numbers, rng)
    choices = np.asarray(azimuths, dtype=float)
    tips = []
    for turn in rng.choice(choices, size=count):
        habit = Habit(base.azimuth + turn, base.height, base.pitch, base.wrap, base.pressing, 1.0)
        tips.append(end_posture(shape, habit, numbers, rng)[0])
    return np.stack(tips)


def end_posture(
    shape: Shape, habit: Habit, numbers: Protocol, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Positions of the five nail trackers (5, 3) and of the wrist (3,) at the grasp [m]."""
    turn = habit.azimuth + rng.normal(scale=numbers.within_azimuth)
    height = habit.height + rng.normal(scale=numbers.within_height)
    rows = np.array([0.5, 1.5, 0.5, -0.5, -1.5]) * habit.pitch
    spread = np.array([0.0, 0.5, 0.15, -0.15, -0.4]) * habit.wrap
    angles = turn + np.array([0.0, np.pi, np.pi, np.pi, np.pi]) + spread
    lift = height + rows + rng.normal(scale=numbers.within_finger, size=5)
    slip = rng.normal(scale=numbers.within_finger, size=5)
    points, normals = _surface(shape, angles, slip)
    idle = np.setdiff1d(np.arange(5), habit.pressing)
    clearance = np.full(5, numbers.nail)
    clearance[idle] += numbers.hover
    tips = points + clearance[:, None] * normals
    tips[:, 2] = np.clip(lift, -0.45 * shape.extents[2], 0.48 * shape.extents[2])
    side = turn + 0.5 * np.pi  # the palm lies between thumb and fingers, on the right
    reach = 0.5 * max(shape.extents[:2]) + 0.085
    wrist = np.array([reach * np.cos(side), reach * np.sin(side) - 0.05, height - 0.015])
    return tips, wrist


def _habit(subject: int, numbers: Protocol, rng: np.random.Generator) -> Habit:
    return Habit(
        azimuth=np.deg2rad(-105.0) + rng.normal(scale=numbers.between_azimuth),
        height=0.010 + rng.normal(scale=numbers.between_height),
        pitch=numbers.finger_pitch * rng.normal(1.0, 0.10),
        wrap=np.deg2rad(rng.normal(25.0, 8.0)),
        pressing=STYLES[subject % len(STYLES)],
        pace=rng.normal(1.0, 0.12),
    )


def _surface(shape: Shape, angles: Floats, slip: Floats) -> tuple[Floats, Floats]:
    """Points on the outline at `angles`, shifted by `slip` along it, and outward normals."""
    half_x, half_y = 0.5 * shape.extents[0], 0.5 * shape.extents[1]
    if shape.kind == "cylinder":
        turned = angles + slip / half_x
        normals = np.stack([np.cos(turned), np.sin(turned), np.zeros(5)], axis=1)
        return half_x * normals, normals
    far = np.where(np.sin(angles) >= 0.0, 1.0, -1.0)  # thumb on the near face, fingers on the far
    across = half_y * np.cos(angles) / np.maximum(np.abs(np.sin(angles)), 0.3) + slip
    across = np.clip(across, -0.9 * half_x, 0.9 * half_x)
    normals = np.stack([np.zeros(5), far, np.zeros(5)], axis=1)
    return np.stack([across, far * half_y, np.zeros(5)], axis=1), normals


def _tidy(subject: str, name: str, trial: int, times: Floats, paths: Floats) -> pd.DataFrame:
    count, sensors = paths.shape[:2]
    flat = paths.transpose(1, 0, 2).reshape(-1, 3)
    return pd.DataFrame(
        {
            "subject": subject, "object": name, "trial": trial,
            "t": np.tile(times, sensors), "sensor": np.repeat(SENSORS, count),
            "x": flat[:, 0], "y": flat[:, 1], "z": flat[:, 2], "simulated": True,
        },
        columns=list(COLUMNS),
    )  # fmt: skip


def true_end_postures(
    *,
    rng: np.random.Generator,
    protocol: Protocol | None = None,
    shapes: tuple[Shape, ...] = SHAPES,
) -> pd.DataFrame:
    """Positions that the generator aims at, in the order of `simulate_recordings` (same seed).

    Returns
    -------
    pandas.DataFrame
        subject, object, trial, sensor, x, y, z [m]: what a perfect pipeline would recover.

    Examples
    --------
    >>> short = Protocol(subjects=1, trials=1)
    >>> len(true_end_postures(rng=np.random.default_rng(1), protocol=short))
    12
    """
    numbers = checked_protocol(protocol or Protocol())
    rows = []
    for name, shape, trial, habit, chance in _trials(numbers, shapes, rng):
        hand, wrist = end_posture(shape, habit, numbers, chance)
        for sensor, place in zip(SENSORS, np.vstack([hand, wrist]), strict=True):
            rows.append((name, shape.name, trial, sensor, *place))
    return pd.DataFrame(rows, columns=["subject", "object", "trial", "sensor", "x", "y", "z"])
