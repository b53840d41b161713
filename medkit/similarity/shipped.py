"""Writes ``data/human_grasps`` anew: the seeded, SIMULATED recordings that ship with medkit."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import numpy as np
import pandas as pd

from medkit.files import whole_file, write_text
from medkit.similarity.simulation import SEED, SHAPES, simulate_recordings

#: 0.1 mm; below the tracker's own noise.
DECIMALS = 4


def write_simulated(folder: str | os.PathLike[str], *, seed: int = SEED) -> list[Path]:
    """Simulate the experiment and write one compressed table per object, and ``objects.csv``.

    Parameters
    ----------
    folder : path-like
        An existing folder.
    seed : int
        Seed of the generator; the shipped tables use `medkit.similarity.simulation.SEED`.

    Returns
    -------
    list of pathlib.Path
        The files written: ``simulated_<object>.csv.gz`` and ``objects.csv``.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    table = simulate_recordings(rng=np.random.default_rng(seed))
    written = []
    for name, rows in table.groupby("object", sort=True):
        target = Path(folder) / f"simulated_{name}.csv.gz"
        text = rows.assign(simulated=1).to_csv(index=False, float_format=f"%.{DECIMALS}f")
        with whole_file(target) as draft:
            draft.write_bytes(gzip.compress(text.encode(), compresslevel=9, mtime=0))
        written.append(target)
    objects = pd.DataFrame(
        [(shape.name, shape.kind, *shape.extents) for shape in SHAPES],
        columns=["object", "shape", "extent_x", "extent_y", "extent_z"],
    )
    target = Path(folder) / "objects.csv"
    write_text(target, objects.to_csv(index=False))
    return [*written, target]
