"""The compiled kernel against its plain numpy twin, and the pictures of both."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.quality import epsilon, expansion_steps
from medkit.quality.reach import support
from medkit.viz.quality import (
    plot_epsilon_over_friction,
    plot_expansion_step,
    plot_friction_cones_2d,
    plot_wrench_polytope,
    plot_wrench_projection,
)
from medkit.wrench_cones import cone_profile, wrench_cones

FEW = settings(max_examples=20, derandomize=True, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)


def tilted(rng, n, dimension):
    points = rng.normal(size=(n, dimension))
    normals = -points + 0.3 * rng.normal(size=(n, dimension))
    return Contacts(points, normals / np.linalg.norm(normals, axis=1)[:, None], 0.6)


@FEW
@given(SEEDS, st.integers(3, 7), st.sampled_from([2, 3]))
def test_both_twins_end_at_the_same_facet(seed, n, dimension):
    contacts = tilted(np.random.default_rng(seed), n, dimension)
    here = {"torque_origin": np.zeros(dimension), "torque_scale": 1.0}
    compiled = epsilon(contacts.points, contacts.normals, friction=0.6, **here)
    steps = expansion_steps(contacts.wrenches(**here))
    bounds = np.array([[step.lower, step.upper] for step in steps])
    inside = np.maximum(bounds[:, 0], 0.0)  # once the origin is inside, the bound only grows
    assert np.all(np.diff(inside) >= -1e-9)
    if compiled.force_closure:
        np.testing.assert_allclose(bounds[-1], compiled.lower, atol=1e-9)
        assert bounds[:, 1].min() >= compiled.lower - 1e-9
    else:
        assert bounds[-1, 1] <= 1e-9


@FEW
@given(SEEDS, st.sampled_from(["point", "soft", "frictionless"]), st.booleans())
def test_the_compiled_support_is_the_best_primitive_wrench(seed, contact, total):
    rng = np.random.default_rng(seed)
    contacts, u = tilted(rng, 5, 3), rng.normal(size=6)
    here = {"torque_origin": np.zeros(3), "torque_scale": 0.7, "contact": contact}
    cones, found = wrench_cones(contacts, **here), np.empty((1, 6))
    profile = cone_profile(3, contact, 8)
    height = support(
        cones.centers, cones.axes, profile, total, u, np.empty(cones.axes.shape[1]), found, 0
    )
    wrenches = contacts.wrenches(**here)
    along = wrenches @ u
    if total:
        best = wrenches[np.arange(5), along.argmax(axis=1)][along.max(axis=1) > 0.0].sum(axis=0)
    else:
        best = wrenches.reshape(-1, 6)[along.argmax()]
    np.testing.assert_allclose(found[0] @ u, best @ u, atol=1e-12)
    assert height == pytest.approx(best @ u, abs=1e-12)


def test_flat_and_missing_wrenches_give_no_steps():
    assert expansion_steps(np.zeros((0, 3))) == []
    assert expansion_steps([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, -1.0, 0.0]]) == []


def test_the_pictures_carry_labels_and_the_ball():
    pinch = Contacts([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]], 1.0)
    wrenches = pinch.wrenches(torque_origin=[0.0, 0.0], torque_scale=1.0)
    step = expansion_steps(wrenches)[-1]
    axes = [
        plot_friction_cones_2d(pinch, outline=[[-1, -1], [1, -1], [1, 1], [-1, 1]]),
        plot_wrench_polytope(wrenches, epsilon=step.lower, direction=step.direction),
        plot_expansion_step(step, wrenches=wrenches),
        plot_wrench_projection(np.random.default_rng(0).normal(size=(9, 6)), 0, 3, epsilon=0.1),
    ]
    assert all("[" in ax.get_xlabel() and "[" in ax.get_ylabel() for ax in axes)
    assert len(axes[1].collections) >= 3  # facets, the nearest facet, the ball
    plt.close("all")
    with pytest.raises(InputError, match="planar"):
        plot_friction_cones_2d(tilted(np.random.default_rng(0), 3, 3))
    with pytest.raises(InputError, match="6 columns"):
        plot_wrench_projection(wrenches, 0, 1)


def test_the_curve_over_friction_is_epsilon_and_the_pyramid_lies_below():
    contacts, here = tilted(np.random.default_rng(2), 5, 3), {"torque_origin": np.zeros(3)}
    grasp, values = (contacts.points, contacts.normals), [0.2, 0.6, 1.0]
    ax = plot_epsilon_over_friction(
        *grasp, values=values, **here, torque_scale=1.0, edges=(4, None)
    )
    rough, smooth = (line.get_ydata() for line in ax.get_lines())
    assert np.all(rough <= smooth + 1e-3)
    expected = [epsilon(*grasp, friction=mu, **here, torque_scale=1.0, edges=4).lower
                for mu in values]  # fmt: skip
    np.testing.assert_array_equal(rough, expected)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["4 edges", "round cones"]
    assert "[N]" in ax.get_ylabel()
    plt.close("all")
