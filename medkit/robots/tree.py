"""A kinematic tree as a struct of arrays, and its forward kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.arguments import short
from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.robots.kernels import FIXED, PRISMATIC, REVOLUTE, forward_kinematics_batch_kernel

__all__ = ["FIXED", "PRISMATIC", "REVOLUTE", "KinematicTree"]

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class KinematicTree:
    """Links in an order in which parents come before their children.

    The pose of a link is ``parent pose @ placement @ motion(axis, value)``, where the value of
    its joint is ``multiplier * q[coordinate] + offset``.

    Attributes
    ----------
    parent : ndarray, shape (L,)
        Index of the parent link, -1 for the base.
    placement : ndarray, shape (L, 4, 4)
        Fixed transform from the joint's frame into the parent's frame [m].
    axis : ndarray, shape (L, 3)
        Unit axis of the joint in its own frame, zero for fixed joints.
    kind : ndarray, shape (L,)
        `FIXED` (0), `REVOLUTE` (1) or `PRISMATIC` (2).
    coordinate : ndarray, shape (L,)
        Index into `q` that drives the joint, -1 for none.
    multiplier, offset : ndarray, shape (L,)
        Coupling to that coordinate [1] and [rad or m].
    """

    parent: Ints
    placement: Floats
    axis: Floats
    kind: Ints
    coordinate: Ints
    multiplier: Floats
    offset: Floats

    def __post_init__(self) -> None:
        for array in self.arrays:
            array.setflags(write=False)

    @property
    def arrays(self) -> tuple[Ints, Floats, Floats, Ints, Ints, Floats, Floats]:
        """The seven arrays in the order in which `forward_kinematics_kernel` takes them."""
        return (
            self.parent, self.placement, self.axis, self.kind,
            self.coordinate, self.multiplier, self.offset,
        )  # fmt: skip

    @property
    def coordinates(self) -> int:
        """Number of coordinates in `q`."""
        return int(self.coordinate.max(initial=-1)) + 1

    def link_poses(self, q: ArrayLike) -> Floats:
        """Poses of all links in the base frame.

        Parameters
        ----------
        q : array-like, shape (nq,) or (B, nq)
            Joint coordinates [rad or m].

        Returns
        -------
        ndarray, shape (L, 4, 4) or (B, L, 4, 4)
            ``T_base_link`` [m].

        Raises
        ------
        InputError
            If `q` has another shape or is not finite.
        """
        try:
            values = np.ascontiguousarray(q, dtype=float)
        except (TypeError, ValueError):
            raise InputError(
                f"Expected q as {self.coordinates} numbers, but got {short(q)}; pass one value per"
                " joint in the order of joint_names."
            ) from None
        if values.ndim not in (1, 2) or values.shape[-1] != self.coordinates:
            raise InputError(
                f"Expected q of shape ({self.coordinates},) or (n, {self.coordinates}), but got"
                f" shape {values.shape}; pass one value per joint in the order of joint_names."
            )
        if not np.all(np.isfinite(values)):
            raise InputError("Expected finite joint values, but got NaN or infinity; check q.")
        rows = np.atleast_2d(values)
        poses = np.empty((len(rows), len(self.parent), 4, 4))
        forward_kinematics_batch_kernel(*self.arrays, rows, poses)
        return poses if values.ndim == 2 else poses[0]

    def ancestors(self, link: int) -> list[int]:
        """Links from `link` up to the base, `link` included."""
        chain = [link]
        while self.parent[chain[-1]] >= 0:
            chain.append(int(self.parent[chain[-1]]))
        return chain

    def links_moved_by(self, coordinate: int) -> Ints:
        """Indices of the links whose pose depends on one coordinate of `q`."""
        driven = (self.coordinate == coordinate) & (self.multiplier != 0.0)
        return np.array(
            [k for k in range(len(self.parent)) if driven[self.ancestors(k)].any()], dtype=np.int64
        )

    def rigid_links(self, link: int) -> Ints:
        """Links that form one piece with `link`, joined to it by fixed joints only.

        Parameters
        ----------
        link : int
            Index of a link.

        Returns
        -------
        ndarray of int
            Indices of the links, `link` included.

        Examples
        --------
        >>> from medkit.robots import load_hand
        >>> tree = load_hand("armar3").tree
        >>> tree.rigid_links(3).tolist()
        [3]
        """
        piece = np.arange(len(self.parent))
        for k, parent in enumerate(self.parent):
            if parent >= 0 and self.kind[k] == FIXED:
                piece[k] = piece[parent]
        return np.asarray(np.flatnonzero(piece == piece[link]), dtype=np.int64)
