"""Reading a hand description: every mistake in the file becomes one clear sentence."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from medkit.errors import InputError
from medkit.geometry import Floats

LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
ANGLE_UNITS = {"rad": 1.0, "deg": float(np.pi / 180.0)}


def suggestion(name: object, known: Iterable[str]) -> str:
    """Return the tail of an error message: the nearest known name, or all of them."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names) or 'none'}."


class _UniqueKeys(yaml.SafeLoader):
    """YAML in which a key that is given twice is an error; plain YAML forgets the first."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]  # type: ignore[no-untyped-call]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key!r} is given twice", node.start_mark
                )
        return super().construct_mapping(node, deep=deep)


class Fields:
    """One section of a description file, with the units of its numbers and its place for errors.

    Parameters
    ----------
    content : object
        What the YAML holds at this place; has to be a mapping.
    place : str
        File and section, as errors name them.
    length, angle : float
        Metres per unit of length and radians per unit of angle.
    """

    def __init__(self, content: object, place: str, length: float = 1.0, angle: float = 1.0):
        if not isinstance(content, Mapping):
            raise InputError(
                f"Expected 'key: value' lines in {place}, but got {content!r}; see"
                " docs/adding_a_hand.md for the layout."
            )
        self.content = content
        self.place = place
        self.length = length
        self.angle = angle

    def allow(self, *keys: str) -> Fields:
        """Check that no other key than `keys` is present, and return self."""
        for key in self.content:
            if key not in keys:
                raise InputError(f"Unexpected key {key!r} in {self.place}; {suggestion(key, keys)}")
        return self

    def has(self, key: str) -> bool:
        """Whether the key is given."""
        return self.content.get(key) is not None

    def get(self, key: str) -> Any:
        """Return the value of a key that has to be there."""
        if not self.has(key):
            raise InputError(
                f"Expected the key {key!r} in {self.place}, but it is missing; add it."
            )
        return self.content[key]

    def section(self, key: str) -> Fields:
        """Return the mapping under `key` as a section; empty when it is left out."""
        content = self.content.get(key)
        return self.inside({} if content is None else content, key)

    def sections(self, key: str) -> list[Fields]:
        """Return the mappings in the list under `key`."""
        content = self.get(key)
        if not isinstance(content, list) or not content:
            raise InputError(
                f"Expected a list of '- ...' entries under {key!r} in {self.place}, but got"
                f" {content!r}; give at least one."
            )
        return [self.inside(item, f"{key}[{k}]") for k, item in enumerate(content)]

    def inside(self, content: object, key: str) -> Fields:
        """Return `content` as a section called `key` of this one, with the same units."""
        return Fields(content, f"{self.place}, {key}", self.length, self.angle)

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; `default` when the key is left out and a default is given."""
        if default is not None and not self.has(key):
            return default
        value = self.get(key)
        if not isinstance(value, str) or not value.strip():
            raise InputError(f"Expected text for {key!r} in {self.place}, but got {value!r}.")
        return value.strip()

    def names(self, key: str) -> list[str]:
        """Return a list of names."""
        value = self.get(key)
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise InputError(
                f"Expected a list of names for {key!r} in {self.place}, but got {value!r};"
                " write it as [first, second]."
            )
        return value

    def number(self, key: str, default: float | None = None, scale: float = 1.0) -> float:
        """Return one finite number, times `scale`."""
        if default is not None and not self.has(key):
            return default
        return float(self._numbers(key, ())) * scale

    def vector(self, key: str, scale: float = 1.0, default: Any = None) -> Floats:
        """Return three finite numbers, times `scale`."""
        if default is not None and not self.has(key):
            return np.asarray(default, dtype=float)
        return self._numbers(key, (3,)) * scale

    def pair(self, key: str) -> Floats:
        """Return two finite numbers, the first not above the second."""
        low, high = self._numbers(key, (2,))
        if low > high:
            raise InputError(
                f"Expected {key!r} in {self.place} as [lower, upper], but got {low:g} above"
                f" {high:g}; swap them."
            )
        return np.array([low, high])

    def unit_vector(self, key: str) -> Floats:
        """Return three numbers of length one, exactly so."""
        vector = self._numbers(key, (3,))
        length = float(np.linalg.norm(vector))
        if abs(length - 1.0) > 1e-3:
            advice = (
                "give a direction"
                if length == 0.0
                else f"write {(vector / length).round(6).tolist()}"
            )
            raise InputError(
                f"Expected a vector of length 1 for {key!r} in {self.place}, but got"
                f" {vector.tolist()} of length {length:.4g}; {advice}."
            )
        return vector / length

    def _numbers(self, key: str, shape: tuple[int, ...]) -> Floats:
        value = self.get(key)
        wanted = f"{shape[0]} numbers" if shape else "a number"
        try:
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            array = np.full((1, 1, 1), np.nan)
        if array.shape != shape or not np.all(np.isfinite(array)) or isinstance(value, bool):
            raise InputError(f"Expected {wanted} for {key!r} in {self.place}, but got {value!r}.")
        return array


def read_fields(path: Path) -> Fields:
    """Read a YAML file as `Fields`, its units section applied.

    Raises
    ------
    InputError
        If the file cannot be read, is not YAML, or names an unknown unit.
    """
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), Loader=_UniqueKeys)
    except OSError as error:
        raise InputError(
            f"Expected a hand description at {path}, but reading failed ({error.strerror});"
            " check the path."
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"Expected YAML in {path}, but parsing failed: {reason}.") from error
    document = Fields(content, path.name)
    units = document.section("units").allow("length", "angle")
    scale = {}
    for key, known, default in (("length", LENGTH_UNITS, "m"), ("angle", ANGLE_UNITS, "rad")):
        name = units.text(key, default)
        if name not in known:
            raise InputError(f"Unknown unit {name!r} in {units.place}; {suggestion(name, known)}")
        scale[key] = known[name]
    return Fields(content, path.name, scale["length"], scale["angle"])
