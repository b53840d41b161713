"""Planar force closure against the antipodal theorem, and the regions for two fingers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit import planar
from medkit.geometry import unit
from medkit.planar.regions import antipodal_pairs, force_closure_pairs

STEADY = settings(derandomize=True, max_examples=40, deadline=None)


def wedge_contacts(angle, radius=0.02):
    touch = planar.wedge(angle, radius=radius)[1]
    return touch, -touch / radius


@STEADY
@given(st.floats(1.0, 3.1), st.floats(0.05, 1.5))
def test_two_contacts_agree_with_the_antipodal_theorem(angle, friction):
    if abs(angle - planar.min_object_angle(friction)) < 1e-6:
        return
    points, normals = wedge_contacts(angle)
    expected = planar.is_antipodal(angle, friction=friction)
    assert planar.is_force_closure(points, normals, friction=friction) == expected
    assert (planar.epsilon(points, normals, friction=friction).lower > 0.0) == expected


@pytest.mark.parametrize("angle", np.radians([95.0, 120.0, 170.0]))
def test_critical_friction_of_two_contacts_is_the_bound(angle):
    points, normals = wedge_contacts(angle)
    found = planar.critical_friction(points, normals)
    assert found == pytest.approx(planar.min_friction(angle), rel=1e-6)


def test_epsilon_and_volume_grow_with_friction_and_shrink_with_length():
    outline = planar.rectangle()
    points = np.array([[0.0, -0.02], [0.03, 0.02], [-0.03, 0.02]])
    normals = np.array([[0.0, 1.0], [0.0, -1.0], [0.0, -1.0]])
    levels = [0.2, 0.5, 1.0]
    eps = [planar.epsilon(points, normals, friction=mu, outline=outline).lower for mu in levels]
    vol = [planar.volume(points, normals, friction=mu, outline=outline) for mu in levels]
    assert np.all(np.diff(eps) > 0.0)
    assert np.all(np.diff(vol) > 0.0)
    one, two = (
        planar.epsilon(points, normals, friction=0.5, torque_origin=[0, 0], torque_scale=length)
        for length in (0.02, 0.2)
    )
    assert two.lower < one.lower


def test_form_closure_needs_four_contacts():
    points = np.array([[-0.04, -0.01], [0.04, 0.01], [0.02, 0.02], [-0.02, -0.02]])
    normals = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])
    # one pair turns the bar one way, the other pair turns it back
    assert planar.is_form_closure(points, normals)
    assert not planar.is_form_closure(points[:3], normals[:3])


def test_primitive_wrenches_span_the_hull_that_epsilon_measures():
    outline = planar.rectangle()
    points, normals = [[-0.04, 0.0], [0.04, 0.0]], [[1.0, 0.0], [-1.0, 0.0]]
    wrenches = planar.primitive_wrenches(points, normals, friction=0.5, outline=outline)
    assert wrenches.shape == (4, 3)
    radius = planar.epsilon(points, normals, friction=0.5, outline=outline).lower
    from scipy.spatial import ConvexHull

    assert radius == pytest.approx(-ConvexHull(wrenches).equations[:, -1].max())


def test_primitive_wrenches_are_force_and_torque_of_the_cone_edges():
    outline, rng = planar.l_shape(), np.random.default_rng(3)
    points, angles = rng.normal(scale=0.05, size=(5, 2)), rng.uniform(0.0, 2.0 * np.pi, 5)
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    sides = np.column_stack([-normals[:, 1], normals[:, 0]])
    forces = np.stack([normals + 0.4 * sides, normals - 0.4 * sides], axis=1).reshape(-1, 2)
    arms = np.repeat(points - outline.center_mass, 2, axis=0) / outline.characteristic_length
    torques = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
    wrenches = planar.primitive_wrenches(points, normals, friction=0.4, outline=outline)
    assert wrenches == pytest.approx(np.column_stack([forces, torques]), abs=1e-12)


@pytest.mark.parametrize(
    "outline", [planar.triangle(), planar.l_shape(), planar.star(), planar.frame()],
    ids=lambda outline: outline.name,
)  # fmt: skip
def test_pair_regions_agree_with_brute_force(outline):
    rng, friction = np.random.default_rng(5), 0.4
    pairs = {}
    for pair in force_closure_pairs(outline, friction=friction):
        pairs.setdefault((pair.first, pair.second), []).append(pair)
    beta = np.arctan(friction)
    for _ in range(400):
        i, j = sorted(rng.choice(len(outline.starts), 2, replace=False))
        place = rng.uniform(0.0, 1.0, 2) * outline.lengths[[i, j]]
        p = outline.starts[[i, j]] + place[:, None] * outline.tangents[[i, j]]
        chord = unit(p[1] - p[0])
        lean = np.arccos([outline.inward_normals[i] @ chord, -outline.inward_normals[j] @ chord])
        margin = max(min(lean.max() - beta, 9.0), -9.0), max((np.pi - lean).max() - beta, -9.0)
        if min(abs(m) for m in margin) < 1e-6:
            continue
        expected = min(margin) < 0.0
        found = any(_inside(pair.region, place) for pair in pairs.get((i, j), []))
        assert found == expected


def _inside(polygon, point):
    a, b = polygon, np.roll(polygon, -1, axis=0)
    side = (b - a)[:, 0] * (point - a)[:, 1] - (b - a)[:, 1] * (point - a)[:, 0]
    return bool((side > 0.0).all() or (side < 0.0).all())


def test_independent_regions_hold_anywhere_within_them():
    outline, friction = planar.l_shape(), 0.3
    rng = np.random.default_rng(0)
    for pair in force_closure_pairs(outline, friction=friction):
        assert pair.room > 0.0
        assert pair.area >= np.prod(np.diff(pair.independent, axis=1)) - 1e-12
        edges = [pair.first, pair.second]
        for share in rng.uniform(0.01, 0.99, (20, 2)):
            place = pair.independent[:, 0] + share * np.diff(pair.independent, axis=1)[:, 0]
            p = outline.starts[edges] + place[:, None] * outline.tangents[edges]
            assert planar.is_force_closure(p, outline.inward_normals[edges], friction=friction)


def test_more_friction_means_more_room():
    outline = planar.triangle()
    areas = [sum(p.area for p in force_closure_pairs(outline, friction=mu))
             for mu in (0.1, 0.3, 0.6, 1.2)]  # fmt: skip
    assert np.all(np.diff(areas) > 0.0)


def test_antipodal_pairs_of_an_ellipse_are_its_axes():
    _, points = antipodal_pairs(planar.ellipse(0.08, 0.05))
    widths = sorted(np.linalg.norm(points[:, 1] - points[:, 0], axis=1))
    assert widths == pytest.approx([0.05, 0.08])


def test_antipodal_pairs_face_each_other():
    outline = planar.random_smooth(np.random.default_rng(2))
    _, points = antipodal_pairs(outline)
    assert len(points) >= 2
    for p, q in points:
        chord = unit(q - p)
        assert abs(outline.inward_normal_at(p) @ chord) == pytest.approx(1.0, abs=1e-9)
        assert abs(outline.inward_normal_at(q) @ chord) == pytest.approx(1.0, abs=1e-9)
