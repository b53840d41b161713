"""A simulated gripper that closes on an outline: does it hold, or does the object slip out?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from medkit.arguments import numbers, one_of, plane_point, whole
from medkit.errors import InputError
from medkit.geometry import Floats, nonnegative
from medkit.planar.fixture import UNITS, Bench, build_bench
from medkit.planar.outlines import Outline, checked_outline
from medkit.planar.settings import DEFAULTS, SqueezeSettings, checked_settings

Fixture = Literal["points", "flat jaws", "three fingers"]
FIXTURES: tuple[str, ...] = get_args(Fixture)

#: Motion and contact are looked at every so many steps.
CHECK_EVERY = 4
#: Why an experiment ended.
HELD, MOVED, LOST_CONTACT = "held", "moved too far", "a finger lost contact"


@dataclass(frozen=True)
class SqueezeResult:
    """What happened in one squeeze. All of it is simulated.

    Attributes
    ----------
    held : bool
        True when no finger lost contact and the object stayed where it was.
    reason : str
        "held", "moved too far" or "a finger lost contact".
    displacement : float
        Largest motion of the object relative to the fingers [m].
    rotation : float
        Largest rotation of the object [rad], absolute.
    times : ndarray, shape (k,)
        Times of the recorded frames [s].
    poses : ndarray, shape (k, 3)
        Recorded x [m], y [m] and angle [rad] of the object's centre of mass, world frame.
    tips : ndarray, shape (k, f, 2)
        Recorded positions of the fingers [m].
    outline : Outline
        The object.
    friction : float
        Coefficient of friction between finger and object [1].
    """

    held: bool
    reason: str
    displacement: float
    rotation: float
    times: Floats
    poses: Floats
    tips: Floats
    outline: Outline
    friction: float


def squeeze(
    outline: Outline,
    p1: ArrayLike,
    p2: ArrayLike,
    *,
    friction: float,
    settings: SqueezeSettings = DEFAULTS,
    fixture: Fixture = "points",
    offset: float = 0.0,
    frames: int = 0,
) -> SqueezeResult:
    """Close two guided, force-limited fingers on an outline, push the object about, and judge.

    The fingers start where they touch, move only along lines parallel to the chord p1 p2, and
    push with equal forces. Then come eight pushes at the centre of mass, 45 degrees apart, and
    a torque in both senses.

    Parameters
    ----------
    outline : Outline
        The object; it may lie anywhere.
    p1, p2 : array-like, shape (2,)
        Contact points on the outline [m].
    friction : float
        Coefficient of friction between finger and object [1].
    settings : SqueezeSettings
        Numerical and experimental settings.
    fixture : {"points", "flat jaws", "three fingers"}
        Round fingertips; wide flat jaws at right angles to the chord; or two fingers side by
        side at `p1` against one at `p2`.
    offset : float
        Sideways shift of the first finger off the chord [m].
    frames : int
        How many frames to record; none when 0.

    Returns
    -------
    SqueezeResult
        With the verdict in ``held``.

    Raises
    ------
    InputError
        If a point does not lie on the outline, the points coincide, or friction is negative.

    Notes
    -----
    The physics engine is pymunk, which multiplies the two shapes' friction: the fingers carry
    `friction`, the object carries one. The same call gives the same trajectory, bit for bit.

    Examples
    --------
    >>> from medkit.planar import rectangle
    >>> squeeze(rectangle(0.08, 0.04), [0, -0.02], [0, 0.02], friction=0.3).held
    True
    """
    outline, settings = checked_outline(outline), checked_settings(settings)
    mu, frames = nonnegative(friction, "friction"), whole(frames, "frames", 0)
    one_of(fixture, FIXTURES, "fixture")
    contacts = np.vstack([plane_point(p1, "p1"), plane_point(p2, "p2")])
    shift = float(numbers(offset, "the offset")[0])
    _check_contacts(outline, contacts)
    bench = build_bench(
        outline, contacts, friction=mu, settings=settings, fixture=fixture, offset=shift
    )
    return _run(bench, outline, mu, settings, frames)


def _check_contacts(outline: Outline, contacts: Floats) -> None:
    size = outline.characteristic_length
    away = float(outline.distance(contacts).max())
    if away > 0.01 * size:
        raise InputError(
            f"Expected contact points on the outline, but one is {away:.3g} m off it;"
            " take touch points of a medial disk or points on an edge."
        )
    if np.linalg.norm(contacts[1] - contacts[0]) < 1e-6 * size:
        raise InputError(
            "Expected two different contact points, but they coincide; move one of them."
        )


def _run(
    bench: Bench, outline: Outline, friction: float, settings: SqueezeSettings, frames: int
) -> SqueezeResult:
    plan, calm = pushes(settings), np.zeros(3)
    total = settings.settle_steps + len(plan) * settings.push_steps
    every = max(1, total // frames) if frames else total + 1
    rows: list[tuple[float, Floats, Floats]] = []
    worst, turned, reason = 0.0, 0.0, HELD
    for index in range(total):
        if frames and index % every == 0:
            rows.append((index * settings.step, bench.pose(), bench.tip_positions()))
        push = (index - settings.settle_steps) // settings.push_steps
        bench.step(plan[push] if push >= 0 else calm)
        if index % CHECK_EVERY:
            continue
        moved, angle = bench.motion()
        worst, turned = max(worst, moved), max(turned, angle)
        if max(moved, angle) > settings.max_displacement:
            reason = MOVED
        elif index and not bench.touching():
            reason = LOST_CONTACT
        if reason != HELD and not frames:
            break
    # pictures show the slip to its end; the verdict is the first failure all the same
    size = outline.characteristic_length
    return SqueezeResult(
        reason == HELD, reason, worst * size, turned, np.array([row[0] for row in rows]),
        _unscale(np.array([row[1] for row in rows]).reshape(-1, 3), outline),
        np.array([row[2] for row in rows]) * size / UNITS + outline.center_mass
        if rows else np.zeros((0, 2, 2)),
        outline, friction,
    )  # fmt: skip


def _unscale(poses: Floats, outline: Outline) -> Floats:
    scale = outline.characteristic_length / UNITS
    return np.column_stack([poses[:, :2] * scale + outline.center_mass, poses[:, 2]])


def pushes(settings: SqueezeSettings) -> Floats:
    """The ten disturbances [fx, fy, torque] in squeeze forces and characteristic lengths."""
    facing = np.arange(8) * (np.pi / 4)
    forces = np.column_stack([np.cos(facing), np.sin(facing), np.zeros(8)])
    # opposite pushes follow each other, so that nothing drifts away in one direction
    order = [0, 4, 2, 6, 1, 5, 3, 7]
    torques = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    return np.asarray(settings.push_share * np.vstack([forces[order], torques]))
