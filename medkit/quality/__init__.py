"""Wrench-space measures, planar and spatial: force closure, epsilon, volume, critical friction."""

from medkit.quality.closure import (
    CriticalFriction,
    closure_margin,
    critical_friction,
    is_force_closure,
    is_form_closure,
)
from medkit.quality.measure import Epsilon, EpsilonBatch, epsilon, epsilon_many
from medkit.quality.steps import ExpansionStep, expansion_steps
from medkit.quality.volume import volume

__all__ = [
    "CriticalFriction",
    "Epsilon",
    "EpsilonBatch",
    "ExpansionStep",
    "closure_margin",
    "critical_friction",
    "epsilon",
    "epsilon_many",
    "expansion_steps",
    "is_force_closure",
    "is_form_closure",
    "volume",
]
