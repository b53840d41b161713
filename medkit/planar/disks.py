"""Medial disks: the axis that they make, and the angle and the span of one of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats, expected
from medkit.planar.outlines import Outline

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class MedialAxis:
    """Medial disks of an outline with the branches they lie on.

    Attributes
    ----------
    outline : Outline
        The region.
    centers : ndarray, shape (n, 2)
        Centres of the disks [m].
    radii : ndarray, shape (n,)
        Radii [m].
    object_angles : ndarray, shape (n,)
        Largest angle at the centre between two touch points [rad], in [0, pi].
    touch_points : ndarray, shape (n, 2, 2)
        The two touch points that make this angle [m].
    spans : ndarray, shape (n,)
        Radius of the smallest circle around all touch points [m]: the lambda of the lambda axis.
    branch : ndarray of int, shape (n,)
        Branch of the disk; -1 for disks at a node, where branches meet.
    node_centers : ndarray, shape (m, 2)
        Where branches end or meet [m].
    node_radii : ndarray, shape (m,)
        Radii there [m]; zero in convex corners.
    branch_nodes : ndarray of int, shape (b, 2)
        Nodes at both ends of each branch.
    """

    outline: Outline
    centers: Floats
    radii: Floats
    object_angles: Floats
    touch_points: Floats
    spans: Floats
    branch: Ints
    node_centers: Floats
    node_radii: Floats
    branch_nodes: Ints

    def __len__(self) -> int:
        return len(self.radii)

    def keep(self, mask: NDArray[np.bool_]) -> MedialAxis:
        """Return the axis with only the disks of a boolean mask; nodes and branches stay."""
        return MedialAxis(
            self.outline, self.centers[mask], self.radii[mask], self.object_angles[mask],
            self.touch_points[mask], self.spans[mask], self.branch[mask],
            self.node_centers, self.node_radii, self.branch_nodes,
        )  # fmt: skip

    @cached_property
    def graph(self) -> nx.MultiGraph:
        """Nodes and branches as a networkx multigraph; every hole of the outline is a cycle."""
        graph: nx.MultiGraph = nx.MultiGraph()
        for node, (center, radius) in enumerate(
            zip(self.node_centers, self.node_radii, strict=True)
        ):
            graph.add_node(node, center=tuple(center), radius=float(radius))
        for index, (first, last) in enumerate(self.branch_nodes):
            graph.add_edge(int(first), int(last), key=index)
        return graph

    @cached_property
    def lengths(self) -> Floats:
        """Length of the axis that each disk stands for, shape (n,) [m]; zero at nodes.

        Half the way to both neighbours along the branch, and all the way to a node. Needs the
        unfiltered axis.
        """
        result = np.zeros(len(self))
        for index in range(len(self.branch_nodes)):
            steps = np.linalg.norm(np.diff(self.branch_curve(index), axis=0), axis=1)
            share = np.concatenate([steps[:1], 0.5 * steps[1:-1]])
            share = share + np.concatenate([0.5 * steps[1:-1], steps[-1:]])
            inner = np.flatnonzero(self.branch == index)
            result[inner] = share[: len(inner)]
        return result

    def branch_curve(self, index: int) -> Floats:
        """Centres along one branch, in order from its first to its last node, shape (k, 2) [m]."""
        first, last = self.branch_nodes[index]
        inner = self.centers[self.branch == index]
        return np.vstack([self.node_centers[first], inner, self.node_centers[last]])


def checked_axis(axis: Any) -> MedialAxis:
    """Return a medial axis as it is, or raise `InputError` that says how to make one."""
    return expected(axis, MedialAxis, "a planar medial axis", "pass medial_axis(outline)")


def angle_between(first: Floats, second: Floats) -> Floats:
    """Angle between planar vectors of shape (..., 2), in [0, pi] [rad], exact near 0 and pi."""
    cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return np.asarray(np.arctan2(np.abs(cross), (first * second).sum(axis=-1)))


def node_disk(center: Floats, touches: Floats) -> tuple[float, Floats, float]:
    """Largest angle, its two touch points, and the span, of a disk with several touch points.

    Parameters
    ----------
    center : ndarray, shape (2,)
        Centre [m].
    touches : ndarray, shape (k, 2)
        Touch points [m], repeats allowed.

    Returns
    -------
    angle : float
        Object angle [rad].
    pair : ndarray, shape (2, 2)
        Touch points that make it [m].
    span : float
        Radius of the smallest circle around the touch points [m].
    """
    spokes = touches - center
    angles = angle_between(spokes[:, None], spokes[None, :])
    i, j = np.unravel_index(int(np.argmax(angles)), angles.shape)
    radius = float(np.linalg.norm(spokes, axis=1).mean())
    facing = np.sort(np.arctan2(spokes[:, 1], spokes[:, 0]))
    gap = float(np.max(np.diff(np.append(facing, facing[0] + 2 * np.pi))))
    # touch points all around the disk: no smaller circle holds them
    span = radius if gap <= np.pi else radius * float(np.sin(angles[i, j] / 2))
    return float(angles[i, j]), touches[[i, j]], span
