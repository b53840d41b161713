"""Compiled forward kinematics, to be called alone or from other compiled loops."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2


@njit(cache=True)
def joint_motion(kind: int, axis: NDArray, value: float, motion: NDArray) -> None:
    """Write the transform (4, 4) of one joint at `value` [rad or m] into `motion`."""
    motion[:] = 0.0
    motion[0, 0] = motion[1, 1] = motion[2, 2] = motion[3, 3] = 1.0
    if kind == 2:
        for i in range(3):
            motion[i, 3] = axis[i] * value
    elif kind == 1:
        sine, cosine = np.sin(value), np.cos(value)
        x, y, z = axis[0], axis[1], axis[2]
        rest = 1.0 - cosine
        motion[0, 0] = cosine + x * x * rest
        motion[0, 1] = x * y * rest - z * sine
        motion[0, 2] = x * z * rest + y * sine
        motion[1, 0] = y * x * rest + z * sine
        motion[1, 1] = cosine + y * y * rest
        motion[1, 2] = y * z * rest - x * sine
        motion[2, 0] = z * x * rest - y * sine
        motion[2, 1] = z * y * rest + x * sine
        motion[2, 2] = cosine + z * z * rest


@njit(cache=True)
def rigid_product(first: NDArray, second: NDArray, out: NDArray) -> None:
    """Write the product of two rigid transforms (4, 4) into `out`, a third array."""
    for i in range(3):
        for j in range(4):
            out[i, j] = (
                first[i, 0] * second[0, j] + first[i, 1] * second[1, j] + first[i, 2] * second[2, j]
            )
        out[i, 3] += first[i, 3]
        out[3, i] = 0.0
    out[3, 3] = 1.0


@njit(cache=True)
def forward_kinematics_kernel(
    parent: NDArray,
    placement: NDArray,
    axis: NDArray,
    kind: NDArray,
    coordinate: NDArray,
    multiplier: NDArray,
    offset: NDArray,
    q: NDArray,
    poses: NDArray,
) -> None:
    """Write the pose of every link at `q` (nq,) into `poses` (L, 4, 4).

    The first seven arguments are `KinematicTree.arrays`; parents come before their children.
    """
    at_joint = np.empty((4, 4))
    motion = np.empty((4, 4))
    for link in range(parent.shape[0]):
        if parent[link] < 0:
            at_joint[:] = placement[link]
        else:
            rigid_product(poses[parent[link]], placement[link], at_joint)
        if kind[link] == 0:
            poses[link] = at_joint
        else:
            value = offset[link]
            if coordinate[link] >= 0:
                value += multiplier[link] * q[coordinate[link]]
            joint_motion(kind[link], axis[link], value, motion)
            rigid_product(at_joint, motion, poses[link])


@njit(cache=True)
def forward_kinematics_batch_kernel(
    parent: NDArray,
    placement: NDArray,
    axis: NDArray,
    kind: NDArray,
    coordinate: NDArray,
    multiplier: NDArray,
    offset: NDArray,
    q: NDArray,
    poses: NDArray,
) -> None:
    """Write the link poses of every row of `q` (B, nq) into `poses` (B, L, 4, 4)."""
    for row in range(q.shape[0]):
        forward_kinematics_kernel(
            parent, placement, axis, kind, coordinate, multiplier, offset, q[row], poses[row]
        )
