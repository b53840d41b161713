"""Neighbourhood and PCA of medial spheres against rivals in the same run; CPU time of one core."""

from __future__ import annotations

import importlib
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from medkit.datasets import load_object, load_printed
from medkit.medial import (
    MedialAxis,
    MedialSphereGrid,
    filter_object_angle,
    local_symmetry,
    medial_axis,
)

NEIGHBORS = 300
RIVAL_SPHERES = 1_000  # the slow rival is asked about so many
NO_OPEN3D = "open3d is not installed here: its column stays empty (pip install open3d fills it)"


def as_axis(centers: np.ndarray) -> MedialAxis:
    """Centres alone, as an axis: local symmetry reads nothing else."""
    n = len(centers)
    return MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 1e-3, 1.0)


def sheet(n: int) -> tuple[MedialAxis, float]:
    """The sheet of a plate and the radius that holds 300 neighbours inside it [m]."""
    side = 1e-3 * np.sqrt(n)
    centers = np.random.default_rng(0).uniform(size=(n, 3)) * [side, side, 1e-5]
    return as_axis(centers), 1e-3 * np.sqrt(NEIGHBORS / np.pi)


def cube(n: int) -> tuple[MedialAxis, float]:
    """Random centres in a cube, which no object has: most cells to open for 300 neighbours."""
    centers = np.random.default_rng(0).uniform(size=(n, 3)) * 1e-3 * np.cbrt(n)
    return as_axis(centers), 1e-3 * np.cbrt(0.75 * NEIGHBORS / np.pi)


def line(n: int) -> tuple[MedialAxis, float]:
    """The axis of a rod."""
    centers = np.random.default_rng(0).uniform(size=(n, 3)) * [1e-3 * n, 1e-5, 1e-5]
    return as_axis(centers), 1e-3 * NEIGHBORS / 2.0


def of_object(name: str) -> tuple[MedialAxis, float]:
    """A shipped object sampled at 4 mm, and the radius with 300 neighbours in the median [m]."""
    axis = filter_object_angle(medial_axis(load_object(name), spacing=0.004))
    some = axis.centers[:: max(1, len(axis) // 200)]
    apart = np.sort(np.linalg.norm(some[:, None] - axis.centers, axis=2), axis=1)
    return axis, float(np.median(apart[:, min(NEIGHBORS, len(axis)) - 1]))


def cpu_microseconds(function: Callable[[], object], spheres: int, runs: int) -> float:
    """Median CPU time of a call, per sphere [us]."""
    function()
    times = []
    for _ in range(runs):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return 1e6 * statistics.median(times) / spheres


def tree_pca(axis: MedialAxis, radius: float) -> float:
    """Rival: scipy's k-d tree and numpy's eigenvectors [us per sphere]."""
    tree = cKDTree(axis.centers)
    where = axis.centers[:: max(1, len(axis) // RIVAL_SPHERES)]

    def run_once() -> None:
        for members in tree.query_ball_point(where, radius):
            near = axis.centers[members]
            near = near - near.mean(axis=0)
            np.linalg.eigh(near.T @ near)

    return cpu_microseconds(run_once, len(where), 3)


def open3d_covariances(axis: MedialAxis, radius: float, open3d: Any) -> float:
    """Rival: open3d's covariances within a radius, without eigenvectors [us per sphere]."""
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(axis.centers))
    search = open3d.geometry.KDTreeSearchParamRadius(radius)
    return cpu_microseconds(lambda: cloud.estimate_covariances(search), len(axis), 3)


def run() -> None:
    """Table of microseconds per sphere and ratios."""
    try:
        open3d = importlib.import_module("open3d")
    except ImportError:
        open3d = None
        print(NO_OPEN3D)
    printed = 1e3 * load_printed("timing_symmetry").time_s.dropna()  # [ms]
    print("neighbourhood and PCA, us per sphere; P13's times hold the making of candidates too")
    print(f"{'set':>14}{'spheres':>9}{'found':>7}{'medkit':>8}{'cKDTree':>9}{'ratio':>7}"
          f"{'open3d':>8}{'ratio':>7}{'P13 / medkit':>16}")  # fmt: skip
    sets: dict[str, tuple[MedialAxis, float]] = {}
    for n in (2_000, 10_000, 50_000):
        sets |= {f"sheet {n}": sheet(n), f"cube {n}": cube(n), f"line {n}": line(n)}
    sets |= {name: of_object(name) for name in ("mug", "giraffe", "cereal_box")}
    for name, (axis, radius) in sets.items():
        grid = MedialSphereGrid.from_axis(axis)
        found = local_symmetry(grid, radius).counts.mean()
        ours = cpu_microseconds(partial(local_symmetry, grid, radius), len(axis), 7)
        tree = tree_pca(axis, radius)
        other = open3d_covariances(axis, radius, open3d) if open3d else float("nan")
        span = f"{1e3 * printed.min() / ours:.0f} to {1e3 * printed.max() / ours:.0f}"
        print(f"{name:>14}{len(axis):>9}{found:>7.0f}{ours:>8.2f}{tree:>9.1f}{tree / ours:>7.0f}"
              f"{other:>8.1f}{other / ours:>7.1f}{span:>16}", flush=True)  # fmt: skip
