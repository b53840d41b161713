"""The grid of medial spheres: all neighbours within a radius, at a cost that n does not raise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, expected, positive
from medkit.medial import grid_kernels as kernels
from medkit.medial.axis import MedialAxis

Indices = NDArray[np.int64]

#: Mean number of spheres per cell; P13 does not state its own (decision 0016, chapter 23).
CELL_DENSITY = 8.0


@dataclass(frozen=True)
class Neighborhoods:
    """Neighbours of many spheres: those of query ``i`` are ``result[i]``.

    Attributes
    ----------
    offsets : ndarray, shape (m + 1,)
        Where each query's members begin and end.
    members : ndarray, shape (total,)
        Sphere indices, ascending within a query; every sphere is its own neighbour.
    """

    offsets: Indices
    members: Indices

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, query: int) -> Indices:
        return self.members[self.offsets[query] : self.offsets[query + 1]]

    @property
    def counts(self) -> Indices:
        """Number of neighbours of each query, shape (m,)."""
        return np.diff(self.offsets)


@dataclass(frozen=True)
class SearchWork:
    """Work of a neighbourhood search around every sphere (P13 3.4.3), each of shape (n,).

    Attributes
    ----------
    opened : ndarray of int
        Cells that the search radius reaches, P13's |J|.
    tested : ndarray of int
        Spheres in these cells, each of them one distance, P13's |S_cu|.
    found : ndarray of int
        Spheres within the radius, the queried one included.
    """

    opened: Indices
    tested: Indices
    found: Indices


@dataclass(frozen=True)
class MedialSphereGrid:
    """Medial spheres sorted into cubic cells (P13 3.4).

    Attributes
    ----------
    axis : MedialAxis
        The spheres.
    cell_density : float
        Mean number of spheres per cell that was asked for, P13's C.
    cell_width : float
        Edge of a cell, P13's delta [m].
    shape : tuple of int
        Number of cells along x, y and z.
    order : ndarray, shape (n,)
        Sphere indices, sorted by cell.
    starts : ndarray, shape (cells + 1,)
        Where each cell's spheres begin in `order`.
    """

    axis: MedialAxis
    cell_density: float
    cell_width: float
    shape: tuple[int, int, int]
    order: Indices
    starts: Indices

    @classmethod
    def from_axis(cls, axis: MedialAxis, *, cell_density: float = CELL_DENSITY) -> MedialSphereGrid:
        """Sort the spheres of an axis into cells.

        Parameters
        ----------
        axis : MedialAxis
            At least one sphere.
        cell_density : float
            Mean number of spheres per cell, P13's C.

        Returns
        -------
        MedialSphereGrid
            With about ``n / cell_density`` cells.

        Raises
        ------
        InputError
            If something else than an axis came, it has no spheres, or the density is not
            positive.

        Examples
        --------
        >>> import trimesh
        >>> from medkit.grasping import medial_axis
        >>> grid = MedialSphereGrid.from_axis(medial_axis(trimesh.creation.box((2, 1, 1))))
        >>> int(grid.starts[-1]) == len(grid.axis)
        True
        """
        remedy = "pass medkit.grasping.medial_axis(mesh)"
        expected(axis, MedialAxis, "the medial axis of a mesh", remedy)
        density = positive(cell_density, "cell_density")
        if len(axis) == 0:
            raise InputError(
                "Expected at least one medial sphere for a grid, but got none;"
                " loosen the filters or use a smaller spacing."
            )
        extents = np.ptp(axis.centers, axis=0)
        width, shape = cell_layout(extents, len(axis), density)
        cells = cell_indices(axis.centers, shape)
        flat = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
        order = np.argsort(flat, kind="stable")
        starts = np.zeros(int(np.prod(shape)) + 1, np.int64)
        np.cumsum(np.bincount(flat, minlength=len(starts) - 1), out=starts[1:])
        return cls(axis, density, width, shape, order, starts)

    def neighbors(self, indices: ArrayLike, radius: float) -> Neighborhoods:
        """All spheres whose centres are within `radius` of those of some spheres.

        Parameters
        ----------
        indices : array-like of int, shape (m,)
            Queried spheres.
        radius : float
            Search radius, P13's r_N [m].

        Returns
        -------
        Neighborhoods
            Exactly the spheres at a distance of at most `radius`, the queried one included.

        Raises
        ------
        InputError
            If an index is out of range or the radius is not positive.
        """
        queries = np.atleast_1d(np.asarray(indices))
        n = len(self.axis)
        if queries.dtype.kind not in "iu" or (len(queries) and not _within(queries, n)):
            raise InputError(
                f"Expected sphere indices from 0 to {n - 1}, but got {indices!r};"
                " pass integers in that range."
            )
        query = (self.axis.centers[queries], positive(radius, "radius", " m"), *self.cells())
        counts = kernels.count_neighbors(*query)
        offsets = np.concatenate([[0], np.cumsum(counts)])
        members = np.empty(offsets[-1], np.int64)
        kernels.list_neighbors(*query, self.order, offsets, members)
        return Neighborhoods(offsets, members)

    def search_work(self, radius: float) -> SearchWork:
        """Count what a search around every sphere opens, tests and finds, without a clock.

        Parameters
        ----------
        radius : float
            Search radius, P13's r_N [m].

        Returns
        -------
        SearchWork
            Three counts per sphere, in the order of the axis.

        Raises
        ------
        InputError
            If the radius is not positive.
        """
        reach = positive(radius, "radius", " m")
        cells = self.cells()
        opened, tested = kernels.count_work(self.axis.centers, reach, *cells)
        return SearchWork(opened, tested, kernels.count_neighbors(self.axis.centers, reach, *cells))

    def cells(self) -> tuple[Floats, Indices, Floats, Floats, Indices]:
        """Cell-sorted centres, starts, lowest corner, cell widths and counts, for the kernels."""
        centers = self.axis.centers
        shape = np.array(self.shape, dtype=np.int64)
        extents = np.ptp(centers, axis=0)
        width = np.where(extents > 0.0, extents, 1.0) / shape
        return centers[self.order], self.starts, centers.min(axis=0), width, shape


def cell_layout(extents: Floats, n: int, cell_density: float) -> tuple[float, tuple[int, int, int]]:
    """Cell width [m] and number of cells per axis for a box of centres (P13 3.4.1).

    P13's formula counts ``ceil((k n / C)**(1/3))`` cells along the longest edge, where k is the
    ratio of the longest to the shortest edge. A flat or straight set of centres makes k infinite.
    The guard keeps the cells so large that their number is at most about n / C.

    Parameters
    ----------
    extents : ndarray, shape (3,)
        Edges of the box of the centres [m]; some or all may be zero.
    n : int
        Number of spheres.
    cell_density : float
        P13's C.

    Returns
    -------
    tuple
        Width of a cell and the counts along x, y and z, each at least 1.

    Examples
    --------
    >>> cell_layout(np.array([4.0, 2.0, 1.0]), 1000, 1.0)[1]
    (16, 8, 4)
    >>> cell_layout(np.array([4.0, 1.0, 0.0]), 1000, 1.0)[1]
    (64, 16, 1)
    """
    longest, middle, shortest = np.sort(extents)[::-1]
    if longest == 0.0:
        return 0.0, (1, 1, 1)
    cells = max(n / cell_density, 1.0)
    along = (longest / shortest * cells) ** (1.0 / 3.0) if shortest > 0.0 else np.inf
    if shortest < longest / along or not np.isfinite(along):
        # thinner than a cell: only the other edges, or the longest alone, can be divided
        along = min(cells, np.sqrt(cells * longest / middle) if middle > 0.0 else cells)
    width = longest / np.ceil(along)
    counts = np.maximum(1, np.floor(extents / width + 1e-9)).astype(int)
    return float(width), (int(counts[0]), int(counts[1]), int(counts[2]))


def cell_indices(centers: Floats, shape: tuple[int, int, int]) -> Indices:
    """Cell of every centre, shape (n, 3), the upper border in the last cell (P13 eq. 3.13)."""
    low = centers.min(axis=0)
    extents = np.ptp(centers, axis=0)
    counts = np.array(shape)
    cells = np.floor(counts * (centers - low) / np.where(extents > 0.0, extents, 1.0))
    return np.minimum(cells.astype(np.int64), counts - 1)


def _within(queries: NDArray[np.integer], n: int) -> bool:
    return bool(queries.min() >= 0 and queries.max() < n)
