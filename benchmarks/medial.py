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
HOPELESS = 1.5  # a rival this many times slower than the better one is left out at that size
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
    a, b, c = (points[tets[:, k]] - points[tets[:, 0]] for k in (1, 2, 3))
    # closed formula: numpy's solver takes longer on small matrices than qhull on everything
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = np.sum(a * bc, axis=1)
    solid = np.abs(volume) > 1e-18
    parts = (np.sum(e * e, axis=1)[solid, None] * n[solid] for e, n in ((a, bc), (b, ca), (c, ab)))
    away = sum(parts) / (2.0 * volume[solid, None])
    near = tets[solid, 0]
    inside = np.einsum("nk,nk->n", away, sample.normals[near]) < 0.0
    return points[near[inside]] + away[inside]


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


RIVALS = {"poles": delaunay_poles, "kd ball": plain_shrinking_ball}


def rival_times(sample: SurfaceSample, before: dict[str, float], full: bool) -> dict[str, float]:
    """Microseconds a sample of the rivals; `before` holds those at the size before.

    No rival gets cheaper per sample on a finer surface: one that was far slower than what the
    other takes now cannot be the better one, and is run only when all are asked for.
    """
    times: dict[str, float] = {}
    for name in sorted(RIVALS, key=lambda n: before.get(n, 0.0)):
        best = min(times.values(), default=np.inf)
        if full or before.get(name, 0.0) < HOPELESS * best:
            runs = 3 if before.get(name, np.inf) * len(sample) < 1e6 else 1  # below a second
            seconds = cpu_seconds(lambda r=RIVALS[name]: r(sample), runs)
            before[name] = times[name] = 1e6 * seconds / len(sample)
    return times


def timed_row(label: str, mesh: trimesh.Trimesh, spacing: float | None, before: dict[str, float],
              full: bool) -> None:  # fmt: skip
    """Print one line of the axis table."""
    sample = sample_surface(mesh, spacing=spacing)
    n = len(sample)
    large = n > 30_000  # long runs vary less
    sampling = cpu_seconds(lambda: sample_surface(mesh, spacing=spacing), 1 if large else 3)
    sampling *= 1e6 / n
    ours = 1e6 * cpu_seconds(lambda: medial_axis_from_surface(sample), 3 if large else 5) / n
    times = rival_times(sample, before, full)
    cells = "".join(f"{times[r]:>9.1f}" if r in times else f"{'-':>9}" for r in RIVALS)
    print(f"{label:>14}{n:>9}{sampling:>10.1f}{ours:>9.1f}{sampling + ours:>7.1f}{cells}"
          f"{min(times.values()) / ours:>8.1f}", flush=True)  # fmt: skip


def print_head() -> None:
    print(f"{'shape':>14}{'samples':>9}{'sampling':>10}{'medkit':>9}{'sum':>7}"
          + "".join(f"{name:>9}" for name in RIVALS) + f"{'ratio':>8}")  # fmt: skip


def run_axes(full: bool) -> None:
    """Medial axis per sample, against both rivals, from 5k to 100k samples."""
    print("medial axis from samples, touch points and angles included, us per sample (sampling"
          " apart)")  # fmt: skip
    print("ratio = better rival / medkit, without sampling, which all need; -: slower than the"
          f" other by more than {HOPELESS:g} at the size before")  # fmt: skip
    print_head()
    for name, make in SHAPES.items():
        mesh, before = make(), dict[str, float]()
        for target in SIZES:
            timed_row(name, mesh, float(np.sqrt(0.89 * mesh.area / target)), before, full)


def run_folder(folder: str, full: bool) -> None:
    """The same for every mesh of a folder, at the default spacing."""
    print(f"\nmeshes of {folder} at the default spacing")
    print_head()
    for name, mesh in load_folder(folder):
        try:
            mended = repair_mesh(mesh).mesh
        except InputError as error:
            print(f"{name:>14} refused: {error}")
            continue
        timed_row(name, mended, None, {}, full)


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
    """All tables: about ten minutes of one core.

    With a folder in the variable MEDKIT_MESHES, its meshes too; with MEDKIT_FULL=1 both rivals at
    all sizes, which takes half an hour more.
    """
    full = os.environ.get("MEDKIT_FULL") == "1"
    local_symmetry(MedialSphereGrid.from_axis(filter_object_angle(medial_axis(hammer()))), 0.03)
    run_axes(full)
    if os.environ.get("MEDKIT_MESHES"):
        run_folder(os.environ["MEDKIT_MESHES"], full)
    run_symmetry()
    run_memory()
    sys.stdout.flush()
