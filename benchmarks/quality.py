"""Epsilon and the force-closure test against Qhull and linear programming, in one run.

Times are CPU seconds of this process; trust the ratios, not the milliseconds.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull

from medkit.contacts import Contacts
from medkit.quality import closure_margin, epsilon, epsilon_many, is_force_closure

HERE = {"torque_origin": np.zeros(3), "torque_scale": 1.0}
FRICTION = 0.5
GRASPS = 15


def grasps_with(contacts: int, rng: np.random.Generator) -> list[Contacts]:
    """Random force-closure grasps of an ellipsoid-like body."""
    found: list[Contacts] = []
    while len(found) < GRASPS:
        points = rng.normal(size=(contacts, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        normals = -points + 0.3 * rng.normal(size=(contacts, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        grasp = Contacts(points * [1.0, 0.8, 0.6], normals, FRICTION)
        if is_force_closure(grasp.points, grasp.normals, friction=FRICTION, **HERE):
            found.append(grasp)
    return found


def milliseconds(call: Callable[[], object], repeats: int) -> float:
    """CPU time of one call [ms]."""
    call()
    start = time.process_time()
    for _ in range(repeats):
        call()
    return (time.process_time() - start) / repeats * 1e3


def hull_epsilon(wrenches: np.ndarray) -> float:
    """The rival: the whole hull, then its nearest facet."""
    return max(0.0, float((-ConvexHull(wrenches).equations[:, -1]).min()))


def timings(grasp: Contacts) -> tuple[float, ...]:
    """Milliseconds of Qhull, LP, epsilon, exact epsilon, closure test; the error against Qhull."""
    wrenches = grasp.wrenches(**HERE).reshape(-1, 6)
    args = (grasp.points, grasp.normals)
    kw = {"friction": FRICTION, **HERE}
    start = time.process_time()
    whole = hull_epsilon(wrenches)
    qhull = (time.process_time() - start) * 1e3
    return (
        qhull,
        milliseconds(lambda: closure_margin(wrenches), 3),
        milliseconds(lambda: epsilon(*args, **kw), 20),
        milliseconds(lambda: epsilon(*args, **kw, edges=None), 5),
        milliseconds(lambda: is_force_closure(*args, **kw), 20),
        abs(epsilon(*args, **kw).lower - whole),
    )


def run() -> None:
    """Print one row per number of contacts: medians over random grasps."""
    rng = np.random.default_rng(0)
    print(
        f"8-edge cones, medians over {GRASPS} grasps, CPU ms (ratios to Qhull and LP in brackets)"
    )
    print(
        f"{'contacts':>8} {'Qhull':>8} {'LP':>7} {'epsilon':>14} {'batch':>14} {'exact cone':>14}"
        f" {'closure':>14} {'largest difference':>20}"
    )
    for contacts in (5, 10, 20, 40):
        grasps = grasps_with(contacts, rng)
        table = np.array([timings(grasp) for grasp in grasps])
        qhull, lp, eps, exact, closure, _ = np.median(table, axis=0)
        many = [g.points for g in grasps] * 10, [g.normals for g in grasps] * 10
        batch = milliseconds(lambda m=many: epsilon_many(*m, friction=FRICTION, **HERE), 1)
        batch /= len(many[0])
        ratios = [np.median(table[:, 0] / table[:, 2]), qhull / batch, qhull / exact, lp / closure]
        cells = [
            f"{value:7.3f} ({ratio:3.0f}x)"
            for value, ratio in zip((eps, batch, exact, closure), ratios, strict=True)
        ]
        print(f"{contacts:8d} {qhull:8.1f} {lp:7.2f}", *cells, f"{table[:, 5].max():20.1e}")


if __name__ == "__main__":
    run()
