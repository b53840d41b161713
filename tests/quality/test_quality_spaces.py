"""Wrench spaces of every kind against a hull that is written out, and values known beforehand."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, QhullError

from medkit.contacts import Contacts
from medkit.quality import critical_friction, epsilon, epsilon_many, is_force_closure

FEW = settings(max_examples=15, derandomize=True, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)
HERE = {"torque_origin": np.zeros(3), "torque_scale": 1.0}
AXES = np.vstack([np.eye(3), -np.eye(3)])


def around(rng, n, tilt=0.3):
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    normals = -points + tilt * rng.normal(size=(n, 3))
    return points * [1.0, 0.8, 0.6], normals / np.linalg.norm(normals, axis=1)[:, None]


def on_faces(rng, n):
    """Contacts on the faces of a box, where edges of different cones are often parallel."""
    faces = AXES[rng.permutation(6)[:n]]
    return np.where(faces != 0, -faces, 0.5 * rng.integers(-1, 2, (n, 3))), faces


def on_ring(n):
    turn = 2.0 * np.pi * np.arange(n) / n
    points = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    return points, -points


def by_sum(wrenches):
    """Epsilon of the Minkowski sum: every choice of a wrench, or none, from every contact."""
    shares = [np.vstack([np.zeros(wrenches.shape[2]), rows]) for rows in wrenches]
    rows = np.array([np.sum(chosen, axis=0) for chosen in itertools.product(*shares)])
    try:
        return max(0.0, float(-ConvexHull(rows).equations[:, -1].max()))
    except (QhullError, ValueError):
        return 0.0


@pytest.mark.parametrize(
    ("contact", "n", "edges"), [("point", 3, 4), ("point", 4, 3), ("soft", 2, 4), ("soft", 3, 4)]
)
@FEW
@given(seed=SEEDS, flat=st.booleans())
def test_fingers_limited_one_by_one_span_the_minkowski_sum(contact, n, edges, seed, flat):
    rng = np.random.default_rng(seed)
    points, normals = on_faces(rng, n) if flat else around(rng, n)
    how = {"edges": edges, "contact": contact, "patch_radius": 0.2}
    found = epsilon(points, normals, friction=0.9, **HERE, **how, norm="linf")
    wrenches = Contacts(points, normals, 0.9).wrenches(**HERE, **how)
    expected, longest = by_sum(wrenches), np.linalg.norm(wrenches, axis=2).max()
    assert found.converged
    np.testing.assert_allclose([found.lower, found.upper], expected, rtol=0, atol=1e-9 * longest)


@FEW
@given(seed=SEEDS)
def test_frictionless_fingers_span_a_zonotope(seed):
    """One segment each; eight of them from the corners of a box, pushing askew."""
    rng = np.random.default_rng(seed)
    points = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
    normals = -points + 0.6 * rng.normal(size=points.shape)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    how = {"contact": "frictionless"}
    found = epsilon(points, normals, friction=0.0, **HERE, **how, norm="linf")
    expected = by_sum(Contacts(points, normals, 0.0).wrenches(**HERE, **how))
    np.testing.assert_allclose([found.lower, found.upper], expected, rtol=0, atol=2e-9)


@FEW
@given(seed=SEEDS, n=st.integers(2, 4))
def test_the_sum_of_planar_contacts(seed, n):
    rng = np.random.default_rng(seed)
    points, angle = rng.normal(size=(n, 2)), rng.uniform(0, 2 * np.pi, n)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    here = {"torque_origin": np.zeros(2), "torque_scale": 1.0}
    found = epsilon(points, normals, friction=0.7, **here, norm="linf")
    wrenches = Contacts(points, normals, 0.7).wrenches(**here)
    longest = np.linalg.norm(wrenches, axis=2).max()
    np.testing.assert_allclose(
        [found.lower, found.upper], by_sum(wrenches), rtol=0, atol=1e-9 * longest
    )


@pytest.mark.parametrize("edges", [3, 4, 8, 32])
@pytest.mark.parametrize("norm", ["l1", "linf"])
def test_a_pyramid_lies_between_two_round_cones(edges, norm):
    """It holds the round cone of its inscribed circle, whatever the phase of its edges."""
    rng, closed = np.random.default_rng(edges), 0
    for n in (5, 6, 7):
        points, normals = around(rng, n, tilt=0.2)
        how = {**HERE, "norm": norm, "tolerance": 1e-8}
        inner = 0.6 * np.cos(np.pi / edges)
        rough = epsilon(points, normals, friction=0.6, edges=edges, **how)
        outside = epsilon(points, normals, friction=0.6, edges=None, **how)
        inside = epsilon(points, normals, friction=inner, edges=None, **how)
        assert inside.lower <= rough.upper + 1e-10
        assert rough.lower <= outside.upper + 1e-10
        closed += outside.force_closure
    assert closed >= 2


def test_the_pyramid_becomes_the_round_cone_with_the_square_of_its_edges():
    points, normals = around(np.random.default_rng(5), 5)
    exact = epsilon(points, normals, friction=0.6, **HERE, edges=None, tolerance=1e-9).lower
    missing = np.array([
        exact - epsilon(points, normals, friction=0.6, **HERE, edges=m).lower
        for m in (16, 64, 256, 1024)
    ])  # fmt: skip
    assert np.all(missing > 0.0)
    assert np.all(missing <= exact * (np.pi / np.array([16, 64, 256, 1024])) ** 2)
    assert missing[-1] < 1e-5


@FEW
@given(seed=SEEDS, norm=st.sampled_from(["l1", "linf"]), low=st.floats(0.0, 1.0),
       edges=st.sampled_from([3, 8]), contact=st.sampled_from(["point", "soft"]))  # fmt: skip
def test_rougher_fingertips_never_hold_less(seed, norm, low, edges, contact):
    rng = np.random.default_rng(seed)
    points, normals = around(rng, 5)
    smooth, more = low * rng.uniform(size=5), rng.uniform(0.0, 0.5, 5)
    how = {**HERE, "norm": norm, "edges": edges, "contact": contact, "patch_radius": 0.1}
    before = epsilon(points, normals, friction=smooth, **how)
    after = epsilon(points, normals, friction=smooth + more, **how)
    assert after.lower >= before.lower - 1e-9


@FEW
@given(seed=SEEDS, times=st.integers(2, 4))
def test_doubled_fingers_double_only_what_each_may_press(seed, times):
    """The same finger k times: nothing new for shared force, k times the force for separate."""
    points, normals = around(np.random.default_rng(seed), 4)
    again = np.repeat(points, times, axis=0), np.repeat(normals, times, axis=0)
    how = {"friction": 0.8, **HERE}
    once, many = epsilon(points, normals, **how), epsilon(*again, **how)
    assert many.lower == pytest.approx(once.lower, abs=1e-9)
    once = epsilon(points, normals, **how, norm="linf")
    many = epsilon(*again, **how, norm="linf")
    assert many.lower == pytest.approx(times * once.lower, abs=1e-9 * times)


FLAT_CASES = {
    "normals all one way": (np.eye(3), np.tile([0.0, 0.0, 1.0], (3, 1)), "point"),
    "fingertips in one line": (np.outer([-1.0, 0.2, 1.0], [1, 0, 0]),
                               [[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]], "point"),
    "frictionless in one plane": (AXES[[0, 1, 3, 4]] + 0.3 * AXES[[1, 3, 4, 0]],
                                  -AXES[[0, 1, 3, 4]], "frictionless"),
    "frictionless through one point": (AXES, -AXES, "frictionless"),
    "one fingertip many times": (np.tile([[0.3, 0.1, -1.0]], (7, 1)),
                                 np.tile([[0.0, 0, 1]], (7, 1)), "soft"),
}  # fmt: skip


@pytest.mark.parametrize("case", FLAT_CASES)
@pytest.mark.parametrize("norm", ["l1", "linf"])
def test_what_cannot_hold_gives_exactly_zero(case, norm):
    points, normals, contact = FLAT_CASES[case]
    for edges in (4, 8, None):
        how = {**HERE, "norm": norm, "contact": contact, "edges": edges}
        found = epsilon(points, normals, friction=2.0, **how)
        assert (found.lower, found.upper, found.force_closure) == (0.0, 0.0, False)
    assert not is_force_closure(points, normals, friction=2.0, contact=contact)


@pytest.mark.parametrize("n", [3, 4, 6])
def test_rings_of_round_cones_meet_their_tolerance(n):
    """A whole circle of weakest directions: pyramids with many edges bracket the answer."""
    points, normals = on_ring(n)
    found = epsilon(points, normals, friction=0.5, **HERE, edges=None, tolerance=1e-3)
    longest = np.sqrt(1.0 + 0.5**2 + 0.5**2)
    assert found.converged
    assert 0.0 < found.upper - found.lower <= 1e-3 * longest
    below = epsilon(points, normals, friction=0.5, **HERE, edges=24).lower
    above = epsilon(points, normals, friction=0.5 / np.cos(np.pi / 24), **HERE, edges=24).upper
    assert below <= found.upper
    assert found.lower <= above


def test_a_wide_ring_that_uses_up_its_room_keeps_honest_bounds():
    points, normals = on_ring(12)
    found = epsilon(points, normals, friction=1.0, **HERE, edges=None, tolerance=1e-6)
    assert not found.converged
    assert 0.0 < found.upper - found.lower < 5e-3
    wrenches = Contacts(points, normals, 1.0).wrenches(**HERE, edges=720)
    reach = (wrenches @ found.weakest_direction).max()
    assert found.lower <= reach <= found.upper + 1e-4
    batch = epsilon_many([points], [normals], friction=1.0, **HERE, edges=None, tolerance=1e-6)
    assert (batch.lower[0], batch.upper[0]) == (found.lower, found.upper)


@pytest.mark.parametrize("seed", range(8))
def test_whether_there_is_a_ball_is_settled_however_coarse_the_bounds(seed):
    """Just above the critical friction the ball is far smaller than the tolerance."""
    rng = np.random.default_rng(seed)
    points = np.array([[1.0, 0, 0], [-0.5, 0.8, 0.1], [-0.5, -0.8, -0.1], [0.1, 0.0, 0.9]])
    normals = [0.0, 0.0, 0.8] - points + 0.1 * rng.normal(size=(4, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    critical = critical_friction(points, normals, torque_origin=np.zeros(3))
    assert critical.outcome == "found"
    how = {**HERE, "edges": None, "tolerance": 0.1}
    above = epsilon(points, normals, friction=critical + 1e-6, **how)
    below = epsilon(points, normals, friction=critical - 1e-6, **how)
    assert (above.force_closure, below.force_closure) == (True, False)
    assert below.upper == 0.0


def test_a_long_queue_of_grasps_leaves_no_trace_in_the_next():
    """The room for facets is used again and again; each answer is that of a fresh start."""
    rng = np.random.default_rng(9)
    points, normals = around(rng, 6)
    first = epsilon(points, normals, friction=0.5, **HERE)
    crowd = [around(rng, int(n), tilt) for n in (3, 20, 5) for tilt in (0.0, 0.5, 2.0)]
    epsilon_many([p for p, _ in crowd], [n for _, n in crowd], friction=0.4, **HERE)
    again = epsilon(points, normals, friction=0.5, **HERE)
    assert (again.lower, again.upper) == (first.lower, first.upper)
    np.testing.assert_array_equal(again.weakest_direction, first.weakest_direction)
