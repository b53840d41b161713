"""The exact medial axis: laws that every disk obeys, and axes known in closed form."""

import itertools

import networkx as nx
import numpy as np
import pytest

from medkit import planar
from medkit.errors import InputError
from medkit.planar.envelope import sites_from_outline
from medkit.planar.outlines import Outline
from medkit.planar.polygon_axis import disks_on_arcs, voronoi_arcs

POLYGONS = [
    planar.rectangle(), planar.regular_polygon(3), planar.regular_polygon(7), planar.triangle(),
    planar.l_shape(), planar.t_shape(), planar.star(), planar.wedge(1.9)[0], planar.frame(),
    Outline(planar.banana().loops, "banana polygon"),
    Outline(planar.ellipse().loops, "ellipse polygon"),
]  # fmt: skip
SMOOTH = [planar.ellipse(), planar.banana()] + [
    planar.random_smooth(np.random.default_rng(seed)) for seed in (0, 1, 2)
]

# neighbours that are nearly in line: the arcs' ends are worse conditioned, the graph must not care
BLOBS = [
    Outline(planar.random_smooth(np.random.default_rng(seed)).loops, f"blob {seed}")
    for seed in (0, 2)
]


def fine_polygon(seed, edges):
    """A smooth outline as a polygon whose neighbours turn by fractions of a degree, or hardly."""
    smooth = planar.random_smooth(np.random.default_rng(seed))
    return Outline((smooth.curve(np.arange(edges) * (2 * np.pi / edges)),), f"fine {seed}")


def named(outline):
    return outline.name


@pytest.mark.parametrize("outline", POLYGONS, ids=named)
def test_disks_touch_the_polygon_and_never_cross_it(outline):
    axis = planar.medial_axis(outline)
    assert outline.contains(axis.centers).all()
    assert np.abs(outline.distance(axis.centers) - axis.radii).max() < 1e-12
    assert outline.distance(axis.touch_points.reshape(-1, 2)).max() < 1e-14
    spokes = axis.touch_points - axis.centers[:, None]
    assert np.abs(np.linalg.norm(spokes, axis=2) - axis.radii[:, None]).max() < 1e-12
    cosine = (spokes[:, 0] * spokes[:, 1]).sum(axis=1) / axis.radii**2
    assert np.cos(axis.object_angles) == pytest.approx(cosine, abs=1e-9)


@pytest.mark.parametrize("outline", POLYGONS + SMOOTH + BLOBS, ids=named)
def test_graph_has_one_cycle_per_hole_and_is_connected(outline):
    graph = planar.medial_axis(outline).graph
    assert nx.is_connected(graph)
    holes = len(outline.loops) - 1
    assert graph.number_of_edges() - graph.number_of_nodes() + 1 == holes


@pytest.mark.parametrize("seed", [2, 6])
def test_a_polygon_of_a_thousand_edges_keeps_its_axis_in_one_piece(seed):
    outline = fine_polygon(seed, 1000)
    axis = planar.medial_axis(outline, spacing=0.002)
    assert nx.is_tree(axis.graph)
    convex = axis.node_radii[[node for node, degree in axis.graph.degree if degree == 1]]
    assert convex.max() < 1e-9  # every loose end lies in a corner, none in the middle
    some = slice(None, None, 40)
    assert np.abs(outline.distance(axis.centers[some]) - axis.radii[some]).max() < 1e-9


@pytest.mark.parametrize("outline", POLYGONS, ids=named)
def test_every_arc_looks_the_same_from_both_sides(outline):
    size = outline.characteristic_length
    unit = Outline(tuple((loop - outline.center_mass) / size for loop in outline.loops))
    sites = sites_from_outline(unit)
    arcs = voronoi_arcs(sites, both_sides=True)
    first = disks_on_arcs(sites, arcs.site, arcs.partner, arcs.begin)[0]
    last = disks_on_arcs(sites, arcs.site, arcs.partner, arcs.end)[0]
    real = np.linalg.norm(last - first, axis=1) > 1e-6
    ends = np.hstack([first, last])[real]
    pairs = np.column_stack([arcs.site, arcs.partner])[real]
    for pair, seen in zip(pairs, ends, strict=True):
        others = ends[(pairs == pair[::-1]).all(axis=1)]
        turned = others[:, [2, 3, 0, 1]]
        assert np.abs(np.vstack([others, turned]) - seen).max(axis=1).min() < 1e-7


@pytest.mark.parametrize("outline", SMOOTH, ids=named)
def test_disks_touch_the_smooth_curve_itself(outline):
    axis = planar.medial_axis(outline)
    fine = outline.curve(np.linspace(0.0, 2.0 * np.pi, 20001))
    nearest = np.array([np.linalg.norm(fine - c, axis=1).min() for c in axis.centers])
    assert (nearest - axis.radii).min() > -1e-12
    assert (nearest - axis.radii).max() < 2e-8  # the sagging of the fine polygon


def test_rectangle_has_a_bar_and_four_corners():
    axis = planar.medial_axis(planar.rectangle(0.08, 0.04))
    flat = np.isclose(axis.object_angles, np.pi)
    assert set(np.degrees(axis.object_angles).round(9)) == {90.0, 180.0}
    assert np.abs(axis.centers[flat, 1]).max() < 1e-15
    assert np.abs(axis.centers[flat, 0]).max() == pytest.approx(0.02)
    assert axis.radii.max() == pytest.approx(0.02)
    assert len(axis.branch_nodes) == 5


def test_triangle_branches_have_the_angle_of_their_corner():
    axis = planar.medial_axis(planar.triangle((30.0, 80.0)))
    branches = axis.branch >= 0
    assert set(np.degrees(axis.object_angles[branches]).round(6)) == {150.0, 100.0, 110.0}
    kept = planar.filter_object_angle(axis, np.radians(120.0))
    assert set(np.degrees(kept.object_angles[kept.branch >= 0]).round(6)) == {150.0}


def test_equilateral_triangle_has_120_degrees_everywhere():
    axis = planar.medial_axis(planar.regular_polygon(3))
    assert np.abs(np.degrees(axis.object_angles) - 120.0).max() < 1e-9
    assert len(planar.filter_object_angle(axis, np.radians(120.0))) == len(axis)


def test_ellipse_axis_ends_at_the_centres_of_curvature():
    a, b = 0.04, 0.025
    axis = planar.medial_axis(planar.ellipse(2 * a, 2 * b))
    assert np.abs(axis.centers[:, 1]).max() < 1e-12
    assert np.abs(axis.node_centers[:, 0]) == pytest.approx((a * a - b * b) / a, abs=1e-9)
    assert axis.node_radii == pytest.approx(b * b / a)
    known = np.sqrt((1 - axis.centers[:, 0] ** 2 / (a * a - b * b)) * b * b)
    assert axis.radii == pytest.approx(known, abs=1e-12)


def test_circle_is_one_disk():
    axis = planar.medial_axis(planar.ellipse(0.05, 0.05))
    assert len(axis) == 1
    assert axis.radii[0] == pytest.approx(0.025)


@pytest.mark.parametrize("outline", [planar.l_shape(), planar.star(), planar.frame()], ids=named)
def test_axis_moves_and_grows_with_the_outline(outline):
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    moved = Outline(tuple(3.0 * loop @ turn.T + [0.3, -2.0] for loop in outline.loops))
    first, second = planar.medial_axis(outline), planar.medial_axis(moved)
    assert sorted(first.radii * 3.0) == pytest.approx(sorted(second.radii), abs=1e-9)
    target = 3.0 * first.centers @ turn.T + [0.3, -2.0]
    gap = np.linalg.norm(target[:, None] - second.centers[None], axis=2).min(axis=1)
    # where a branch leaves a corner tangentially, the place is a double root
    assert gap.max() < 1e-7 * moved.characteristic_length


def test_spacing_changes_how_many_disks_not_where():
    outline = planar.l_shape()
    coarse, fine = (planar.medial_axis(outline, spacing=s) for s in (0.01, 0.0005))
    assert len(fine) > 5 * len(coarse)
    gap = np.linalg.norm(coarse.centers[:, None] - fine.centers[None], axis=2).min(axis=1)
    assert gap.max() < 0.0005
    with pytest.raises(InputError, match="spacing"):
        planar.medial_axis(outline, spacing=0.0)


def test_branch_curves_run_from_node_to_node():
    axis = planar.medial_axis(planar.l_shape())
    for number, (first, last) in enumerate(axis.branch_nodes):
        curve = axis.branch_curve(number)
        assert curve[0] == pytest.approx(axis.node_centers[first])
        assert curve[-1] == pytest.approx(axis.node_centers[last])
        steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
        assert steps.max() < 0.05 * axis.outline.characteristic_length


def test_lengths_add_up_to_the_axis():
    bar = planar.medial_axis(planar.rectangle(0.08, 0.04))
    flat = np.isclose(bar.object_angles, np.pi)
    assert bar.lengths[flat].sum() == pytest.approx(0.04)
    assert bar.lengths.sum() == pytest.approx(0.04 + 4 * 0.02 * np.sqrt(2))
    a, b = 0.04, 0.025
    oval = planar.medial_axis(planar.ellipse(2 * a, 2 * b))
    assert oval.lengths.sum() == pytest.approx(2 * (a * a - b * b) / a)


@pytest.mark.parametrize("outline", [planar.rectangle(), planar.ellipse()], ids=named)
def test_filters_shrink_as_they_get_stricter(outline):
    axis = planar.medial_axis(outline)
    for keep, levels in (
        (planar.filter_object_angle, np.radians([0, 60, 100, 150])),
        (planar.filter_lambda, [0.0, 0.005, 0.01, 0.015]),
        (planar.filter_scale, [1.0, 1.05, 1.2, 1.5]),
    ):
        kept = [{tuple(c) for c in keep(axis, level).centers} for level in levels]
        assert all(b <= a for a, b in itertools.pairwise(kept))
        assert kept[-1]
    with pytest.raises(InputError):
        planar.filter_scale(axis, 0.9)


def test_only_180_degrees_turns_the_ellipse_into_a_point():
    axis = planar.medial_axis(planar.ellipse())
    assert axis.object_angles.max() > np.radians(179.0)
    strict = planar.filter_object_angle(axis, np.radians(179.0))
    assert np.ptp(strict.centers[:, 0]) < 0.03 * np.ptp(axis.centers[:, 0])
