"""A second code path looks at planned grasps: libigl for surfaces, Qhull for epsilon."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from medkit.grasping import plan_power_grasps
from medkit.meshes import mass_properties, repair_mesh
from medkit.robots import load_hand

FRICTION = 0.5


def mug():
    outer = trimesh.creation.cylinder(0.04, 0.1, sections=48)
    inner = trimesh.creation.cylinder(0.036, 0.1, sections=48)
    inner.apply_translation([0, 0, 0.006])
    handle = trimesh.creation.torus(0.028, 0.006, major_sections=32, minor_sections=16)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([0.042, 0, 0])
    body = trimesh.boolean.union([outer, handle], engine="manifold")
    return trimesh.boolean.difference([body, inner], engine="manifold")


def hammer():
    head = trimesh.creation.box([0.03, 0.09, 0.03])
    head.apply_translation([0, 0, 0.1])
    shaft = trimesh.creation.cylinder(0.017, 0.2, sections=32)
    return trimesh.boolean.union([head, shaft], engine="manifold")


OBJECTS = {
    "mug": mug,
    "box": lambda: trimesh.creation.box([0.05, 0.08, 0.15]),
    "capsule": lambda: trimesh.creation.capsule(0.12, 0.025),
    "hammer": hammer,
}


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module", params=sorted(OBJECTS))
def planned(request, hand):
    mesh = repair_mesh(OBJECTS[request.param]()).mesh
    rng = np.random.default_rng(5)
    return mesh, plan_power_grasps(
        mesh, hand, friction=FRICTION, max_candidates=24, min_radius_ratio=0.0, rng=rng
    )


def surface(mesh):
    return np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=np.int64)


def test_contacts_lie_on_the_mesh_with_its_inward_normal(planned):
    mesh, found = planned
    vertices, faces = surface(mesh)
    for grasp in found.grasps:
        if not len(grasp.points):
            continue
        squared, face, _ = igl.point_mesh_squared_distance(grasp.points, vertices, faces)
        assert np.sqrt(squared).max() < 1e-6
        inward = -mesh.face_normals[face]
        assert np.einsum("ij,ij->i", inward, grasp.normals).min() > np.cos(np.radians(15.0))


def test_no_link_goes_into_the_object_nor_the_object_into_a_link(planned, hand):
    mesh, found = planned
    vertices, faces = surface(mesh)
    dense, _ = trimesh.sample.sample_surface(mesh, 4000, seed=1)
    kind = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
    for grasp in found.grasps[::3]:
        for link in hand.link_meshes(grasp.q).values():
            link.apply_transform(grasp.pose)
            points, _ = trimesh.sample.sample_surface(link, 500, seed=1)
            points = np.vstack([points, link.vertices])
            assert igl.signed_distance(points, vertices, faces, kind)[0].min() > -1e-3
            near = dense[(np.abs(dense - link.bounds.mean(axis=0)) < link.extents / 2).all(axis=1)]
            if len(near):
                assert igl.signed_distance(near, *surface(link), kind)[0].min() > -1e-3


def test_contacts_touch_the_link_they_name(planned, hand):
    _, found = planned
    for grasp in found.grasps[::3]:
        links = hand.link_meshes(grasp.q)
        for point, link in zip(grasp.points, grasp.links, strict=True):
            mesh = links[link].copy()
            mesh.apply_transform(grasp.pose)
            squared = igl.point_mesh_squared_distance(point[None], *surface(mesh))[0]
            assert np.sqrt(squared[0]) < 1e-3


def qhull_epsilon(points, normals, center, scale):
    wrenches = []
    for point, normal in zip(points, normals, strict=True):
        helper = np.eye(3)[np.argmin(np.abs(normal))]
        first = np.cross(normal, helper)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        for angle in np.arange(8) * np.pi / 4:
            force = normal + FRICTION * (np.cos(angle) * first + np.sin(angle) * second)
            wrenches.append(np.r_[force, np.cross(point - center, force) / scale])
    offsets = -ConvexHull(np.array(wrenches), qhull_options="QJ").equations[:, -1]
    return max(offsets.min(), 0.0)


def test_epsilon_is_that_of_a_full_convex_hull(planned):
    mesh, found = planned
    body = mass_properties(mesh)
    checked = 0
    for grasp in found.grasps:
        if 3 <= len(grasp.points) <= 8 and checked < 2:
            value = qhull_epsilon(grasp.points, grasp.normals, body.center_mass, body.torque_scale)
            # cones start at another edge: two regular octagons differ by at most 1 - cos(pi / 8)
            assert grasp.epsilon == pytest.approx(value, abs=0.08 * max(value, 0.01))
            checked += 1


def test_some_grasps_of_every_object_hold(planned):
    _, found = planned
    assert found.force_closure.sum() >= 3
