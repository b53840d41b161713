"""Bodies as signed distances: round chains, ellipsoids, plates, lathes; blended, carved, meshed.

A body is a list of parts in any one unit of length. The parts are added (or carved away) in their
order, each with its own blend, and the zero surface is meshed. Distances need only be right near
the surface: they steer a mesher, not a planner.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from medkit.errors import InputError
from medkit.geometry import Floats, rotation_about, unit

Distance = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Part:
    """One piece of a body: its signed distance, the box that holds it, and how it is joined.

    Attributes
    ----------
    distance : callable
        From points (n, 3) to signed distances (n,), negative inside [the body's unit].
    low, high : ndarray, shape (3,)
        Corners of a box that holds the piece.
    blend : float
        Width of the smooth transition to what was there before; 0 joins sharply.
    carve : bool
        Take the piece away instead of adding it.
    """

    distance: Distance
    low: Floats
    high: Floats
    blend: float = 0.0
    carve: bool = False

    def blended(self, width: float) -> Part:
        """Return the same part, joined over a transition of `width`."""
        return replace(self, blend=width)

    def carved(self, width: float = 0.0) -> Part:
        """Return the same part, to be taken away, its edge rounded over `width`."""
        return replace(self, carve=True, blend=width)

    def moved(self, offset: ArrayLike) -> Part:
        """Return the part shifted by `offset` (3,)."""
        shift = np.asarray(offset, dtype=float)
        inner = self.distance
        return replace(
            self,
            distance=lambda p: inner(p - shift),
            low=self.low + shift,
            high=self.high + shift,
        )

    def turned(self, axis: ArrayLike, angle_deg: float) -> Part:
        """Return the part turned about an axis through the origin by `angle_deg` [deg]."""
        R = rotation_about(axis, np.deg2rad(angle_deg))
        inner = self.distance
        low, high = _box_of(_corners(self.low, self.high) @ R.T)
        return replace(self, distance=lambda p: inner(p @ R), low=low, high=high)

    def mirrored(self, axis: int = 1) -> Part:
        """Return the part reflected in the plane through the origin normal to `axis`."""
        flip = np.ones(3)
        flip[axis] = -1.0
        inner = self.distance
        low, high = _box_of(_corners(self.low, self.high) * flip)
        return replace(self, distance=lambda p: inner(p * flip), low=low, high=high)


def pair(part: Part) -> list[Part]:
    """Return a part and its reflection in the plane y = 0: the two arms, legs or ears."""
    return [part, part.mirrored(1)]


def ellipsoid(center: ArrayLike, radii: ArrayLike) -> Part:
    """Ellipsoid with its axes along x, y, z; `center` (3,), `radii` (3,)."""
    r = np.asarray(radii, dtype=float) * np.ones(3)

    def distance(p: Floats) -> Floats:
        inside = np.linalg.norm(p / r, axis=-1)
        slope = np.linalg.norm(p / r**2, axis=-1)
        return np.asarray(inside * (inside - 1.0) / np.maximum(slope, 1e-12 / r.min()))

    return Part(distance, -r, r).moved(center)


def box(center: ArrayLike, half: ArrayLike, rounding: float = 0.0) -> Part:
    """Box with half edges `half` (3,), its edges and corners rounded by `rounding`."""
    h = np.asarray(half, dtype=float) * np.ones(3)

    def distance(p: Floats) -> Floats:
        q = np.abs(p) - (h - rounding)
        outside = np.linalg.norm(np.maximum(q, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(q.max(axis=-1), 0.0) - rounding)

    return Part(distance, -h, h).moved(center)


def torus(center: ArrayLike, axis: ArrayLike, ring: float, tube: float) -> Part:
    """Torus about `axis` (3,) with ring radius `ring` and tube radius `tube`."""
    n = unit(axis)

    def distance(p: Floats) -> Floats:
        along = p @ n
        across = np.sqrt(np.maximum((p * p).sum(axis=-1) - along**2, 0.0))
        return np.asarray(np.hypot(across - ring, along) - tube)

    reach = np.full(3, ring + tube)
    return Part(distance, -reach, reach).moved(center)


def chain(points: ArrayLike, radii: ArrayLike, *, steps: int = 6, flatten: float = 1.0) -> Part:
    """Round limb along a smooth curve through `points` (n, 3) with `radii` (n,) at them.

    Parameters
    ----------
    points : array-like, shape (n, 3)
        Points that the limb's middle passes through.
    radii : float or array-like, shape (n,)
        Half thickness there.
    steps : int
        Straight pieces between two points; 1 keeps the corners.
    flatten : float
        Factor on the thickness across the plane y = 0 (limbs of fish and birds are flat).
    """
    knots = np.asarray(points, dtype=float) * [1.0, 1.0 / flatten, 1.0]
    sizes = np.asarray(radii, dtype=float) * np.ones(len(knots))
    if steps > 1 and len(knots) > 2:
        at = np.arange(len(knots), dtype=float)
        fine = np.linspace(0.0, at[-1], steps * (len(knots) - 1) + 1)
        sizes = np.interp(fine, at, sizes)
        knots = CubicSpline(at, knots)(fine)

    def distance(p: Floats) -> Floats:
        q = p * [1.0, 1.0 / flatten, 1.0]
        best = np.full(p.shape[:-1], np.inf)
        for i in range(len(knots) - 1):
            ab = knots[i + 1] - knots[i]
            share = np.clip((q - knots[i]) @ ab / max(float(ab @ ab), 1e-12), 0.0, 1.0)
            gap = np.linalg.norm(q - knots[i] - share[..., None] * ab, axis=-1)
            best = np.minimum(best, gap - (sizes[i] + share * (sizes[i + 1] - sizes[i])))
        return best * min(flatten, 1.0)

    low = (knots - sizes[:, None]).min(axis=0) * [1.0, flatten, 1.0]
    high = (knots + sizes[:, None]).max(axis=0) * [1.0, flatten, 1.0]
    return Part(distance, low, high)


def plate(outline: ArrayLike, thickness: float, rounding: float = 0.0) -> Part:
    """Plate with a polygon `outline` (n, 2) in the x-z plane and `thickness` along y."""
    flat = np.asarray(outline, dtype=float)
    lookup = _outline_lookup(flat)

    def distance(p: Floats) -> Floats:
        return _rounded(lookup(p[..., 0], p[..., 2]), np.abs(p[..., 1]) - thickness / 2.0, rounding)

    low = np.array([flat[:, 0].min(), -thickness / 2.0, flat[:, 1].min()])
    high = np.array([flat[:, 0].max(), thickness / 2.0, flat[:, 1].max()])
    return Part(distance, low, high)


def lathe(profile: ArrayLike) -> Part:
    """Body of revolution about z of a closed `profile` (n, 2) of radius and height.

    The profile may touch the axis; give its corners as one polygon, in either direction.
    """
    flat = np.asarray(profile, dtype=float)
    # Reflected in the axis, the profile becomes a polygon whose interior holds the axis.
    touching = flat[:, 0] <= 0.0
    lookup = _outline_lookup(
        np.vstack([flat, flat[::-1] * [-1.0, 1.0]]) if touching.any() else flat
    )

    def distance(p: Floats) -> Floats:
        return lookup(np.hypot(p[..., 0], p[..., 1]), p[..., 2])

    reach = flat[:, 0].max()
    return Part(
        distance,
        np.array([-reach, -reach, flat[:, 1].min()]),
        np.array([reach, reach, flat[:, 1].max()]),
    )


def profile_through(points: list[tuple[float, float]], fine: int = 40) -> Floats:
    """Half section (fine + 2, 2) of a solid lathe body: radii at heights, closed at the axis.

    `points` are (height, radius) from bottom to top; the curve between them does not overshoot.
    """
    knots = np.asarray(points, dtype=float)
    heights = np.linspace(knots[0, 0], knots[-1, 0], fine)
    radii = PchipInterpolator(knots[:, 0], knots[:, 1])(heights)
    return np.vstack([[0.0, heights[0]], np.column_stack([radii, heights]), [0.0, heights[-1]]])


def mesh_of(parts: Sequence[Part], *, longest: float, triangles: int = 12000) -> trimesh.Trimesh:
    """Mesh the surface of a body and bring it to its size.

    Parameters
    ----------
    parts : sequence of Part
        Added or carved in this order.
    longest : float
        Length of the longest edge of the bounding box of the result [m].
    triangles : int
        About how many triangles are wanted; the cell size follows from it.

    Returns
    -------
    trimesh.Trimesh
        Closed, normals outwards, the bounding box's centre at the origin [m].

    Raises
    ------
    InputError
        If the parts leave no closed surface.

    Examples
    --------
    >>> ball = mesh_of([ellipsoid([0, 0, 0], 1.0)], longest=0.1, triangles=2000)
    >>> ball.is_watertight, bool(abs(ball.volume / (np.pi * 0.1**3 / 6) - 1) < 0.02)
    (True, True)
    """
    span = float(np.max(_body_high(parts) - _body_low(parts)))
    coarse = span / 48.0
    guess = _surface(parts, coarse)
    # The number of triangles grows with the inverse square of the cell.
    cell = max(coarse * float(np.sqrt(len(guess[1]) / triangles)), span / 260.0)
    vertices, faces = _without_crumbs(*_surface(parts, cell))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    scale = longest / float(np.max(high - low))
    mesh = trimesh.Trimesh((vertices - (low + high) / 2.0) * scale, faces, process=False)
    if not mesh.is_watertight or mesh.volume <= 0.0:
        raise InputError(
            "Expected parts that enclose a body, but the meshed surface is not closed;"
            " check the parts' bounding boxes."
        )
    return mesh


def field_of(parts: Sequence[Part], axes: tuple[Floats, Floats, Floats]) -> Floats:
    """Signed distances of a body on a grid (nx, ny, nz), right near its surface.

    Every part is evaluated only where it can matter: within its box, widened by its blend.
    """
    shape = tuple(len(axis) for axis in axes)
    cell = float(axes[0][1] - axes[0][0])
    field = np.full(shape, 4.0 * cell)
    for part in parts:
        reach = part.blend + 4.0 * cell
        window = tuple(
            slice(*np.searchsorted(axis, [lo - reach, hi + reach]))
            for axis, lo, hi in zip(axes, part.low, part.high, strict=True)
        )
        local = [axis[cut] for axis, cut in zip(axes, window, strict=True)]
        if min(len(axis) for axis in local) == 0:
            continue
        grid = np.stack(np.meshgrid(*local, indexing="ij"), axis=-1)
        distance = part.distance(grid)
        if part.carve:
            field[window] = -_smooth_min(-field[window], distance, part.blend)
        else:
            field[window] = _smooth_min(field[window], distance, part.blend)
    return field


def _smooth_min(a: Floats, b: Floats, width: float) -> Floats:
    """Smaller of two distances, rounded where they differ by less than `width`."""
    if width <= 0.0:
        return np.minimum(a, b)
    near = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.asarray(np.minimum(a, b) - near * near * width / 4.0)


def _surface(parts: Sequence[Part], cell: float) -> tuple[Floats, np.ndarray]:
    from skimage.measure import marching_cubes

    low, high = _body_low(parts) - 2.37 * cell, _body_high(parts) + 2.61 * cell
    axes = tuple(
        lo + cell * np.arange(int((hi - lo) / cell) + 2) for lo, hi in zip(low, high, strict=True)
    )
    field = field_of(parts, (axes[0], axes[1], axes[2]))
    if not (field.min() < 0.0 < field.max()):
        raise InputError("Expected parts that enclose a body, but nothing is inside; add a part.")
    # Grid points on or beside the surface would give slivers: push the surface off them.
    slight = np.abs(field) < 0.03 * cell
    field[slight] = np.where(field[slight] < 0.0, -0.03, 0.03) * cell
    vertices, faces, _, _ = marching_cubes(field, 0.0, gradient_direction="ascent")
    return low + cell * vertices.astype(float), faces[:, ::-1].astype(np.int64)


def _without_crumbs(vertices: Floats, faces: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Drop shells of fewer than 40 triangles: bits of a blend that only the cells tore off."""
    links = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(links)), links.T), shape=2 * (len(vertices),))
    label = connected_components(graph, directed=False)[1]
    kept = faces[np.bincount(label[faces[:, 0]])[label[faces[:, 0]]] >= 40]
    used, renamed = np.unique(kept, return_inverse=True)
    return vertices[used], renamed.reshape(-1, 3)


def _outline_lookup(outline: Floats) -> Callable[[Floats, Floats], Floats]:
    """Signed distance to a polygon (n, 2), tabulated on a fine grid and interpolated."""
    margin = 0.2 * float(np.max(np.ptp(outline, axis=0)))
    low, high = outline.min(axis=0) - margin, outline.max(axis=0) + margin
    step = float(np.max(high - low)) / 260.0
    axes = [np.arange(lo, hi + step, step) for lo, hi in zip(low, high, strict=True)]
    table = _polygon_distance(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1), outline)

    def lookup(u: Floats, v: Floats) -> Floats:
        at = np.stack([(u - low[0]) / step, (v - low[1]) / step])
        return np.asarray(map_coordinates(table, at, order=1, mode="nearest"))

    return lookup


def _polygon_distance(points: Floats, outline: Floats) -> Floats:
    nearest = np.full(points.shape[:-1], np.inf)
    inside = np.zeros(points.shape[:-1], dtype=bool)
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        ab = b - a
        if not ab.any():
            continue
        share = np.clip((points - a) @ ab / (ab @ ab), 0.0, 1.0)
        nearest = np.minimum(nearest, ((points - a - share[..., None] * ab) ** 2).sum(axis=-1))
        crosses = (a[1] > points[..., 1]) != (b[1] > points[..., 1])
        if ab[1] != 0.0:
            inside ^= crosses & (points[..., 0] < a[0] + (points[..., 1] - a[1]) / ab[1] * ab[0])
    return np.where(inside, -1.0, 1.0) * np.sqrt(nearest)


def _rounded(across: Floats, along: Floats, rounding: float) -> Floats:
    """Distance of an extruded outline from its two distances, edges rounded."""
    u, v = across + rounding, along + rounding
    outside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(u, v), 0.0) - rounding)


def _corners(low: Floats, high: Floats) -> Floats:
    choice = np.indices((2, 2, 2)).reshape(3, -1).T
    return np.asarray(np.where(choice == 1, high, low))


def _box_of(points: Floats) -> tuple[Floats, Floats]:
    return points.min(axis=0), points.max(axis=0)


def _body_low(parts: Sequence[Part]) -> Floats:
    return np.asarray(np.min([p.low - p.blend / 4.0 for p in parts if not p.carve], axis=0))


def _body_high(parts: Sequence[Part]) -> Floats:
    return np.asarray(np.max([p.high + p.blend / 4.0 for p in parts if not p.carve], axis=0))
