"""Compiled support function of the wrench space: how far it reaches in a direction, and where.

A contact is an ellipse ``centre + axes^T z`` of wrenches, ``|z| <= 1`` (see `medkit.contacts`); a
linearised contact offers only the rows of `profile` for z. Closed forms for all cases, so that no
list of primitive wrenches is ever made.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _shadow(centers, axes, i, u, shadow):  # type: ignore[no-untyped-def]
    """Component of contact i's centre along `u`; those of its axes go into `shadow`."""
    along = 0.0
    for a in range(u.shape[0]):
        along += centers[i, a] * u[a]
    for j in range(axes.shape[1]):
        value = 0.0
        for a in range(u.shape[0]):
            value += axes[i, j, a] * u[a]
        shadow[j] = value
    return along


@njit(cache=True, error_model="numpy")
def _best_profile(profile, shadow, least):  # type: ignore[no-untyped-def]
    """Index and component of a contact's best profile point; (-1, length) for an exact cone.

    Gives up with -inf when even the whole ellipse cannot reach `least`.
    """
    square = 0.0
    for j in range(shadow.shape[0]):
        square += shadow[j] * shadow[j]
    if least > 0.0 and square < least * least:
        return -1, -np.inf
    if profile.shape[0] == 0:
        return -1, np.sqrt(square)
    best, chosen = -np.inf, 0
    for z in range(profile.shape[0]):
        value = 0.0
        for j in range(shadow.shape[0]):
            value += profile[z, j] * shadow[j]
        if value > best:
            best, chosen = value, z
    return chosen, best


@njit(cache=True, error_model="numpy")
def _add_wrench(centers, axes, profile, i, chosen, length, shadow, out, row):  # type: ignore[no-untyped-def]
    """Add the chosen wrench of contact i to row `row` of `out`."""
    for a in range(out.shape[1]):
        out[row, a] += centers[i, a]
    for j in range(axes.shape[1]):
        weight = profile[chosen, j] if chosen >= 0 else shadow[j] / max(length, 1e-300)
        for a in range(out.shape[1]):
            out[row, a] += weight * axes[i, j, a]


@njit(cache=True, error_model="numpy")
def support(centers, axes, profile, total, u, shadow, out, row):  # type: ignore[no-untyped-def]
    """Furthest point of the wrench space along `u` into a row of `out`; returns its component.

    The union of contacts (`total` False) takes the best contact; the sum takes every contact
    that helps at all, each at full normal force.
    """
    for a in range(u.shape[0]):
        out[row, a] = 0.0
    best, chosen = -np.inf, np.int64(0)  # a bare 0 would be compiled as a type of its own
    for i in range(centers.shape[0]):
        along = _shadow(centers, axes, i, u, shadow)
        index, value = _best_profile(profile, shadow, (0.0 if total else best) - along)
        if total and along + value > 0.0:
            _add_wrench(centers, axes, profile, i, index, value, shadow, out, row)
        elif along + value > best:
            best, chosen = along + value, i
    if not total:
        _shadow(centers, axes, chosen, u, shadow)
        index, value = _best_profile(profile, shadow, -1.0)
        _add_wrench(centers, axes, profile, chosen, index, value, shadow, out, row)
    height = 0.0
    for a in range(u.shape[0]):
        height += u[a] * out[row, a]
    return height
