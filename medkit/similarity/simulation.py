"""A seeded generator of reaches to grasp that follow P13's protocol; everything in it is SIMULATED.

P13 prints no raw data. What the generator does, and after whom, is said at each parameter of
`Protocol`; `data/human_grasps/README.md` repeats it as a table.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from medkit.datasets.human_grasps import COLUMNS, SENSORS
from medkit.errors import InputError
from medkit.geometry import Floats


@dataclass(frozen=True)
class Protocol:
    """The numbers of the simulated experiment; lengths [m], times [s], angles [rad]."""

    rate: float = 100.0  # [Hz] usual for electromagnetic trackers; P13 gives none
    subjects: int = 5  # P13 6.2.2
    trials: int = 10  # per subject and object, P13 6.2.2
    start_distance: float = 0.30  # P13 6.2.2, hand in front of the object
    put_down: tuple[float, float] = (-0.20, 0.20)  # to the left and away, P13 figure 6.8
    lift: float = 0.06  # height of the arc on which the object is carried
    rest: float = 0.25  # quiet time before, between and after the movements
    movement_time: float = 0.90  # reach of 0.3 m at ease (Jeannerod 1984: 0.7 to 1.0 s)
    movement_time_spread: float = 0.08  # standard deviation between trials, as a share
    peak_aperture_time: float = 0.70  # share of the reach (Jeannerod 1984; Smeets & Brenner 1999)
    opening: float = 0.022  # each finger's clearance at the peak (Smeets & Brenner 1999)
    nail: float = 0.012  # tracker on the fingernail: thickness of the fingertip under it
    finger_pitch: float = 0.019  # distance of neighbouring fingers along the object's height
    between_azimuth: float = np.deg2rad(14.0)  # between subjects: where around the object
    within_azimuth: float = np.deg2rad(3.0)  # within a subject ("very consistent", P13 6.2.2)
    between_height: float = 0.014  # between subjects: how high
    within_height: float = 0.004  # within a subject
    within_finger: float = 0.003  # each finger by itself, within a subject
    hover: float = 0.022  # clearance of a finger that the subject does not use
    tremor: float = 0.0005  # low-frequency wobble of the hand
    noise: float = 0.0004  # white noise of the tracker (order of magnitude of such devices)
    dropout_rate: float = 0.25  # drop-outs per sensor and trial
    dropout_time: float = 0.05  # mean length of a drop-out


@dataclass(frozen=True)
class Shape:
    """A thing to grasp: standing upright, origin at its centre, x to the right, z up."""

    name: str
    kind: str  # "cylinder" or "box"
    extents: tuple[float, float, float]  # [m]


#: The two objects; P13 gives no sizes, these are the generator's choice.
SHAPES = (
    Shape("cylinder", "cylinder", (0.070, 0.070, 0.140)),
    Shape("box", "box", (0.090, 0.055, 0.150)),
)
#: Fingers that press, one set per style of hand; P13 leaves their number to the subject.
STYLES = ((0, 1, 2, 3, 4), (0, 1, 2, 3, 4), (0, 1, 2, 3), (0, 1, 2))
SEED = 20130711


@dataclass(frozen=True)
class Habit:
    """What one subject does every time."""

    azimuth: float  # [rad] of the thumb's side
    height: float  # [m] of the hand above the object's centre
    pitch: float  # [m] between neighbouring fingers
    wrap: float  # [rad] by which the fingers are spread around the object
    pressing: tuple[int, ...]
    pace: float  # [1] movement time, relative


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
    numbers = _checked(protocol or Protocol())
    tables = []
    for subject, own in enumerate(rng.spawn(numbers.subjects)):
        habit = _habit(subject, numbers, own)
        for shape in shapes:
            for trial, chance in enumerate(own.spawn(numbers.trials), start=1):
                hand, wrist = end_posture(shape, habit, numbers, chance)
                times, paths = _trial(shape, habit, hand, wrist, numbers, chance)
                tables.append(_tidy(f"S{subject + 1}", shape.name, trial, times, paths))
    return pd.concat(tables, ignore_index=True)


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
    numbers = _checked(protocol or Protocol())
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


def _checked(protocol: Protocol) -> Protocol:
    for field in fields(protocol):
        value = np.asarray(getattr(protocol, field.name), dtype=float)
        if not np.all(np.isfinite(value)) or (field.name != "put_down" and np.any(value < 0.0)):
            raise InputError(
                f"Expected {field.name} of the protocol to be a finite number of zero or more,"
                f" but got {value}; correct it."
            )
    if min(protocol.subjects, protocol.trials, protocol.rate, protocol.movement_time) <= 0:
        raise InputError(
            "Expected subjects, trials, rate and movement_time above zero, but one is not;"
            " correct the protocol."
        )
    return protocol


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


def _minimum_jerk(share: Floats) -> Floats:
    """Course from 0 to 1 with least jerk (Flash & Hogan 1985)."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def _opening(share: Floats, peak: float) -> Floats:
    """A hump from 0 to 1 and back to 0 with its top at `peak`, flat at both ends."""
    s = np.clip(share, 0.0, 1.0)
    rise = 2.0 * peak / (1.0 - peak)
    return np.asarray((s / peak) ** rise * ((1.0 - s) / (1.0 - peak)) ** 2)


def _trial(
    shape: Shape, habit: Habit, hand: Floats, wrist: Floats, numbers: Protocol,
    rng: np.random.Generator,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Times (n,) [s] and positions (n, 6, 3) [m] of one trial, as the tracker gives them."""
    spread = 1.0 + numbers.movement_time_spread * float(np.clip(rng.normal(), -2.5, 2.5))
    reach_time = numbers.movement_time * habit.pace * spread
    carry_start = 2.0 * numbers.rest + reach_time
    carry_time = 0.8 * reach_time
    total = carry_start + carry_time + numbers.rest
    times = np.arange(int(np.ceil(total * numbers.rate))) / numbers.rate
    share = (times - numbers.rest) / reach_time
    paths = _reach(shape, hand, wrist, share, numbers)
    paths = paths + _carry((times - carry_start) / carry_time, numbers)[:, None, :]
    paths = paths + _tremor(times, numbers, rng)[:, None, :]
    paths = paths + rng.normal(scale=numbers.noise, size=paths.shape)
    return times, _dropouts(paths, numbers, rng)


def _reach(shape: Shape, hand: Floats, wrist: Floats, share: Floats, numbers: Protocol) -> Floats:
    going = _minimum_jerk(share)[:, None]
    table = -0.5 * shape.extents[2] + 0.03
    closed = np.array(
        [[-0.012, -0.01], [0.012, 0.0], [0.020, 0.0], [0.028, -0.005], [0.036, -0.01]]
    )
    rest_hand = np.column_stack([closed, np.full(5, table)])
    rest_hand[:, 1] -= numbers.start_distance
    rest_wrist = np.array([0.04, -numbers.start_distance - 0.12, table + 0.02])
    outward = hand - hand.mean(axis=0)
    outward[:, 2] = 0.0
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    hump = numbers.opening * _opening(share, numbers.peak_aperture_time)
    # The hand's own form is ready when the aperture peaks; from there on the fingers only close.
    forming = _minimum_jerk(share / numbers.peak_aperture_time)[:, None, None]
    middle, rest_middle = hand.mean(axis=0), rest_hand.mean(axis=0)
    carried = rest_middle + going * (middle - rest_middle)
    formed = (1.0 - forming) * (rest_hand - rest_middle) + forming * (hand - middle)
    fingers = carried[:, None, :] + formed
    wrists = rest_wrist + going * (wrist - rest_wrist)
    paths = np.concatenate([fingers, wrists[:, None, :]], axis=1)
    paths[:, :5] += hump[:, None, None] * outward
    return np.asarray(paths)


def _carry(share: Floats, numbers: Protocol) -> Floats:
    going = _minimum_jerk(share)
    arc = 16.0 * going**2 * (1.0 - going) ** 2 * numbers.lift
    return np.stack([numbers.put_down[0] * going, numbers.put_down[1] * going, arc], axis=1)


def _tremor(times: Floats, numbers: Protocol, rng: np.random.Generator) -> Floats:
    pitch = rng.uniform(1.0, 3.0, size=3)  # [Hz]
    phase = rng.uniform(0.0, 2.0 * np.pi, size=3)
    wave = np.sin(2.0 * np.pi * times[:, None] * pitch + phase)
    return np.asarray(numbers.tremor * np.sqrt(2.0) * wave)


def _dropouts(paths: Floats, numbers: Protocol, rng: np.random.Generator) -> Floats:
    seen = paths.copy()
    for sensor in range(paths.shape[1]):
        for _ in range(rng.poisson(numbers.dropout_rate)):
            first = int(rng.integers(0, len(paths)))
            length = 1 + int(rng.exponential(numbers.dropout_time) * numbers.rate)
            seen[first : first + length, sensor] = np.nan
    return seen


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
    numbers = _checked(protocol or Protocol())
    rows = []
    for subject, own in enumerate(rng.spawn(numbers.subjects)):
        habit = _habit(subject, numbers, own)
        for shape in shapes:
            for trial, chance in enumerate(own.spawn(numbers.trials), start=1):
                hand, wrist = end_posture(shape, habit, numbers, chance)
                for sensor, place in zip(SENSORS, np.vstack([hand, wrist]), strict=True):
                    rows.append((f"S{subject + 1}", shape.name, trial, sensor, *place))
    return pd.DataFrame(rows, columns=["subject", "object", "trial", "sensor", "x", "y", "z"])
