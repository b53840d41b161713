"""Medial axis and local symmetry against rivals in the same run; CPU time of one core."""

from __future__ import annotations

import importlib.util
import os
import statistics
import sys
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import trimesh
from scipy.spatial import Delaunay, cKDTree

from medkit.datasets import load_folder
from medkit.errors import InputError
from medkit.grasping import (
    MedialAxis,
    MedialSphereGrid,
    SurfaceSample,
    filter_object_angle,
    local_symmetry,
    medial_axis,
    sample_surface,
)
from medkit.medial.axis import medial_axis_from_surface
from medkit.meshes import repair_mesh

create = trimesh.creation
SIZES = (5_000, 10_000, 20_000, 50_000, 100_000)
RIVAL_SECONDS = 1.0  # CPU time on one shape after which a rival is not run on larger ones
P13_MS = (6.0, 37.0)  # P13 table 5.6, per sphere, on the hardware of 2013


def bumpy_sphere() -> trimesh.Trimesh:
    ball = create.icosphere(5, 1.0)
    x, y, z = 6.0 * ball.vertices.T
    height = 1.0 + 0.08 * np.sin(x) * np.sin(y + 1.0) * np.sin(z + 2.0)
    return trimesh.Trimesh(0.05 * ball.vertices * height[:, None], ball.faces)


def mug() -> trimesh.Trimesh:
    outer, inner = create.cylinder(0.04, 0.1, sections=64), create.cylinder(0.036, 0.1, sections=64)
    inner.apply_translation([0.0, 0.0, 0.004])
    handle = create.torus(0.025, 0.006, 48, 24)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([0.042, 0.0, 0.0])
    body = trimesh.boolean.union([outer, handle], engine="manifold")
    return trimesh.boolean.difference([body, inner], engine="manifold")


def hammer() -> trimesh.Trimesh:
    head = create.box((0.1, 0.03, 0.03))
    head.apply_translation([0.01, 0.0, 0.125])
    return trimesh.boolean.union(
        [create.cylinder(0.012, 0.25, sections=48), head], engine="manifold"
    )


SHAPES: dict[str, Callable[[], trimesh.Trimesh]] = {
    "bumpy sphere": bumpy_sphere,
    "ball": lambda: create.icosphere(4, 0.05),
    "capsule": lambda: create.capsule(0.2, 0.03, count=[32, 32]),
    "torus": lambda: create.torus(0.08, 0.02, 64, 32),
    "box": lambda: create.box((0.2, 0.1, 0.05)),
    "mug": mug,
    "hammer": hammer,
}


def delaunay_poles(sample: SurfaceSample) -> np.ndarray:
    """Rival: circumcentres of the Delaunay tetrahedra that lie inside, by the nearest normal."""
    points = sample.points
    tets = Delaunay(points).simplices
    base = points[tets[:, 0]]
    edges = points[tets[:, 1:]] - base[:, None]
    solid = np.abs(np.linalg.det(edges)) > 1e-18
    half = 0.5 * np.einsum("nij,nij->ni", edges[solid], edges[solid])
    centers = base[solid] + np.linalg.solve(edges[solid], half[..., None])[..., 0]
    near = tets[solid, 0]
    inside = np.einsum("nk,nk->n", points[near] - centers, sample.normals[near]) > 0.0
    return centers[inside]


def plain_shrinking_ball(sample: SurfaceSample) -> np.ndarray:
    """Rival: the usual shrinking ball, all samples at once, on scipy's k-d tree."""
    points, normals = sample.points, sample.normals
    tree = cKDTree(points)
    radii = np.full(len(points), 0.5 * sample.diagonal)
    active = np.arange(len(points))
    for _ in range(30):
        centers = points[active] - radii[active, None] * normals[active]
        distance, nearest = tree.query(centers)
        inside = distance < radii[active] - 0.1 * sample.spacing
        active, nearest = active[inside], nearest[inside]
        if not len(active):
            break
        away = points[active] - points[nearest]
        depth = np.einsum("nk,nk->n", away, normals[active])
        shrunk = np.sum(away**2, axis=1) / np.maximum(2.0 * depth, 1e-12)
        radii[active] = np.minimum(shrunk, radii[active])
    return points - radii[:, None] * normals


def cpu_seconds(function: Callable[[], object], runs: int = 3) -> float:
    """Median CPU time of a call [s]."""
    times = []
    for _ in range(runs):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return statistics.median(times)


def timed_row(label: str, sample: SurfaceSample, sampling: float, spent: dict[str, float]) -> None:
    """Print one line of the axis table; a rival that has used up its time is left out."""
    n = len(sample)
    ours = 1e6 * cpu_seconds(lambda: medial_axis_from_surface(sample)) / n
    rivals = {"poles": delaunay_poles, "kd ball": plain_shrinking_ball}
    times = {}
    for name, rival in rivals.items():
        if spent[name] < RIVAL_SECONDS:
            seconds = cpu_seconds(lambda r=rival: r(sample), 1)
            spent[name] += seconds
            times[name] = 1e6 * seconds / n
    cells = "".join(f"{times[name]:>9.1f}" if name in times else f"{'-':>9}" for name in rivals)
    ratio = f"{min(times.values()) / ours:>8.1f}" if times else f"{'-':>8}"
    print(f"{label:>14}{n:>9}{1e6 * sampling / n:>10.1f}{ours:>9.1f}{cells}{ratio}", flush=True)


def run_axes() -> None:
    """Medial axis per sample, against both rivals, from 5k to 100k samples."""
    print("medial axis from samples, touch points and angles included, us per sample (sampling"
          " apart)")  # fmt: skip
    print(f"ratio = better rival / medkit; a rival is stopped after {RIVAL_SECONDS:g} s a shape")
    print(f"{'shape':>14}{'samples':>9}{'sampling':>10}{'medkit':>9}{'poles':>9}"
          f"{'kd ball':>9}{'ratio':>8}")  # fmt: skip
    for name, make in SHAPES.items():
        mesh, spent = make(), {"poles": 0.0, "kd ball": 0.0}
        for target in SIZES:
            spacing = float(np.sqrt(0.89 * mesh.area / target))
            start = time.process_time()
            sample = sample_surface(mesh, spacing=spacing)
            timed_row(name, sample, time.process_time() - start, spent)


def run_folder(folder: str) -> None:
    """The same for every mesh of a folder, at the default spacing."""
    print(f"\nmeshes of {folder} at the default spacing")
    for name, mesh in load_folder(folder):
        try:
            mended = repair_mesh(mesh).mesh
        except InputError as error:
            print(f"{name:>14} refused: {error}")
            continue
        start = time.process_time()
        sample = sample_surface(mended)
        timed_row(name, sample, time.process_time() - start, {"poles": 0.0, "kd ball": 0.0})


def sheet(n: int) -> MedialAxis:
    """The medial sheet of a plate, n spheres on a square of unit density per (1 mm)^2."""
    side = 1e-3 * np.sqrt(n)
    centers = np.random.default_rng(0).uniform(size=(n, 3)) * [side, side, 1e-5]
    return MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 1e-3, side)


def tree_symmetry(axis: MedialAxis, radius: float) -> None:
    """Rival: scipy's k-d tree and numpy's eigenvectors."""
    tree = cKDTree(axis.centers)
    for members in tree.query_ball_point(axis.centers, radius):
        near = axis.centers[members]
        near = near - near.mean(axis=0)
        np.linalg.eigh(near.T @ near)


def run_symmetry() -> None:
    """Neighbourhood and PCA per sphere at 300 neighbours and constant density."""
    radius = 1e-3 * np.sqrt(300 / np.pi)
    print("\nneighbourhood and PCA, us per sphere at 300 neighbours")
    print(f"{'spheres':>9}{'medkit':>9}{'cKDTree':>9}{'ratio':>8}{'P13 / medkit':>18}")
    for n in (2_000, 10_000, 50_000):
        axis = sheet(n)
        grid = MedialSphereGrid.from_axis(axis)
        ours = 1e6 * cpu_seconds(lambda g=grid: local_symmetry(g, radius), 5) / n
        few = axis.select(np.arange(min(n, 2_000)))
        rival = 1e6 * cpu_seconds(lambda a=few: tree_symmetry(a, radius), 1) / len(few)
        span = " to ".join(f"{1e3 * ms / ours:.0f}" for ms in P13_MS)
        print(f"{n:>9}{ours:>9.2f}{rival:>9.1f}{rival / ours:>8.1f}{span:>18}")
        if importlib.util.find_spec("open3d"):
            print(f"{'open3d':>9}{open3d_symmetry(axis, radius):>9.1f}")


def open3d_symmetry(axis: MedialAxis, radius: float) -> float:
    """Microseconds per sphere of open3d's covariances in a radius."""
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(axis.centers))
    search = open3d.geometry.KDTreeSearchParamRadius(radius)
    return 1e6 * cpu_seconds(lambda: cloud.estimate_covariances(search), 3) / len(axis)


def run_memory() -> None:
    """Peak of Python's and numpy's memory over the sample number."""
    print("\npeak memory of medial_axis with sampling [MB]")
    mesh = create.torus(0.08, 0.02, 64, 32)
    for target in (25_000, 50_000, 100_000):
        tracemalloc.start()
        sample = sample_surface(mesh, spacing=float(np.sqrt(0.89 * mesh.area / target)))
        medial_axis_from_surface(sample)
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        print(f"{len(sample):>9}{peak:>9.0f}")


def run() -> None:
    """All tables; with a folder in the variable MEDKIT_MESHES, its meshes too."""
    local_symmetry(MedialSphereGrid.from_axis(filter_object_angle(medial_axis(hammer()))), 0.03)
    run_axes()
    if os.environ.get("MEDKIT_MESHES"):
        run_folder(os.environ["MEDKIT_MESHES"])
    run_symmetry()
    run_memory()
    sys.stdout.flush()
