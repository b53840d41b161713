"""Iso-score curves: what a known model gives back, monotony, scaling, proportionality."""

import itertools

import numpy as np
import pandas as pd
import pytest

from medkit.errors import InputError
from medkit.handover import iso_score, iso_slope, link_comparison, load_trials, recommend_force
from medkit.handover.ordinal import eta_at_score, rating_probabilities

THRESHOLDS = np.array([-9.0, -6.0])


def table_of(shift, weight_effect, repetitions=4000):
    """Expected counts of subjects whose iso-score curve is known in closed form."""
    rows = []
    for (subject, moved), force, grams in itertools.product(
        enumerate(shift), [0.5, 1, 2, 5, 7, 10, 15, 20], [100, 300, 600, 1000]
    ):
        eta = moved - 3.0 * np.sqrt(force) + weight_effect * grams / 1000
        bad, acceptable, good = np.rint(repetitions * rating_probabilities(eta, THRESHOLDS))
        rows.append(("P1", "position", force, grams, f"S{subject}", good, acceptable, bad))
    columns = ["pose", "mode", "force_N", "weight_g", "subject", "good", "acceptable", "bad"]
    return pd.DataFrame(rows, columns=columns)


def test_a_known_curve_comes_back():
    curve = iso_score(table_of([0.0, 0.0, 0.0], 2.0), 0.75)
    root = (2.0 * curve["weight"] - eta_at_score(0.75, THRESHOLDS)) / 3.0
    np.testing.assert_allclose(curve["force"], root**2, rtol=2e-3)
    np.testing.assert_allclose(curve["low"], curve["high"], rtol=1e-6)


def test_subjects_who_differ_widen_the_interval_around_the_mean_root():
    curve = iso_score(table_of([-0.5, 0.0, 0.5], 2.0), 0.75)
    root = (2.0 * curve["weight"] - eta_at_score(0.75, THRESHOLDS)) / 3.0
    np.testing.assert_allclose(curve["force"], root**2, rtol=3e-3)
    reach = 4.302653 * (0.5 / 3.0) / np.sqrt(3)  # t quantile with two degrees of freedom
    np.testing.assert_allclose(np.sqrt(curve["high"]), root + reach, rtol=1e-2)


def test_a_stricter_level_asks_for_less_force_everywhere():
    trials = load_trials()
    curves = [iso_score(trials, level)["force"] for level in (0.9, 0.75, 0.5, 0.25)]
    for strict, lax in itertools.pairwise(curves):
        assert (strict < lax).all()


def test_force_grows_with_weight_in_the_thesis():
    for _, part in iso_score(load_trials()).groupby(["pose", "mode"]):
        assert part["force"].is_monotonic_increasing
        assert ((part["low"] <= part["force"]) & (part["force"] <= part["high"])).all()


def test_both_scopes_share_the_estimate_and_people_vary_more():
    trials = load_trials()
    people, these = iso_slope(trials), iso_slope(trials, scope="these", draws=60)
    np.testing.assert_allclose(people["slope"], these["slope"])
    pooled = people["pose"] == "all"
    assert (people["low"] < these["low"])[pooled].all()
    assert (people["high"] > these["high"])[pooled].all()


def test_proportionality_is_told_from_its_absence():
    proportional = table_of([0.0, 0.3, -0.3], 0.0)
    scaled = []
    for grams, part in proportional.groupby("weight_g"):
        # with every force scaled by the load, the curve is proportional to the load
        scaled.append(part.assign(force_N=part["force_N"] * grams / 300))
    rising = iso_slope(pd.concat(scaled, ignore_index=True)).iloc[0]
    level = iso_slope(proportional).iloc[0]
    assert level["exponent"] == pytest.approx(0, abs=0.01)
    assert level["proportional"] == "contradicted"
    assert rising["exponent"] > 0.5


@pytest.mark.parametrize("irregular", ["keep", "best", "worst"])
def test_the_nine_cells_move_the_slope_by_less_than_its_error(irregular):
    ours = iso_slope(load_trials(), scope="these", draws=60).set_index(["pose", "mode"])
    other = iso_slope(load_trials(irregular=irregular)).set_index(["pose", "mode"])
    moved = (other["slope"] - ours["slope"]).abs()
    assert (moved < (ours["high"] - ours["low"]) / 4).all()
    assert (other["proportional"] == "contradicted").all()


def test_recommendation_lies_above_the_safety_limit_and_says_when_it_is_unnatural():
    table = recommend_force(load_trials(), weight_error_kg=0.05, bump_N=0.2)
    assert table["lower"].unique() == pytest.approx(0.05 * 9.81 + 0.2)
    assert (table["force"] >= table["lower"]).all()
    opened = table["window"] == "open"
    assert (table.loc[opened, "force"] == table.loc[opened, "upper"]).all()
    hard = recommend_force(load_trials(), bump_N=30)
    assert (hard["window"] == "closed").all()


def test_a_surer_weight_never_closes_a_window():
    order = {"closed": 0, "narrow": 1, "open": 2}
    windows = [
        recommend_force(load_trials(), weight_error_kg=error)["window"].map(order)
        for error in (0.2, 0.1, 0.02)
    ]
    for unsure, sure in itertools.pairwise(windows):
        assert (unsure <= sure).all()


def test_the_root_of_the_force_fits_best():
    assert link_comparison(load_trials())["difference"].idxmin() == "root of force"


def test_who_met_one_weight_has_no_curve_and_the_others_keep_theirs():
    trials = load_trials()
    lacking = (trials["subject"] == "T1") & (trials["weight_g"] != 300)
    fewer, three = iso_score(trials[~lacking]), iso_score(trials[trials["subject"] != "T1"])
    assert (fewer["subjects"] == 3).all()
    np.testing.assert_allclose(fewer["force"], three["force"], rtol=1e-6)


def test_bad_levels_allowances_and_single_forces_are_refused():
    trials = load_trials()
    with pytest.raises(InputError, match="between 0 and 1"):
        iso_score(trials, 1.2)
    with pytest.raises(InputError, match="zero or more"):
        recommend_force(trials, bump_N=-1)
    with pytest.raises(InputError, match="at least two release forces"):
        iso_score(trials[trials["force_N"] == 5])
