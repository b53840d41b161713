"""Laws of the distances between grasps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.geometry import perpendicular, random_rotation, rotation_about
from medkit.similarity import d_eucl, d_symmetric, d_z, nearest_human, share_within
from medkit.similarity.measures import distance_table
from medkit.similarity.symmetry import (
    SymmetryGroup,
    ball_group,
    cyclic_group,
    dihedral_group,
    generated,
    revolution_group,
    trivial_group,
)

SEEDS = st.integers(0, 2**32 - 1)
LAW = settings(max_examples=25, derandomize=True, deadline=None)


def octahedral(center=(0.0, 0.0, 0.0)) -> SymmetryGroup:
    quarter = rotation_about([0, 0, 1], np.pi / 2), rotation_about([1, 0, 0], np.pi / 2)
    return SymmetryGroup("O", np.asarray(center), generated(quarter), np.array([0, 0, 1.0]))


def groups(rng: np.random.Generator) -> list[SymmetryGroup]:
    axis = random_rotation(rng)[0]
    across = perpendicular(axis)
    place = rng.normal(scale=0.05, size=3)
    return [
        trivial_group(place),
        cyclic_group(axis, 3, center=place),
        dihedral_group(axis, 4, across, center=place),
        octahedral(place),
        revolution_group(axis, center=place),
        revolution_group(axis, flips=True, center=place),
        ball_group(center=place),
    ]


def turned(grasp: np.ndarray, rotation: np.ndarray, center: np.ndarray) -> np.ndarray:
    return (grasp - center) @ rotation.T + center


@given(SEEDS)
@LAW
def test_reduced_distance_is_invariant_under_its_group_on_either_side(seed):
    rng = np.random.default_rng(seed)
    planned, human = rng.normal(scale=0.1, size=(2, 5, 3))
    for group in groups(rng):
        before = d_symmetric(planned, human, group=group)
        element = group.random_element(rng=rng)
        assert group.contains(element)
        moved = turned(planned, element, group.center)
        assert d_symmetric(moved, human, group=group) == pytest.approx(before, abs=1e-12)
        moved = turned(human, element, group.center)
        assert d_symmetric(planned, moved, group=group) == pytest.approx(before, abs=1e-12)
        assert d_symmetric(human, planned, group=group) == pytest.approx(before, abs=1e-12)


@given(SEEDS)
@LAW
def test_reduced_distance_changes_under_rotations_outside_the_group(seed):
    rng = np.random.default_rng(seed)
    grasp = rng.normal(scale=0.1, size=(5, 3))
    for group in groups(rng)[:-1]:
        outside = random_rotation(rng)  # almost surely outside, and never by a tiny angle
        if abs(np.trace(outside) - 3.0) < 0.1 or group.contains(outside, tolerance=0.1):
            continue
        moved = turned(grasp, outside, group.center)
        assert d_symmetric(moved, grasp, group=group) > 1e-4
        assert d_symmetric(grasp, grasp, group=group) < 1e-12


@given(SEEDS)
@LAW
def test_reduced_distance_is_the_least_over_many_elements(seed):
    rng = np.random.default_rng(seed)
    planned, human = rng.normal(scale=0.1, size=(2, 5, 3))
    for group in groups(rng):
        least = float(d_symmetric(planned, human, group=group))
        tried = [
            float(d_eucl(planned, turned(human, group.random_element(rng=rng), group.center)))
            for _ in range(40)
        ]
        assert min(tried) >= least - 1e-12
        assert least <= float(d_eucl(planned, human)) + 1e-12


def test_closed_form_about_an_axis_meets_a_fine_search():
    rng = np.random.default_rng(5)
    planned, human = rng.normal(scale=0.1, size=(2, 5, 3))
    group = revolution_group([0, 0, 1])
    angles = np.linspace(0.0, 2.0 * np.pi, 20001)
    fine = min(d_eucl(planned, human @ rotation_about([0, 0, 1], a).T) for a in angles)
    assert d_symmetric(planned, human, group=group) == pytest.approx(fine, abs=1e-7)


@given(SEEDS)
@LAW
def test_published_measures_are_metrics_and_height_is_the_weaker(seed):
    rng = np.random.default_rng(seed)
    a, b, c = rng.normal(scale=0.1, size=(3, 5, 3))
    for distance in (d_eucl, d_z):
        assert distance(a, a) == 0.0
        assert distance(a, b) == distance(b, a)
        assert distance(a, c) <= distance(a, b) + distance(b, c) + 1e-12
        shift = rng.normal(size=3)
        assert distance(a + shift, b + shift) == pytest.approx(distance(a, b))
    assert d_z(a, b) <= d_eucl(a, b)
    about_z = rotation_about([0, 0, 1], 1.0)
    assert d_z(a @ about_z.T, b) == pytest.approx(d_z(a, b), abs=1e-14)


def test_several_trials_of_a_subject_are_averaged_as_published():
    rng = np.random.default_rng(1)
    planned, trials = rng.normal(size=(4, 5, 3)), rng.normal(size=(10, 5, 3))
    vector = planned.reshape(4, 15) - trials.mean(axis=0).reshape(15)
    np.testing.assert_allclose(d_eucl(planned, trials), np.linalg.norm(vector, axis=1))
    heights = vector.reshape(4, 5, 3)[..., 2]
    np.testing.assert_allclose(d_z(planned, trials), np.linalg.norm(heights, axis=1))


def test_nearest_recording_is_found_and_shares_count_it():
    rng = np.random.default_rng(2)
    people = rng.normal(scale=0.1, size=(12, 5, 3))
    found = nearest_human(people + 1e-6, people)
    np.testing.assert_array_equal(found.index, np.arange(12))
    assert found.distance.max() < 1e-5
    shares = [share_within(people, people, radius=r) for r in (1e-9, 0.3, 10.0)]
    np.testing.assert_allclose(shares[0], 1.0 / 12.0)
    assert np.all(shares[1] <= shares[2])
    np.testing.assert_allclose(shares[2], 1.0)


def test_nearest_recording_ignores_symmetric_turns():
    rng = np.random.default_rng(3)
    people = rng.normal(scale=0.1, size=(6, 5, 3))
    group = revolution_group([0, 0, 1], flips=True)
    moved = np.stack([turned(g, group.random_element(rng=rng), group.center) for g in people])
    assert nearest_human(moved, people, group=group).distance.max() < 1e-12
    assert nearest_human(moved, people).distance.min() > 1e-3


def test_fewer_fingers_are_scaled_to_five():
    people = np.full((3, 3), 0.01)
    assert d_eucl(np.zeros((3, 3)), people) == pytest.approx(np.sqrt(15) * 0.01)
    table = distance_table(np.zeros((1, 2, 3)), np.full((1, 2, 3), 0.01))
    assert table[0, 0] == pytest.approx(np.sqrt(15) * 0.01)


def test_subgroup_that_keeps_up_drops_the_flips_of_a_can():
    group = revolution_group([0, 0, 1], flips=True)
    upright = group.keeping([0, 0, 1])
    assert upright.contains(rotation_about([0, 0, 1], 0.7))
    assert not upright.contains(rotation_about([1, 0, 0], np.pi))
    assert group.keeping([1, 0, 0]).order == 2
    assert octahedral().keeping([0, 0, 1]).order == 4
    assert octahedral().keeping([1, 1, 1]).order == 3
    assert ball_group().keeping([0, 1, 0]).continuous == "axis"


def test_finite_groups_are_closed():
    for group, order in ((octahedral(), 24), (dihedral_group([0, 0, 1], 6, [1, 0, 0]), 12)):
        assert group.order == order
        products = np.einsum("iab,jbc->ijac", group.rotations, group.rotations).reshape(-1, 3, 3)
        assert all(group.contains(product) for product in products)


@pytest.mark.parametrize(
    ("planned", "human"),
    [
        (np.zeros((5, 2)), np.zeros((5, 3))),
        (np.zeros((4, 3)), np.zeros((5, 3))),
        (np.full((5, 3), np.nan), np.zeros((5, 3))),
        (np.zeros((0, 5, 3)), np.zeros((5, 3))),
    ],
)
def test_unusable_fingertips_are_refused(planned, human):
    with pytest.raises(InputError, match="Expected"):
        d_eucl(planned, human)


def test_unusable_radius_and_generators_are_refused():
    with pytest.raises(InputError, match="radius"):
        share_within(np.zeros((5, 3)), np.zeros((1, 5, 3)), radius=0.0)
    with pytest.raises(InputError, match="finite group"):
        generated([rotation_about([0, 0, 1], 1.0)])
