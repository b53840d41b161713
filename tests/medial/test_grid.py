"""Laws of the grid of medial spheres."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.grasping import MedialAxis, MedialSphereGrid
from medkit.medial.grid import cell_indices, cell_layout


def axis_of(centers):
    centers = np.asarray(centers, dtype=float)
    n = len(centers)
    return MedialAxis(centers, np.ones(n), np.full(n, np.pi), np.zeros((n, 2, 3)), 0.01, 1.0)


def brute_force(centers, i, radius):
    d = centers - centers[i]
    return np.flatnonzero(d[:, 0] ** 2 + d[:, 1] ** 2 + d[:, 2] ** 2 <= radius**2)


coordinate = st.one_of(st.floats(-1.0, 1.0, width=32), st.sampled_from([0.0, 0.25, 0.5, 1.0]))


@settings(max_examples=120, derandomize=True, deadline=None)
@given(
    centers=st.integers(1, 60).flatmap(lambda n: arrays(float, (n, 3), elements=coordinate)),
    flat=st.sampled_from([(1, 1, 1), (1, 1, 0), (1, 0, 0), (0, 0, 0), (1, 1e-9, 1e-3)]),
    radius=st.sampled_from([1e-6, 0.25, 0.5, 1.0, 10.0]),
    density=st.sampled_from([0.1, 1.0, 4.0, 1000.0]),
)
def test_neighborhoods_equal_brute_force(centers, flat, radius, density):
    centers = centers * np.array(flat)
    grid = MedialSphereGrid.from_axis(axis_of(centers), cell_density=density)
    found = grid.neighbors(np.arange(len(centers)), radius)
    for i in range(len(centers)):
        assert np.array_equal(found[i], brute_force(centers, i, radius))
    assert found.counts.sum() == len(found.members)


def test_neighbours_exactly_on_the_border_are_found():
    centers = np.c_[np.arange(21) * 0.1, np.zeros((21, 2))]
    for density in (0.5, 1.0, 2.0):
        grid = MedialSphereGrid.from_axis(axis_of(centers), cell_density=density)
        for radius in (0.1, 0.2, 0.5):
            for i in range(21):
                expected = brute_force(centers, i, radius)
                assert np.array_equal(grid.neighbors([i], radius)[0], expected)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0, 100.0])
def test_about_n_over_c_cells_for_boxes_of_one_long_edge_ratio(ratio):
    # P13's formula counts n / C times the middle over the longest edge
    n, density = 8000, 4.0
    _, shape = cell_layout(np.array([ratio, ratio, 1.0]), n, density)
    assert np.prod(shape) == pytest.approx(n / density, rel=0.5)


@pytest.mark.parametrize("extents", [(1, 1, 0), (3, 1, 0), (1, 0, 0), (5, 1e-12, 0), (1, 1, 1e-9)])
def test_flat_and_straight_sets_do_not_explode(extents):
    n, density = 10_000, 4.0
    _, shape = cell_layout(np.array(extents, dtype=float), n, density)
    assert 0.5 * n / density < np.prod(shape) < 1.5 * n / density


def test_all_centres_in_one_point_make_one_cell():
    grid = MedialSphereGrid.from_axis(axis_of(np.full((50, 3), 0.3)))
    assert grid.shape == (1, 1, 1)
    assert len(grid.neighbors([7], 0.001)[0]) == 50


def test_cells_are_cubes_up_to_rounding():
    extents = np.array([0.31, 0.17, 0.08])
    width, shape = cell_layout(extents, 5000, 4.0)
    edges = extents / shape
    assert edges.min() >= width * (1.0 - 1e-9)
    assert edges.max() < width * 1.5


def test_the_upper_border_goes_into_the_last_cell():
    centers = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.5]])
    assert cell_indices(centers, (4, 4, 4)).tolist() == [[0, 0, 0], [3, 3, 3], [2, 2, 2]]


def test_every_sphere_is_in_the_grid_once():
    centers = np.random.default_rng(1).normal(size=(500, 3))
    grid = MedialSphereGrid.from_axis(axis_of(centers))
    assert np.array_equal(np.sort(grid.order), np.arange(500))
    assert grid.starts[0] == 0
    assert grid.starts[-1] == 500


def test_neighbours_are_the_same_when_the_set_is_turned():
    rng = np.random.default_rng(8)
    flat = rng.normal(size=(800, 3)) * [1.0, 0.6, 0.02]
    for _ in range(3):
        turned = flat @ random_rotation(rng).T + rng.normal(size=3)
        found = [
            MedialSphereGrid.from_axis(axis_of(centers)).neighbors(np.arange(800), 0.31)
            for centers in (flat, turned)
        ]
        assert np.array_equal(found[0].offsets, found[1].offsets)
        assert np.array_equal(found[0].members, found[1].members)


def test_search_work_counts_cells_and_candidates():
    # four points in the middles of the outer of 1 x 1 x 4 cells of width 0.25
    centers = np.c_[np.zeros((8, 2)), [0.0, 0.1, 0.3, 0.4, 0.6, 0.7, 0.9, 1.0]]
    grid = MedialSphereGrid.from_axis(axis_of(centers), cell_density=2.0)
    assert grid.shape == (1, 1, 4)
    work = grid.search_work(0.12)
    assert work.opened.tolist() == [1, 1, 2, 2, 2, 2, 1, 1]
    assert work.tested.tolist() == [2, 2, 4, 4, 4, 4, 2, 2]
    assert work.found.tolist() == [2, 2, 2, 2, 2, 2, 2, 2]


@pytest.mark.parametrize("density", [0.5, 4.0, 50.0])
def test_search_work_bounds_what_is_found_and_stays_when_the_set_grows(density):
    def inner_work(n, side):
        centers = np.random.default_rng(3).uniform(size=(n, 3)) * [side, side, 1e-6]
        work = MedialSphereGrid.from_axis(axis_of(centers), cell_density=density).search_work(0.1)
        assert np.all((work.found >= 1) & (work.tested >= work.found) & (work.opened >= 1))
        return work.tested[
            np.all(np.abs(centers[:, :2] - side / 2) < side / 2 - 0.2, axis=1)
        ].mean()

    # sixteen times the spheres on sixteen times the area
    assert inner_work(16_000, 4.0) == pytest.approx(inner_work(1000, 1.0), rel=0.15)


def test_bad_arguments_are_refused():
    grid = MedialSphereGrid.from_axis(axis_of(np.eye(3)))
    for indices in ([3], [-1], [0.5]):
        with pytest.raises(InputError, match="indices from 0 to 2"):
            grid.neighbors(indices, 1.0)
    with pytest.raises(InputError, match="radius"):
        grid.neighbors([0], 0.0)
    with pytest.raises(InputError, match="radius"):
        grid.search_work(-1.0)
    with pytest.raises(InputError, match="cell_density"):
        MedialSphereGrid.from_axis(axis_of(np.eye(3)), cell_density=0.0)
    with pytest.raises(InputError, match="at least one medial sphere"):
        MedialSphereGrid.from_axis(axis_of(np.zeros((0, 3))))
