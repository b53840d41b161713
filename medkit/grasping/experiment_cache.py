"""Where counts of finished objects are kept, by all that they depend on, the code included."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from medkit.files import cache_folder
from medkit.grasping.settings import Setting
from medkit.robots.digest import hand_digest
from medkit.robots.hand import Hand


def cache_file(
    mesh: trimesh.Trimesh, hand: Hand, settings: Sequence[Setting], asked: Mapping[str, Any]
) -> Path | None:
    """Where the counts of one object are kept, or None where no cache can be written."""
    digest = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(hand_digest(hand).encode())
    digest.update(json.dumps([[asdict(s) for s in settings], dict(asked)]).encode())
    digest.update(_code_digest())
    try:
        return cache_folder("experiments") / f"{digest.hexdigest()[:24]}.json"
    except OSError:
        return None


@lru_cache(maxsize=1)
def _code_digest() -> bytes:
    """Hash of every file of code that a count can depend on, as it was when first asked for."""
    package = Path(__file__).parents[1]
    rooms = ("grasping", "medial", "quality", "robots", "meshes")
    found = [source for room in rooms for source in (package / room).rglob("*.py")]
    digest = hashlib.sha256()
    found += [package / f"{name}.py" for name in ("contacts", "wrench_cones", "geometry")]
    for source in sorted(found):
        digest.update(source.read_bytes())
    return digest.digest()


def stored(path: Path | None) -> list[dict[str, Any]] | None:
    """Counts of one object as they were kept, or None where there are none that can be read."""
    if path is None or not path.is_file():
        return None
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None  # a broken cache file is made anew
    return rows if isinstance(rows, list) else None
