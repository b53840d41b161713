"""Force closure, form closure, critical friction and volume: theorems and second opinions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.quality import (
    closure_margin,
    critical_friction,
    epsilon,
    is_force_closure,
    is_form_closure,
    volume,
)

FEW = settings(max_examples=40, derandomize=True, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)


def wedge(alpha):
    """Two planar contacts whose normals are `alpha` apart, on a chord along x."""
    half = 0.5 * (np.pi - alpha)
    normals = [[np.cos(half), np.sin(half)], [-np.cos(half), np.sin(half)]]
    return np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array(normals)


@FEW
@given(st.floats(0.05, np.pi), st.floats(0.01, 1.5))
def test_two_planar_contacts_close_exactly_as_the_antipodal_theorem_says(alpha, beta):
    points, normals = wedge(alpha)
    if abs(alpha + 2.0 * beta - np.pi) > 1e-8:
        closed = is_force_closure(points, normals, friction=np.tan(beta))
        assert closed == (alpha + 2.0 * beta > np.pi)


@pytest.mark.parametrize("alpha_deg", [30, 60, 90, 120, 135, 150, 179, 180])
def test_on_the_edge_of_the_theorem_there_is_no_closure(alpha_deg):
    alpha = np.deg2rad(alpha_deg)
    points, normals = wedge(alpha)
    friction = np.tan((np.pi - alpha) / 2.0)
    assert not is_force_closure(points, normals, friction=friction)
    assert is_force_closure(points, normals, friction=friction + 1e-6)
    assert critical_friction(points, normals) == pytest.approx(friction, abs=1e-6)


@FEW
@given(SEEDS, st.floats(0.05, 2.0))
def test_two_planar_contacts_anywhere_follow_nguyen(seed, friction):
    """Closed when and only when the chord lies inside both cones (Nguyen 1988)."""
    rng = np.random.default_rng(seed)
    points, angle = rng.normal(size=(2, 2)), rng.uniform(0, 2 * np.pi, 2)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    chord = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    off = np.arccos(np.clip([chord @ normals[0], -chord @ normals[1]], -1, 1))
    off_reversed = np.pi - off  # both may also pull the chord apart from inside
    half = np.arctan(friction)
    inside = (off < half).all() or (off_reversed < half).all()
    assert is_force_closure(points, normals, friction=friction) == inside


@FEW
@given(SEEDS)
def test_two_hard_contacts_in_space_never_close(seed):
    rng = np.random.default_rng(seed)
    points, normals = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for edges in (8, None):
        assert not is_force_closure(points, normals, friction=rng.uniform(0, 5), edges=edges)
    facing = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    assert not is_force_closure(-facing, facing, friction=1.0, edges=None)
    assert is_force_closure(-facing, facing, friction=1.0, contact="soft")


@FEW
@given(SEEDS, st.integers(2, 6), st.sampled_from(["point", "soft", "frictionless"]))
def test_closure_is_what_linear_programming_says(seed, n, contact):
    rng = np.random.default_rng(seed)
    n = 2 * n + 3 if contact == "frictionless" else n
    points = rng.normal(size=(n, 3))
    normals = -points + 0.5 * rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    origin, scale = points.mean(axis=0), np.linalg.norm(points - points.mean(axis=0), axis=1).max()
    wrenches = Contacts(points, normals, 0.4).wrenches(
        torque_origin=origin, torque_scale=scale, contact=contact, edges=6
    )
    closed = is_force_closure(points, normals, friction=0.4, contact=contact, edges=6)
    assert closed == (closure_margin(wrenches) > 1e-9)


@FEW
@given(SEEDS, st.floats(0.2, 5.0))
def test_closure_does_not_depend_on_origin_and_scale_for_exact_cones(seed, scale):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(4, 3))
    normals = -points / np.linalg.norm(points, axis=1)[:, None]
    plain = is_force_closure(points, normals, friction=0.5, edges=None)
    moved = is_force_closure(
        points, normals, friction=0.5, edges=None, torque_origin=rng.normal(size=3),
        torque_scale=scale,
    )  # fmt: skip
    assert plain == moved


def test_form_closure_takes_four_contacts_in_the_plane_and_turns_in_both_senses():
    normals = np.array([[1.0, 0], [-1, 0], [0, -1], [0, 1]])
    pinwheels = np.array([[-1, 0.5], [1, -0.5], [-0.5, 1], [0.5, -1]])
    assert is_form_closure(pinwheels, normals)
    one_sense = np.array([[-1, 0.5], [1, -0.5], [0.5, 1], [-0.5, -1]])
    assert not is_form_closure(one_sense, normals)
    for left_out in range(4):
        kept = np.delete(np.arange(4), left_out)
        assert not is_form_closure(pinwheels[kept], normals[kept])


def test_six_frictionless_contacts_never_close_and_a_box_on_twelve_does():
    rng = np.random.default_rng(4)
    for _ in range(20):
        normals = rng.normal(size=(6, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        assert not is_form_closure(rng.normal(size=(6, 3)), normals)
    faces = np.vstack([np.eye(3), -np.eye(3)])
    off = np.roll(np.abs(faces), 1, axis=1)
    points = np.vstack([-faces + 0.5 * off, -faces - 0.5 * off])
    assert is_form_closure(points, np.vstack([faces, faces]))


@FEW
@given(SEEDS)
def test_critical_friction_parts_open_from_closed(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(3, 3))
    normals = -points + 0.3 * rng.normal(size=(3, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    critical = critical_friction(points, normals, tolerance=1e-7)
    if critical.outcome == "found":
        assert is_force_closure(points, normals, friction=float(critical), edges=None)
        assert not is_force_closure(points, normals, friction=critical.lower, edges=None)
        assert np.arctan(critical) - np.arctan(critical.lower) <= 1e-7
    else:
        assert critical.outcome == "none"


def test_critical_friction_says_when_there_is_none_and_when_none_is_needed():
    same_side = critical_friction([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0, 0, 1.0], [0, 0, 1.0]])
    assert np.isnan(same_side)
    assert (same_side.outcome, same_side.lower) == ("none", 1000.0)
    pinwheels = [[-1, 0.5], [1, -0.5], [-0.5, 1], [0.5, -1]]
    held = critical_friction(pinwheels, [[1, 0], [-1, 0], [0, -1], [0, 1]])
    assert (float(held), held.outcome) == (0.0, "frictionless")
    with pytest.raises(InputError, match="above zero"):
        critical_friction(pinwheels, [[1, 0], [-1, 0], [0, -1], [0, 1]], tolerance=0.0)


def test_epsilon_begins_to_grow_at_the_critical_friction():
    points = np.array([[1.0, 0, 0], [-0.5, 0.8, 0.1], [-0.5, -0.8, -0.1]])
    normals = [0.0, 0.0, 0.3] - points  # all lifted to one side, so that friction has to pull back
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    critical = critical_friction(points, normals, edges=8, torque_origin=np.zeros(3))
    here = {"torque_origin": np.zeros(3), "torque_scale": 1.0}
    assert critical.outcome == "found"
    assert critical > 0.2
    assert epsilon(points, normals, friction=critical - 1e-4, **here).upper == 0.0
    assert 0.0 < epsilon(points, normals, friction=critical + 1e-4, **here).lower < 1e-3


@FEW
@given(SEEDS, st.integers(3, 6))
def test_volume_is_the_hulls_and_grows_with_contacts(seed, n):
    rng = np.random.default_rng(seed)
    points, angle = rng.normal(size=(n, 2)), rng.uniform(0, 2 * np.pi, n)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    here = {"friction": 0.5, "torque_origin": [0.0, 0.0], "torque_scale": 1.0}
    rows = Contacts(points, normals, 0.5).wrenches(torque_origin=[0.0, 0.0], torque_scale=1.0)
    found = volume(points, normals, **here)
    assert found == pytest.approx(ConvexHull(rows.reshape(-1, 3)).volume)
    assert found >= volume(points[:-1], normals[:-1], **here) - 1e-12
    assert found >= 4.0 / 3.0 * np.pi * epsilon(points, normals, **here).lower ** 3


def test_volume_of_flat_wrench_spaces_is_zero():
    facing = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    here = {"friction": 0.5, "torque_origin": np.zeros(3), "torque_scale": 1.0}
    assert volume(-facing, facing, **here) == 0.0
    assert volume(np.zeros((0, 3)), np.zeros((0, 3)), **here) == 0.0


@pytest.mark.parametrize("contact", ["point", "soft"])
def test_round_cones_have_no_primitive_wrenches_so_their_volume_is_refused(contact):
    facing = np.vstack([np.eye(3), -np.eye(3)])
    here = {"friction": 0.5, "torque_origin": np.zeros(3), "torque_scale": 1.0, "contact": contact}
    with pytest.raises(InputError, match="whole number of three or more, but got None"):
        volume(-facing, facing, **here, edges=None)
    with pytest.raises(InputError, match="but got None"):
        Contacts(-facing, facing, 0.5).cone_edges(torque_origin=np.zeros(3), edges=None)


def test_cones_that_need_no_edges_are_not_asked_for_them():
    planar = volume(
        [[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]],
        friction=1.0, torque_origin=[0.0, 0.0], torque_scale=1.0, edges=None,
    )  # fmt: skip
    assert planar == pytest.approx(8.0 / 3.0)
    points, inward = np.random.default_rng(0).normal(size=(2, 12, 3))
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    here = {"friction": 0.5, "torque_origin": np.zeros(3), "torque_scale": 1.0}
    exact = volume(points, inward, **here, contact="frictionless", edges=None)
    assert exact == volume(points, inward, **here, contact="frictionless") > 0.0


def test_numbers_that_are_not_finite_are_refused_in_one_line():
    with pytest.raises(InputError, match="row 1 is not finite") as caught:
        closure_margin([[1.0, 0.0, 0.0], [0.0, np.nan, 0.0]] * 5)
    assert "\n" not in str(caught.value)
