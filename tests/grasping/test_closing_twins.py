"""The closing kernels against plain numpy: clipping, walks down the tree, gaps, kinematics."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh

from medkit.geometry import random_rotation
from medkit.grasping.closing import (
    body_kernels,
    finger_kernels,
    self_kernels,
    sight_kernels,
    tree_kernels,
)
from medkit.grasping.closing.chain_kernels import place_links
from medkit.grasping.closing.face_tree import FAN
from medkit.grasping.closing.finger_kernels import LIMIT, SELF, TOUCH
from medkit.grasping.closing.hand_tables import closing_hand
from medkit.grasping.closing.hull_tables import CELL
from medkit.grasping.closing.kernel_options import entry
from medkit.grasping.closing.object_field import object_field
from medkit.grasping.closing.whole_kernels import retreat
from medkit.robots import load_hand

BLOB = trimesh.creation.torus(0.05, 0.015, major_sections=40, minor_sections=16)
NAMES = ("armar3", "wsg50")


@entry
def call_meet(field, hand, body, pose, window, enough, work):
    """Let Python call `meet`."""
    return tree_kernels.meet(field.tree, hand.hulls, body, pose, window, enough, work)


@entry
def call_collect(field, hand, body, pose, margin, work):
    """Let Python call `collect_faces`."""
    return tree_kernels.collect_faces(field.tree, hand.hulls, body, pose, margin, work)


@entry
def call_look_at(field, hand, body, pose, node, work):
    """Let Python call `look_at`."""
    sight_kernels.look_at(field.tree.blocks[node], hand.hulls, body, pose, work.sight)


@entry
def call_push_near(child, limit, work):
    """Let Python call `push_near` on a stack of one."""
    return sight_kernels.push_near(child, limit, work.sight, 1)


@entry
def call_clip(hand, body, margin, clip):
    """Let Python call `clip_to_body`."""
    return body_kernels.clip_to_body(hand.hulls, body, margin, clip)


@entry
def call_touches(hand, body, clip):
    """Let Python call `touches`."""
    return body_kernels.touches(hand.hulls, body, clip)


@entry
def call_self_clearance(hand, step, enough, work):
    """Let Python call `self_clearance`."""
    return self_kernels.self_clearance(hand, step, enough, work)


@entry
def call_close_fingers(field, hand, base, q, stops, work):
    """Let Python call `close_fingers`."""
    finger_kernels.close_fingers(field, hand, base, q, stops, work)


@pytest.fixture(scope="module", params=NAMES)
def setup(request):
    hand = load_hand(request.param)
    field = object_field(np.array(BLOB.triangles))
    arrays = closing_hand(hand)
    return hand, field, arrays, body_kernels.workspace(field, arrays)


def planes_of(arrays, body):
    return arrays.hulls.planes[arrays.hulls.plane_start[body] : arrays.hulls.plane_start[body + 1]]


def clipped(triangle, planes, margin=0.0):
    """Part of a triangle below all planes moved out by `margin`, plane after plane."""
    polygon = np.array(triangle)
    for plane in planes:
        heights = polygon @ plane[:3] - plane[3] - margin
        corners = []
        for here in range(len(polygon)):
            there = (here + 1) % len(polygon)
            if heights[here] <= 0.0:
                corners.append(polygon[here])
            if heights[here] * heights[there] < 0.0:
                share = heights[here] / (heights[here] - heights[there])
                corners.append(polygon[here] + share * (polygon[there] - polygon[here]))
        if not corners:
            return np.zeros((0, 3))
        polygon = np.array(corners)
    return polygon


def area(polygon):
    spokes = polygon[1:] - polygon[0] if len(polygon) else np.zeros((0, 3))
    return 0.5 * np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))


def poses_near(rng, count):
    for _ in range(count):
        pose = np.eye(4)
        pose[:3, :3] = random_rotation(rng)
        pose[:3, 3] = rng.uniform(-0.09, 0.09, 3)
        yield pose


def test_clipping_leaves_what_plane_after_plane_leaves(setup):
    _, _, arrays, work = setup
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(300):
        body = int(rng.integers(len(arrays.body_link)))
        planes = planes_of(arrays, body)
        middle = arrays.ball_center[body] + rng.normal(size=3) * 0.5 * arrays.ball_radius[body]
        triangle = middle + rng.normal(size=(3, 3)) * rng.choice([0.002, 0.01, 0.05])
        for margin in (0.0, 0.0005):
            work.clip.local[:] = triangle
            count = call_clip(arrays, body, margin, work.clip)
            wanted = clipped(triangle, planes, margin)
            assert (count > 0) == (len(wanted) > 0)
            assert area(work.clip.polygon[:count]) == pytest.approx(area(wanted), abs=1e-12)
        work.clip.local[:] = triangle
        assert call_touches(arrays, body, work.clip) == (len(clipped(triangle, planes)) > 0)
        hits += len(clipped(triangle, planes)) > 0
    assert 50 < hits < 250


def test_a_walk_down_the_tree_finds_a_hit_whenever_there_is_one(setup):
    _, field, arrays, work = setup
    rng = np.random.default_rng(2)
    met = 0
    for pose in poses_near(rng, 60):
        body = int(rng.integers(len(arrays.body_link)))
        planes = planes_of(arrays, body)
        local = (field.triangles - pose[:3, 3]) @ pose[:3, :3]
        apart = ((local @ planes[:, :3].T - planes[:, 3]) > 0.0).all(axis=1).any(axis=1)
        hits = [face for face in np.flatnonzero(~apart) if len(clipped(local[face], planes))]
        gap = call_meet(field, arrays, body, pose, 0.004, 0.08, work)
        assert (work.hit[0] >= 0) == bool(hits)
        if hits:
            met += 1
            assert gap <= 0.0
            assert field.tree.faces[work.hit[0]] in hits
    assert 10 < met < 50


def test_a_gap_is_never_overstated_and_not_by_far_understated(setup):
    hand, field, arrays, work = setup
    rng = np.random.default_rng(4)
    vertices, faces = np.array(BLOB.vertices), np.array(BLOB.faces, dtype=np.int64)
    shares = []
    for pose in poses_near(rng, 60):
        body = int(rng.integers(len(arrays.body_link)))
        gap = call_meet(field, arrays, body, pose, 0.001, 0.08, work)
        mesh = trimesh.Trimesh(hand.bodies[body].vertices, hand.bodies[body].faces)
        points = trimesh.sample.sample_surface(mesh, 3000, seed=0)[0]
        points = points @ pose[:3, :3].T + pose[:3, 3]
        true = np.sqrt(igl.point_mesh_squared_distance(points, vertices, faces)[0].min())
        if work.hit[0] < 0:
            assert gap <= true + 1e-9
            if 0.004 < true < 0.05:
                shares.append(gap / true)
    assert len(shares) > 10
    assert np.median(shares) > 0.5


def test_a_block_is_seen_where_it_stands_and_no_nearer_than_it_is(setup):
    _, field, arrays, work = setup
    rng = np.random.default_rng(11)
    hulls, sight = arrays.hulls, work.sight
    for pose in poses_near(rng, 40):
        body = int(rng.integers(len(arrays.body_link)))
        node = int(rng.integers(1, len(field.tree.blocks)))
        balls = field.tree.blocks[node].reshape(4, FAN).T.astype(float)
        call_look_at(field, arrays, body, pose, node, work)
        middle = (balls[:, :3] - pose[:3, 3]) @ pose[:3, :3]
        np.testing.assert_allclose(sight.middle.reshape(3, FAN).T, middle, atol=1e-12)
        cell = np.floor((middle - hulls.origin[body]) / CELL).astype(int)
        i, j, k = np.clip(cell, 0, hulls.cells[body] - 1).T
        row = (i * hulls.cells[body, 1] + j) * hulls.cells[body, 2] + k
        hint = hulls.hints[hulls.cell_start[body] + row].astype(int)
        assert (sight.plane == hint).all()
        plane = hulls.planes[np.maximum(hint, -1 - hint)]
        gap = (middle * plane[:, :3]).sum(axis=1) - plane[:, 3] - balls[:, 3]
        np.testing.assert_allclose(sight.gap, gap, atol=1e-12)
        # the highest plane is a bound from below of the distance, so any plane is
        top = (middle @ planes_of(arrays, body)[:, :3].T - planes_of(arrays, body)[:, 3]).max(
            axis=1
        )
        assert (sight.gap <= top - balls[:, 3] + 1e-12).all()


def test_children_are_stacked_if_near_and_the_nearest_is_on_top(setup):
    _, _, _, work = setup
    rng = np.random.default_rng(12)
    for limit in (-1.0, 0.3, 2.0):
        for _ in range(20):
            work.sight.gap[:] = rng.uniform(0.0, 1.0, FAN)
            top = call_push_near(100, limit, work)
            stacked = work.sight.stack[1:top]
            assert sorted(stacked - 100) == np.flatnonzero(work.sight.gap < limit).tolist()
            np.testing.assert_array_equal(work.sight.bounds[1:top], work.sight.gap[stacked - 100])
            if top > 1:
                assert work.sight.bounds[top - 1] == work.sight.gap.min()


def test_collected_faces_hold_all_that_a_grown_body_meets(setup):
    _, field, arrays, work = setup
    rng = np.random.default_rng(5)
    for pose in poses_near(rng, 25):
        body = int(rng.integers(len(arrays.body_link)))
        planes = planes_of(arrays, body)
        local = (field.triangles - pose[:3, 3]) @ pose[:3, :3]
        apart = ((local @ planes[:, :3].T - planes[:, 3]) > 0.0005).all(axis=1).any(axis=1)
        wanted = {f for f in np.flatnonzero(~apart) if len(clipped(local[f], planes, 0.0005))}
        count = call_collect(field, arrays, body, pose, 0.0005, work)
        found = work.faces[:count].tolist()
        assert wanted <= set(found)
        assert len(set(found)) == count


def test_links_stand_where_the_tree_of_the_hand_puts_them(setup):
    hand, _, arrays, work = setup
    rng = np.random.default_rng(6)
    for base in poses_near(rng, 5):
        q = rng.uniform(arrays.limits[:, 0], arrays.limits[:, 1])
        place_links(arrays, q, base, work)
        np.testing.assert_allclose(work.poses, base @ hand.link_poses(q), atol=1e-12)


def test_gaps_within_the_hand_are_least_heights_of_samples_over_planes(setup):
    _, _, arrays, work = setup
    rng = np.random.default_rng(7)
    for _ in range(8):
        q = rng.uniform(arrays.limits[:, 0], arrays.limits[:, 1])
        place_links(arrays, q, np.eye(4), work)
        for step in range(len(arrays.joint)):
            got = call_self_clearance(arrays, step, 0.01, work)
            assert got == pytest.approx(least_gap(arrays, work.poses, step, 0.01), abs=1e-9)


def least_gap(arrays, poses, step, enough):
    """Least height of samples of moved bodies over planes of unmoved partners, and vice versa."""
    bodies = arrays.moved_body[arrays.moved_body_start[step] : arrays.moved_body_start[step + 1]]
    best = enough
    for a in bodies:
        for b in arrays.partner[arrays.partner_start[a] : arrays.partner_start[a + 1]]:
            if b in bodies:
                continue
            for one, other in ((a, b), (b, a)):
                samples = arrays.surface.samples[slice(*arrays.surface.start[one : one + 2])]
                into = np.linalg.inv(poses[arrays.body_link[other]])
                into = into @ poses[arrays.body_link[one]]
                points = samples @ into[:3, :3].T + into[:3, 3]
                planes = planes_of(arrays, other)
                best = min(best, (points @ planes[:, :3].T - planes[:, 3]).max(axis=1).min())
    return best


def meets(arrays, field, poses, bodies):
    """Whether one of the bodies shares a point with a triangle of the object."""
    for body in bodies:
        planes, pose = planes_of(arrays, body), poses[arrays.body_link[body]]
        local = (field.triangles - pose[:3, 3]) @ pose[:3, :3]
        apart = ((local @ planes[:, :3].T - planes[:, 3]) > 0.0).all(axis=1).any(axis=1)
        if any(len(clipped(local[face], planes)) for face in np.flatnonzero(~apart)):
            return True
    return False


def test_joint_by_joint_the_end_is_free_and_a_hair_further_is_not(setup):
    """The whole closing, tried out: free where a joint stopped, a hit just beyond."""
    hand, field, arrays, work = setup
    rng = np.random.default_rng(8)
    touched = 0
    for base in poses_near(rng, 6):
        approach = base[:3, :3] @ hand.palm_direction
        q, stops = arrays.preshape.copy(), np.zeros(len(arrays.joint), dtype=np.int64)
        way = retreat(field, arrays, q, base, approach, 1.0, work)
        everything = range(len(hand.bodies))
        assert not meets(arrays, field, base @ hand.link_poses(q), everything)
        if way > 1e-3:
            nearer = base.copy()
            nearer[:3, 3] += 1e-4 * approach
            assert meets(arrays, field, nearer @ hand.link_poses(q), everything)
        call_close_fingers(field, arrays, base, q, stops, work)
        now = arrays.preshape.copy()
        for step, (joint, sign) in enumerate(zip(arrays.joint, arrays.closing, strict=True)):
            moved = arrays.moved_body[slice(*arrays.moved_body_start[step : step + 2])]
            now[joint] = q[joint]
            assert stops[step] in (TOUCH, SELF, LIMIT)
            assert not meets(arrays, field, base @ hand.link_poses(now), moved)
            if stops[step] == TOUCH:
                touched += 1
                beyond = now.copy()
                beyond[joint] += sign * 2.0**-10 * 0.008 / arrays.lever.min() * 1.1
                assert meets(arrays, field, base @ hand.link_poses(beyond), moved)
    assert touched > 3
