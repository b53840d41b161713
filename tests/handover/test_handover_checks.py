"""Model checks and power: what holds by construction, and what these ratings show."""

import numpy as np
import pandas as pd
import pytest

from medkit.handover import claims, load_trials, subject_estimates
from medkit.handover.cells import rating_cells
from medkit.handover.checks import (
    calibration,
    leave_one_subject_out,
    method_agreement,
    predicted_probabilities,
    predictive_check,
    proportional_odds_check,
    readings,
)
from medkit.handover.power import (
    claim_power,
    normal_population,
    simulate_population,
    slope_estimates,
    slope_power,
    subjects_needed,
)


@pytest.fixture(scope="module")
def trials():
    return load_trials()


@pytest.fixture(scope="module")
def simulated(trials):
    return simulate_population(trials, subjects=40, rng=np.random.default_rng(1))


def test_a_simulated_table_passes_the_checks_the_real_one_fails(trials, simulated):
    """Ratings drawn one by one from the model are unanimous as often as the model says."""
    rng = np.random.default_rng(2)
    few = simulated[simulated["subject"] < "S006"]
    fine = predictive_check(few, draws=100, rng=rng).loc["unanimous cells"]
    assert fine["low"] <= fine["observed"] <= fine["high"]
    real = predictive_check(trials, draws=100, rng=rng).loc["unanimous cells"]
    assert real["observed"] > real["high"] + 0.1


def test_predictions_match_the_totals_they_were_fitted_to(trials):
    table = predictive_check(trials, draws=100, rng=np.random.default_rng(3))
    for statistic in ("share good", "share bad"):
        row = table.loc[statistic]
        assert row["low"] <= row["observed"] <= row["high"]


def test_calibration_is_near_the_diagonal_and_worse_for_strangers(trials):
    def error(**options):
        table = calibration(trials, **options)
        return float(((table["predicted"] - table["observed"]) ** 2).mean())

    own = calibration(trials)
    assert (own["predicted"] - own["observed"]).abs().max() < 0.1
    assert own.groupby("event")["cells"].sum().tolist() == [len(trials)] * 2
    cells = rating_cells(trials)

    def loss(chances):
        return -(cells.counts * np.log(chances)).sum()

    known = loss(predicted_probabilities(cells))
    assert known < loss(predicted_probabilities(cells, leave_subject_out=True))
    assert error(leave_subject_out=True) < 0.01


def test_proportional_odds_hold_where_they_were_put_in(simulated):
    table = proportional_odds_check(simulated)
    assert (table["difference"].abs() < 0.25 * table["good"].abs() + 0.1).all()
    assert table["low"]["weight"] < 0 < table["high"]["weight"]


def test_leaving_one_out_averages_to_the_whole(trials):
    left = leave_one_subject_out(trials)
    whole = subject_estimates(trials).mean(axis=1)
    for number in (1, 2, 3, 4, 6, 7):
        assert left.loc[number].mean() == pytest.approx(whole[number], abs=1e-6)
    assert np.isnan(left.loc[5, "without T4"])
    assert (left.loc[[1, 2, 3, 4, 6, 7, "slope"]] > 0).all(axis=None)


def test_careless_intervals_are_shorter_than_careful_ones(trials):
    table = method_agreement(trials)
    width = (table["high"] - table["low"]).groupby([table["number"], table["method"]]).sum()
    for number in (1, 2, 3, 4):
        assert width[number, "ratings independent"] < width[number, "subjects, t"] / 3
    assert (np.sign(table["estimate"]) == 1).all()
    ours = claims(trials, draws=10, shuffles=19)["estimate"]
    t_rows = table[table["method"] == "subjects, t"].set_index("number")["estimate"]
    np.testing.assert_allclose(t_rows, ours[:4], atol=1e-6)


def test_readings_differ_where_they_should(trials):
    tables = readings()
    assert {name: len(table) for name, table in tables.items()} == {
        "dropped": 855, "kept": 864, "best": 864, "worst": 864, "20 g": 855, "odd cells out": 849,
    }  # fmt: skip
    assert (tables["20 g"]["weight_g"] == 24).sum() == 0


def test_simulated_subjects_vary_like_the_real_ones(trials, simulated):
    assert simulated.attrs["simulated"]
    assert simulated["subject"].nunique() == 40
    real, drawn = slope_estimates(trials), slope_estimates(simulated)
    drawn = drawn[np.isfinite(drawn)]
    assert len(drawn) > 30
    assert abs(drawn.mean() - real.mean()) < 3 * drawn.std() / np.sqrt(4)
    again = simulate_population(trials, subjects=40, rng=np.random.default_rng(1))
    pd.testing.assert_frame_equal(again, simulated)


def test_more_subjects_narrow_the_interval_by_the_t_law():
    pool = np.random.default_rng(4).normal(3.0, 2.0, 5000)
    table = slope_power(pool, subjects=(4, 9, 36), rng=np.random.default_rng(5))
    plain = table[table["spread"] == "as estimated"].set_index("subjects")["half_width"]
    # mean sample deviation times the t quantile over the root of n
    assert plain[36] == pytest.approx(2.0 * 0.993 * 2.0301 / 6, rel=0.05)
    assert plain[4] == pytest.approx(2.0 * 0.9213 * 3.1824 / 2, rel=0.05)
    larger = table[table["spread"] == "larger"].set_index("subjects")["half_width"]
    np.testing.assert_allclose(larger / plain, 1.727, rtol=0.05)


def test_power_rises_with_subjects_and_equals_the_level_without_an_effect():
    estimates = pd.DataFrame({"a": [1.0, 0.0], "b": [3.0, 2.0], "c": [2.0, -2.0]}, index=[1, 2])
    pool = normal_population(estimates, rng=np.random.default_rng(6))
    table = claim_power(pool - pool.mean(axis=1).to_numpy()[:, None] * [[0], [1]],
                        subjects=(4, 8, 16), rng=np.random.default_rng(7))  # fmt: skip
    with_effect = table.loc[table["number"] == 1, "power"]
    assert with_effect.is_monotonic_increasing
    without = table.loc[table["number"] == 2, "power"]
    assert (abs(without - 0.05) < 0.02).all()
    assert subjects_needed(table)[1] <= 8
    assert np.isnan(subjects_needed(table)[2])
