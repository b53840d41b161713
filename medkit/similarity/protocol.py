"""The numbers of the simulated experiment: protocol, objects, and what one person always does."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from medkit.errors import InputError


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


def checked_protocol(protocol: Protocol) -> Protocol:
    """Return a protocol whose numbers can be simulated, or say which one cannot."""
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
