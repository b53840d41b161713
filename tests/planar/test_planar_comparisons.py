"""Comparisons between axes, regions and simulations: laws and cases known by hand."""

import numpy as np
import pytest

from medkit import planar
from medkit.errors import InputError
from medkit.planar.comparisons import (
    covered_share,
    friction_deviation,
    graspable_share,
    living_branches,
    notch_distance,
    numerics_study,
    stray_and_hole,
    voronoi_centers,
)


def test_strays_and_holes_are_told_apart():
    whole = planar.medial_axis(planar.rectangle(0.08, 0.04))
    bar = planar.filter_object_angle(whole, np.radians(120.0))
    stray, hole = stray_and_hole(bar, whole)
    assert stray == 0.0
    assert hole == pytest.approx(np.hypot(0.02, 0.02), rel=0.05)  # from the bar's end to a corner
    assert stray_and_hole(whole, bar) == (hole, stray)
    assert (living_branches(whole), living_branches(bar)) == (5, 1)
    with pytest.raises(InputError, match="at least one disk"):
        stray_and_hole(bar.keep(np.zeros(len(bar), dtype=bool)), whole)


def test_more_friction_never_makes_less_graspable():
    axis = planar.medial_axis(planar.ellipse())
    shares = [graspable_share(axis, friction=mu) for mu in np.linspace(0.0, 4.0, 20)]
    assert shares[0] == 0.0
    assert np.all(np.diff(shares) >= 0.0)
    assert shares[-1] > 0.95


def test_finer_disks_rebuild_more_of_the_shape():
    points = np.random.default_rng(1).uniform(0.0, 0.08, (3000, 2))
    shares = [
        covered_share(planar.medial_axis(planar.l_shape(), spacing=spacing), points)
        for spacing in (0.016, 0.004, 0.001)
    ]
    assert shares == sorted(shares)
    assert shares[0] < 0.985
    assert shares[-1] > 0.99


def test_voronoi_vertices_come_near_the_exact_axis_as_samples_grow():
    outline = planar.l_shape()
    exact = planar.medial_axis(outline, spacing=0.0002)
    worst = []
    for samples in (60, 240, 960):
        gap = voronoi_centers(outline, samples)[:, None] - exact.centers
        worst.append(float(np.linalg.norm(gap, axis=2).min(axis=1).max()))
    assert worst == sorted(worst, reverse=True)
    assert worst[-1] < 5e-4


def test_only_corners_that_point_inwards_are_notches():
    assert np.isinf(notch_distance(planar.rectangle(), [[0.0, 0.0]])).all()
    assert np.isinf(notch_distance(planar.ellipse(), [[0.0, 0.0]])).all()
    frame = planar.frame(0.08, 0.02)
    assert notch_distance(frame, [[0.02, 0.02], [0.04, 0.04]]) == pytest.approx(
        [0.0, 0.02 * 2**0.5]
    )


def test_a_wedge_deviates_by_no_more_than_the_bisection():
    outline, touch = planar.wedge(np.radians(130.0))
    center = [0.0, 0.0]
    assert abs(friction_deviation(outline, touch, center)) < 2e-3
    study = numerics_study(outline, touch, center, {"as is": {}, "pushed": {"push_share": 0.05}})
    assert abs(study["as is"]) < 2e-3 < 0.05 < study["pushed"]
