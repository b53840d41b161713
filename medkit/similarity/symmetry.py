"""Groups of rotations that map a shape onto itself, and the best one of them for two grasps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from medkit.arguments import generator, number_array, whole
from medkit.errors import InputError
from medkit.geometry import (
    Floats,
    expected,
    perpendicular,
    random_rotation,
    rotation_about,
    unit,
)

Continuous = Literal["none", "axis", "all"]
_NO_PLANES = np.zeros((0, 3))


@dataclass(frozen=True)
class SymmetryGroup:
    """Rotations about `center` that map a shape onto itself, and its mirror planes.

    The group is ``rotations`` when `continuous` is "none"; every turn about `axis`, times each of
    ``rotations``, when it is "axis"; every rotation when it is "all". Mirror planes pass through
    the centre and are reported, but no distance uses them: a mirrored right hand is a left one.
    """

    name: str  # Schoenflies: C1, C4, D2, T, O, I; Cinf, Dinf for a body of revolution; K a ball
    center: Floats  # (3,) [m], object frame
    rotations: Floats  # (k, 3, 3) [1], the identity first
    axis: Floats  # (3,) [1], the main axis
    continuous: Continuous = "none"
    mirrors: Floats = field(default_factory=lambda: _NO_PLANES)  # (m, 3) normals [1]
    residual: float = 0.0  # [1] worst misfit of the parts, over the shape's radius

    @property
    def order(self) -> float:
        """Number of rotations; infinite for a body of revolution or a ball."""
        return float(len(self.rotations)) if self.continuous == "none" else float("inf")

    def contains(self, rotation: ArrayLike, *, tolerance: float = 1e-6) -> bool:
        """Whether a rotation (3, 3) belongs to the group, entries within `tolerance` [1]."""
        turn = _numbers(rotation, (3, 3), "a rotation")
        if self.continuous == "all":
            return True
        if self.continuous == "axis":
            along = float(self.axis @ turn @ self.axis)
            flips = any(self.axis @ part @ self.axis < 0.0 for part in self.rotations)
            return abs(along - 1.0) < tolerance or (flips and abs(along + 1.0) < tolerance)
        return bool(np.any(np.abs(self.rotations - turn).max(axis=(1, 2)) < tolerance))

    def random_element(self, *, rng: np.random.Generator) -> Floats:
        """One rotation (3, 3) of the group, drawn evenly."""
        generator(rng)
        if self.continuous == "all":
            return random_rotation(rng)
        part = self.rotations[rng.integers(len(self.rotations))]
        if self.continuous == "axis":
            part = rotation_about(self.axis, rng.uniform(0.0, 2.0 * np.pi)) @ part
        return np.asarray(part)

    def keeping(self, direction: ArrayLike) -> SymmetryGroup:
        """Return the subgroup that leaves a direction where it is, for example up.

        Parameters
        ----------
        direction : array-like, shape (3,)
            Any length but zero.

        Returns
        -------
        SymmetryGroup
            For a can that must stand upright: the turns about its axis without the flips.
        """
        fixed = _line(direction, "direction")
        if self.continuous == "all":
            return revolution_group(fixed, center=self.center)
        if self.continuous == "axis" and abs(float(self.axis @ fixed)) > 1.0 - 1e-6:
            kept = self.rotations[np.einsum("a,kab,b->k", fixed, self.rotations, fixed) > 0.0]
            return replace(self, name="Cinf", rotations=kept[:1], mirrors=_NO_PLANES)
        parts = self.rotations if self.continuous == "none" else self._turned_onto(fixed)
        kept = parts[np.einsum("a,kab,b->k", fixed, parts, fixed) > 1.0 - 1e-6]
        return replace(
            self, name=f"C{len(kept)}", rotations=kept, axis=fixed, continuous="none",
            mirrors=_NO_PLANES,
        )  # fmt: skip

    def _turned_onto(self, fixed: Floats) -> Floats:
        """Rotations of a body of revolution that keep a direction off its axis: one half turn."""
        half_turn = rotation_about(fixed, np.pi)
        parts = [np.eye(3)]
        if len(self.rotations) > 1 and abs(float(self.axis @ fixed)) < 1e-6:
            parts.append(half_turn)
        return np.stack(parts)


def trivial_group(center: ArrayLike = (0.0, 0.0, 0.0)) -> SymmetryGroup:
    """Return the group of a shape without any rotational symmetry, C1."""
    return SymmetryGroup("C1", _place(center), np.eye(3)[None], np.array([0.0, 0.0, 1.0]))


def cyclic_group(
    axis: ArrayLike, fold: int, *, center: ArrayLike = (0.0, 0.0, 0.0)
) -> SymmetryGroup:
    """Return the turns about an axis (3,) by multiples of 2 pi / fold.

    Examples
    --------
    >>> cyclic_group([0, 0, 1], 4).order
    4.0
    """
    line, count = _line(axis), whole(fold, "fold")
    parts = np.stack([rotation_about(line, 2.0 * np.pi * k / count) for k in range(count)])
    return SymmetryGroup(f"C{count}", _place(center), parts, line)


def dihedral_group(
    axis: ArrayLike, fold: int, second: ArrayLike, *, center: ArrayLike = (0.0, 0.0, 0.0)
) -> SymmetryGroup:
    """Return the group of a prism: turns about `axis`, half turns about `second` and its copies.

    Examples
    --------
    >>> dihedral_group([0, 0, 1], 2, [1, 0, 0]).order
    4.0
    """
    line, count = _line(axis), whole(fold, "fold")
    across = _numbers(second, (3,), "the second axis")
    across = unit(across - (across @ line) * line)
    parts = generated([rotation_about(line, 2.0 * np.pi / count), rotation_about(across, np.pi)])
    return SymmetryGroup(f"D{count}", _place(center), parts, line)


def revolution_group(
    axis: ArrayLike, *, flips: bool = False, center: ArrayLike = (0.0, 0.0, 0.0)
) -> SymmetryGroup:
    """Return every turn about `axis`; with `flips` also the half turns across it (a cylinder)."""
    line = _line(axis)
    expected(flips, (bool, np.bool_), "flips as True or False", "say whether a cylinder is meant")
    parts = [np.eye(3)] + ([rotation_about(perpendicular(line), np.pi)] if flips else [])
    name = "Dinf" if flips else "Cinf"
    return SymmetryGroup(name, _place(center), np.stack(parts), line, "axis")


def ball_group(*, center: ArrayLike = (0.0, 0.0, 0.0)) -> SymmetryGroup:
    """Return every rotation: the group of a ball, K."""
    return SymmetryGroup("K", _place(center), np.eye(3)[None], np.array([0.0, 0.0, 1.0]), "all")


def generated(generators: Sequence[Floats], *, limit: int = 120) -> Floats:
    """Multiply rotations until nothing new comes: the finite group they generate, (k, 3, 3).

    Raises
    ------
    InputError
        If more than `limit` elements appear: the generators do not belong to one finite group.
    """
    elements = [np.eye(3)]
    fresh = [np.eye(3)]
    while fresh:
        products = [step @ element for element in fresh for step in generators]
        fresh = []
        for product in products:
            if not any(np.abs(product - known).max() < 1e-6 for known in elements):
                elements.append(product)
                fresh.append(product)
        if len(elements) > limit:
            raise InputError(
                f"Expected rotations of one finite group, but they generate more than {limit}"
                " elements; pass exact axes and angles."
            )
    return np.stack(elements)


def rotated_to(planned: Floats, human: Floats, group: SymmetryGroup) -> Floats:
    """Turn human grasps by the group's elements that bring them nearest to planned ones.

    Parameters
    ----------
    planned : ndarray, shape (n, k, 3)
        Fingertips of the planned grasps [m].
    human : ndarray, shape (m, k, 3)
        Fingertips of the recorded grasps [m].
    group : SymmetryGroup
        Rotations that change nothing physical.

    Returns
    -------
    ndarray, shape (n, m, k, 3)
        For each pair the recorded grasp, turned [m]. The minimum is exact also for continuous
        groups: in closed form about an axis, by Kabsch's decomposition for a ball.
    """
    remedy = "take one from symmetry_group_from_mesh"
    expected(group, SymmetryGroup, "a symmetry group", remedy)
    p = planned - group.center
    h = human - group.center
    best = np.full((len(p), len(h)), np.inf)
    turned = np.broadcast_to(h, (len(p), *h.shape)).copy()
    for part in group.rotations:
        candidate = _best_turn(p, h @ part.T, group)
        squared = np.sum((p[:, None] - candidate) ** 2, axis=(2, 3))
        better = squared < best
        best = np.where(better, squared, best)
        turned[better] = candidate[better]
    return np.asarray(turned + group.center)


def _best_turn(p: Floats, h: Floats, group: SymmetryGroup) -> Floats:
    if group.continuous == "axis":
        return _turn_about_axis(p, h, group.axis)
    if group.continuous == "all":
        return _turn_any_way(p, h)
    return np.broadcast_to(h, (len(p), *h.shape))


def _turn_about_axis(p: Floats, h: Floats, axis: Floats) -> Floats:
    first = perpendicular(axis)
    second = np.cross(axis, first)
    p_plane, h_plane = (np.stack([x @ first, x @ second], axis=-1) for x in (p, h))
    even = np.einsum("nka,mka->nm", p_plane, h_plane)
    odd = np.einsum("nk,mk->nm", p_plane[..., 1], h_plane[..., 0]) - np.einsum(
        "nk,mk->nm", p_plane[..., 0], h_plane[..., 1]
    )
    angle = np.arctan2(odd, even)[..., None]
    c, s = np.cos(angle), np.sin(angle)
    u = c * h_plane[None, ..., 0] - s * h_plane[None, ..., 1]
    v = s * h_plane[None, ..., 0] + c * h_plane[None, ..., 1]
    along = np.broadcast_to(h @ axis, u.shape)
    return np.asarray(u[..., None] * first + v[..., None] * second + along[..., None] * axis)


def _turn_any_way(p: Floats, h: Floats) -> Floats:
    moment = np.einsum("nka,mkb->nmab", p, h)
    left, _, right = np.linalg.svd(moment)
    sign = np.sign(np.linalg.det(left @ right))
    left = left.copy()
    left[..., :, 2] *= sign[..., None]
    return np.asarray(np.einsum("nmab,mkb->nmka", left @ right, h))


def _place(center: ArrayLike) -> Floats:
    flat = number_array(center, "a center", "pass three coordinates").reshape(-1)
    return _numbers(flat, (3,), "a center")


def _line(axis: ArrayLike, name: str = "axis") -> Floats:
    return unit(_numbers(axis, (3,), f"the {name}"))


def _numbers(values: ArrayLike, shape: tuple[int, ...], what: str) -> Floats:
    """Return finite numbers of a shape, or raise `InputError`."""
    remedy = f"pass an array of shape {shape}"
    array = number_array(values, what, remedy)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise InputError(
            f"Expected {what} of finite numbers in shape {shape}, but got shape {array.shape}"
            f" or a number that is not finite; {remedy}."
        )
    return array
