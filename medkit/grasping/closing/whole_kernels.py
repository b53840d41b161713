"""Compiled whole candidates: draw back, close, read the contacts, in one call from Python.

Handing the tables of hand, object and scratch over to a kernel takes some twenty microseconds,
and what several such calls have in common would be compiled for each of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from medkit.grasping.closing.chain_kernels import place_links
from medkit.grasping.closing.contact_kernels import hand_contacts
from medkit.grasping.closing.finger_kernels import close_fingers
from medkit.grasping.closing.kernel_options import entry
from medkit.grasping.closing.pad_kernels import close_pads
from medkit.grasping.closing.retreat_kernels import draw_back


@entry
def retreat(
    field: Any,
    hand: Any,
    q: np.ndarray,
    base: np.ndarray,
    approach: np.ndarray,
    limit: float,
    work: Any,
) -> float:
    """Draw the hand back until it is free of the object, see `draw_back`."""
    return draw_back(field, hand, q, base, approach, limit, work)


@entry
def power_grasp(
    field: Any,
    hand: Any,
    q: np.ndarray,
    base: np.ndarray,
    approach: np.ndarray,
    limit: float,
    stops: np.ndarray,
    reading: Any,
    work: Any,
) -> tuple[float, int]:
    """Draw back, close the fingers, read the contacts; the way [m], -1 if never free, and how many.

    `base`, `q` and `stops` are changed in place; the contacts are in ``reading.contacts``.
    """
    way = draw_back(field, hand, q, base, approach, limit, work)
    if way < 0.0:
        return way, 0
    close_fingers(field, hand, base, q, stops, work)
    return way, hand_contacts(field, hand, reading, work)


@entry
def precision_grasp(
    field: Any,
    hand: Any,
    grip: Any,
    follow: np.ndarray,
    base: np.ndarray,
    q: np.ndarray,
    amounts: np.ndarray,
    touched: np.ndarray,
    reading: Any,
    work: Any,
) -> int:
    """Close the pads, see `close_pads`, and read the contacts; how many, -1 if the start hits."""
    slack = work.slack
    if not close_pads(field, hand, grip, follow, base, q, amounts, touched, slack, work):
        return -1
    return hand_contacts(field, hand, reading, work)


@entry
def contacts_at(
    field: Any, hand: Any, q: np.ndarray, base: np.ndarray, reading: Any, work: Any
) -> int:
    """Contacts of the hand at `q` with its base at `base`, wherever that is; how many."""
    place_links(hand, q, base, work)
    for body in range(hand.body_link.shape[0]):
        work.slack[body] = 0.0  # nothing is known of where this is
    return hand_contacts(field, hand, reading, work)
