"""Rating trials to scores to ordinal models to a release force."""

from medkit.handover.trials import (
    describe_trials,
    load_trials,
    mean_scores,
    rating_shares,
    score,
    with_light_object,
)

__all__ = [
    "describe_trials",
    "load_trials",
    "mean_scores",
    "rating_shares",
    "score",
    "with_light_object",
]
