"""One simulated trial as the tracker gives it: reach, carry, tremor, noise and drop-outs."""

from __future__ import annotations

import numpy as np

from medkit.geometry import Floats
from medkit.similarity.protocol import Habit, Protocol, Shape


def _minimum_jerk(share: Floats) -> Floats:
    """Course from 0 to 1 with least jerk (Flash & Hogan 1985)."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def _opening(share: Floats, peak: float) -> Floats:
    """A hump from 0 to 1 and back to 0 with its top at `peak`, flat at both ends."""
    s = np.clip(share, 0.0, 1.0)
    rise = 2.0 * peak / (1.0 - peak)
    return np.asarray((s / peak) ** rise * ((1.0 - s) / (1.0 - peak)) ** 2)


def trial_paths(
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
