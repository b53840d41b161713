"""Local symmetry of an object, read from the centres of its medial spheres (P13 4.3)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from medkit.arguments import whole
from medkit.errors import InputError
from medkit.geometry import Floats, expected, nonnegative, positive
from medkit.medial import grid_kernels as kernels
from medkit.medial.grid import MedialSphereGrid

RHO_AXIS = 0.01  # P13 4.3: at most this, the centres lie on a symmetry axis
RHO_PLANE = 0.4  # P13 4.3: at least this, a sphere is inside a symmetry plane


class SymmetryKind(IntEnum):
    """What the neighbourhood of a sphere looks like."""

    AXIS = 0  # on a local symmetry axis along e1
    RIM = 1  # on the rim of a symmetry sheet: e1 along the rim, e2 across it
    INTERIOR = 2  # inside a symmetry sheet
    TOO_FEW = 3  # fewer neighbours than a PCA needs
    POINT = 4  # all neighbours coincide, as in a ball: no direction stands out


@dataclass(frozen=True)
class LocalSymmetry:
    """PCA of the centres around every medial sphere of a grid, in the order of its axis.

    Attributes
    ----------
    kind : ndarray of int8, shape (n,)
        Values of `SymmetryKind`.
    rho : ndarray, shape (n,)
        lambda2 / lambda1 [1]; 0 where the kind is TOO_FEW or POINT.
    e1, e2 : ndarray, shape (n, 3)
        Unit directions of the largest and second largest variance [1], meaningful for the
        kinds AXIS, RIM and INTERIOR. The component of largest size is positive.
    lambdas : ndarray, shape (n, 3)
        Variances along the three principal axes, falling [m2].
    centroid : ndarray, shape (n, 3)
        Mean of the neighbouring centres [m].
    counts : ndarray of int, shape (n,)
        Number of neighbours, the sphere itself included.
    radius : float
        The search radius [m].
    """

    kind: NDArray[np.int8]
    rho: Floats
    e1: Floats
    e2: Floats
    lambdas: Floats
    centroid: Floats
    counts: NDArray[np.int64]
    radius: float

    def __len__(self) -> int:
        return len(self.kind)


def local_symmetry(
    grid: MedialSphereGrid,
    radius: float,
    *,
    rho_axis: float = RHO_AXIS,
    rho_plane: float = RHO_PLANE,
    min_neighbors: int = 5,
    point_spread: float = 0.02,
) -> LocalSymmetry:
    """Classify the neighbourhood of every sphere of a grid by the PCA of the centres in it.

    Parameters
    ----------
    grid : MedialSphereGrid
        Usually of the spheres with an object angle of at least 120 deg.
    radius : float
        Search radius, P13's r_N [m].
    rho_axis, rho_plane : float
        Thresholds of rho between axis and rim, and rim and interior [1].
    min_neighbors : int
        With fewer, the sphere itself included, the kind is TOO_FEW.
    point_spread : float
        Where the standard deviation along e1 is below this share of the radius, the centres
        coincide for all that matters and the kind is POINT [1].

    Returns
    -------
    LocalSymmetry
        One row per sphere of ``grid.axis``.

    Raises
    ------
    InputError
        If something else than a grid came, the radius is not positive, or the thresholds are
        not in order.

    Examples
    --------
    >>> import numpy as np, trimesh
    >>> from medkit.grasping import MedialSphereGrid, medial_axis
    >>> axis = medial_axis(trimesh.creation.capsule(0.2, 0.02))
    >>> symmetry = local_symmetry(MedialSphereGrid.from_axis(axis), 0.03)
    >>> bool(np.all(symmetry.kind == SymmetryKind.AXIS))
    True
    """
    remedy = "pass MedialSphereGrid.from_axis(axis)"
    expected(grid, MedialSphereGrid, "a grid of medial spheres", remedy)
    reach = positive(radius, "radius", " m")
    nonnegative(rho_axis, "rho_axis")
    nonnegative(rho_plane, "rho_plane")
    least = max(whole(min_neighbors, "min_neighbors"), 2)
    if not rho_axis < rho_plane:
        raise InputError(
            f"Expected 0 <= rho_axis < rho_plane, but got {rho_axis:g} and {rho_plane:g};"
            " pass the smaller threshold as rho_axis."
        )
    nonnegative(point_spread, "point_spread")
    counts, moments = kernels.local_moments(reach, *grid.cells())
    values, vectors = kernels.principal_axes(moments)
    back = np.empty_like(grid.order)
    back[grid.order] = np.arange(len(grid.order))
    counts, moments, values, vectors = counts[back], moments[back], values[back], vectors[back]
    few = counts < least
    point = ~few & (np.sqrt(values[:, 0]) < point_spread * reach)
    clear = ~few & ~point
    rho = np.zeros(len(counts))
    np.divide(values[:, 1], values[:, 0], out=rho, where=clear)
    kind = np.select(
        [few, point, rho <= rho_axis, rho < rho_plane],
        [SymmetryKind.TOO_FEW, SymmetryKind.POINT, SymmetryKind.AXIS, SymmetryKind.RIM],
        SymmetryKind.INTERIOR,
    ).astype(np.int8)
    centroid = grid.axis.centers + moments[:, :3]
    return LocalSymmetry(kind, rho, vectors[:, 0], vectors[:, 1], values, centroid, counts, reach)
