"""The hands medkit brings along, and `load_hand`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from medkit.errors import InputError
from medkit.geometry import expected
from medkit.robots.build import hand_from_file
from medkit.robots.fields import suggestion
from medkit.robots.hand import Hand

FOLDER = Path(__file__).parent / "hands"


def hand_names() -> list[str]:
    """Names of the hands that medkit brings along.

    Returns
    -------
    list of str
        In the order of the alphabet; `load_hand` takes each of them.

    Examples
    --------
    >>> hand_names()
    ['armar3', 'armar3_left', 'schunk', 'wsg50']
    """
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def load_hand(
    name_or_path: str | os.PathLike[str], *, package_dirs: Sequence[str | os.PathLike[str]] = ()
) -> Hand:
    """Load a hand by name, or from the user's own description.

    Parameters
    ----------
    name_or_path : str or path-like
        One of `hand_names()`, or the path of a YAML description (docs/adding_a_hand.md).
    package_dirs : sequence of path-like
        Folders in which ``package://`` paths of a URDF are looked up.

    Returns
    -------
    Hand
        Kinematic tree, convex bodies, fingers, preshapes.

    Raises
    ------
    InputError
        If no hand has this name, the description cannot be used, or neither a name nor a path
        came.

    Examples
    --------
    >>> hand = load_hand("armar3")
    >>> len(hand.joint_names), [finger.name for finger in hand.fingers]
    (11, ['thumb', 'index', 'middle', 'ring', 'pinky'])
    """
    known = ", ".join(hand_names())
    remedy = f"name one of {known}, or the path of a YAML description"
    what = "the name or the path of a hand"
    expected(name_or_path, (str, os.PathLike), what, remedy)
    text = os.fspath(name_or_path)
    if text in hand_names():
        return _builtin(text)
    path = Path(text)
    if path.suffix.lower() in (".yaml", ".yml") or path.is_file():
        if path.suffix.lower() in (".urdf", ".xml"):
            raise InputError(
                f"Expected a YAML description, but got {path.name}; write a short one that names"
                " this file under 'urdf' (docs/adding_a_hand.md)."
            )
        return hand_from_file(path, [Path(folder) for folder in package_dirs])
    raise InputError(
        f"Expected one of the hands {known} or the path of a YAML description,"
        f" but got {text!r}; {suggestion(text, hand_names())}"
    )


def usable_hand(hand: Hand | str | os.PathLike[str]) -> Hand:
    """Return a hand as it is, or load it where its name or path came instead.

    Raises
    ------
    InputError
        If it is neither, or cannot be loaded.

    Examples
    --------
    >>> usable_hand("wsg50").name, usable_hand(load_hand("wsg50")).name
    ('wsg50', 'wsg50')
    """
    if isinstance(hand, str | os.PathLike):
        return load_hand(hand)
    remedy = f"pass load_hand(name), or just the name: {', '.join(hand_names())}"
    return expected(hand, Hand, "a hand", remedy)


@lru_cache(maxsize=8)
def _builtin(name: str) -> Hand:
    return hand_from_file(FOLDER / f"{name}.yaml")
