"""Cumulative logit with subjects drawn from a population: adaptive Gauss-Hermite quadrature.

statsmodels has no ordinal mixed model. Each subject's own intercept (and slope) is a draw from a
normal distribution; the likelihood of a subject is an integral over that draw, taken on a grid of
nodes that is moved and stretched to where the integrand of that subject lives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from medkit.arguments import one_of
from medkit.errors import InputError
from medkit.geometry import expected
from medkit.handover.cells import design_columns, rating_cells
from medkit.handover.ordinal import fit_cumulative_logit

Array = np.ndarray
TERMS = ("root_force", "weight", "pose", "mode", "subject")


@dataclass(frozen=True)
class MixedLogit:
    """A fitted cumulative logit with random effects.

    Attributes
    ----------
    names : tuple of str
        Of the coefficients.
    thresholds : (2,) ndarray
        Of an average subject [log-odds].
    coefficients, errors : (p,) ndarray
        Fixed effects and their standard errors (inverse information; too small with few
        subjects).
    random_names : tuple of str
        ``intercept``, then the columns with a slope of their own per subject.
    spread : (q, q) ndarray
        Covariance of the random effects.
    modes : (s, q) ndarray
        Most likely random effects of each subject.
    log_likelihood : float
        Marginal, at the estimate.
    converged : bool
        Whether the optimiser ended on a small gradient.
    """

    names: tuple[str, ...]
    thresholds: Array
    coefficients: Array
    errors: Array
    random_names: tuple[str, ...]
    spread: Array
    modes: Array
    log_likelihood: float
    converged: bool


def fit_mixed_logit(
    design: Array, counts: Array, subject: Array, *, names: Sequence[str],
    slopes: Sequence[str] = (),
    nodes: int = 7,
) -> MixedLogit:  # fmt: skip
    """Fit a cumulative logit with random intercepts, and random slopes if asked for.

    Parameters
    ----------
    design : (n, p) ndarray
        Fixed effects, without a constant column.
    counts : (n, 3) ndarray
        Ratings bad, acceptable, good.
    subject : (n,) ndarray of int
        Who gave them, 0 to s - 1.
    names : sequence of str
        Names of the columns.
    slopes : sequence of str
        Columns whose slope varies between subjects too.
    nodes : int
        Quadrature nodes per random effect.

    Returns
    -------
    MixedLogit
        The estimate; see its attributes.

    Raises
    ------
    InputError
        If a slope is not among the names.

    Examples
    --------
    >>> from medkit.handover.recovery import simulate_counts
    >>> rng = np.random.default_rng(0)
    >>> design, subject = np.tile(np.linspace(0, 4, 9), 6)[:, None], np.repeat(np.arange(6), 9)
    >>> counts = simulate_counts(design, subject, thresholds=[-4, -2], coefficients=[-2],
    ...                          spread=[[0.5]], slopes=[], ratings=8, rng=rng)
    >>> fit_mixed_logit(design, counts, subject, names=["force"]).converged
    True
    """
    absent = [name for name in slopes if name not in names]
    if absent:
        raise InputError(
            f"Expected slopes among the columns {', '.join(names)}, came {absent[0]!r}; name a"
            " column of the design."
        )
    problem = _Problem(design, counts, subject, [list(names).index(name) for name in slopes], nodes)
    start = fit_cumulative_logit(design, counts)
    first = np.r_[start.thresholds[0, 0], np.log(np.diff(start.thresholds[0])),
                  start.coefficients[0], problem.start_factor()]  # fmt: skip
    found = minimize(problem.value_and_slope, first, jac=True, method="BFGS",
                     options={"gtol": 1e-3, "maxiter": 200})  # fmt: skip
    point = found.x
    errors = _errors(problem, point)[2 : 2 + design.shape[1]]
    factor = problem.factor(point)
    return MixedLogit(
        tuple(names), point[0] + np.r_[0.0, np.exp(point[1])], point[2 : 2 + design.shape[1]],
        errors, ("intercept", *slopes), factor @ factor.T, problem.modes @ factor.T,
        -float(found.fun), bool(np.abs(found.jac).max() < 0.05),
    )  # fmt: skip


def fit_population(
    trials: pd.DataFrame, *, terms: Sequence[str] = ("root_force", "weight", "pose", "mode"),
    slopes: Sequence[str] = (),
) -> MixedLogit:  # fmt: skip
    """Fit the mixed model to a trial table.

    Parameters
    ----------
    trials : pandas.DataFrame
        From :func:`medkit.handover.load_trials`.
    terms : sequence of str
        Terms as in :func:`medkit.handover.cells.design_columns`.
    slopes : sequence of str
        Terms with a slope per subject: ``root_force`` or ``weight``.

    Returns
    -------
    MixedLogit
        Names of poses and modes are spelled out, for example ``pose P2``.

    Raises
    ------
    InputError
        If no table came, a term is unknown, or a slope is not among the terms.
    """
    cells = rating_cells(trials)
    for name, columns in (("terms", terms), ("slopes", slopes)):
        _check_terms(columns, name)
    names: list[str] = []
    for term in terms:
        levels = {"pose": cells.poses, "mode": cells.modes}.get(term)
        names += [term] if levels is None else [f"{term} {level}" for level in levels[1:]]
    design = design_columns(cells, terms)
    return fit_mixed_logit(design, cells.counts, cells.subject, names=names, slopes=slopes)


def _check_terms(columns: Sequence[str], name: str) -> None:
    remedy = 'pass a tuple such as ("root_force", "weight")'
    expected(columns, (list, tuple), f"{name} as a tuple of columns", remedy)
    for column in columns:
        if name == "terms":
            one_of(column, TERMS, name, remedy)
        else:
            expected(column, str, f"names of columns as {name}", remedy)


class _Problem:
    """Marginal likelihood and its slope; remembers each subject's mode as the next start."""

    def __init__(
        self, design: Array, counts: Array, subject: Array, slopes: Sequence[int], nodes: int
    ) -> None:
        order = np.argsort(subject, kind="stable")
        self.design = np.asarray(design, float)[order]
        self.counts = np.asarray(counts, float)[order]
        self.subject = np.unique(np.asarray(subject)[order], return_inverse=True)[1]
        self.starts = np.searchsorted(self.subject, np.arange(self.subject[-1] + 1))
        self.carriers = np.column_stack([np.ones(len(order)), self.design[:, list(slopes)]])
        size = self.carriers.shape[1]
        self.modes = np.zeros((len(self.starts), size))
        self.lower = np.tril_indices(size)
        x, w = np.polynomial.hermite_e.hermegauss(nodes)
        grid = np.meshgrid(*[x] * size, indexing="ij")
        self.nodes = np.column_stack([axis.ravel() for axis in grid])
        weight = np.meshgrid(*[np.log(w)] * size, indexing="ij")
        self.log_weight = np.sum([axis.ravel() for axis in weight], axis=0)
        self.log_weight = self.log_weight + 0.5 * (self.nodes**2).sum(axis=1)

    def start_factor(self) -> Array:
        """Return a small diagonal factor to start from."""
        size = self.carriers.shape[1]
        return np.diag(np.r_[0.7, np.full(size - 1, 0.3)])[self.lower]

    def factor(self, point: Array) -> Array:
        """Return the lower triangular factor of the covariance."""
        factor = np.zeros((self.carriers.shape[1],) * 2)
        factor[self.lower] = point[2 + self.design.shape[1] :]
        return factor

    def value_and_slope(self, point: Array) -> tuple[float, Array]:
        """Return minus the marginal log-likelihood and its slope (Fisher's identity)."""
        thresholds = point[0] + np.array([0.0, np.exp(point[1])])
        fixed = self.design @ point[2 : 2 + self.design.shape[1]]
        loading = self.carriers @ self.factor(point)
        spread = self._find_modes(fixed, loading, thresholds)
        place = self.modes[:, None] + np.einsum("sij,qj->sqi", spread, self.nodes)
        eta = fixed[:, None] + np.einsum("ni,nqi->nq", loading, place[self.subject])
        log_p, first, second = _cell_terms(eta, self.counts, thresholds)
        joint = np.add.reduceat(log_p, self.starts, axis=0) - 0.5 * (place**2).sum(axis=2)
        joint += self.log_weight + np.linalg.slogdet(spread)[1][:, None]
        joint -= 0.5 * place.shape[2] * np.log(2 * np.pi)
        top = joint.max(axis=1, keepdims=True)
        share = np.exp(joint - top)
        total = share.sum(axis=1, keepdims=True)
        value = float((top + np.log(total)).sum())
        share = (share / total)[self.subject]
        s1, s2 = share * first, share * second
        return -value, -self._slope(point, s1, s2, place)

    def _slope(self, point: Array, s1: Array, s2: Array, place: Array) -> Array:
        push = -(s1 + s2)
        moved = np.einsum("nq,nqi->ni", push, place[self.subject])
        factor = self.carriers.T @ moved
        gap = np.exp(point[1]) * s2.sum()
        return np.r_[(s1 + s2).sum(), gap, push.sum(axis=1) @ self.design, factor[self.lower]]

    def _find_modes(self, fixed: Array, loading: Array, thresholds: Array) -> Array:
        """Newton steps to each subject's mode; returns the factors of the inverse curvature."""
        identity = np.eye(self.modes.shape[1])
        for _ in range(25):
            eta = fixed + (loading * self.modes[self.subject]).sum(axis=1)
            push, curve = _eta_terms(eta, self.counts, thresholds)
            slope = np.add.reduceat(loading * push[:, None], self.starts, axis=0) - self.modes
            outer = loading[:, :, None] * loading[:, None, :] * curve[:, None, None]
            hessian = np.add.reduceat(outer, self.starts, axis=0) - identity
            step = np.linalg.solve(hessian, slope[..., None])[..., 0]
            length = np.linalg.norm(step, axis=1, keepdims=True)
            self.modes = self.modes - step * np.minimum(1.0, 2.0 / np.maximum(length, 1e-12))
            if np.abs(step).max() < 1e-8:
                break
        return np.linalg.cholesky(np.linalg.inv(-hessian))


def _cell_terms(eta: Array, counts: Array, thresholds: Array) -> tuple[Array, Array, Array]:
    """Return log-likelihoods of cells and their slopes over both threshold distances, (n, q)."""
    low, high = thresholds[0] - eta, thresholds[1] - eta
    first, second = 0.5 * (1 + np.tanh(0.5 * low)), 0.5 * (1 + np.tanh(0.5 * high))
    n0, n1, n2 = (counts[:, k].reshape(-1, *[1] * (eta.ndim - 1)) for k in range(3))
    middle = np.maximum(second * (1 - first) * -np.expm1(thresholds[0] - thresholds[1]), 1e-100)
    value = -n0 * np.logaddexp(0, -low) - n2 * np.logaddexp(0, high) + n1 * np.log(middle)
    slope1 = n0 * (1 - first) - n1 * first * (1 - first) / middle
    slope2 = n1 * second * (1 - second) / middle - n2 * second
    return value, slope1, slope2


def _eta_terms(eta: Array, counts: Array, thresholds: Array) -> tuple[Array, Array]:
    """Return slope and curvature of the cells' log-likelihoods over the linear predictor.

    The middle probability splits into factors of one distance each, so both take a short form.
    """
    low, high = thresholds[0] - eta, thresholds[1] - eta
    first, second = 0.5 * (1 + np.tanh(0.5 * low)), 0.5 * (1 + np.tanh(0.5 * high))
    n0, n1, n2 = counts.T
    push = -n0 * (1 - first) + n1 * (first + second - 1) + n2 * second
    curve = -(n0 + n1) * first * (1 - first) - (n1 + n2) * second * (1 - second)
    return push, curve


def _errors(problem: _Problem, point: Array) -> Array:
    """Return standard errors from the curvature, by central differences of the slope."""
    step = 1e-4
    rows = []
    for index in range(len(point)):
        shift = np.zeros(len(point))
        shift[index] = step
        ahead, behind = (problem.value_and_slope(point + s)[1] for s in (shift, -shift))
        rows.append((ahead - behind) / (2 * step))
    problem.value_and_slope(point)
    curvature = np.array(rows)
    inverse = np.linalg.pinv((curvature + curvature.T) / 2)
    return np.sqrt(np.maximum(np.diag(inverse), 0.0))
