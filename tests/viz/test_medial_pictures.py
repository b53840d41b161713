"""Flat pictures of medial spheres: the view fits the object, the counts are those of the grid."""

import matplotlib as mpl
import numpy as np
import pytest
import trimesh

from medkit.grasping import MedialAxis, MedialSphereGrid, filter_object_angle, medial_axis
from medkit.viz.medial import plot_search, plot_side

mpl.use("Agg")


@pytest.mark.parametrize("turn", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_the_side_view_takes_the_two_longest_directions_whatever_they_are_called(turn):
    edges = np.array([0.2, 0.12, 0.04])[list(turn)]
    axis = medial_axis(trimesh.creation.box(edges))
    view = plot_side(filter_object_angle(axis), within=axis)
    longest, second, _ = np.argsort(edges)[::-1]
    assert view.get_xlabel() == f"{'xyz'[longest]} [cm]"
    assert view.get_ylabel() == f"{'xyz'[second]} [cm]"
    low, high = view.get_xlim()
    turned = plot_side(axis, plane=(2, 0))
    assert (turned.get_xlabel(), turned.get_ylabel()) == ("z [cm]", "x [cm]")
    assert low < 100 * axis.centers[:, longest].min() < 100 * axis.centers[:, longest].max() < high


@pytest.mark.parametrize("density", [1, 8, 64])
def test_the_picture_of_a_search_counts_what_the_grid_counts(density):
    rng = np.random.default_rng(0)
    n = 2_000
    centers = np.c_[rng.uniform(size=(n, 2)) * 0.05, np.zeros(n)]
    sheet = MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 1e-3, 0.05)
    grid = MedialSphereGrid.from_axis(sheet, cell_density=density)
    work = grid.search_work(0.006)
    sphere = int(np.argmin(np.linalg.norm(centers[:, :2] - [0.02, 0.03], axis=1)))
    view = plot_search(grid, (0.02, 0.03), 0.006)
    counted = f"{work.tested[sphere]} tested, {work.found[sphere]} found"
    assert view.get_title() == f"C = {density}: {counted}"
