"""Laws of the implicit bodies: known volumes, convergence, blending, mirror, turn."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.datasets.implicit import (
    box,
    chain,
    ellipsoid,
    field_of,
    lathe,
    mesh_of,
    pair,
    plate,
    torus,
)  # fmt: skip
from medkit.errors import InputError
from medkit.geometry import random_rotation

POINTS = np.random.default_rng(3).uniform(-3.0, 3.0, (200, 3))


def volume_of(part, triangles=6000):
    mesh = mesh_of([part], longest=float(np.max(part.high - part.low)), triangles=triangles)
    return mesh.volume


@pytest.mark.parametrize(
    ("part", "volume"),
    [
        (ellipsoid([1, 2, 3], [1.0, 0.8, 0.6]), 4 / 3 * np.pi * 0.48),
        (torus([0, 0, 0], [0, 0, 1], 2.0, 0.5), 2 * np.pi**2 * 2.0 * 0.25),
        (chain([(0, 0, 0), (2, 0, 0)], 0.5, steps=1), np.pi * 0.25 * (2 + 4 / 3 * 0.5)),
        (lathe([(0, 0), (1, 0), (1, 2), (0, 2)]), np.pi * 2),
        (lathe([(1, 0), (2, 0), (2, 1), (1, 1)]), np.pi * 3),
    ],
)
def test_volumes_of_known_bodies(part, volume):
    assert volume_of(part) == pytest.approx(volume, rel=0.02)


def test_the_mesh_converges_to_the_ball_as_cells_shrink():
    error = [
        abs(volume_of(ellipsoid([0, 0, 0], 1.0), triangles) / (4 / 3 * np.pi) - 1)
        for triangles in (800, 20000)
    ]
    assert error[1] < 0.2 * error[0]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10, derandomize=True, deadline=None)
def test_round_parts_measure_true_distances(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1, 1, (2, 3))
    limb = chain([a, b], 0.3, steps=1)
    # Euclidean distance to a rounded segment has slope one everywhere off its middle.
    step = 1e-6 * random_rotation(rng)
    slopes = [(limb.distance(POINTS + d) - limb.distance(POINTS - d)) / 2e-6 for d in step]
    assert np.linalg.norm(slopes, axis=0) == pytest.approx(np.ones(len(POINTS)), abs=1e-4)


def test_mirror_turn_and_move_carry_the_distance_along():
    part = box([0.5, 0.7, 0.1], [0.2, 0.4, 0.6], 0.1)
    assert np.allclose(part.mirrored(1).distance(POINTS * [1, -1, 1]), part.distance(POINTS))
    assert np.allclose(
        part.moved(np.arange(1, 4)).distance(POINTS + np.arange(1, 4)), part.distance(POINTS)
    )
    turned = part.turned([0, 0, 1], 90.0)
    assert np.allclose(turned.distance(POINTS[:, [1, 0, 2]] * [-1, 1, 1]), part.distance(POINTS))
    assert np.allclose(turned.high, [-0.3, 0.7, 0.7])


def test_a_blend_only_ever_adds_and_a_carving_only_ever_takes():
    axes = 3 * (np.linspace(-2, 2, 30),)
    ball, other = ellipsoid([0, 0, 0], 1.0), ellipsoid([1.0, 0, 0], 0.8)
    sharp = field_of([ball, other], axes)
    assert np.all(field_of([ball, other.blended(0.4)], axes) <= sharp + 1e-12)
    alone = field_of([ball], axes)
    assert np.all(field_of([ball, other.carved(0.2)], axes) >= alone - 1e-12)


def test_a_pair_is_symmetric_about_the_middle_plane():
    mesh = mesh_of([ellipsoid([0, 0, 0], 1.0), *pair(ellipsoid([0, 1.1, 0], 0.5))], longest=0.1)
    assert mesh.volume > 0
    assert np.allclose(mesh.center_mass, 0.0, atol=2e-4)


def test_a_plate_keeps_outline_and_thickness():
    outline = [(0, 0), (2, 0), (2, 1), (0, 1)]
    assert volume_of(plate(outline, 0.5), 20000) == pytest.approx(1.0, rel=0.02)
    assert plate(outline, 0.5).distance(np.array([[1.0, 0.0, 0.5]]))[0] == pytest.approx(-0.25)
    assert plate(outline, 0.5).distance(np.array([[1.0, 1.0, 0.5]]))[0] == pytest.approx(0.75)


def test_parts_that_leave_nothing_are_refused():
    ball = ellipsoid([0, 0, 0], 1.0)
    with pytest.raises(InputError, match="nothing is inside"):
        mesh_of([ball, ellipsoid([0, 0, 0], 1.5).carved()], longest=0.1)
