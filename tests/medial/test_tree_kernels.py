"""The tree of samples: its bounds hold, and no search leaves out what it should find."""

import numpy as np
import pytest
from medial_twins import (
    SAMPLES,
    each,
    foot_directions,
    pair_bounds,
    plain_balls,
    sample_touches,
    slack_of,
)
from numba import njit

from medkit.medial.axis import REACH, TOUCH, sample_tree
from medkit.medial.axis_kernels import entered_samples, reached_children
from medkit.medial.size import in_own_frame
from medkit.medial.touch_kernels import NONE, touched_children, touching_samples
from medkit.medial.tree_kernels import (
    BEND,
    BOTTOM,
    COLUMNS,
    FAN,
    LEAF_SIZE,
    LOW,
    SIZE,
    SPREAD,
    STACK,
    TOP,
    TURN,
    WIDTH,
    push_near,
    push_turned,
)


def block_of(tree, node):
    return tree.blocks[node].reshape(COLUMNS, FAN)


def first_child(tree, node):
    return 1 if node == 0 else 1 + tree.fan + FAN * (node - 1)


def children(tree, node):
    """Numbers of a node's children, and their samples as slices."""
    begin = first_child(tree, node)
    numbers = range(begin, begin + (tree.fan if node == 0 else FAN))
    return [(child, members(tree, child)) for child in numbers]


def members(tree, node):
    low = high = node
    while low < len(tree.blocks):
        low, high = first_child(tree, low), first_child(tree, high + 1) - 1
    return slice(tree.start[low - len(tree.blocks)], tree.start[high + 1 - len(tree.blocks)])


@each
def test_the_tree_is_balanced_and_its_bounds_hold(name):
    sample = SAMPLES[name]
    order, tree = sample_tree(sample)
    assert sorted(order) == list(range(len(sample)))
    assert np.array_equal(tree.points, sample.points[order])
    assert tree.start[[0, -1]].tolist() == [0, len(sample)]
    sizes = np.diff(tree.start)
    assert sizes.max() <= min(LEAF_SIZE, sizes.min() + 1)
    for node in range(len(tree.blocks)):
        block = block_of(tree, node)
        for k, (_, inside) in enumerate(children(tree, node)):
            points, normals, column = tree.points[inside], tree.normals[inside], block[:, k]
            low, high = points.min(axis=0), points.max(axis=0)
            assert np.array_equal(column[:3], 0.5 * (low + high))
            assert column[SIZE] == pytest.approx(0.5 * np.linalg.norm(high - low))
            frame = column[3:12].reshape(3, 3)
            assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-9)
            height, s, t = frame @ (points - column[:3]).T
            assert np.all(np.abs([s, t]) <= column[WIDTH : WIDTH + 2, None] + 1e-12)
            bowl = column[BOTTOM] - 0.5 * (column[BEND] * s**2 + column[BEND + 1] * t**2)
            assert np.all((height <= column[TOP] + 1e-12) & (height >= bowl - 1e-12))
            assert height.min() == pytest.approx(column[LOW], abs=1e-12)
            assert np.linalg.norm(normals - frame[0], axis=1).max() <= column[SPREAD] + 1e-12


@each
def test_halves_are_split_along_the_widest_axis_and_know_the_way(name):
    sample = SAMPLES[name]
    order, tree = sample_tree(sample)
    own = in_own_frame(sample.points)[order]
    for node in range(len(tree.blocks)):
        parts = [inside for _, inside in children(tree, node)]
        splits = FAN // len(parts)
        while len(parts) > 1:
            pairs = list(zip(parts[::2], parts[1::2], strict=True))
            parts = [slice(one.start, two.stop) for one, two in pairs]
            for k, (one, two) in enumerate(pairs):
                both = own[one.start : two.stop]
                axis = np.argmax(np.ptp(both, axis=0))
                assert own[one, axis].max() <= own[two, axis].min()
                assert one.stop - one.start == len(both) // 2
                ends = [
                    tree.points[part].min(axis=0) + tree.points[part].max(axis=0)
                    for part in (one, two)
                ]
                turn = block_of(tree, node)[TURN : TURN + 3, splits * len(parts) + k]
                assert turn == pytest.approx(ends[1] - ends[0], abs=1e-12)


@njit
def reached(block, count, ball, normal, slack):
    x, y, z, r = ball
    u, v, w = normal
    return reached_children(block, count, x, y, z, u, v, w, r, slack)


@njit
def entered(leaf, count, point, normal, r, slack):
    x, y, z = point
    u, v, w = normal
    return entered_samples(leaf, count, x, y, z, u, v, w, r, slack)


def bits(number):
    return {k for k in range(number.bit_length()) if number >> k & 1}


@each
def test_no_child_or_sample_is_left_out_that_a_ball_reaches(name):
    """The bits that prune the search, against all pairs; they may be too many, never too few."""
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    slack = slack_of(sample)
    rng = np.random.default_rng(5)
    bound = pair_bounds(tree.points, tree.normals, slack)
    passed = empty = 0
    for _ in range(300):
        i = rng.integers(len(sample))
        r = rng.uniform(0.7, 1.1) * min(bound[i].min(), 0.3 * sample.diagonal)
        deeper = bound[i] < r
        center, normal = tree.points[i] - r * tree.normals[i], tuple(tree.normals[i])
        node = rng.integers(len(tree.blocks))
        needed = {k for k, (_, s) in enumerate(children(tree, node)) if np.any(deeper[s])}
        found = bits(reached(tree.blocks[node], FAN, (*center, r), normal, slack))
        assert needed <= found <= set(range(len(children(tree, node))))
        empty += len(children(tree, node)) - len(needed)
        passed += len(children(tree, node)) - len(found)
        leaf = rng.integers(len(tree.leaves))
        begin, end = tree.start[leaf : leaf + 2]
        needed = set(np.flatnonzero(deeper[begin:end]))
        found = bits(entered(tree.leaves[leaf], LEAF_SIZE, tuple(tree.points[i]), normal, r, slack))
        assert found == needed
    # the bound is not only safe, it is also good for something
    assert passed > 0.5 * empty


@njit
def touched(block, count, ball, rows, best, second):
    return touched_children(block, count, ball, rows, best, second)


@njit
def touching(leaf, count, ball, rows, best, second):
    return touching_samples(leaf, count, ball, rows, best, second)


@each
def test_no_child_or_sample_is_left_out_that_a_wider_touch_may_be_in(name):
    sample = SAMPLES[name]
    _, tree = sample_tree(sample)
    centers, radii, own, stop = plain_balls(sample, tree)
    tolerances = np.array([TOUCH * sample.spacing, slack_of(sample)])
    reach = REACH * sample.spacing
    rng = np.random.default_rng(6)
    passed = empty = 0
    for _ in range(300):
        i = rng.integers(len(own))
        near, direction = sample_touches(
            centers[i], radii[i], own[i], stop[i], tree, tolerances, reach
        )
        wide = foot_directions(centers[i], tree, max(reach, 0.3 * radii[i]))[2][stop[i]]
        rows = np.array([tree.normals[own[i]], wide, rng.permutation(direction)[0]])
        best, second = rng.uniform(-0.9, 0.6), (NONE, rng.uniform(-0.9, 0.6))[rng.integers(2)]
        wanted = near & ((direction @ rows[2] < best) | (direction @ rows[1] < second))
        ball = (*centers[i], radii[i], *tolerances, reach)
        node = rng.integers(len(tree.blocks))
        needed = {k for k, (_, s) in enumerate(children(tree, node)) if np.any(wanted[s])}
        found, turned = touched(tree.blocks[node], FAN, ball, rows, best, second)
        assert needed <= bits(found) <= set(range(len(children(tree, node))))
        ways = block_of(tree, node)[TURN : TURN + 3].T @ rows[2]
        assert bits(turned) == set(np.flatnonzero(ways < 0.0))
        empty += len(children(tree, node)) - len(needed)
        passed += len(children(tree, node)) - len(bits(found))
        leaf = rng.integers(len(tree.leaves))
        begin, end = tree.start[leaf : leaf + 2]
        needed = set(np.flatnonzero(wanted[begin:end]))
        found = bits(touching(tree.leaves[leaf], LEAF_SIZE, ball, rows, best, second))
        assert needed <= found <= needed | set(np.flatnonzero(~wanted[begin:end]))
    assert passed > 0.5 * empty


@njit
def pushed(block, found, turned, center):
    stack, distance = np.zeros(STACK, np.int64), np.zeros(STACK)
    x, y, z = center
    near = push_near(block, found, 100, x, y, z, stack, distance, 2)
    turn_stack = np.zeros(STACK, np.int64)
    return near, stack, push_turned(found, turned, 100, turn_stack, 2), turn_stack


def test_the_nearest_child_and_the_half_that_lies_ahead_are_on_top():
    rng = np.random.default_rng(2)
    _, tree = sample_tree(SAMPLES["bumpy"])
    for _ in range(50):
        node, found, turned = rng.integers(len(tree.blocks)), *rng.integers(256, size=2)
        center = rng.uniform(-0.05, 0.05, size=3)
        middle = block_of(tree, node)[:3].T
        top, stack, turn_top, turn_stack = pushed(tree.blocks[node], found, turned, tuple(center))
        away = np.linalg.norm(middle - center, axis=1)
        near = sorted(bits(int(found)), key=lambda k: -away[k])
        assert (stack[2:top] - 100).tolist() == near

        def place(k, turned=int(turned)):
            """Rank of a child: first halves first, unless turned."""
            ways = (k >> 2, k >> 1 & 1, k & 1)
            splits = (1, 2 + (k >> 2), 4 + (k >> 1))
            return [way ^ (turned >> split & 1) for way, split in zip(ways, splits, strict=True)]

        ahead = sorted(bits(int(found)), key=place, reverse=True)
        assert (turn_stack[2:turn_top] - 100).tolist() == ahead
