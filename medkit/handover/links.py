"""On which scale the force belongs into the model: newtons, their roots, or their logarithm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from medkit.handover.cells import design_columns, rating_cells
from medkit.handover.ordinal import fit_cumulative_logit

Array = np.ndarray
#: Candidate scales of the force in the linear predictor.
FORCE_SCALES: dict[str, Callable[[Array], Array]] = {
    "force": lambda force: force,
    "root of force": np.sqrt,
    "cube root of force": np.cbrt,
    "logarithm of force": np.log,
}


def link_comparison(trials: pd.DataFrame) -> pd.DataFrame:
    """Compare scales of the force by Akaike's criterion, subject effects included.

    Returns
    -------
    pandas.DataFrame
        Per scale ``aic`` and its difference from the best; smaller is better. As ratings of a cell
        are not independent, read differences of a few units as ties.

    Examples
    --------
    >>> from medkit.handover import load_trials
    >>> link_comparison(load_trials())["aic"].idxmin()
    'root of force'
    """
    cells = rating_cells(trials)
    rest = design_columns(cells, ["weight", "pose", "mode", "subject"])
    aic = {}
    for name, scale in FORCE_SCALES.items():
        fit = fit_cumulative_logit(np.column_stack([scale(cells.force), rest]), cells.counts)
        aic[name] = 2 * (3 + rest.shape[1]) - 2 * float(fit.log_likelihood[0])
    table = pd.DataFrame({"aic": aic})
    return table.assign(difference=table["aic"] - table["aic"].min())
