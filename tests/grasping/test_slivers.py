"""Triangles without area, as remeshing and exports leave them: they measure as what they are."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from medkit.grasping.closing.object_field import object_field
from medkit.grasping.closing.object_kernels import point_triangle_distance_squared

A, B, C = np.zeros(3), np.array([1.0, 0, 0]), np.array([0.25, 0, 0])
SLIVERS = {
    "one point three times": [A, A, A],
    "first corner twice": [A, A, B],
    "last corner twice": [A, B, B],
    "ends the same": [B, A, B],
    "corners in a row": [A, C, B],
    "in a row, the middle first": [C, A, B],
    "in a row, the middle last": [A, B, C],
}


@pytest.mark.parametrize("name", SLIVERS)
def test_a_triangle_without_area_is_as_far_as_its_longest_side(name):
    corners = np.array(SLIVERS[name])
    rng = np.random.default_rng(3)
    points = [*rng.uniform(-2.0, 2.0, (200, 3)), np.array([0.5, 1.0, 0]), A, np.array([3.0, 0, 0])]
    along = np.linspace(0.0, 1.0, 20001)[:, None]
    sides = [corners[k - 1] + along * (corners[k] - corners[k - 1]) for k in range(3)]
    for p in points:
        found = point_triangle_distance_squared(*p, corners)
        nearest = min(float(((side - p) ** 2).sum(axis=1).min()) for side in sides)
        assert found == pytest.approx(nearest, abs=2e-4)


def test_slivers_between_the_faces_change_nothing_of_an_object():
    box = trimesh.creation.box([0.06, 0.04, 0.02])
    corner, other = box.triangles[0][0], box.triangles[0][1]
    slivers = [
        [corner, corner, corner],
        [corner, other, other],
        [corner, 0.5 * (corner + other), other],
    ]
    with_slivers = object_field(np.concatenate([box.triangles, slivers]))
    plain = object_field(box.triangles)
    np.testing.assert_allclose(with_slivers.distances, plain.distances, atol=1e-9)
    np.testing.assert_array_equal(with_slivers.inside, plain.inside)
