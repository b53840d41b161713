"""A release force between what noise forbids below and what feels natural above."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from medkit.geometry import nonnegative
from medkit.handover.release import iso_score

GRAVITY = 9.81  # [m/s^2]


def recommend_force(
    trials: pd.DataFrame, *, level: float = 0.75, weight_error_kg: float = 0.1,
    bump_N: float = 0.5, weights: Sequence[float] | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Return the release force between what noise forbids below and naturalness above.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    level : float
        Expected score that must be kept.
    weight_error_kg : float
        By how much the weight may be underestimated (L14 4.1: about 0.1 kg within 2 s). The
        missing load already pulls at the gripper.
    bump_N : float
        Noise and light bumps on top. 0.5 N is what released nothing early in L14's trials, while
        0.1 N often did (section 4.2); a harder bump is the user's to state.
    weights : sequence of float, optional
        Masses [kg]; those met in the pose when left out.

    Returns
    -------
    pandas.DataFrame
        pose, mode, weight [kg]; ``lower`` [N] (safety), ``upper`` [N] (the cautious end of the
        iso-score interval), ``upper_estimate`` [N], ``force`` [N] (the recommendation: the cautious
        upper end, since a firmer hold is the safer one, but never below the safety limit),
        ``window``: "open" (lower < upper), "narrow" (lower < upper_estimate only) or "closed".

    Raises
    ------
    InputError
        If an allowance is negative.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> row = recommend_force(load_trials(), weights=[0.6]).iloc[1]
    >>> row["mode"], round(float(row["lower"]), 2), row["window"]
    ('position', 1.48, 'open')
    """
    weight_error_kg = nonnegative(weight_error_kg, "weight_error_kg", " kg")
    bump_N = nonnegative(bump_N, "bump_N", " N")
    curve = iso_score(trials, level, weights=weights)
    lower = GRAVITY * weight_error_kg + bump_N
    window = np.select([lower < curve["low"], lower < curve["force"]], ["open", "narrow"], "closed")
    return pd.DataFrame(
        {
            "pose": curve["pose"], "mode": curve["mode"], "weight": curve["weight"],
            "lower": lower, "upper": curve["low"], "upper_estimate": curve["force"],
            "force": np.maximum(lower, curve["low"]), "window": window,
        }
    )  # fmt: skip
