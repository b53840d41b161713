"""The settings of a simulated squeeze."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from medkit.geometry import expected, nonnegative, positive


@dataclass(frozen=True)
class SqueezeSettings:
    """How a squeeze is simulated. The defaults are those of the studies in the notebooks.

    Attributes
    ----------
    step : float
        Time step of the physics engine [s].
    iterations : int
        Sweeps of the engine's contact solver per step.
    settle_steps : int
        Steps before the first push, the squeeze alone.
    push_steps : int
        Steps each of the ten pushes lasts.
    push_share : float
        Size of a push relative to the squeeze force [1]; torques are this share of the squeeze
        force times the characteristic length.
    max_displacement : float
        Largest motion that still counts as held, in characteristic lengths [1]: translation
        relative to the middle of the fingers, or rotation [rad], whichever is larger.
    tip_radius : float
        Radius of a round fingertip, in characteristic lengths [1].
    slop : float
        Overlap the engine tolerates, in characteristic lengths [1].
    squeeze_rate : float
        Squeeze force over the object's mass, in characteristic lengths per second squared
        [1/s^2].
    gravity_share : float
        Weight of the object relative to the squeeze force [1], pulling along -y.
    """

    step: float = 1.0 / 600.0
    iterations: int = 30
    settle_steps: int = 60
    push_steps: int = 60
    push_share: float = 2e-4
    max_displacement: float = 2e-3
    tip_radius: float = 0.01
    slop: float = 1e-4
    squeeze_rate: float = 50.0
    gravity_share: float = 0.0

    def __post_init__(self) -> None:
        for name in ("step", "iterations", "push_steps", "max_displacement", "tip_radius",
                     "slop", "squeeze_rate"):  # fmt: skip
            positive(getattr(self, name), name)
        for name in ("settle_steps", "push_share", "gravity_share"):
            nonnegative(getattr(self, name), name)


DEFAULTS = SqueezeSettings()


def checked_settings(settings: Any) -> SqueezeSettings:
    """Return settings as they are, or raise `InputError` that says how to make them."""
    return expected(settings, SqueezeSettings, "squeeze settings", "pass SqueezeSettings()")
