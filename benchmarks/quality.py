"""Epsilon and the force-closure test against Qhull and linear programming, in one run.

On the grasps that the planners really test, and on random contacts. Times are CPU seconds of this
process; trust the ratios, not the milliseconds.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from medkit.contacts import Contacts
from medkit.quality import closure_margin, epsilon, epsilon_many, is_force_closure

HERE = {"torque_origin": np.zeros(3), "torque_scale": 1.0}
FRICTION = 0.5
GRASPS = 15
#: Objects and kinds of grasp that stand for what the planners ask about, and candidates of each.
PLANNED = (("mug", "power"), ("giraffe", "power"), ("dog", "power"), ("moon", "precision"),
           ("clown", "precision"), ("bottle", "precision"))  # fmt: skip
CANDIDATES = 50


def grasps_with(contacts: int, rng: np.random.Generator, tilt: float = 0.3) -> list[Contacts]:
    """Random force-closure grasps of an ellipsoid-like body; a ball when normals do not tilt."""
    shape = [1.0, 0.8, 0.6] if tilt else [1.0, 1.0, 1.0]
    found: list[Contacts] = []
    while len(found) < GRASPS:
        points = rng.normal(size=(contacts, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        normals = -points + tilt * rng.normal(size=(contacts, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        grasp = Contacts(points * shape, normals, FRICTION)
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
    try:
        return max(0.0, float((-ConvexHull(wrenches).equations[:, -1]).min()))
    except (QhullError, ValueError):  # wrenches that do not span the space
        return 0.0


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


def random_grasps() -> None:
    """Print one row per number of random contacts, and one for contacts on a ball."""
    rng = np.random.default_rng(0)
    print(f"random force-closure grasps, 8-edge cones: medians over {GRASPS} grasps, CPU ms"
          " (ratios to Qhull and LP in brackets)")  # fmt: skip
    print(
        f"{'contacts':>14} {'Qhull':>8} {'LP':>7} {'epsilon':>14} {'batch':>14} {'exact cone':>14}"
        f" {'closure':>14} {'largest difference':>20}"
    )
    for contacts, tilt in ((5, 0.3), (10, 0.3), (20, 0.3), (40, 0.3), (20, 0.0)):
        grasps = grasps_with(contacts, rng, tilt)
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
        name = f"{contacts}" if tilt else f"{contacts} on a ball"
        print(f"{name:>14} {qhull:8.1f} {lp:7.2f}", *cells, f"{table[:, 5].max():20.1e}")


def planned_grasps(name: str, kind: str) -> tuple[list[tuple[np.ndarray, np.ndarray]], dict]:
    """Contacts of every candidate that a planner closed on a named object, and its torque frame."""
    from medkit.datasets import load_object
    from medkit.grasping import plan_grasps
    from medkit.robots import load_hand

    mesh = load_object(name)
    tested = plan_grasps(
        mesh, load_hand("armar3"), grasp=kind, friction=FRICTION, max_candidates=CANDIDATES,
        rng=np.random.default_rng(0),
    )  # fmt: skip
    center = tested.object.center_mass
    reach = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    closed = [(g.points, g.normals) for g in tested.grasps if len(g.points) >= 3]
    return closed, {"friction": FRICTION, "torque_origin": center, "torque_scale": reach}


def planned_row(points: np.ndarray, normals: np.ndarray, how: dict) -> tuple[float, ...]:
    """Contacts, milliseconds of Qhull, epsilon and closure test, error against Qhull, epsilon."""
    frame = {key: how[key] for key in ("torque_origin", "torque_scale")}
    wrenches = Contacts(points, normals, FRICTION).wrenches(**frame).reshape(-1, 6)
    start = time.process_time()
    whole = hull_epsilon(wrenches)
    qhull = (time.process_time() - start) * 1e3
    value = epsilon(points, normals, **how).lower
    return (
        len(points),
        qhull,
        milliseconds(lambda: epsilon(points, normals, **how), 20),
        milliseconds(lambda: is_force_closure(points, normals, **how), 20),
        abs(value - whole),
        value,
    )


def real_grasps() -> None:
    """Print one row per object for the grasps that the planner tested, and one for all."""
    print(f"grasps as planned, all that closed with 3 contacts or more, {CANDIDATES} candidates an"
          " object: medians, CPU ms")  # fmt: skip
    print(
        f"{'':>20} {'grasps':>7} {'closed':>7} {'contacts':>8} {'Qhull':>7}"
        f" {'epsilon':>14} {'not closed':>11} {'batch':>7} {'largest difference':>20}"
    )
    tables, batches = [], []
    for name, kind in PLANNED:
        grasps, how = planned_grasps(name, kind)
        table = np.array([planned_row(*grasp, how) for grasp in grasps]).reshape(-1, 6)
        points, normals = [p for p, _ in grasps], [n for _, n in grasps]
        batch = milliseconds(lambda p=points, n=normals, h=how: epsilon_many(p, n, **h), 3)
        tables.append(table)
        batches.append(batch / len(grasps))
        print_planned(f"{name} {kind}", table, batches[-1])
    print_planned("all", np.vstack(tables), float(np.median(batches)))


def print_planned(name: str, table: np.ndarray, batch: float) -> None:
    """One row of the table of planned grasps."""
    closed = table[:, 5] > 0.0
    apart = f"{np.median(table[~closed, 2]):11.3f}" if not closed.all() else f"{'-':>11}"
    ratio = np.median(table[closed, 1] / table[closed, 2])
    print(
        f"{name:>20} {len(table):7d} {closed.mean():7.0%} {np.median(table[:, 0]):8.0f}"
        f" {np.median(table[closed, 1]):7.1f} {np.median(table[closed, 2]):7.3f} ({ratio:3.0f}x)"
        f" {apart} {batch:7.3f} {table[:, 4].max():20.1e}"
    )


def run() -> None:
    """Both tables."""
    real_grasps()
    print()
    random_grasps()


if __name__ == "__main__":
    run()
