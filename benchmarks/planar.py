"""The phase diagram, and the exact medial axis against point-sampled rivals, in one run.

CPU seconds of this process where one process works, wall-clock seconds for the diagram on two.
Trust the ratios.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import Voronoi

from medkit import planar


def seconds(call: Callable[[], object], repeats: int = 3) -> float:
    """Median CPU time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return statistics.median(times)


def polygon(corners: int) -> planar.Outline:
    """Wavy polygon with a given number of corners, reflex ones among them."""
    turn = np.arange(corners) * (2 * np.pi / corners)
    reach = 0.04 * (1.0 + 0.25 * np.cos(3 * turn) + 0.1 * np.cos(7 * turn))
    return planar.outline_from_loops(reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]))


def brute_axis(outline: planar.Outline, tangent_samples: int = 400) -> np.ndarray:
    """Rival 1: from points along the edges, halve the radius of the tangent disk until it fits.

    Every step asks for the distance from all edges; thirty halvings give nine digits.
    """
    share = (np.arange(tangent_samples) + 0.5) / tangent_samples * outline.lengths.sum()
    edge = np.searchsorted(np.cumsum(outline.lengths), share)
    before = np.concatenate([[0.0], np.cumsum(outline.lengths)[:-1]])[edge]
    foot = outline.starts[edge] + (share - before)[:, None] * outline.tangents[edge]
    low, high = np.zeros(len(foot)), np.full(len(foot), 2 * outline.characteristic_length)
    for _ in range(30):
        middle = 0.5 * (low + high)
        center = foot + middle[:, None] * outline.inward_normals[edge]
        fits = outline.distance(center) >= middle * (1 - 1e-9)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return foot + low[:, None] * outline.inward_normals[edge]


def sampled_axis(outline: planar.Outline, count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Rival 2: Voronoi diagram of points on the outline; its vertices inside, and their radii."""
    share = (np.arange(count) + 0.5) / count * outline.lengths.sum()
    edge = np.searchsorted(np.cumsum(outline.lengths), share)
    before = np.concatenate([[0.0], np.cumsum(outline.lengths)[:-1]])[edge]
    points = outline.starts[edge] + (share - before)[:, None] * outline.tangents[edge]
    diagram = Voronoi(points)
    nearest = np.full(len(diagram.vertices), -1)
    for point, region in enumerate(diagram.point_region):
        nearest[[vertex for vertex in diagram.regions[region] if vertex >= 0]] = point
    inside = outline.contains(diagram.vertices)
    center = diagram.vertices[inside]
    return center, np.linalg.norm(center - points[nearest[inside]], axis=1)


def axis_rows() -> list[dict[str, float]]:
    """Exact axis and both rivals over the number of edges."""
    rows = []
    for corners in (25, 50, 100, 200, 400):
        outline = polygon(corners)
        exact = seconds(lambda o=outline: planar.medial_axis(o))
        brute = seconds(lambda o=outline: brute_axis(o), repeats=1)
        voronoi = seconds(lambda o=outline: sampled_axis(o), repeats=1)
        axis = planar.medial_axis(outline)
        center, radius = sampled_axis(outline)
        error = np.abs(outline.distance(axis.centers) - axis.radii).max()
        rows.append({
            "edges": corners, "disks": len(axis), "exact_s": exact, "exact_ms_per_disk":
            1e3 * exact / len(axis), "exact_error_m": float(error), "brute_ms_per_disk":
            1e3 * brute / 400, "voronoi_s": voronoi, "voronoi_error_m":
            float(np.abs(outline.distance(center) - radius).max()),
        })  # fmt: skip
    return rows


def phase_row(side: int, jobs: int) -> dict[str, float]:
    """Wall-clock time of a phase diagram of side x side squeezes, and where it differs."""
    start = time.perf_counter()
    diagram = planar.phase_diagram(
        np.radians(np.linspace(91.0, 176.0, side)), np.linspace(0.03, 1.1, side), jobs=jobs,
        progress=True,
    )  # fmt: skip
    return {"squeezes": side * side, "jobs": jobs, "wall_s": time.perf_counter() - start,
            "disagreements": diagram.disagreements}  # fmt: skip


def run() -> dict[str, list[dict[str, float]]]:
    """Run everything and print it."""
    planar.medial_axis(polygon(8))
    results = {"medial axis": axis_rows(), "phase diagram": [phase_row(30, 2)]}
    for name, rows in results.items():
        print(name)
        for row in rows:
            print("  " + "  ".join(f"{key} {value:.3g}" for key, value in row.items()))
    return results


if __name__ == "__main__":
    run()
