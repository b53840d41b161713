"""A second code path looks at planned grasps: libigl for surfaces, Qhull for epsilon."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from medkit.grasping import plan_power_grasps
from medkit.meshes import mass_properties, repair_mesh
from medkit.quality import epsilon
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


def cone_wrenches(points, normals, center, scale):
    """Eight wrenches a contact, its first edge along the lever arm: docs/decisions/0020."""
    wrenches = []
    for point, normal in zip(points, normals, strict=True):
        arm = point - center
        along = arm - (arm @ normal) * normal
        if np.linalg.norm(along) <= 1e-6 * np.linalg.norm(arm):
            along = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        first = along / np.linalg.norm(along)
        second = np.cross(normal, first)
        for angle in 2.0 * np.pi * np.arange(8) / 8:
            force = normal + FRICTION * (np.cos(angle) * first + np.sin(angle) * second)
            wrenches.append(np.r_[force, np.cross(arm, force) / scale])
    return np.array(wrenches)


def qhull_epsilon(wrenches):
    return max(-ConvexHull(wrenches).equations[:, -1].max(), 0.0)


def test_epsilon_is_that_of_a_full_convex_hull(planned):
    mesh, found = planned
    body = mass_properties(mesh)
    place = {"torque_origin": body.center_mass, "torque_scale": body.torque_scale}
    # Qhull in six dimensions takes seconds for many contacts, so the smallest grasps are taken
    holding = sorted(np.flatnonzero(found.force_closure), key=lambda k: len(found.grasps[k].points))
    assert len(holding) >= 3
    for grasp in (found.grasps[k] for k in holding[:3]):
        wrenches = cone_wrenches(grasp.points, grasp.normals, *place.values())
        value = qhull_epsilon(wrenches)
        ours = epsilon(grasp.points, grasp.normals, friction=FRICTION, edges=8, **place)
        assert value > 0.0
        assert ours.lower == pytest.approx(value, abs=1e-9)
        assert grasp.epsilon == pytest.approx(value, abs=1e-9)


def test_some_grasps_of_every_object_hold(planned):
    _, found = planned
    assert found.force_closure.sum() >= 3
