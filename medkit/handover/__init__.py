"""Rating trials to scores to ordinal models to a release force."""

from medkit.handover.checks import (
    calibration,
    leave_one_subject_out,
    method_agreement,
    predictive_check,
    proportional_odds_check,
    readings,
    sensitivity,
)
from medkit.handover.claims import claims, subject_estimates
from medkit.handover.links import link_comparison
from medkit.handover.mixed import fit_population
from medkit.handover.ordinal import expected_score, fit_cumulative_logit, rating_probabilities
from medkit.handover.power import (
    claim_power,
    normal_population,
    simulate_population,
    slope_estimates,
    slope_power,
    subjects_needed,
)
from medkit.handover.recommendation import recommend_force
from medkit.handover.recovery import recovery_study
from medkit.handover.release import iso_score, iso_slope
from medkit.handover.trials import (
    describe_trials,
    load_trials,
    mean_scores,
    rating_shares,
    score,
    with_light_object,
)

__all__ = [
    "calibration", "claim_power", "claims", "describe_trials", "expected_score",
    "fit_cumulative_logit", "fit_population", "iso_score", "iso_slope", "leave_one_subject_out",
    "link_comparison", "load_trials", "mean_scores", "method_agreement", "normal_population",
    "predictive_check", "proportional_odds_check", "rating_probabilities", "rating_shares",
    "readings", "recommend_force", "recovery_study", "score", "sensitivity",
    "simulate_population", "slope_estimates", "slope_power", "subject_estimates",
    "subjects_needed", "with_light_object",
]  # fmt: skip
