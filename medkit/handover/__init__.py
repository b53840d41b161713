"""Rating trials to scores to ordinal models to a release force."""

from medkit.handover.claims import claims, subject_estimates
from medkit.handover.ordinal import expected_score, fit_cumulative_logit, rating_probabilities
from medkit.handover.release import iso_score, iso_slope, link_comparison, recommend_force
from medkit.handover.trials import (
    describe_trials,
    load_trials,
    mean_scores,
    rating_shares,
    score,
    with_light_object,
)

__all__ = [
    "claims",
    "describe_trials",
    "expected_score",
    "fit_cumulative_logit",
    "iso_score",
    "iso_slope",
    "link_comparison",
    "load_trials",
    "mean_scores",
    "rating_probabilities",
    "rating_shares",
    "recommend_force",
    "score",
    "subject_estimates",
    "with_light_object",
]
