"""Pictures of the planar room: what they must show, whatever they look like."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from medkit import planar
from medkit.viz.planar import (
    plot_grasp,
    plot_graspable_shares,
    plot_object_angle_bound,
    plot_region,
    plot_wrench_space,
)


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def test_a_grasp_says_whether_it_holds():
    bar = planar.rectangle(0.08, 0.04)
    ends, inward = [[-0.04, 0.0], [0.04, 0.0]], [[1.0, 0.0], [-1.0, 0.0]]
    assert plot_grasp(bar, ends, inward, friction=0.3).get_title() == "force closure"
    assert plot_grasp(bar, ends, inward, friction=0.0).get_title() == "no force closure"
    ball = plot_wrench_space(ends, inward, friction=0.3, outline=bar)
    assert ball.get_title().startswith("epsilon")
    assert not ball.computed_zorder


def test_the_bound_names_every_material_and_where_a_range_leaves_the_picture():
    ax = plot_object_angle_bound(friction=0.5)
    words = [text.get_text() for text in ax.texts]
    assert all(any(pair.name in word for word in words) for pair in planar.MATERIALS)
    assert "rubber on solids (up to 4)" in words
    assert "126.9 deg" in words


def test_a_region_draws_every_grasp_that_was_asked():
    pair = planar.force_closure_pairs(planar.l_shape(), friction=0.3)[0]
    places = np.random.default_rng(1).uniform(0.0, 0.03, (20, 2))
    held = np.arange(20) < 7
    good, bad, box = plot_region(pair, places, held).lines
    assert (len(good.get_xdata()), len(bad.get_xdata()), len(box.get_xdata())) == (7, 13, 5)


def test_shares_stand_in_one_panel_per_shape():
    shares = {("a", "x"): (0.1, 0.5), ("a", "y"): (0.0, 0.0), ("b", "x"): (1.0, 1.0),
              ("b", "y"): (0.2, 0.3)}  # fmt: skip
    figure = plot_graspable_shares(shares)
    assert [ax.get_title() for ax in figure.axes] == ["a", "b"]
    assert [bar.get_width() for bar in figure.axes[0].patches] == [50.0, 0.0, 10.0, 0.0]
