"""The user's own folder of meshes, read one by one, so that an original benchmark can be used."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import trimesh

from medkit.arguments import file_path
from medkit.errors import InputError
from medkit.geometry import positive
from medkit.meshes import load_mesh
from medkit.meshes.loading import READABLE


def load_folder(
    path: str | os.PathLike[str], *, scale: float = 1.0
) -> Iterator[tuple[str, trimesh.Trimesh]]:
    """Read every mesh file of a folder, in the order of their names.

    Parameters
    ----------
    path : path-like
        Folder with mesh files (STL, OBJ, OFF, PLY and the like). Files of other kinds, a readme
        for example, are no meshes and are passed over; subfolders are not entered.
    scale : float
        Metres per unit of the files [m].

    Yields
    ------
    name : str
        File name without its ending.
    mesh : trimesh.Trimesh
        The mesh as it is in the file, in metres; `medkit.meshes.repair_mesh` closes it.

    Raises
    ------
    InputError
        Before the first mesh, if the folder is missing, holds no mesh, or holds two meshes of
        one name; on its turn, if a mesh file cannot be read. No mesh file is skipped.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = trimesh.creation.box((10, 20, 30)).export(pathlib.Path(folder) / "brick.stl")
    ...     [(name, float(mesh.extents.max())) for name, mesh in load_folder(folder, scale=0.01)]
    [('brick', 0.3)]
    """
    factor = positive(scale, "scale")
    files = _mesh_files(file_path(path, "a folder of meshes"))
    return ((file.stem, load_mesh(file, scale=factor)) for file in files)


def _mesh_files(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise InputError(f"Expected a folder of meshes, but {folder} is not one; check the path.")
    files = sorted(
        file for file in folder.iterdir() if file.is_file() and file.suffix.lower() in READABLE
    )
    if not files:
        raise InputError(
            f"Expected mesh files ({', '.join(READABLE)}) in {folder}, but it holds none;"
            " put at least one there."
        )
    twins = [b.name for a, b in pairwise(files) if a.stem == b.stem]
    if twins:
        raise InputError(
            f"Expected one mesh a name in {folder}, but {twins[0]} has a twin of another format;"
            " remove or rename one of them."
        )
    return files
