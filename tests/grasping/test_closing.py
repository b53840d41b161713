"""Closing: known angles, monotony, independence of the triangulation, clearance bounds."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh

from medkit.errors import InputError
from medkit.grasping import PowerCloser, object_field
from medkit.grasping.closing.body_kernels import point_clearance
from medkit.grasping.closing.object_field import split_long_edges
from medkit.robots import load_hand

APPROACH, ALONG = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


def closed(hand, mesh, **options):
    closer = PowerCloser(hand, object_field(mesh.triangles, **options))
    return closer.close(np.zeros(3), APPROACH, ALONG)


def test_lattice_never_overstates_the_distance():
    mesh = trimesh.creation.torus(0.04, 0.01)
    field = object_field(mesh.triangles, spacing=0.006)
    points = np.random.default_rng(0).uniform(-0.09, 0.09, (500, 3))
    squared = igl.point_mesh_squared_distance(
        points, np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    )[0]
    bound = np.array([point_clearance(field, *point) for point in points])
    assert (bound <= np.sqrt(squared) + 1e-7).all()


def test_inside_flags_agree_with_a_ball():
    field = object_field(trimesh.creation.icosphere(4, 0.05).triangles, spacing=0.004)
    nodes = field.origin + np.argwhere(field.inside) * field.spacing
    assert len(nodes) > 500
    assert np.linalg.norm(nodes, axis=1).max() < 0.05


def test_splitting_keeps_the_area():
    triangles = trimesh.creation.box([1.0, 2.0, 3.0]).triangles
    pieces, source = split_long_edges(np.array(triangles), 0.3)
    area = 0.5 * np.linalg.norm(
        np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]), axis=1
    )
    assert area.sum() == pytest.approx(22.0)
    assert (np.diff(source) >= 0).all()


def test_a_thinner_bar_lets_the_thumb_close_further(hand):
    joint = hand.joint_names.index(hand.joint_names[int(hand.fingers[0].joints[0])])
    angles = [
        closed(hand, trimesh.creation.cylinder(r, 0.3, sections=96)).q[joint]
        for r in (0.035, 0.028, 0.021)
    ]
    assert angles == sorted(angles)


def test_the_result_does_not_depend_on_the_triangulation(hand):
    coarse = trimesh.creation.box([0.05, 0.06, 0.2])
    fine = coarse.subdivide().subdivide().subdivide()
    first, second = closed(hand, coarse), closed(hand, fine)
    assert first.retreat == pytest.approx(second.retreat, abs=1e-5)
    np.testing.assert_allclose(first.q, second.q, atol=2e-3)


def test_the_spacing_of_the_lattice_changes_nothing(hand):
    mesh = trimesh.creation.cylinder(0.03, 0.2, sections=64)
    first, second = closed(hand, mesh, spacing=0.003), closed(hand, mesh, spacing=0.007)
    np.testing.assert_allclose(first.q, second.q, atol=2e-3)


def test_a_finger_stops_at_a_plane_where_geometry_says(hand):
    """Whatever stopped by touch has its links within a hair of the surface."""
    mesh = trimesh.creation.box([0.06, 0.06, 0.3])
    grasp = closed(hand, mesh)
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    gaps = []
    for link in hand.link_meshes(grasp.q).values():
        link.apply_transform(grasp.pose)
        kind = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
        points = np.vstack([link.vertices, trimesh.sample.sample_surface(link, 2000, seed=0)[0]])
        gaps.append(igl.signed_distance(points, vertices, faces, kind)[0].min())
    assert min(gaps) > -1e-5
    assert sum(gap < 2e-4 for gap in gaps) >= 3


def test_an_empty_or_broken_object_is_refused():
    with pytest.raises(InputError, match="triangles"):
        object_field(np.zeros((0, 3, 3)))
    with pytest.raises(InputError, match="finite"):
        object_field(np.full((1, 3, 3), np.nan))
