"""Compiled measures of triangles, and balls around them as blocks of a tree.

Sums run from first to last, as numpy's do, so that the same tree comes out.
"""

from __future__ import annotations

import numpy as np

from medkit.grasping.closing.kernel_options import exact


@exact
def longest_edges(triangles: np.ndarray, length: np.ndarray, edge: np.ndarray) -> None:
    """Length (n,) [m] and number (n,) of the longest edge of each triangle (n, 3, 3)."""
    for t in range(len(triangles)):
        longest, which = -1.0, 0
        for a in range(3):
            b = (a + 1) % 3
            x = triangles[t, b, 0] - triangles[t, a, 0]
            y = triangles[t, b, 1] - triangles[t, a, 1]
            z = triangles[t, b, 2] - triangles[t, a, 2]
            side = np.sqrt(x * x + y * y + z * z)
            if side > longest:
                longest, which = side, a
        length[t], edge[t] = longest, which


@exact
def node_balls(corners: np.ndarray, level: int, balls: np.ndarray) -> None:
    """Balls (2 ** level, 4) around the boxes' middles of the nodes' corners (n, c, 3)."""
    count = len(corners)
    for k in range(len(balls)):
        low, high = (count * k) >> level, (count * (k + 1)) >> level
        for a in range(3):
            least = most = corners[low, 0, a]
            for i in range(low, high):
                for j in range(corners.shape[1]):
                    least, most = min(least, corners[i, j, a]), max(most, corners[i, j, a])
            balls[k, a] = 0.5 * (least + most)
        most = 0.0
        for i in range(low, high):
            for j in range(corners.shape[1]):
                x, y = corners[i, j, 0] - balls[k, 0], corners[i, j, 1] - balls[k, 1]
                z = corners[i, j, 2] - balls[k, 2]
                most = max(most, x * x + y * y + z * z)
        balls[k, 3] = np.sqrt(most)
