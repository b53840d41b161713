"""Scores: bounds, order, mirror law; irregular cells treated as said."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.handover import (
    describe_trials,
    load_trials,
    mean_scores,
    rating_shares,
    score,
    with_light_object,
)

COUNTS = st.lists(
    st.tuples(*[st.integers(0, 9)] * 3).filter(lambda row: sum(row) > 0), min_size=1, max_size=8
)


def frame(rows):
    return pd.DataFrame(rows, columns=["good", "acceptable", "bad"])


@settings(derandomize=True, max_examples=40)
@given(COUNTS)
def test_score_is_bounded_and_mirrors_when_the_scale_is_turned(rows):
    table = frame(rows)
    turned = table.rename(columns={"good": "bad", "bad": "good"})
    ours = score(table).to_numpy()
    assert ((ours >= 0) & (ours <= 1)).all()
    np.testing.assert_allclose(ours + score(turned).to_numpy(), 1.0, atol=1e-12)


@settings(derandomize=True, max_examples=40)
@given(COUNTS)
def test_a_better_rating_raises_the_score(rows):
    worse = frame([(good, acceptable, bad + 1) for good, acceptable, bad in rows])
    middle = frame([(good, acceptable + 1, bad) for good, acceptable, bad in rows])
    better = frame([(good + 1, acceptable, bad) for good, acceptable, bad in rows])
    assert (score(worse) < score(middle)).all()
    assert (score(middle) < score(better)).all()


def test_score_does_not_change_when_every_count_is_multiplied():
    trials = load_trials()
    tripled = trials.assign(**{name: 3 * trials[name] for name in ("good", "acceptable", "bad")})
    np.testing.assert_allclose(score(tripled), score(trials))


def test_rows_without_ratings_and_missing_columns_are_refused():
    with pytest.raises(InputError, match="row 1"):
        score(frame([(1, 0, 0), (0, 0, 0)]))
    with pytest.raises(InputError, match="acceptable is missing"):
        score(pd.DataFrame({"good": [1], "bad": [0]}))


def test_nine_cells_are_dropped_and_said_so():
    trials = load_trials()
    assert len(trials) == 855
    assert (trials[["good", "acceptable", "bad"]].sum(axis=1) == 4).all()
    assert trials.attrs == {"cells": 864, "irregular": 9, "treatment": "drop", "repetitions": 4}
    assert "9 of 864 cells" in describe_trials(trials)


def test_treatments_bracket_the_lost_ratings():
    best, worst = load_trials(irregular="best"), load_trials(irregular="worst")
    kept = load_trials(irregular="keep")
    assert len(best) == len(worst) == len(kept) == 864
    low, middle, high = score(worst), score(kept), score(best)
    assert (low <= middle).all()
    assert (middle <= high).all()
    assert (high - low > 0).sum() == 9
    assert (high - low).max() == pytest.approx(1 / 4)


def test_an_unknown_treatment_is_refused():
    with pytest.raises(InputError, match="drop, keep, best, worst"):
        load_trials(irregular="guess")


def test_reading_24_as_20_touches_the_lightest_object_alone():
    trials = load_trials()
    read = with_light_object(trials)
    changed = trials["weight_g"] != read["weight_g"]
    assert set(trials.loc[changed, "weight_g"]) == {24}
    assert set(read.loc[changed, "weight_g"]) == {20}
    assert (trials["weight_g"] == 24).sum() == changed.sum()


def test_shares_add_up_and_pool_to_the_score():
    trials = load_trials()
    shares = rating_shares(trials, ["pose", "mode", "force_N"])
    np.testing.assert_allclose(shares[["good", "acceptable", "bad"]].sum(axis=1), 1.0)
    assert shares["ratings"].sum() == 4 * len(trials)
    pooled = shares["good"] + shares["acceptable"] / 2
    np.testing.assert_allclose(pooled, mean_scores(trials, ["pose", "mode", "force_N"]))
