"""Every published view comes from one call, with labelled axes; wrong names are refused."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from medkit.datasets.handover_trials import human_references
from medkit.errors import InputError
from medkit.handover import claims, iso_score, load_trials, recommend_force, score
from medkit.viz.handover import plot_rating_shares, plot_score_map
from medkit.viz.handover_figures import FIGURES, thesis_figure
from medkit.viz.handover_results import (
    add_load_line,
    figure_iso_score,
    figure_recommendation,
    plot_calibration,
    plot_claims,
    plot_experiments,
    plot_human_release,
    plot_interval_width,
    plot_link,
    plot_people,
    plot_power,
)


@pytest.fixture(scope="module")
def trials():
    return load_trials()


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


def test_the_list_of_views_is_complete():
    assert list(FIGURES) == [f"4.{number}" for number in range(5, 30)]


@pytest.mark.parametrize("number", ["4.5", "4.11", "4.14", "4.17", "4.22", "4.24", "4.26", "4.29"])
def test_a_view_has_labelled_axes_with_units(trials, number):
    figure = thesis_figure(trials, number)
    axes = figure.axes
    assert any("[" in ax.get_xlabel() for ax in axes)
    assert any("[" in ax.get_ylabel() for ax in axes)


def test_stacked_shares_fill_the_bar(trials):
    ax = plot_rating_shares(trials)
    tops = np.array([patch.get_height() for patch in ax.patches]).reshape(3, -1).sum(axis=0)
    np.testing.assert_allclose(tops, 1.0)


def test_the_heat_map_shows_the_mean_scores(trials):
    part = trials[(trials["pose"] == "P2") & (trials["mode"] == "impedance")]
    shown = plot_score_map(part).images[0].get_array()
    assert shown.shape == (9, 4)
    assert float(shown.mean()) == pytest.approx(score(part).mean())


@pytest.mark.parametrize("kind", ["contour", "3d"])
def test_other_kinds_of_map_draw(trials, kind):
    assert plot_score_map(trials, kind=kind).get_ylabel() == "release force [N]"


def test_results_draw_with_one_panel_per_condition(trials):
    assert len(figure_iso_score(iso_score(trials), level=0.75).axes) == 4
    assert len(figure_recommendation(recommend_force(trials)).axes) == 4
    ax = plot_claims(claims(trials, draws=10, shuffles=19))
    assert len(ax.get_yticklabels()) == 7


def test_no_curve_leaves_its_panel(trials):
    curve, table = iso_score(trials), recommend_force(trials)
    for figure, highest in (
        (figure_iso_score(curve), curve["high"].max()),
        (figure_recommendation(table), table["upper_estimate"].max()),
    ):
        assert all(ax.get_ylim()[1] > highest for ax in figure.axes)
        assert all(ax.get_ylim()[0] == 0 for ax in figure.axes)


def test_checks_and_plans_draw_a_line_per_group():
    points = pd.DataFrame({"predicted": [0.1, 0.9], "observed": [0.2, 0.8], "error": 0.05})
    ax = plot_calibration(pd.concat([points.assign(event=name) for name in ("a", "b")]))
    assert len(ax.containers) == 2
    power = pd.DataFrame({"number": [1, 1, 2, 2], "subjects": [4, 8] * 2, "power": 0.5})
    assert len(plot_power(power).get_legend().get_texts()) == 2
    width = pd.DataFrame({"spread": ["x", "x"], "subjects": [4, 8], "half_width": [2.0, 1.0]})
    assert plot_interval_width(width).get_ylim()[1] > 2.0
    ax = plot_link(thresholds=(-1.0, 2.0))
    assert len(ax.get_legend().get_texts()) == 4
    assert [line.get_xdata()[0] for line in ax.lines[-2:]] == [-1.0, 2.0]  # the two borders
    ax = plot_human_release(human_references())
    assert len(ax.patches) == 5  # the sixth has no upper bound: an arrow
    assert len(add_load_line(ax, np.array([0.1, 1.0])).lines) == 2


def test_intervals_that_cover_zero_look_different():
    people = pd.Series({"a": -1.0, "b": 2.0, "c": 3.0})
    ax = plot_people(people, ["b", "b", "c"], (2.3, 0.9, 3.8))
    assert ax.get_title() == "clear of zero"
    assert [text.get_text() for text in ax.texts] == ["a x 0", "b x 2", "c x 1"]
    assert plot_people(people, ["a", "b"], (0.5, -9.0, 10.0)).get_title() == "covers zero"
    ax = plot_experiments([[1.0, 0.5, 1.5], [1.0, -0.5, 2.5]], truth=1.2)
    styles = [line.get_linestyle() for line in ax.lines if len(line.get_xdata()) == 2]
    assert styles[:2] == ["-", "--"]


def test_contour_labels_stand_between_the_columns_of_data(trials):
    part = trials[(trials["pose"] == "P1") & (trials["mode"] == "position")]
    texts = plot_score_map(part, kind="contour").texts
    assert [text.get_text() for text in texts] == ["0.25", "0.50", "0.75"]
    assert all(abs(text.get_position()[0] - 0.35) < 0.04 for text in texts)


def test_unknown_names_are_refused(trials):
    with pytest.raises(InputError, match=r"4\.5 to 4\.29"):
        thesis_figure(trials, "4.30")
    with pytest.raises(InputError, match="heat, contour or 3d"):
        plot_score_map(trials, kind="pie")
