"""Exact groups put together from axes that were only measured; the caller tests their elements."""

from __future__ import annotations

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats, rotation_about, unit
from medkit.similarity.symmetry import SymmetryGroup, cyclic_group, dihedral_group, generated


def hemisphere(count: int) -> Floats:
    """Directions spread evenly over half a sphere, a spiral of golden turns."""
    z = (np.arange(count) + 0.5) / count
    around = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z**2)
    return np.stack([ring * np.cos(around), ring * np.sin(around), z], axis=1)


def distinct_lines(axes: list[Floats]) -> list[Floats]:
    """Keep of lines through the origin those that lie more than 8 deg apart."""
    kept: list[Floats] = []
    for axis in axes:
        if all(abs(float(axis @ other)) < np.cos(np.deg2rad(8.0)) for other in kept):
            kept.append(upwards(axis))
    return kept


def upwards(axis: Floats) -> Floats:
    """The one of the two directions of a line whose largest component is positive."""
    return np.asarray(axis * np.sign(axis[np.argmax(np.abs(axis))]))


def candidate_groups(axes: dict[int, list[Floats]]) -> list[SymmetryGroup]:
    """Groups that the axes suggest, largest first; the caller tests every element."""
    candidates = _polyhedral_groups(axes)
    for fold in sorted(axes, reverse=True):
        for main in axes[fold]:
            across = [axis for axis in axes[2] if abs(float(axis @ main)) < 0.1]
            candidates += [dihedral_group(main, fold, second) for second in across]
            candidates.append(cyclic_group(main, fold))
    return sorted(candidates, key=lambda group: -group.order)


def _polyhedral_groups(axes: dict[int, list[Floats]]) -> list[SymmetryGroup]:
    """Tetrahedral, octahedral and icosahedral groups from two of their axes, made exact."""
    groups = []
    kinds = (("I", 5, np.sqrt(0.2), 6), ("O", 4, 0.0, 3), ("T", 3, 1.0 / 3.0, 4))
    for name, fold, cosine, count in kinds:
        lines = axes[fold]
        if len(lines) < 2 or len(lines) > count + 1:
            continue
        first, second = _at_angle(lines[0], lines[1], cosine)
        turn = 2.0 * np.pi / fold
        parts = [rotation_about(first, turn), rotation_about(second, turn)]
        try:
            elements = generated(parts)
        except InputError:  # the two lines were no neighbours of such a solid
            continue
        groups.append(SymmetryGroup(name, np.zeros(3), elements, first))
    return groups


def _at_angle(first: Floats, second: Floats, cosine: float) -> tuple[Floats, Floats]:
    """Turn the second line in the plane of both so that the cosine of their angle is exact."""
    aligned = second * (1.0 if float(first @ second) >= 0.0 else -1.0)
    across = unit(aligned - float(aligned @ first) * first)
    return first, cosine * first + np.sqrt(1.0 - cosine**2) * across
