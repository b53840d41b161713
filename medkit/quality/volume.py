"""Volume of the grasp wrench space, through Qhull."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from medkit.contacts import Contacts


def volume(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    friction: ArrayLike,
    torque_origin: ArrayLike,
    torque_scale: float,
    **cones: Any,
) -> float:
    """Volume of the hull of the primitive wrenches (L1, linearised cones).

    Unlike epsilon it does not tell whether the origin lies inside. The whole hull is built: the
    time grows steeply with the number of contacts.

    Parameters
    ----------
    points, normals, friction, torque_origin, torque_scale
        As in `medkit.quality.epsilon`.
    **cones
        `edges`, `contact` and `patch_radius`, as there.

    Returns
    -------
    float
        Volume in the six (planar: three) coordinates of ``[force, torque / torque_scale]``
        [N^6 or N^3]; 0.0 when the wrenches do not span the space.

    Raises
    ------
    InputError
        For arguments out of their range, and for ``edges=None``: round cones have no hull of
        finitely many wrenches.

    Examples
    --------
    >>> round(volume([[-1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]],
    ...              friction=1.0, torque_origin=[0.0, 0.0], torque_scale=1.0), 6)
    2.666667
    """
    wrenches = Contacts(points, normals, friction).wrenches(
        torque_origin=torque_origin, torque_scale=torque_scale, **cones
    )
    rows = wrenches.reshape(-1, wrenches.shape[-1])
    dimension = rows.shape[1]
    if len(rows) <= dimension:
        return 0.0
    spread = rows - rows.mean(axis=0)
    if np.linalg.matrix_rank(spread, tol=1e-9 * np.abs(rows).max()) < dimension:
        return 0.0
    return float(ConvexHull(rows).volume)
