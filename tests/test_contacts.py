"""Contacts: the cone-edge convention, the wrenches, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.geometry import perpendicular, random_rotation
from medkit.wrench_cones import cone_profile, wrench_cones

FEW = settings(max_examples=25, derandomize=True, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)


def contacts_on_a_ball(rng, n, friction=0.5):
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    normals = -points + 0.3 * rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Contacts(points, normals, friction)


def plain_edges(contacts, origin, edges):
    """The convention of decision 0020 in plain numpy, one contact after the other."""
    result = []
    for p, n, mu in zip(contacts.points, contacts.normals, contacts.friction, strict=True):
        arm = p - origin
        tangential = arm - (arm @ n) * n
        if np.linalg.norm(tangential) <= 1e-6 * np.linalg.norm(arm):
            tangential = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        t1 = tangential / np.linalg.norm(tangential)
        t2 = np.cross(n, t1)
        turn = 2 * np.pi * np.arange(edges) / edges
        result.append(n + mu * (np.outer(np.cos(turn), t1) + np.outer(np.sin(turn), t2)))
    return np.array(result)


@FEW
@given(SEEDS, st.integers(3, 12))
def test_edges_follow_the_convention_in_plain_numpy(seed, edges):
    rng = np.random.default_rng(seed)
    contacts, origin = contacts_on_a_ball(rng, 4, rng.uniform(0, 2, 4)), rng.normal(size=3)
    forces = contacts.cone_edges(torque_origin=origin, edges=edges)
    np.testing.assert_allclose(forces, plain_edges(contacts, origin, edges), atol=1e-12)


@FEW
@given(SEEDS, st.floats(0.1, 10.0))
def test_wrenches_are_the_edges_and_their_scaled_torques(seed, scale):
    rng = np.random.default_rng(seed)
    contacts, origin = contacts_on_a_ball(rng, 5), rng.normal(size=3)
    forces = contacts.cone_edges(torque_origin=origin)
    torques = np.cross((contacts.points - origin)[:, None, :], forces) / scale
    wrenches = contacts.wrenches(torque_origin=origin, torque_scale=scale)
    np.testing.assert_allclose(wrenches, np.concatenate([forces, torques], axis=2), atol=1e-12)


@FEW
@given(SEEDS)
def test_edges_turn_with_the_grasp(seed):
    rng = np.random.default_rng(seed)
    contacts, turn = contacts_on_a_ball(rng, 4), random_rotation(rng)
    turned = Contacts(contacts.points @ turn.T, contacts.normals @ turn.T, 0.5)
    np.testing.assert_allclose(
        turned.cone_edges(torque_origin=np.zeros(3)),
        contacts.cone_edges(torque_origin=np.zeros(3)) @ turn.T,
        atol=1e-9,
    )


def test_a_lever_along_the_normal_takes_a_world_axis():
    normals = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8]])
    contacts = Contacts(-normals, normals, 0.5)
    first = contacts.cone_edges(torque_origin=np.zeros(3))[:, 0]
    np.testing.assert_allclose(first, normals + 0.5 * perpendicular(normals), atol=1e-15)


def test_every_edge_lies_on_the_cone():
    contacts = contacts_on_a_ball(np.random.default_rng(3), 6, friction=0.7)
    forces = contacts.cone_edges(torque_origin=np.zeros(3), edges=7)
    along = np.einsum("nmi,ni->nm", forces, contacts.normals)
    across = np.linalg.norm(forces - along[:, :, None] * contacts.normals[:, None, :], axis=2)
    np.testing.assert_allclose(along, 1.0, atol=1e-12)
    np.testing.assert_allclose(across, 0.7, atol=1e-12)


def test_planar_wrenches_are_the_spatial_ones_seen_from_above():
    rng = np.random.default_rng(5)
    points, angle = rng.normal(size=(4, 2)), rng.uniform(0, 2 * np.pi, 4)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    flat = Contacts(points, normals, 0.4).wrenches(torque_origin=[0.1, 0.2], torque_scale=0.5)
    arms = points - [0.1, 0.2]
    for side, column in ((1.0, 0), (-1.0, 1)):
        force = normals + side * 0.4 * np.column_stack([-normals[:, 1], normals[:, 0]])
        torque = (arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]) / 0.5
        np.testing.assert_allclose(flat[:, column], np.column_stack([force, torque]), atol=1e-12)


def test_a_soft_finger_adds_torsion_about_the_normal_and_nothing_in_the_plane():
    contacts = Contacts([[0.0, 0.0, -0.1]], [[0.0, 0.0, 1.0]], 0.6)
    cones = wrench_cones(
        contacts, torque_origin=np.zeros(3), torque_scale=0.1, contact="soft", patch_radius=0.006
    )
    np.testing.assert_allclose(cones.axes[0, 2], [0, 0, 0, 0, 0, 2 / 3 * 0.6 * 0.006 / 0.1])
    flat = Contacts([[-1.0, 0.0]], [[1.0, 0.0]], 0.6)
    same = {"torque_origin": [0.0, 0.0], "torque_scale": 1.0}
    np.testing.assert_array_equal(flat.wrenches(**same, contact="soft"), flat.wrenches(**same))


@pytest.mark.parametrize(("edges", "rows"), [(4, 6), (6, 14), (8, 26), (12, 62)])
def test_the_soft_profile_lies_on_the_unit_sphere(edges, rows):
    profile = cone_profile(3, "soft", edges)
    assert profile.shape == (rows, 3)
    np.testing.assert_allclose(np.linalg.norm(profile, axis=1), 1.0, atol=1e-12)


GOOD = ([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]], 0.5)


@pytest.mark.parametrize(
    ("points", "normals", "friction", "said"),
    [
        (GOOD[0], GOOD[1], -0.1, "zero or more"),
        (GOOD[0], GOOD[1], np.nan, "finite"),
        (GOOD[0], GOOD[1], [0.1, 0.2, 0.3], "one for each of 2"),
        (GOOD[0], [[1.0, 0.0], [-1.1, 0.0]], 0.5, "length one"),
        (GOOD[0], [[1.0, 0.0], [np.nan, 0.0]], 0.5, "finite"),
        (GOOD[0], [[1.0, 0.0]], 0.5, "one normal per point"),
        ([[np.inf, 0.0], [1.0, 0.0]], GOOD[1], 0.5, "finite"),
        ([1.0, 2.0], GOOD[1], 0.5, "shape"),
        (np.zeros((2, 4)), GOOD[1], 0.5, "shape"),
    ],
)
def test_bad_contacts_are_refused_with_a_reason(points, normals, friction, said):
    with pytest.raises(InputError, match=said):
        Contacts(points, normals, friction)


@pytest.mark.parametrize("edges", [2, 0, -8, 8.0, True])
def test_a_cone_has_three_edges_or_more(edges):
    with pytest.raises(InputError, match="three or more"):
        cone_profile(3, "point", edges)


def test_contacts_keep_their_own_numbers():
    points, normals = np.array(GOOD[0]), np.array(GOOD[1])
    contacts = Contacts(points, normals, 0.5)
    points[:], normals[:] = 7.0, 0.0
    np.testing.assert_array_equal(contacts.points, GOOD[0])
    np.testing.assert_array_equal(contacts.normals, GOOD[1])
    for rows in (points, np.asfortranarray(np.ones((3, 3)))):
        rows.flags.writeable = False
        side = np.eye(3)[: len(rows), : rows.shape[1]]
        assert len(Contacts(rows, side, 0.1)) == len(rows)


@pytest.mark.parametrize("friction", [np.nan, -0.1, [[0.5]]])
def test_no_contacts_at_all_are_checked_like_any(friction):
    with pytest.raises(InputError, match="friction"):
        Contacts(np.zeros((0, 3)), np.zeros((0, 3)), friction)
    assert len(Contacts(np.zeros((0, 3)), np.zeros((0, 3)), [])) == 0


def test_contacts_cannot_be_changed_by_attribute():
    contacts = Contacts(*GOOD)
    assert (len(contacts), contacts.dimension) == (2, 2)
    with pytest.raises(AttributeError):
        contacts.friction = 0.9


@pytest.mark.parametrize("origin", [[0.0, 0.0], 0.0, None, [[0.0, 0.0, 0.0]], [0.0, np.nan, 0.0]])
def test_a_torque_origin_is_asked_for_as_one_point(origin):
    pinch = Contacts(np.zeros((1, 3)), [[1.0, 0.0, 0.0]], 0.5)
    with pytest.raises(InputError, match="torque_origin to be 3 finite numbers, but got"):
        pinch.cone_edges(torque_origin=origin)
