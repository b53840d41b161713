"""The wrench space as the compiled code wants it: ellipses of wrenches, and how they are shared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from medkit.contacts import Contacts
from medkit.errors import InputError
from medkit.geometry import Floats, positive
from medkit.wrench_cones import PATCH_RADIUS, ContactModel, cone_profile, wrench_cones

Norm = Literal["l1", "linf"]

#: Bounds of linearised cones meet this closely, in units of the longest wrench.
LINEAR_GAP = 1e-10


@dataclass(frozen=True)
class SpaceOptions:
    """What a measure is told besides contacts and torque frame; see `medkit.quality.epsilon`."""

    edges: int | None = 8
    norm: Norm = "l1"
    contact: ContactModel = "point"
    patch_radius: float = PATCH_RADIUS
    tolerance: float = 1e-4


class WrenchSpace(NamedTuple):
    """Ellipses of wrenches, one per contact, of one grasp or of many in a row.

    `centers` (n, D) and `axes` (n, k, D) as in `medkit.contacts.WrenchCones`; `profile` (m, k)
    the points that stand for an ellipse, none for exact cones; `total` whether the space is the
    Minkowski sum of the contacts' shares; `gap` how closely bounds shall meet [longest wrenches].
    """

    centers: Floats
    axes: Floats
    profile: Floats
    total: bool
    gap: float


def wrench_rows(wrenches: ArrayLike) -> Floats:
    """Return wrenches of shape (n, m, D) or (n, D) as rows (k, D), or raise `InputError`."""
    try:
        array = np.asarray(wrenches, dtype=float)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    rows = array.reshape(-1, array.shape[-1]) if array.ndim in (2, 3) else array
    if rows.ndim == 2 and np.isfinite(rows).all():
        return rows
    came = f"got {f'shape {array.shape}' if array.ndim else ' '.join(str(wrenches).split())[:40]}"
    if rows.ndim == 2:
        came = f"row {int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])} is not finite"
    raise InputError(
        f"Expected wrenches of shape (n, m, D) or (n, D), but {came}; pass finite numbers, such as"
        " Contacts.wrenches gives."
    )


def wrench_space(
    contacts: Contacts, torque_origin: ArrayLike, torque_scale: float, options: SpaceOptions
) -> WrenchSpace:
    """Check what is left to check and lay the wrenches out."""
    if not isinstance(options.norm, str) or options.norm not in ("l1", "linf"):
        raise InputError(
            f"Expected norm to be 'l1' or 'linf', but got {options.norm!r}; use one of both."
        )
    cones = wrench_cones(
        contacts, torque_origin=torque_origin, torque_scale=torque_scale,
        contact=options.contact, patch_radius=options.patch_radius,
    )  # fmt: skip
    profile = cone_profile(contacts.dimension, options.contact, options.edges)
    tolerance = positive(options.tolerance, "tolerance")
    gap = LINEAR_GAP if len(profile) else tolerance
    return WrenchSpace(cones.centers, cones.axes, profile, options.norm == "linf", gap)
