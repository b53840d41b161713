"""Compiled loops of the medial axis against their plain numpy twins."""

import numpy as np
import pytest
from medial_twins import (
    SAMPLES,
    each,
    pair_bounds,
    plain_angle,
    plain_balls,
    plain_refine,
    plain_touches,
    slack_of,
)

from medkit.medial.axis import ENOUGH, MODEST, REACH, TOUCH, sample_tree
from medkit.medial.axis_kernels import refine_balls, shrink_balls
from medkit.medial.surface_kernels import bucket
from medkit.medial.touch_kernels import widest_touch


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
    n, leaves = len(sample), len(tree.leaves)
    radii, stop, known = np.full(n, largest), np.full(n, -1), np.full(4 * leaves, -1)

    def center(i):
        return tree.points[i] - radii[i] * tree.normals[i]

    def cell(i):
        return bucket(*np.floor(center(i) / (2.0 * slack)).astype(np.int64), len(known))

    for leaf in range(leaves):
        for i in range(tree.start[leaf], tree.start[leaf + 1]):
            tried = np.arange(tree.start[leaf], tree.start[leaf + 1])
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
