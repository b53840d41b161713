"""The cumulative logit: derivatives, statsmodels as judge, symmetry, known parameters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import approx_fprime
from statsmodels.miscmodels.ordinal_model import OrderedModel

from medkit.errors import InputError
from medkit.handover.ordinal import (
    _derivatives,
    _objective,
    eta_at_score,
    expected_score,
    fit_cumulative_logit,
    rating_probabilities,
)


def simulated(rng, cells=60, ratings=6):
    design = np.column_stack([rng.uniform(0, 4, cells), rng.uniform(0, 1, cells)])
    chances = rating_probabilities(design @ np.array([-1.5, 2.0]), np.array([-4.0, -2.0]))
    return design, np.array([rng.multinomial(ratings, row) for row in chances])


def test_derivatives_agree_with_differences():
    design, counts = simulated(np.random.default_rng(1))
    point = np.array([[-1.0, 0.7, 0.3, -0.2]])
    gradient, hessian = _derivatives(design, counts[None], point, 0.2)
    slope = approx_fprime(point[0], lambda x: _objective(design, counts[None], x[None], 0.2)[0])
    np.testing.assert_allclose(gradient[0], slope, rtol=1e-4, atol=1e-3)
    curve = approx_fprime(
        point[0], lambda x: _derivatives(design, counts[None], x[None], 0.2)[0][0]
    )
    np.testing.assert_allclose(hessian[0], curve, rtol=1e-4, atol=1e-3)


def test_statsmodels_finds_the_same_estimate_and_errors():
    design, counts = simulated(np.random.default_rng(2))
    rows = np.repeat(np.tile(np.arange(3), len(design)), counts.ravel())
    long = np.repeat(np.repeat(design, 3, axis=0), counts.ravel(), axis=0)
    judge = OrderedModel(rows, long, distr="logit").fit(method="bfgs", disp=0, gtol=1e-8)
    ours = fit_cumulative_logit(design, counts, ridge=0.0)
    np.testing.assert_allclose(ours.coefficients[0], judge.params[:2], atol=1e-4)
    first, gap = judge.params[2:]
    np.testing.assert_allclose(ours.thresholds[0], [first, first + np.exp(gap)], atol=1e-4)
    np.testing.assert_allclose(ours.log_likelihood[0], judge.llf, atol=1e-6)
    errors = np.sqrt(np.diag(ours.covariance[0]))[2:]
    np.testing.assert_allclose(errors, judge.bse[:2], rtol=1e-2)


def test_a_stack_of_fits_equals_the_fits_one_by_one():
    rng = np.random.default_rng(3)
    design, _ = simulated(rng)
    stack = rng.multinomial(5, [0.3, 0.3, 0.4], size=(4, len(design)))
    together = fit_cumulative_logit(design, stack)
    for index, counts in enumerate(stack):
        alone = fit_cumulative_logit(design, counts)
        np.testing.assert_allclose(together.coefficients[index], alone.coefficients[0], atol=1e-7)


def test_turning_the_scale_turns_the_sign():
    design, counts = simulated(np.random.default_rng(4))
    plain = fit_cumulative_logit(design, counts)
    turned = fit_cumulative_logit(design, counts[:, ::-1])
    np.testing.assert_allclose(plain.coefficients, -turned.coefficients, atol=1e-6)
    np.testing.assert_allclose(plain.thresholds, -turned.thresholds[:, ::-1], atol=1e-6)


def test_estimates_centre_on_the_truth_with_the_stated_spread():
    rng = np.random.default_rng(5)
    design, _ = simulated(rng)
    chances = rating_probabilities(design @ np.array([-1.5, 2.0]), np.array([-4.0, -2.0]))
    counts = np.array([[rng.multinomial(6, row) for row in chances] for _ in range(200)])
    fits = fit_cumulative_logit(design, counts)
    errors = np.sqrt(np.diagonal(fits.covariance, axis1=1, axis2=2))[:, 2:]
    covered = np.abs(fits.coefficients - [-1.5, 2.0]) < 1.96 * errors
    assert (np.abs(covered.mean(axis=0) - 0.95) < 0.05).all()
    assert np.abs(fits.coefficients.mean(axis=0) - [-1.5, 2.0]).max() < 0.08


def test_one_kind_of_rating_alone_keeps_finite_estimates():
    design = np.linspace(0, 1, 8)[:, None]
    for level in range(3):
        counts = np.zeros((8, 3))
        counts[:, level] = 4
        fit = fit_cumulative_logit(design, counts)
        assert np.isfinite(fit.coefficients).all()
        assert fit.thresholds[0, 0] < fit.thresholds[0, 1]
        assert fit.converged.all()


@settings(derandomize=True, max_examples=50)
@given(st.floats(0.02, 0.98), st.floats(-8, 8), st.floats(0.01, 12))
def test_score_level_is_met_at_the_solved_predictor(level, first, gap):
    thresholds = np.array([first, first + gap])
    assert expected_score(eta_at_score(level, thresholds), thresholds) == pytest.approx(level)


def test_bad_shapes_and_levels_are_refused():
    with pytest.raises(InputError, match="one row of counts per cell"):
        fit_cumulative_logit(np.ones((3, 1)), np.ones((4, 3)))
    with pytest.raises(InputError, match="one has none"):
        fit_cumulative_logit(np.ones((3, 1)), np.zeros((3, 3)))
    with pytest.raises(InputError, match="between 0 and 1"):
        eta_at_score(1.0, np.array([0.0, 1.0]))
