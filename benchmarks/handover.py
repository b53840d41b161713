"""Our ordinal fits against statsmodels and a plain quadrature, on the same table in one run.

CPU seconds of this process, medians; trust the ratios.
"""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize
from statsmodels.miscmodels.ordinal_model import OrderedModel

from medkit.handover.cells import design_columns, rating_cells
from medkit.handover.mixed import fit_mixed_logit
from medkit.handover.ordinal import fit_cumulative_logit, rating_probabilities
from medkit.handover.trials import load_trials

TERMS = ("root_force", "weight", "pose", "mode")


def seconds(call: Callable[[], object], repeats: int = 3) -> float:
    """Median CPU time of a call [s], after one call to warm up."""
    call()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return statistics.median(times)


def one_row_per_rating(design: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and ratings (0 bad, 1 acceptable, 2 good), as the rivals want them."""
    cell, rating = np.nonzero(np.ones_like(counts))
    times = counts.ravel().astype(int)
    return np.repeat(design[cell], times, axis=0), np.repeat(rating, times)


def plain_quadrature(
    design: np.ndarray, counts: np.ndarray, subject: np.ndarray, nodes: int
) -> tuple[np.ndarray, float]:
    """Rival: random intercept on a grid that stays put, slopes by differences (scipy's BFGS)."""
    x, w = np.polynomial.hermite_e.hermegauss(nodes)
    log_weight = np.log(w / w.sum())
    people = np.eye(subject.max() + 1)[:, subject]

    def loss(point: np.ndarray) -> float:
        thresholds = np.array([point[0], point[0] + np.exp(point[1])])
        eta = (design @ point[2:-1])[:, None] + point[-1] * x
        chance = rating_probabilities(eta, thresholds)
        cells = (counts[:, None, :] * np.log(np.maximum(chance, 1e-300))).sum(axis=2)
        return -float(np.logaddexp.reduce(people @ cells + log_weight, axis=1).sum())

    first = fit_cumulative_logit(design, counts)
    start = np.r_[first.thresholds[0, 0], np.log(np.diff(first.thresholds[0])),
                  first.coefficients[0], 0.7]  # fmt: skip
    found = minimize(loss, start, method="BFGS", options={"gtol": 1e-2})
    return found.x[2:-1], -float(found.fun)


def run() -> None:
    """Print times, ratios and how far the estimates differ."""
    warnings.simplefilter("ignore")
    cells = rating_cells(load_trials())
    design, counts = design_columns(cells, TERMS), cells.counts
    rows, ratings = one_row_per_rating(design, counts)
    model = OrderedModel(ratings, rows, distr="logit")
    theirs = model.fit(method="bfgs", disp=False).params[: design.shape[1]]
    ours = fit_cumulative_logit(design, counts).coefficients[0]
    a = seconds(lambda: fit_cumulative_logit(design, counts))
    b = seconds(lambda: model.fit(method="bfgs", disp=False))
    print(f"cumulative logit, {len(ratings)} ratings: ours {1e3 * a:.1f} ms, OrderedModel"
          f" {1e3 * b:.0f} ms, ratio {b / a:.0f}, largest difference"
          f" {np.abs(ours - theirs).max():.1e}")  # fmt: skip
    draws = np.random.default_rng(0).multinomial(len(counts), np.ones(len(counts)) / len(counts),
                                                 size=100)  # fmt: skip
    many = draws[:, :, None] * counts
    c = seconds(lambda: fit_cumulative_logit(design, many), 1) / len(many)
    print(f"one of 100 bootstrap fits: ours {1e3 * c:.2f} ms, ratio {b / c:.0f} to OrderedModel")
    e = seconds(lambda: fit_mixed_logit(design, counts, cells.subject, names=list("abcd")))
    fit = fit_mixed_logit(design, counts, cells.subject, names=list("abcd"))
    print(f"random intercepts, adaptive: ours {e:.2f} s, log-likelihood {fit.log_likelihood:.3f}")
    for nodes in (15, 61):
        found, value = plain_quadrature(design, counts, cells.subject, nodes)
        f = seconds(lambda n=nodes: plain_quadrature(design, counts, cells.subject, n), 1)
        off = np.abs(found - fit.coefficients).max()
        print(f"  a grid of {nodes} nodes that stays put: {f:.2f} s, ratio {f / e:.1f},"
              f" log-likelihood {value:.3f}, coefficients off by {off:.1e}")  # fmt: skip
