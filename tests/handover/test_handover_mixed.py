"""The mixed model: brute-force integral, slope, limits, and known parameters of simulated data."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import approx_fprime
from scipy.stats import norm

from medkit.errors import InputError
from medkit.handover.mixed import _Problem, fit_mixed_logit, fit_population
from medkit.handover.ordinal import fit_cumulative_logit, rating_probabilities
from medkit.handover.recovery import recovery_study, simulate_counts
from medkit.handover.trials import load_trials


def small_table(rng, spread, slopes=(), subjects=5):
    force = np.tile(np.linspace(0.5, 3.5, 6), subjects)[:, None]
    subject = np.repeat(np.arange(subjects), 6)
    counts = simulate_counts(
        force, subject, thresholds=[-5, -3], coefficients=[-2], spread=spread, slopes=slopes,
        ratings=4, rng=rng,
    )  # fmt: skip
    return force, counts, subject


def test_marginal_likelihood_equals_the_integral_by_brute_force():
    design, counts, subject = small_table(np.random.default_rng(0), [[0.8]])
    point = np.array([-4.8, np.log(2.1), -1.9, 0.9])
    ours = -_Problem(design, counts, subject, [], 15).value_and_slope(point)[0]
    thresholds = np.array([-4.8, -4.8 + 2.1])
    total = 0.0
    for person in range(5):
        own = subject == person

        def integrand(u, own=own):
            chances = rating_probabilities(design[own] @ [-1.9] + 0.9 * u, thresholds)
            return np.prod(chances ** counts[own]) * norm.pdf(u)

        total += np.log(quad(integrand, -8, 8, limit=200)[0])
    assert ours == pytest.approx(total, abs=1e-6)


@pytest.mark.parametrize(("slopes", "extra"), [([], [0.8]), ([0], [0.8, 0.1, 0.4])])
def test_slope_agrees_with_differences(slopes, extra):
    design, counts, subject = small_table(np.random.default_rng(1), [[0.8]])
    problem = _Problem(design, counts, subject, slopes, 9)
    point = np.r_[-4.8, np.log(2.1), -1.9, extra]
    slope = problem.value_and_slope(point)[1]
    numeric = approx_fprime(point, lambda x: problem.value_and_slope(x)[0], 1e-5)
    np.testing.assert_allclose(slope, numeric, atol=0.02)


def test_without_differences_between_subjects_it_is_the_plain_model():
    design, counts, subject = small_table(np.random.default_rng(2), [[0.0]], subjects=8)
    mixed = fit_mixed_logit(design, counts, subject, names=["force"])
    plain = fit_cumulative_logit(design, counts, ridge=0.0)
    assert mixed.log_likelihood >= plain.log_likelihood[0] - 1e-3
    assert mixed.spread[0, 0] < 0.5
    np.testing.assert_allclose(mixed.coefficients, plain.coefficients[0], rtol=0.1)


def test_names_of_subjects_and_order_of_cells_do_not_matter():
    design, counts, subject = small_table(np.random.default_rng(3), [[0.8]])
    order = np.random.default_rng(0).permutation(len(design))
    one = fit_mixed_logit(design, counts, subject, names=["force"])
    two = fit_mixed_logit(design[order], counts[order], 4 - subject[order], names=["force"])
    assert one.log_likelihood == pytest.approx(two.log_likelihood, abs=1e-4)
    np.testing.assert_allclose(one.coefficients, two.coefficients, atol=1e-3)
    np.testing.assert_allclose(one.modes, two.modes[::-1], atol=1e-2)


def test_known_parameters_come_back_with_the_stated_coverage():
    study = recovery_study(studies=24, subjects=8, rng=np.random.default_rng(4))
    assert (study["bias"].abs() < 4 * study["monte_carlo_error"]).all()
    assert (study["bias"].abs() < 0.06 * study["truth"].abs()).all()
    assert (study["coverage"] > 0.8).all()


def test_random_slopes_are_found_where_they_are():
    rng = np.random.default_rng(5)
    design, counts, subject = small_table(rng, [[0.2, 0], [0, 0.6]], [0], subjects=24)
    plain = fit_mixed_logit(design, counts, subject, names=["force"])
    sloped = fit_mixed_logit(design, counts, subject, names=["force"], slopes=["force"])
    assert sloped.log_likelihood > plain.log_likelihood + 5
    assert sloped.spread[1, 1] == pytest.approx(0.6, rel=0.8)


def test_the_thesis_has_subjects_who_differ_in_slope_too():
    trials = load_trials()
    plain = fit_population(trials)
    sloped = fit_population(trials, slopes=["root_force"])
    assert plain.converged
    assert sloped.converged
    assert sloped.log_likelihood > plain.log_likelihood + 20
    assert (np.sign(plain.coefficients) == [-1, 1, -1, 1]).all()  # force, weight, P2, position


def test_an_unknown_slope_is_refused():
    with pytest.raises(InputError, match="among the columns"):
        fit_mixed_logit(np.ones((2, 1)), np.ones((2, 3)), np.arange(2), names=["a"], slopes=["b"])
