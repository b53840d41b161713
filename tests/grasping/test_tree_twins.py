"""The object's tree against plain numpy that sorts every half: the same numbers to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from medkit.grasping.closing.ball_kernels import node_balls
from medkit.grasping.closing.face_tree import halved, measured, smallest_balls


def starts_of(count, level):
    return (count * np.arange(2**level + 1)) // 2**level


def sorted_halves(points, depth):
    """Order of points of which every half is sorted stably along its longest side."""
    order = np.arange(len(points))
    for level in range(depth + 1):
        starts = starts_of(len(points), level)
        ordered = points[order]
        low = np.minimum.reduceat(ordered, starts[:-1])
        longest = (np.maximum.reduceat(ordered, starts[:-1]) - low).argmax(axis=1)
        node = np.repeat(np.arange(len(longest)), np.diff(starts))
        along = ordered[np.arange(len(points)), longest[node]]
        order = order[np.lexsort((along, node))]
    return order


def balls_of_boxes(pieces, level):
    """Balls around the boxes' middles of consecutive pieces."""
    starts = starts_of(len(pieces), level)
    low = np.minimum.reduceat(pieces.min(axis=1), starts[:-1])
    high = np.maximum.reduceat(pieces.max(axis=1), starts[:-1])
    middle = 0.5 * (low + high)
    way = pieces - np.repeat(middle, np.diff(starts), axis=0)[:, None]
    radius = np.maximum.reduceat(np.linalg.norm(way, axis=2).max(axis=1), starts[:-1])
    return np.column_stack([middle, radius])


def balls_of_triangles(triangles):
    """Smallest balls around triangles, and the lengths of their edges."""
    rows = np.arange(len(triangles))
    sides = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    first = sides.argmax(axis=1)
    a, b, c = (triangles[rows, (first + shift) % 3] for shift in range(3))
    u, v = b - a, c - a
    uu, vv, uv = ((x * y).sum(axis=1) for x, y in ((u, u), (v, v), (u, v)))
    cross = uu * vv - uv**2
    acute = (vv + ((c - b) ** 2).sum(axis=1) > uu) & (cross > 1e-12 * uu**2)
    safe = np.where(acute, 2.0 * cross, 1.0)
    s = np.where(acute, vv * (uu - uv) / safe, 0.5)
    t = np.where(acute, uu * (vv - uv) / safe, 0.0)
    middle = a + s[:, None] * u + t[:, None] * v
    radius = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return np.column_stack([middle, radius]), sides


def points_with(kind, count):
    rng = np.random.default_rng(count)
    if kind == "spread":
        return rng.uniform(-0.1, 0.1, (count, 3))
    if kind == "many alike":  # ties at every halving, told apart by the halvings before
        return rng.integers(0, 4, (count, 3)) * np.array([1.0, 0.9, 0.5])
    return np.zeros((count, 3))


@pytest.mark.parametrize("kind", ["spread", "many alike", "one place"])
@pytest.mark.parametrize("count", [1, 7, 9, 100, 1000, 4097])
def test_parting_at_the_middle_gives_the_order_of_sorting(kind, count):
    points = points_with(kind, count)
    depth = max(int(np.ceil(np.log2(count / 8))), 0)
    assert np.array_equal(halved(points, depth), sorted_halves(points, depth))


@pytest.mark.parametrize("shape", [(500, 3, 3), (500, 1, 3)])
@pytest.mark.parametrize("level", [0, 3, 6])
def test_balls_around_nodes_are_those_of_numpy(shape, level):
    corners = np.random.default_rng(level).normal(size=shape)
    balls = np.zeros((2**level, 4))
    node_balls(corners, level, balls)
    assert np.array_equal(balls, balls_of_boxes(corners, level))


def test_balls_and_edges_of_triangles_are_those_of_numpy():
    slivers = np.random.default_rng(0).normal(size=(2000, 3, 3))
    slivers[::3, 2] = slivers[::3, 0] + 1e-9
    slivers[::7] = slivers[::7, :1]
    for triangles in (slivers, np.array(trimesh.creation.icosphere(3).triangles)):
        balls, sides = balls_of_triangles(triangles)
        length, edge = measured(triangles)
        assert np.array_equal(length, sides.max(axis=1))
        assert np.array_equal(edge, sides.argmax(axis=1))
        assert np.array_equal(smallest_balls(triangles), balls)
