"""Compiled loops of the medial axis against their plain numpy twins."""

import numpy as np
import pytest
import trimesh

from medkit.grasping import sample_surface
from medkit.medial.axis import ENOUGH, MODEST, REACH, SLACK, TOUCH, sample_tree
from medkit.medial.axis_kernels import THIN, refine_balls, shrink_balls
from medkit.medial.size import in_own_frame
from medkit.medial.surface_kernels import bucket
from medkit.medial.touch_kernels import SLANTED, STEPS, widest_touch
from medkit.medial.tree_kernels import (
    BEND,
    BOTTOM,
    SIZE,
    SPREAD,
    TOP,
    WIDTH,
    ball_misses,
)

create = trimesh.creation


def step():
    """A block with a step: convex and reentrant edges."""
    low, high = create.box((0.1, 0.06, 0.03)), create.box((0.05, 0.06, 0.06))
    high.apply_translation([0.025, 0.0, 0.015])
    return trimesh.boolean.union([low, high], engine="manifold")


def bumpy():
    ball = create.icosphere(4, 0.05)
    x, y, z = 120.0 * ball.vertices.T
    height = 1.0 + 0.1 * np.sin(x) * np.sin(y + 1.0) * np.sin(z + 2.0)
    return trimesh.Trimesh(ball.vertices * height[:, None], ball.faces)


SAMPLES = {
    "box": sample_surface(create.box((0.2, 0.1, 0.05)), spacing=0.008),
    "ball": sample_surface(create.icosphere(4, 0.05), spacing=0.006),
    "torus": sample_surface(create.torus(0.08, 0.03), spacing=0.007),
    "step": sample_surface(step(), spacing=0.005),
    "bumpy": sample_surface(bumpy(), spacing=0.005),
    "leaf": sample_surface(create.box((0.1, 0.1, 0.004)), spacing=0.006),
}
each = pytest.mark.parametrize("name", SAMPLES)


def slack_of(sample):
    return max(SLACK * sample.spacing, sample.facet_depth)


def pair_bounds(points, normals, slack):
    """Radius (n, n) of the ball tangent at the row's sample that the column's allows."""
    away = points[:, None] - points[None]
    d2 = np.sum(away**2, axis=2)
    h = np.einsum("ijk,ik->ij", away, normals)
    allowed = np.where(normals @ normals.T > 0.0, slack, np.minimum(slack, THIN * h))
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = (d2 - allowed**2) / (2.0 * (h - allowed))
    return np.where((h > allowed) & (d2 > 0.0), bound, np.inf)


def plain_refine(points, normals, radii, stop, reach):
    refined = np.full(len(points), np.inf)
    two_point = pair_bounds(points, normals, 0.0)
    for i in np.flatnonzero(stop >= 0):
        j = stop[i]
        along = normals[j] @ (points[j] - points[i])
        dot = normals[i] @ normals[j]
        refined[i] = min(radii[i], two_point[i, j])
        if dot >= 0.9:
            continue
        if abs(along) <= 1e-9 * reach:
            refined[i] = 0.0
            continue
        r = along / (1.0 - dot)
        foot = points[i] - r * normals[i] + r * normals[j]
        if 0.0 < r < refined[i] and np.sum((foot - points[j]) ** 2) <= reach**2:
            refined[i] = r
    return refined


def plain_balls(sample, tree):
    """Refined spheres of a sample: centres, radii, own and stopping sample."""
    bound = pair_bounds(tree.points, tree.normals, slack_of(sample))
    stop = np.argmin(bound, axis=1)
    radii = bound[np.arange(len(stop)), stop]
    stop[radii > 0.5 * sample.diagonal] = -1
    radii = plain_refine(tree.points, tree.normals, radii, stop, REACH * sample.spacing)
    own = np.flatnonzero((stop >= 0) & (radii > 0.0))
    centers = tree.points[own] - radii[own, None] * tree.normals[own]
    return centers, radii[own], own, stop[own]


def foot_directions(center, tree, reach):
    """For all samples: whether the foot on its plane counts, distance and unit direction."""
    away = tree.points - center
    d2 = np.sum(away**2, axis=1)
    h = np.einsum("nk,nk->n", away, tree.normals)
    foot = (h > 0.0) & (d2 - h**2 <= reach**2)
    direct = away / np.maximum(np.sqrt(d2), 1e-300)[:, None]
    return foot, np.where(foot, h, np.sqrt(d2)), np.where(foot[:, None], tree.normals, direct)


def plain_touches(center, radius, own, stop, tree, tolerances, reach):
    """Directions to all touches of one sphere; the first two are those it always has."""
    wide = foot_directions(center, tree, max(reach, 0.3 * radius))[2][stop]
    seeds = np.array([tree.normals[own], wide])
    foot, distance, direction = foot_directions(center, tree, reach)
    chord = np.sqrt(np.maximum(0.0, 2.0 - 2.0 * (direction @ seeds.T).max(axis=1)))
    slanted = np.einsum("nk,nk->n", direction, tree.normals) < SLANTED
    near = np.where(
        foot,
        distance <= radius + tolerances[0] * chord,
        slanted & (distance <= radius + tolerances[1]),
    )
    return np.vstack([seeds, direction[near & (distance >= radius - 2.0 * tolerances[1])]])


def plain_angle(touches):
    """Widest from the first direction, widest from that, and so on; from `MODEST` on [rad]."""
    cosine = touches @ touches[0]
    if cosine.min() >= np.cos(MODEST):
        return float(np.arccos(cosine[1]))
    best, partner = cosine.min(), touches[np.argmin(cosine)]
    for _ in range(STEPS - 1):
        cosine = touches @ partner
        if cosine.min() >= best:
            break
        best, partner = cosine.min(), touches[np.argmin(cosine)]
    return float(np.arccos(np.clip(best, -1.0, 1.0)))


@each
def test_the_tree_is_balanced_and_its_bounds_hold(name):
    sample = SAMPLES[name]
    order, tree = sample_tree(sample)
    assert sorted(order) == list(range(len(sample)))
    assert np.array_equal(tree.points, sample.points[order])
    leaves = len(tree.first) // 2
    own = in_own_frame(sample.points)[order]
    for node in range(1, 2 * leaves):
        members = slice(tree.first[node], tree.last[node])
        points, normals, row = tree.points[members], tree.normals[members], tree.nodes[node]
        assert np.array_equal(row[:6], np.concatenate([points.min(axis=0), points.max(axis=0)]))
        assert row[SIZE] == pytest.approx(0.5 * np.linalg.norm(row[3:6] - row[:3]))
        frame = row[6:15].reshape(3, 3)
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-9)
        height, s, t = frame @ (points - 0.5 * (row[:3] + row[3:6])).T
        assert np.all(np.abs([s, t]) <= row[WIDTH : WIDTH + 2, None] + 1e-12)
        bowl = row[BOTTOM] - 0.5 * (row[BEND] * s**2 + row[BEND + 1] * t**2)
        assert np.all((height <= row[TOP] + 1e-12) & (height >= bowl - 1e-12))
        assert np.linalg.norm(normals - frame[0], axis=1).max() <= row[SPREAD] + 1e-12
        if node < leaves:
            axis = np.argmax(np.ptp(own[members], axis=0))
            left, right = (own[tree.first[k] : tree.last[k]] for k in (2 * node, 2 * node + 1))
            assert left[:, axis].max() <= right[:, axis].min()
            assert tree.last[2 * node] - tree.first[2 * node] == (len(points)) // 2


@each
def test_no_ball_is_said_to_miss_a_node_that_it_reaches(name):
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    rng = np.random.default_rng(5)
    right = missed = 0
    for _ in range(300):
        node = rng.integers(1, len(tree.first))
        i = rng.integers(len(sample))
        radius = rng.uniform(0.0, 0.3) * sample.diagonal
        center = tree.points[i] - rng.uniform(0.8, 1.5) * radius * tree.normals[i]
        members = tree.points[tree.first[node] : tree.last[node]]
        empty = np.linalg.norm(members - center, axis=1).min() >= radius * (1.0 - 1e-12)
        said = ball_misses(tree.nodes, node, *center, radius)
        assert empty or not said
        missed, right = missed + said, right + empty
    # the bound is not only safe, it is also good for something
    assert missed > 0.3 * right


@each
def test_the_tree_finds_what_brute_force_finds(name):
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    slack = slack_of(sample)
    radii, stop = shrink_balls(tree, 0.5 * sample.diagonal, slack, 0.0)
    bound = pair_bounds(tree.points, tree.normals, slack)
    assert radii == pytest.approx(np.minimum(bound.min(axis=1), 0.5 * sample.diagonal), rel=1e-12)
    found = np.flatnonzero(stop >= 0)
    assert bound[found, stop[found]] == pytest.approx(radii[found], rel=1e-12)


@each
def test_balls_taken_over_are_those_of_the_plain_loop(name):
    """The same rule without a tree: balls in a known one are trusted, others see all samples."""
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    slack, largest = slack_of(sample), 0.5 * sample.diagonal
    bound = pair_bounds(tree.points, tree.normals, slack)
    bound[bound >= largest] = np.inf
    n, leaves = len(sample), len(tree.first) // 2
    radii, stop, known = np.full(n, largest), np.full(n, -1), np.full(4 * leaves, -1)

    def center(i):
        return tree.points[i] - radii[i] * tree.normals[i]

    def cell(i):
        return bucket(*np.floor(center(i) / (2.0 * slack)).astype(np.int64), len(known))

    for leaf in range(leaves, 2 * leaves):
        for i in range(tree.first[leaf], tree.last[leaf]):
            tried = np.arange(tree.first[leaf], tree.last[leaf])
            back = stop[max(0, i - 4) : i]
            tried = np.concatenate([tried, back[(back >= 0) & (back != i)]])
            best = tried[np.argmin(bound[i, tried])]
            if np.isfinite(bound[i, best]):
                radii[i], stop[i] = bound[i, best], best
                k = known[cell(i)]
                room = radii[k] - radii[i] + slack
                if k >= 0 and room >= 0.0 and np.linalg.norm(center(i) - center(k)) <= room:
                    continue
            best = np.argmin(bound[i])
            if np.isfinite(bound[i, best]):
                radii[i], stop[i] = bound[i, best], best
            known[cell(i)] = i
    compiled = shrink_balls(tree, largest, slack, slack)[0]
    assert compiled == pytest.approx(radii, rel=1e-12)


@each
def test_refinement_equals_its_plain_twin(name):
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    slack, reach = slack_of(sample), REACH * sample.spacing
    radii, stop = shrink_balls(tree, 0.5 * sample.diagonal, slack, slack)
    plain = plain_refine(tree.points, tree.normals, radii, stop, reach)
    assert refine_balls(tree, radii, stop, reach) == pytest.approx(plain, rel=1e-12)


@each
def test_the_widest_touch_equals_its_plain_twin(name):
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    balls = plain_balls(sample, tree)
    tolerances = np.array([TOUCH * sample.spacing, slack_of(sample)])
    reach = REACH * sample.spacing
    angles, pairs = widest_touch(*balls, tree, tolerances, reach, ENOUGH, MODEST)
    arms = (pairs - balls[0][:, None]) / balls[1][:, None, None]
    span = np.einsum("nk,nk->n", arms[:, 0], arms[:, 1])
    assert np.cos(angles) == pytest.approx(span, abs=1e-9)
    for k in range(0, len(angles), 3):
        touches = plain_touches(*(part[k] for part in balls), tree, tolerances, reach)
        if angles[k] > ENOUGH:
            assert np.arccos((touches @ touches.T).min().clip(-1.0, 1.0)) >= angles[k] - 1e-6
        else:
            assert np.cos(angles[k]) == pytest.approx(np.cos(plain_angle(touches)), abs=1e-12)


@each
def test_no_two_touches_are_much_wider_than_the_object_angle(name):
    """The farthest-point search nearly always find the widest of all pairs."""
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    balls = plain_balls(sample, tree)
    tolerances = np.array([TOUCH * sample.spacing, slack_of(sample)])
    reach = REACH * sample.spacing
    angles = widest_touch(*balls, tree, tolerances, reach, ENOUGH, MODEST)[0]
    wider = []
    for k in range(len(angles)):
        touches = plain_touches(*(part[k] for part in balls), tree, tolerances, reach)
        widest = np.arccos((touches @ touches.T).min().clip(-1.0, 1.0))
        assert widest <= max(2.0 * angles[k], 2.0 * MODEST) + 1e-9
        # only angles that a grasp could ask for are searched to the end
        if widest >= 2.0 * MODEST:
            wider.append(0.0 if angles[k] > ENOUGH else widest - angles[k])
    missed = np.count_nonzero(np.array(wider) > np.radians(1.0))
    assert missed <= 1 + 0.1 * len(wider)  # the bumpy ball has but two such spheres
