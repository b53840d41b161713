"""A fingerprint of a hand: what is stored for one hand must not be taken for another's."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from medkit.robots.hand import Hand


def hand_digest(hand: Hand) -> str:
    """Hash of everything in a hand that a grasp can depend on.

    Parameters
    ----------
    hand : Hand
        The hand.

    Returns
    -------
    str
        24 hexadecimal digits; the text that says where the numbers come from does not count.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from medkit.robots import load_hand
    >>> hand = load_hand("wsg50")
    >>> turned = replace(hand, closing_axis=-hand.closing_axis)
    >>> [hand_digest(one) == hand_digest(hand) for one in (load_hand("wsg50"), turned)]
    [True, False]
    """
    digest = hashlib.sha256()
    for piece in _pieces(
        {one.name: getattr(hand, one.name) for one in fields(hand)} | {"source": ""}
    ):
        digest.update(piece)
    return digest.hexdigest()[:24]


def _pieces(value: Any) -> Iterator[bytes]:
    """Bytes that differ when anything in a nest of dataclasses, tuples and arrays does."""
    if is_dataclass(value):
        value = {one.name: getattr(value, one.name) for one in fields(value)}
    if isinstance(value, Mapping):
        for key in sorted(value):
            yield repr(key).encode()
            yield from _pieces(value[key])
    elif isinstance(value, tuple | list):
        yield str(len(value)).encode()
        for one in value:
            yield from _pieces(one)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    else:
        yield repr(value).encode()
