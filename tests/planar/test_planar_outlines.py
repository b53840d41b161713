"""Outlines: what is refused, and what their measures obey."""

import numpy as np
import pytest

from medkit import planar
from medkit.errors import InputError

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
SHAPES = [
    planar.rectangle(), planar.regular_polygon(6), planar.triangle(), planar.l_shape(),
    planar.t_shape(), planar.star(), planar.wedge(2.0)[0], planar.frame(), planar.ellipse(),
    planar.banana(), planar.random_smooth(np.random.default_rng(4)),
]  # fmt: skip


@pytest.mark.parametrize(
    ("points", "word"),
    [
        ([[0, 0], [1, 1], [1, 0], [0, 2]], "cross"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "area"),
        ([[0, 0], [1, 0]], "3 corners"),
        ([[0, 0], [1, 0], [2, 0]], "3 corners"),
        ([[0, 0], [1, 0], [float("nan"), 1]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "shape"),
        ([[0, 0], [2, 0], [2, 1], [1, 0], [0, 1]], "touch"),
        ([[0, 0]] * 4, "3 corners"),
    ],
)
def test_bad_loops_are_refused(points, word):
    with pytest.raises(InputError, match=word):
        planar.outline_from_loops(points)


def test_holes_must_lie_inside_and_apart():
    inner = 0.2 * np.array(SQUARE) + 0.3
    with pytest.raises(InputError, match="hole 0"):
        planar.outline_from_loops(SQUARE, [inner + 2.0])
    with pytest.raises(InputError):
        planar.outline_from_loops(SQUARE, [inner, 0.1 * np.array(SQUARE) + 0.35])
    with pytest.raises(InputError, match="meet"):
        planar.outline_from_loops(SQUARE, [inner, inner + 0.1])


def test_direction_and_straight_vertices_do_not_matter():
    clockwise = planar.outline_from_loops([[0, 1], [1, 1], [1, 0], [0.5, 0], [0, 0]])
    assert clockwise.area == 1.0
    assert len(clockwise.starts) == 4


@pytest.mark.parametrize("outline", SHAPES, ids=lambda outline: outline.name)
def test_measures_agree_with_counting(outline):
    low, high = outline.loops[0].min(axis=0), outline.loops[0].max(axis=0)
    steps = [(np.arange(300) + 0.5) / 300 * (b - a) + a for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2)
    inside = grid[outline.contains(grid)]
    share = len(inside) / len(grid) * np.prod(high - low)
    assert outline.area == pytest.approx(share, rel=1e-2)
    assert inside.mean(axis=0) == pytest.approx(outline.center_mass, abs=2e-4)
    middle = (outline.starts + outline.ends) / 2
    assert outline.contains(middle + 1e-6 * outline.inward_normals).all()


def test_characteristic_length_is_the_largest_distance():
    assert planar.rectangle(0.06, 0.08).characteristic_length == pytest.approx(0.05)


@pytest.mark.parametrize("angle", np.radians([90.0, 120.0, 150.0, 175.0, 180.0]))
def test_wedge_touches_its_disk_at_the_object_angle(angle):
    outline, touch = planar.wedge(angle, radius=0.02)
    assert outline.distance(touch).max() < 1e-15
    assert outline.distance([[0.0, 0.0]])[0] == pytest.approx(0.02)
    cosine = touch[0] @ touch[1] / 0.02**2
    assert np.arccos(np.clip(cosine, -1, 1)) == pytest.approx(angle, abs=1e-7)


def test_random_shape_depends_on_the_generator_alone():
    first = planar.random_smooth(np.random.default_rng(7))
    second = planar.random_smooth(np.random.default_rng(7))
    assert np.array_equal(first.coefficients, second.coefficients)
    assert not np.allclose(first.coefficients, SHAPES[-1].coefficients)


def test_smooth_derivatives_match_differences():
    outline, t, h = planar.banana(), np.linspace(0, 6, 7), 1e-5
    for order in (1, 2, 3):
        difference = (outline.curve(t + h, order - 1) - outline.curve(t - h, order - 1)) / (2 * h)
        assert outline.curve(t, order) == pytest.approx(difference, abs=1e-8)


@pytest.mark.parametrize(
    "make",
    [
        lambda: planar.rectangle(-1.0),
        lambda: planar.triangle((100.0, 90.0)),
        lambda: planar.wedge(4.0),
        lambda: planar.random_smooth(np.random.default_rng(0), roughness=0.9),
        lambda: planar.smooth_outline([1.0, 2.0]),
        lambda: planar.regular_polygon(2),
    ],
)
def test_bad_shape_arguments_are_refused(make):
    with pytest.raises(InputError):
        make()
