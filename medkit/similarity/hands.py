"""Making human and planned grasps comparable: object sizes, and fingers that do not exist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from medkit.arguments import number_array, short
from medkit.errors import InputError
from medkit.geometry import Floats, expected
from medkit.similarity.measures import fingertip_array

#: Rows of weights over (thumb, index, middle, ring, little), one per robot finger in its order.
#: Two to four fingers: the last one stands for all human fingers that it replaces, as their mean
#: (the "virtual finger" of Arbib and Iberall).
_SHARES = {
    5: ((0,), (1,), (2,), (3,), (4,)),
    4: ((0,), (1,), (2,), (3, 4)),
    3: ((0,), (1,), (2, 3, 4)),
    2: ((0,), (1, 2, 3, 4)),
}


@dataclass(frozen=True)
class Correspondence:
    """Which human fingers each robot finger is compared with."""

    weights: Floats  # (k, 5) rows sum to one, columns thumb to little
    orders: tuple[tuple[int, ...], ...]  # orders of robot fingers that are mechanically the same

    def human(self, fingertips: ArrayLike) -> Floats:
        """Human fingertips (n, 5, 3) [m] as the k points that the robot's fingers stand for."""
        array = fingertip_array(fingertips, "human grasps")
        if array.shape[1] != 5:
            raise InputError(
                f"Expected five human fingertips, but got {array.shape[1]};"
                " pass thumb, index, middle, ring and little."
            )
        return np.asarray(np.einsum("kf,nfa->nka", self.weights, array))


def correspondence(fingers: int, *, interchangeable: bool = False) -> Correspondence:
    """Match a hand of two to five fingers with the human one.

    Parameters
    ----------
    fingers : int
        Number of the robot's fingers, in the order thumb (or first jaw), index, middle, ...
    interchangeable : bool
        Whether the two jaws of a gripper may be swapped without changing anything.

    Returns
    -------
    Correspondence
        Five: finger by finger. Four: the last against the mean of ring and little. Three: the
        last against the mean of middle, ring and little. Two: the second against the mean of all
        four fingers, which oppose the thumb as one.

    Raises
    ------
    InputError
        If the number is not between two and five.

    Examples
    --------
    >>> correspondence(2).weights
    array([[1.  , 0.  , 0.  , 0.  , 0.  ],
           [0.  , 0.25, 0.25, 0.25, 0.25]])
    """
    remedy = "say whether the jaws may be swapped"
    expected(interchangeable, (bool, np.bool_), "interchangeable as True or False", remedy)
    if not isinstance(fingers, int | np.integer) or fingers not in _SHARES:
        raise InputError(
            f"Expected a hand of two to five fingers, but got {short(fingers)};"
            " leave out fingers that take no part."
        )
    weights = np.zeros((fingers, 5))
    for row, columns in enumerate(_SHARES[fingers]):
        weights[row, list(columns)] = 1.0 / len(columns)
    same = tuple(range(fingers))
    orders = (same, same[::-1]) if interchangeable and fingers == 2 else (same,)
    return Correspondence(weights, orders)


def scaled_to_object(
    fingertips: ArrayLike, *, recorded_extents: ArrayLike, extents: ArrayLike
) -> Floats:
    """Scale human grasps to another object of the kind, about its centre of mass (P13 6.2.4).

    Parameters
    ----------
    fingertips : array-like, shape (n, 5, 3)
        Human fingertips [m], origin at the recorded object's centre of mass.
    recorded_extents, extents : array-like, shape (3,)
        Sizes of the recorded object and of the robot's [m], along the same axes.

    Returns
    -------
    ndarray, shape (n, 5, 3)
        Scaled axis by axis [m]: what touched a face touches it again.

    Raises
    ------
    InputError
        If a size is not above zero.

    Examples
    --------
    >>> scaled_to_object(np.ones((1, 5, 3)), recorded_extents=[1, 1, 1], extents=[2, 1, 3])[0, 0]
    array([2., 1., 3.])
    """
    remedy = "give both objects' extents"
    old, new = (
        number_array(size, "three sizes", remedy).reshape(-1)
        for size in (recorded_extents, extents)
    )
    if old.shape != (3,) or new.shape != (3,) or not np.all((old > 0.0) & (new > 0.0)):
        raise InputError(
            f"Expected three sizes above zero, but got {short(old.tolist())} and"
            f" {short(new.tolist())} m; {remedy}."
        )
    return fingertip_array(fingertips, "human grasps") * (new / old)
