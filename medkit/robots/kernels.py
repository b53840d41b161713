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


@njit(cache=True)
def boxes_apart(first: NDArray, second: NDArray, half_a: NDArray, half_b: NDArray) -> bool:
    """Whether two boxes, given by their poses (4, 4) and half edges (3,), surely do not touch.

    Tests the fifteen separating axes: face normals and cross products of edges.
    """
    turn = np.empty((3, 3))
    reach = np.empty((3, 3))
    shift = np.empty(3)
    for i in range(3):
        shift[i] = 0.0
        for k in range(3):
            shift[i] += first[k, i] * (second[k, 3] - first[k, 3])
        for j in range(3):
            turn[i, j] = 0.0
            for k in range(3):
                turn[i, j] += first[k, i] * second[k, j]
            reach[i, j] = abs(turn[i, j]) + 1e-12
    for i in range(3):
        span = half_b[0] * reach[i, 0] + half_b[1] * reach[i, 1] + half_b[2] * reach[i, 2]
        if abs(shift[i]) > half_a[i] + span:
            return True
        gap = shift[0] * turn[0, i] + shift[1] * turn[1, i] + shift[2] * turn[2, i]
        span = half_a[0] * reach[0, i] + half_a[1] * reach[1, i] + half_a[2] * reach[2, i]
        if abs(gap) > half_b[i] + span:
            return True
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            u, v = (j + 1) % 3, (j + 2) % 3
            gap = shift[m] * turn[k, j] - shift[k] * turn[m, j]
            span = half_a[k] * reach[m, j] + half_a[m] * reach[k, j]
            span += half_b[u] * reach[i, v] + half_b[v] * reach[i, u]
            if abs(gap) > span:
                return True
    return False


@njit(cache=True)
def near_pairs_kernel(
    links: NDArray, owner: NDArray, middle: NDArray, half: NDArray, pairs: NDArray, near: NDArray
) -> None:
    """Write into `near` (p,) whether the boxes of each pair of bodies (p, 2) may touch.

    `links` (L, 4, 4) are poses, `owner` (n,) the link of each body, `middle` and `half` (n, 3)
    its box in the frame of the link.
    """
    count = owner.shape[0]
    boxes = np.empty((count, 4, 4))
    for body in range(count):
        pose = links[owner[body]]
        boxes[body] = pose
        for i in range(3):
            for k in range(3):
                boxes[body, i, 3] += pose[i, k] * middle[body, k]
    for row in range(pairs.shape[0]):
        a, b = pairs[row]
        near[row] = not boxes_apart(boxes[a], boxes[b], half[a], half[b])
