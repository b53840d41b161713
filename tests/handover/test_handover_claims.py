"""Claims: the rule, mirror laws, tables that cannot speak to a claim, and the irregular cells."""

import numpy as np
import pandas as pd
import pytest

from medkit.errors import InputError
from medkit.handover import claims, load_trials, subject_estimates, with_light_object
from medkit.handover.claims import verdict
from medkit.handover.resampling import (
    bootstrap_weights,
    holm,
    permutation_p,
    sign_flip_p,
    subject_interval,
)

FEW = {"draws": 30, "shuffles": 199}


@pytest.fixture(scope="module")
def trials():
    return load_trials()


@pytest.fixture(scope="module")
def table(trials):
    return claims(trials, **FEW)


def test_contract_columns_and_order(table):
    expected = ["claim", "estimate", "low", "high", "p_permutation", "verdict"]
    assert table.columns.tolist()[:6] == expected
    assert table.index.tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert (table["low"] <= table["estimate"]).all()
    assert (table["estimate"] <= table["high"]).all()


def test_verdicts_follow_the_rule(table):
    for row in table.itertuples():
        assert row.verdict == verdict(row.low, row.high, row.p_holm)
        assert row.verdict_these == verdict(row.low_these, row.high_these, row.p_holm)


def test_what_these_ratings_decide(table):
    decided = table["verdict"].to_dict()
    assert decided[1] == decided[2] == "supported"
    assert all(decided[number] == "not decided" for number in (3, 4, 5, 6, 7))
    assert (table["verdict_these"] == "supported").all()


def test_four_subjects_cannot_get_below_one_eighth(table):
    assert (table["p_sign"] >= 0.125).all()


def test_same_table_same_answer(trials, table):
    pd.testing.assert_frame_equal(claims(trials, **FEW), table)


def test_turning_the_scale_turns_the_first_four_claims(trials, table):
    turned = claims(trials.rename(columns={"good": "bad", "bad": "good"}), **FEW)
    np.testing.assert_allclose(turned["estimate"][:4], -table["estimate"][:4], atol=1e-5)
    np.testing.assert_allclose(turned["low"][:4], -table["high"][:4], atol=1e-5)
    assert turned["verdict"][1] == turned["verdict"][2] == "contradicted"


@pytest.mark.parametrize("irregular", ["keep", "best", "worst"])
def test_the_nine_cells_change_no_verdict(table, irregular):
    other = claims(load_trials(irregular=irregular), **FEW)
    assert other["verdict"].tolist() == table["verdict"].tolist()
    assert other["verdict_these"].tolist() == table["verdict_these"].tolist()


def test_reading_24_as_20_changes_no_verdict(trials, table):
    other = claims(with_light_object(trials), **FEW)
    assert other["verdict"].tolist() == table["verdict"].tolist()


def test_order_of_rows_and_names_of_subjects_do_not_matter(trials, table):
    mixed = trials.sample(frac=1, random_state=np.random.default_rng(0)).reset_index(drop=True)
    renamed = mixed.assign(subject=mixed["subject"].map(lambda name: "person " + name))
    other = claims(renamed, subject="person T4", **FEW)
    np.testing.assert_allclose(other["estimate"], table["estimate"], atol=1e-6)
    np.testing.assert_allclose(other["low"], table["low"], atol=1e-5)


def test_a_table_of_one_pose_and_mode_leaves_comparisons_undecided(trials):
    part = trials[(trials["pose"] == "P1") & (trials["mode"] == "position")]
    other = claims(part, **FEW)
    for number in (3, 4):
        assert np.isnan(other["estimate"][number])
        assert other["verdict"][number] == "not decided"
    assert other["verdict"][1] == "supported"


def test_other_names_weights_and_subjects_are_served(trials):
    lab = trials[(trials["weight_g"] == 300) & trials["subject"].isin(["T1", "T2"])]
    lab = lab.assign(pose="tray", mode="soft", force_N=lab["force_N"] * 1.5)
    lab = lab.groupby(["pose", "mode", "force_N", "weight_g", "subject"]).sum(numeric_only=True)
    other = claims(lab.reset_index(), **FEW)
    assert np.isfinite(other["estimate"][1])
    assert other["estimate"][[2, 3, 4, 5, 7]].isna().all()


def test_a_subject_who_met_one_side_only_does_not_count_for_the_comparison(trials, table):
    lacking = (trials["subject"] == "T1") & (trials["pose"] == "P2")
    other = claims(trials[~lacking], **FEW)
    assert other["agree"][3] == "3 of 3"
    assert other["agree"][4] == table["agree"][4]
    single = (trials["subject"] == "T1") & (trials["weight_g"] != 300)
    assert claims(trials[~single], **FEW)["agree"][[2, 7]].tolist() == ["3 of 3", "3 of 3"]


def test_one_subject_is_refused(trials):
    with pytest.raises(InputError, match="at least two subjects"):
        claims(trials[trials["subject"] == "T1"])


def test_rating_noise_alone_supports_nothing(trials):
    rng = np.random.default_rng(7)
    noise = trials.copy()
    noise[["good", "acceptable", "bad"]] = rng.multinomial(4, [0.3, 0.4, 0.3], size=len(noise))
    assert (claims(noise, **FEW)["verdict"] == "not decided").all()


def test_subject_interval_keeps_its_coverage():
    rng = np.random.default_rng(8)
    mean, low, high = subject_interval(rng.normal(1.0, 2.0, size=(4, 4000)))
    assert abs(((low < 1) & (high > 1)).mean() - 0.95) < 0.015
    assert np.allclose((low + high) / 2, mean)


def test_permutation_p_is_level_under_the_null():
    rng = np.random.default_rng(9)
    strata = np.repeat(np.arange(5), 6)
    x = np.tile(np.arange(6.0), 5)
    p = [permutation_p(x, rng.random(30), strata, draws=99, rng=rng) for _ in range(300)]
    assert abs(np.mean(np.array(p) <= 0.1) - 0.1) < 0.06


def test_permutation_stays_within_strata():
    strata = np.array([0, 0, 1, 1])
    x, y = np.array([0.0, 1, 0, 1]), np.array([0.0, 1, 10, 11])
    # both strata in order: 1 of 4 arrangements, and its mirror image
    p = permutation_p(x, y, strata, draws=4000, rng=np.random.default_rng(1))
    assert p == pytest.approx(0.5, abs=0.03)


def test_resamples_keep_every_stratum_whole():
    strata = np.array([0, 0, 0, 1, 1, 2])
    weights = bootstrap_weights(strata, 50, np.random.default_rng(0))
    for stratum, size in ((0, 3), (1, 2), (2, 1)):
        assert (weights[:, strata == stratum].sum(axis=1) == size).all()


def test_sign_flips_and_holm():
    assert sign_flip_p(np.array([1.0, -1.0, 2.0])) == 0.75
    corrected = holm(np.array([0.001, np.nan, 0.5, 0.02]))
    np.testing.assert_allclose(corrected, [0.003, np.nan, 0.5, 0.04])


def test_a_person_who_says_one_word_only_has_no_effects(trials):
    words = ["good", "acceptable", "bad"]
    changed = trials.copy()
    mute = changed["subject"] == "T2"
    changed.loc[mute, words] = [4, 0, 0]
    single = subject_estimates(changed)
    assert single.loc[[1, 2, 3, 4], "T2"].isna().all()
    assert np.allclose(single.loc[[1, 2, 3, 4], "T1"], subject_estimates(trials).loc[1:4, "T1"])
    changed[words] = [0, 4, 0]
    with pytest.raises(InputError, match="that are all acceptable"):
        claims(changed, **FEW)


def test_shuffling_what_does_not_vary_proves_nothing():
    rng = np.random.default_rng(0)
    strata = np.repeat(np.arange(40), 9)
    forces = np.sqrt(np.tile([0.5, 1, 2, 5, 7, 10, 12, 15, 20], 40))
    assert permutation_p(forces, np.full(360, 0.3), strata, draws=99, rng=rng) == 1.0
