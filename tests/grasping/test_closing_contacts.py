"""Contacts against plain numpy, and fingers that close on a cylinder where geometry says."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq

from medkit.grasping import PowerCloser, object_field
from medkit.grasping.closing.finger_kernels import TOUCH
from medkit.grasping.closing.hand_tables import palm_frame
from medkit.grasping.power import (
    CONTACT_SEPARATION,
    CONTACT_TOLERANCE,
    CONTACTS_PER_BODY,
    MIN_OPPOSITION,
)
from medkit.robots import load_hand

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
BODIES = {
    "torus": trimesh.creation.torus(0.05, 0.015, major_sections=40, minor_sections=16),
    "bar": trimesh.creation.box([0.05, 0.04, 0.2]),
}


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module", params=sorted(BODIES))
def grasped(request, hand):
    mesh = BODIES[request.param]
    closer = PowerCloser(hand, object_field(mesh.triangles))
    start = np.array([0.05, 0.0, 0.0]) if request.param == "torus" else np.zeros(3)
    return mesh, closer, closer.close(start, X, Z)


def planes_of(closer, body):
    hulls = closer.arrays.hulls
    return hulls.planes[hulls.plane_start[body] : hulls.plane_start[body + 1]]


def heights_over(closer, grasp, body, points):
    """Heights (n, p) of points over the planes of a body of the closed hand."""
    pose = grasp.pose @ closer.hand.link_poses(grasp.q)[closer.arrays.body_link[body]]
    planes = planes_of(closer, body)
    return ((points - pose[:3, 3]) @ pose[:3, :3]) @ planes[:, :3].T - planes[:, 3], pose, planes


def test_every_contact_lies_on_a_face_within_the_tolerance_and_faces_its_body(grasped):
    mesh, closer, grasp = grasped
    found = grasp.contacts
    assert len(found.points) >= 4
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    squared = igl.point_mesh_squared_distance(found.points, vertices, faces)[0]
    assert squared.max() < 1e-18
    for point, normal, body in zip(found.points, found.normals, found.bodies, strict=True):
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        in_plane = np.abs((mesh.triangles_center - point) @ normal) < 1e-9
        assert (mesh.face_normals[in_plane] @ normal).min() == pytest.approx(-1.0, abs=1e-9)
        heights, pose, planes = heights_over(closer, grasp, body, point[None])
        top = int(heights[0].argmax())
        assert -1e-6 < heights[0, top] <= CONTACT_TOLERANCE + 1e-12
        assert (pose[:3, :3] @ planes[top, :3]) @ normal >= MIN_OPPOSITION - 1e-9


def test_contacts_of_a_body_keep_apart_and_are_few(grasped):
    _, _, grasp = grasped
    for body in set(grasp.contacts.bodies):
        points = grasp.contacts.points[grasp.contacts.bodies == body]
        assert len(points) <= CONTACTS_PER_BODY
        for k in range(1, len(points)):
            way = np.linalg.norm(points[:k] - points[k], axis=1)
            assert way.min() >= CONTACT_SEPARATION - 1e-12


def test_a_body_touches_where_a_dense_sample_of_the_object_says_so(grasped):
    """The twin: which bodies have contacts, from samples of all faces and all planes."""
    mesh, closer, grasp = grasped
    points, faces = trimesh.sample.sample_surface(mesh, 60_000, seed=0)
    touching = set(grasp.contacts.bodies)
    for body in range(len(closer.arrays.body_link)):
        heights, pose, planes = heights_over(closer, grasp, body, points)
        top = heights.argmax(axis=1)
        gap = heights[np.arange(len(points)), top]
        opposed = -np.einsum("ij,ij->i", planes[top, :3] @ pose[:3, :3].T, mesh.face_normals[faces])
        clear = (gap < 0.6 * CONTACT_TOLERANCE) & (opposed > MIN_OPPOSITION + 0.05)
        if clear.any():
            assert body in touching
        if gap.min() > CONTACT_TOLERANCE + 2e-4:
            assert body not in touching


def test_reading_contacts_again_gives_the_same(grasped):
    """What closing knows of far bodies only saves work."""
    _, closer, grasp = grasped
    again = closer.contacts(grasp.pose, grasp.q)
    np.testing.assert_allclose(again.points, grasp.contacts.points, atol=1e-12)
    assert (again.bodies == grasp.contacts.bodies).all()


def test_a_finger_stops_where_its_links_reach_a_cylinder(hand):
    """A cylinder before the fingers: the angle is the root of the links' distance from it.

    The links are convex and closed against the true cylinder, of which the mesh lies inside by
    less than a micrometre.
    """
    radius, sections = 0.03, 720
    rod = trimesh.creation.cylinder(radius, 0.6, sections=sections)
    middle = np.array([0.035, 0.0, 0.0])
    rod.apply_translation(middle)
    closer = PowerCloser(hand, object_field(rod.triangles))
    grasp = closer.close_from(closer.start_pose(np.zeros(3), X, Z), X)
    stops = dict(zip(closer.arrays.joint.tolist(), grasp.stops.tolist(), strict=True))
    tried = 0
    for finger in hand.fingers[1:]:
        joint, bodies = int(finger.joints[0]), finger.moved_bodies[0]
        if stops[joint] != TOUCH:
            continue

        def gap(angle, joint=joint, bodies=bodies):
            q = np.array(hand.preshapes["power"])
            q[joint] = angle
            poses = grasp.pose @ hand.link_poses(q)
            return min(way_to_axis(hand.bodies[b], poses, middle) for b in bodies) - radius

        angles = np.linspace(hand.preshapes["power"][joint], hand.limits[joint, 1], 240)
        gaps = np.array([gap(angle) for angle in angles])
        assert gaps[0] > 0.0
        first = int(np.argmax(gaps < 0.0))
        wanted = brentq(gap, angles[first - 1], angles[first])
        assert grasp.q[joint] == pytest.approx(wanted, abs=1e-3)
        tried += 1
    assert tried >= 3


def way_to_axis(body, poses, middle):
    """Distance [m] of a body's faces from a line along z through `middle`, seen along it."""
    at = poses[body.link]
    corners = (body.vertices @ at[:3, :3].T + at[:3, 3] - middle)[:, :2]
    ends = corners[np.vstack([body.faces[:, [0, 1]], body.faces[:, [1, 2]], body.faces[:, [2, 0]]])]
    along = ends[:, 1] - ends[:, 0]
    square = np.maximum((along**2).sum(axis=1), 1e-24)
    share = np.clip(-(ends[:, 0] * along).sum(axis=1) / square, 0.0, 1.0)
    return float(np.linalg.norm(ends[:, 0] + share[:, None] * along, axis=1).min())


def test_a_palm_frame_is_a_rotation_with_the_direction_last():
    rng = np.random.default_rng(5)
    for direction, axis in rng.normal(size=(50, 2, 3)):
        frame = palm_frame(direction, axis)
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        np.testing.assert_allclose(frame[:, 2], direction / np.linalg.norm(direction))
        assert frame[:, 0] @ axis == pytest.approx(0.0, abs=1e-12)
        assert frame[:, 1] @ axis > 0.0
