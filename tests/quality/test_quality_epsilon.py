"""Epsilon: agreement with Qhull, and the laws a radius obeys."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, QhullError

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.geometry import random_rotation
from medkit.quality import closure_margin, epsilon, epsilon_many

FEW = settings(max_examples=30, derandomize=True, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)
AXES = np.vstack([np.eye(3), -np.eye(3)])
HERE = {"torque_origin": np.zeros(3), "torque_scale": 1.0}


def on_a_ball(rng, n, tilt=0.3):
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    normals = -points + tilt * rng.normal(size=(n, 3))
    return points * [1.0, 0.8, 0.6], normals / np.linalg.norm(normals, axis=1)[:, None]


def on_a_box(rng, n, grid=2):
    """Contacts at grid points of a box's faces: coplanar, collinear, repeated."""
    faces = AXES[rng.integers(6, size=n)]
    points = np.round(rng.uniform(-1, 1, (n, 3)) * grid) / grid
    return np.where(faces != 0, -faces, points) * [1.0, 0.7, 0.4], faces


def on_a_ring(rng, n):
    turn = 2 * np.pi * np.arange(n) / n
    inward = np.column_stack([-np.cos(turn), -np.sin(turn), 0 * turn])
    return -inward + np.outer(rng.choice([-0.5, 0.0, 0.5], n), [0, 0, 1]), inward


def on_a_solid(rng, n):
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T / np.sqrt(3)
    points = [AXES, corners][rng.integers(2)]
    points = points[rng.permutation(len(points))[:n]]
    return points, -points


def repeated(rng, n):
    points, normals = on_a_box(rng, max(2, n // 2))
    chosen = rng.integers(len(points), size=n)
    return points[chosen], normals[chosen]


def by_qhull(points, normals, friction, scale=1.0, **how):
    """Epsilon from the whole hull of the primitive wrenches; also the longest wrench."""
    contacts = Contacts(points, normals, friction)
    rows = contacts.wrenches(
        torque_origin=np.zeros(contacts.dimension), torque_scale=scale, **how
    ).reshape(-1, 3 * (contacts.dimension - 1))
    longest = np.linalg.norm(rows, axis=1).max()
    try:
        hull = ConvexHull(rows)
    except (QhullError, ValueError):  # fewer points than a simplex has, or all in one plane
        return 0.0, longest
    return max(0.0, float((-hull.equations[:, -1]).min())), longest


@pytest.mark.parametrize("family", [on_a_ball, on_a_box, on_a_ring, on_a_solid, repeated])
@FEW
@given(seed=SEEDS, n=st.integers(1, 8), friction=st.sampled_from([0.1, 0.5, 1.0]),
       scale=st.sampled_from([0.3, 1.0, 1.7]))  # fmt: skip
def test_linearised_cones_agree_with_qhull(family, seed, n, friction, scale):
    points, normals = family(np.random.default_rng(seed), n)
    expected, longest = by_qhull(points, normals, friction, scale)
    found = epsilon(
        points, normals, friction=friction, torque_origin=np.zeros(3), torque_scale=scale
    )
    assert found.converged
    assert found.lower <= found.upper
    np.testing.assert_allclose([found.lower, found.upper], expected, rtol=0, atol=1e-9 * longest)


@pytest.mark.parametrize("friction", [0.1, 0.5, 1.0])
def test_contacts_in_perfect_balance_are_no_trap(friction):
    """The mean wrench of all corners of a cube is zero, up to rounding or exactly."""
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T / np.sqrt(3)
    rng = np.random.default_rng(0)
    for _ in range(20):
        order = rng.permutation(8)
        expected, longest = by_qhull(corners[order], -corners[order], friction, edges=6)
        found = epsilon(corners[order], -corners[order], friction=friction, **HERE, edges=6)
        assert found.lower == pytest.approx(expected, abs=1e-9 * longest)
        assert found.force_closure


@pytest.mark.parametrize("jitter", [1e-14, 1e-12, 1e-11, 1e-10, 1e-9, 1e-7])
def test_almost_coplanar_facets_are_no_trap_either(jitter):
    rng = np.random.default_rng(1)
    for n in (5, 6, 7, 9):
        turn = 2 * np.pi * np.arange(n) / n
        ring = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
        points = ring + jitter * rng.normal(size=(n, 3))
        found = epsilon(points, -ring, friction=0.3, **HERE, edges=4)
        wrenches = Contacts(points, -ring, 0.3).wrenches(**HERE, edges=4)
        assert found.converged
        reach = (wrenches.reshape(-1, 6) @ found.weakest_direction).max()
        assert reach == pytest.approx(found.upper, abs=1e-9)
        assert found.upper - found.lower <= 1e-9 * np.linalg.norm(wrenches, axis=2).max()
        assert closure_margin(wrenches) > 0.0
        assert found.force_closure


@pytest.mark.parametrize("contact", ["soft", "frictionless"])
@FEW
@given(seed=SEEDS, n=st.integers(2, 8))
def test_soft_and_frictionless_fingers_agree_with_qhull(contact, seed, n):
    rng = np.random.default_rng(seed)
    points, normals = on_a_box(rng, n) if contact == "soft" else on_a_ball(rng, 2 * n)
    how = {"contact": contact, "edges": 4, "patch_radius": 0.1}
    expected, longest = by_qhull(points, normals, 0.5, **how)
    found = epsilon(points, normals, friction=0.5, **HERE, **how)
    np.testing.assert_allclose([found.lower, found.upper], expected, rtol=0, atol=1e-9 * longest)


@FEW
@given(seed=SEEDS, n=st.integers(1, 7))
def test_the_plane_runs_through_the_same_code(seed, n):
    rng = np.random.default_rng(seed)
    points, angle = rng.normal(size=(n, 2)), rng.uniform(0, 2 * np.pi, n)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    expected, longest = by_qhull(points, normals, 0.6)
    found = epsilon(points, normals, friction=0.6, torque_origin=np.zeros(2), torque_scale=1.0)
    np.testing.assert_allclose([found.lower, found.upper], expected, rtol=0, atol=1e-9 * longest)


@FEW
@given(seed=SEEDS, n=st.integers(2, 6))
def test_a_radius_exactly_where_linear_programming_finds_closure(seed, n):
    points, normals = on_a_box(np.random.default_rng(seed), n)
    wrenches = Contacts(points, normals, 0.5).wrenches(**HERE)
    found = epsilon(points, normals, friction=0.5, **HERE)
    assert found.force_closure == (closure_margin(wrenches) > 1e-9)


@pytest.mark.parametrize("norm", ["l1", "linf"])
@pytest.mark.parametrize("contact", ["point", "soft"])
def test_the_whole_grasp_may_turn_about_the_torque_origin(norm, contact):
    rng = np.random.default_rng(11)
    for edges in (8, None):
        points, normals = on_a_ball(rng, 5)
        turn = random_rotation(rng)
        how = {"friction": 0.6, **HERE, "norm": norm, "contact": contact, "edges": edges}
        straight = epsilon(points, normals, **how, tolerance=1e-8)
        turned = epsilon(points @ turn.T, normals @ turn.T, **how, tolerance=1e-8)
        assert turned.lower == pytest.approx(straight.lower, abs=3e-8 if edges is None else 1e-9)
        assert straight.lower > 0.0


@FEW
@given(seed=SEEDS, factor=st.floats(1e-3, 1e3), norm=st.sampled_from(["l1", "linf"]))
def test_units_do_not_matter_when_every_length_is_scaled(seed, factor, norm):
    points, normals = on_a_ball(np.random.default_rng(seed), 5)
    how = {"friction": 0.5, "torque_origin": np.zeros(3), "contact": "soft", "norm": norm}
    plain = epsilon(points, normals, **how, torque_scale=1.0, patch_radius=0.05)
    scaled = epsilon(
        factor * points, normals, **how, torque_scale=factor, patch_radius=0.05 * factor
    )
    assert scaled.lower == pytest.approx(plain.lower, abs=1e-9)


@FEW
@given(seed=SEEDS, low=st.floats(0.0, 1.0), more=st.floats(0.0, 1.0))
def test_rougher_is_never_worse_with_exact_cones(seed, low, more):
    points, normals = on_a_ball(np.random.default_rng(seed), 4)
    smooth = epsilon(points, normals, friction=low, **HERE, edges=None)
    rough = epsilon(points, normals, friction=low + more, **HERE, edges=None)
    assert rough.upper >= smooth.lower


@FEW
@given(seed=SEEDS, n=st.integers(3, 7), norm=st.sampled_from(["l1", "linf"]))
def test_another_contact_is_never_worse(seed, n, norm):
    points, normals = on_a_ball(np.random.default_rng(seed), n)
    how = {"friction": 0.5, **HERE, "norm": norm}
    fewer = epsilon(points[:-1], normals[:-1], **how)
    assert epsilon(points, normals, **how).upper >= fewer.lower - 1e-10


@FEW
@given(seed=SEEDS, n=st.integers(3, 7))
def test_forces_bounded_one_by_one_reach_at_least_as_far_as_their_sum(seed, n):
    points, normals = on_a_ball(np.random.default_rng(seed), n)
    union = epsilon(points, normals, friction=0.5, **HERE)
    total = epsilon(points, normals, friction=0.5, **HERE, norm="linf")
    assert total.upper >= union.lower - 1e-10
    assert total.lower <= n * union.upper + 1e-9


@pytest.mark.parametrize("contact", ["point", "soft"])
def test_more_edges_approach_the_exact_cone_from_below(contact):
    points, normals = on_a_ball(np.random.default_rng(2), 5)
    how = {"friction": 0.7, **HERE, "contact": contact, "patch_radius": 0.2}
    exact = epsilon(points, normals, **how, edges=None, tolerance=1e-8)
    assert exact.upper - exact.lower <= 1e-8 * 2.0
    doubled = [epsilon(points, normals, **how, edges=m).lower for m in (4, 8, 16, 32, 64)]
    assert np.all(np.diff(doubled) >= -1e-10)  # edges of m are among those of 2 m
    assert doubled[-1] <= exact.upper
    errors = exact.lower - np.array(doubled)
    assert errors[-1] < 0.01 * exact.lower
    assert errors[-1] < errors[0] / 50.0


@FEW
@given(seed=SEEDS)
def test_the_order_of_contacts_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    points, normals = on_a_box(rng, 6)
    order = rng.permutation(6)
    first = epsilon(points, normals, friction=0.5, **HERE)
    second = epsilon(points[order], normals[order], friction=0.5, **HERE)
    assert second.lower == pytest.approx(first.lower, abs=1e-10)


@FEW
@given(seed=SEEDS, norm=st.sampled_from(["l1", "linf"]), edges=st.sampled_from([8, None]))
def test_the_weakest_direction_is_where_the_upper_bound_is_reached(seed, norm, edges):
    points, normals = on_a_ball(np.random.default_rng(seed), 6)
    found = epsilon(points, normals, friction=0.5, **HERE, norm=norm, edges=edges)
    wrenches = Contacts(points, normals, 0.5).wrenches(**HERE, edges=edges or 512)
    reach = (wrenches @ found.weakest_direction).max(axis=1)
    height = reach.max() if norm == "l1" else np.maximum(reach, 0.0).sum()
    assert np.linalg.norm(found.weakest_direction) == pytest.approx(1.0)
    if found.force_closure:
        assert height == pytest.approx(found.upper, abs=2e-4 if edges is None else 1e-10)
    else:
        assert height <= 1e-9


def test_two_soft_fingers_hold_where_two_hard_ones_never_do():
    points, normals = np.array([[-1.0, 0, 0], [1.0, 0, 0]]), np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    for edges in (8, None):
        how = {"friction": 0.8, **HERE, "edges": edges}
        assert epsilon(points, normals, **how).upper == 0.0
        assert epsilon(points, normals, **how, contact="soft", patch_radius=0.1).lower > 0.01


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("norm", ["l1", "linf"])
def test_too_few_contacts_give_zero_and_no_exception(dimension, norm):
    for n in (0, 1):
        found = epsilon(
            np.ones((n, dimension)), np.eye(dimension)[:n], friction=0.5,
            torque_origin=np.zeros(dimension), torque_scale=1.0, norm=norm,
        )  # fmt: skip
        assert (found.lower, found.upper, found.force_closure) == (0.0, 0.0, False)


def test_a_disk_pinched_across_has_the_radius_of_its_drawing():
    """Wrenches (+-1, +-mu, -+mu): the tetrahedron's faces lie at sqrt(1/3) for mu = 1."""
    pinch = ([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]])
    found = epsilon(*pinch, friction=1.0, torque_origin=[0.0, 0.0], torque_scale=1.0)
    assert found.lower == pytest.approx(np.sqrt(1.0 / 3.0), abs=1e-12)


def test_a_batch_gives_what_single_calls_give():
    rng = np.random.default_rng(8)
    grasps = [on_a_ball(rng, int(n)) for n in rng.integers(1, 12, 40)]
    how = {"friction": 0.5, **HERE}
    batch = epsilon_many([p for p, _ in grasps], [n for _, n in grasps], **how)
    singles = [epsilon(p, n, **how) for p, n in grasps]
    np.testing.assert_array_equal(batch.lower, [one.lower for one in singles])
    np.testing.assert_array_equal(batch.upper, [one.upper for one in singles])
    assert 0 < batch.force_closure.sum() < 40
    assert len(epsilon_many([], [], **how).lower) == 0
    with pytest.raises(InputError, match="in pairs"):
        epsilon_many([grasps[0][0]], [grasps[0][1][:-1]], **how)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"norm": "l2"}, "'l1' or 'linf'"),
        ({"contact": "hard"}, "'point', 'frictionless' or 'soft'"),
        ({"torque_scale": 0.0}, "above zero"),
        ({"torque_origin": [0.0, 0.0]}, "torque_origin"),
        ({"friction": -1.0}, "zero or more"),
        ({"edges": None, "tolerance": 0.0}, "above zero"),
    ],
)
def test_bad_arguments_are_refused_with_a_reason(change, said):
    points, normals = on_a_ball(np.random.default_rng(0), 4)
    with pytest.raises(InputError, match=said):
        epsilon(points, normals, **({"friction": 0.5, **HERE} | change))
