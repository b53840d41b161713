"""Studies of the squeeze: wedges with bisection, the phase diagram, and who agrees with whom."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from tqdm import tqdm

from medkit.arguments import numbers, whole
from medkit.geometry import Floats, expected, nonnegative, positive
from medkit.planar.bounds import is_antipodal, min_friction
from medkit.planar.closure import is_force_closure
from medkit.planar.disks import MedialAxis
from medkit.planar.medial import medial_axis
from medkit.planar.outlines import Outline
from medkit.planar.settings import DEFAULTS, SqueezeSettings
from medkit.planar.shapes import wedge
from medkit.planar.squeezing import squeeze


def simulated_critical_friction(
    outline: Outline,
    p1: ArrayLike,
    p2: ArrayLike,
    *,
    low: float,
    high: float,
    tolerance: float = 1e-3,
    settings: SqueezeSettings = DEFAULTS,
    **fixture: Any,
) -> float:
    """Friction at which a simulated squeeze begins to hold, by bisection.

    Parameters
    ----------
    outline : Outline
        The object.
    p1, p2 : array-like, shape (2,)
        Contact points [m].
    low, high : float
        Friction to search between [1].
    tolerance : float
        Width of the last interval relative to its upper end [1].
    settings : SqueezeSettings
        How each squeeze is simulated.
    **fixture
        Passed on to :func:`medkit.planar.squeeze`.

    Returns
    -------
    float
        Middle of the last interval [1]; `high` when even that slips, `low` when that holds.
    """
    low, high = nonnegative(low, "low"), positive(high, "high")
    tolerance = positive(tolerance, "tolerance")

    def holds(friction: float) -> bool:
        return squeeze(outline, p1, p2, friction=friction, settings=settings, **fixture).held

    if not holds(high):
        return high
    if holds(low):
        return low
    while high - low > tolerance * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 0.5 * (low + high)


def wedge_family(
    object_angles: ArrayLike, *, settings: SqueezeSettings = DEFAULTS, tolerance: float = 1e-3
) -> pd.DataFrame:
    """Critical friction of wedges, simulated, beside the bound.

    Parameters
    ----------
    object_angles : array-like, shape (n,)
        Object angles [rad], below pi.
    settings : SqueezeSettings
        How each squeeze is simulated.
    tolerance : float
        Relative width at which the bisection stops [1].

    Returns
    -------
    DataFrame
        Columns object_angle [rad], bound [1], simulated [1], deviation [1] = simulated / bound
        minus one.
    """
    rows = []
    for angle in numbers(object_angles, "object_angles"):
        outline, touch = wedge(float(angle))
        bound = min_friction(float(angle))
        found = simulated_critical_friction(
            outline, *touch, low=0.5 * bound, high=2.0 * bound, tolerance=tolerance,
            settings=settings,
        )  # fmt: skip
        rows.append((float(angle), bound, found, found / bound - 1.0))
    return pd.DataFrame(rows, columns=["object_angle", "bound", "simulated", "deviation"])


@dataclass(frozen=True)
class PhaseDiagram:
    """Verdicts of simulated squeezes of wedges over object angle and friction.

    Attributes
    ----------
    object_angles : ndarray, shape (n,)
        Object angles [rad].
    frictions : ndarray, shape (m,)
        Coefficients of friction [1].
    held : ndarray of bool, shape (n, m)
        What the simulation said.
    predicted : ndarray of bool, shape (n, m)
        What the bound says.
    """

    object_angles: Floats
    frictions: Floats
    held: NDArray[np.bool_]
    predicted: NDArray[np.bool_]

    @property
    def disagreements(self) -> int:
        """Number of cells where simulation and bound differ."""
        return int((self.held != self.predicted).sum())


def phase_diagram(
    object_angles: ArrayLike,
    frictions: ArrayLike,
    *,
    settings: SqueezeSettings = DEFAULTS,
    jobs: int = 1,
    progress: bool = False,
) -> PhaseDiagram:
    """Squeeze a wedge for every object angle and every friction.

    Parameters
    ----------
    object_angles : array-like, shape (n,)
        Object angles [rad].
    frictions : array-like, shape (m,)
        Coefficients of friction [1].
    settings : SqueezeSettings
        How each squeeze is simulated.
    jobs : int
        Processes to use; the result does not depend on it.
    progress : bool
        Show a progress bar over the object angles.

    Returns
    -------
    PhaseDiagram
        Simulated and predicted verdicts.
    """
    angles, levels = numbers(object_angles, "object_angles"), numbers(frictions, "frictions")
    work = partial(_phase_row, frictions=levels, settings=settings)
    rows = _mapped(work, angles.tolist(), jobs, progress)
    predicted = [[is_antipodal(a, friction=mu) for mu in levels] for a in angles]
    return PhaseDiagram(angles, levels, np.array(rows), np.array(predicted))


def _phase_row(angle: float, *, frictions: Floats, settings: SqueezeSettings) -> list[bool]:
    outline, touch = wedge(angle)
    return [squeeze(outline, *touch, friction=mu, settings=settings).held for mu in frictions]


def _mapped(work: Callable[[Any], Any], items: list[Any], jobs: int, progress: bool) -> list[Any]:
    if whole(jobs, "jobs") == 1:
        return [work(item) for item in tqdm(items, disable=progress is not True)]
    with ProcessPoolExecutor(int(jobs)) as pool:
        return list(tqdm(pool.map(work, items), total=len(items), disable=progress is not True))


def agreement(
    outlines: Sequence[Outline],
    frictions: dict[str, float],
    *,
    disks: int = 8,
    settings: SqueezeSettings = DEFAULTS,
    jobs: int = 1,
) -> pd.DataFrame:
    """Ask bound, wrench space and simulation about disks of several shapes.

    Parameters
    ----------
    outlines : sequence of Outline
        The objects.
    frictions : dict of str to float
        Name of a material pair and its coefficient of friction [1].
    disks : int
        Disks per outline, evenly spread over its medial axis in order of object angle.
    settings : SqueezeSettings
        How each squeeze is simulated.
    jobs : int
        Processes to use; the result does not depend on it.

    Returns
    -------
    DataFrame
        One row per disk and friction: shape, disk, material, friction, object_angle [rad],
        radius [m], x1, y1, x2, y2 [m], bound, wrench, simulation (bool), reason.
    """
    expected(outlines, (list, tuple), "a list of outlines", "put one outline into brackets")
    expected(frictions, dict, "a name and a coefficient of friction each", "pass {name: value}")
    disks = whole(disks, "disks")
    work = partial(_agreement_of, frictions=frictions, disks=disks, settings=settings)
    return pd.concat(_mapped(work, list(outlines), jobs, False), ignore_index=True)


def spread_disks(axis: MedialAxis, count: int) -> NDArray[np.int64]:
    """Indices of `count` disks spread over the object angles of the axis, small ones left out."""
    fit = np.flatnonzero((axis.object_angles > np.radians(60.0))
                         & (axis.radii > 0.15 * axis.radii.max()))  # fmt: skip
    order = fit[np.argsort(axis.object_angles[fit], kind="stable")]
    return np.unique(order[np.linspace(0, len(order) - 1, min(count, len(order))).astype(int)])


def _agreement_of(
    outline: Outline, *, frictions: dict[str, float], disks: int, settings: SqueezeSettings
) -> pd.DataFrame:
    axis = medial_axis(outline)
    rows = []
    for index in spread_disks(axis, disks):
        p1, p2 = touch = axis.touch_points[index]
        normals = (axis.centers[index] - touch) / axis.radii[index]
        angle = float(axis.object_angles[index])
        for name, friction in frictions.items():
            result = squeeze(outline, p1, p2, friction=friction, settings=settings)
            rows.append({
                "shape": outline.name, "disk": int(index), "material": name, "friction": friction,
                "object_angle": angle, "radius": float(axis.radii[index]), "x1": p1[0],
                "y1": p1[1], "x2": p2[0], "y2": p2[1],
                "bound": is_antipodal(angle, friction=friction),
                "wrench": is_force_closure(touch, normals, friction=friction, outline=outline),
                "simulation": result.held, "reason": result.reason,
            })  # fmt: skip
    return pd.DataFrame(rows)
