"""From a file to a triangle mesh in metres."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from medkit.errors import InputError
from medkit.geometry import positive

READABLE = (".stl", ".obj", ".off", ".ply", ".glb", ".gltf", ".3mf", ".dae")
#: What trimesh reads only together with another package, which medkit does not ask for.
NEEDED = {".3mf": "lxml", ".dae": "pycollada"}
LARGEST_OBJECT = 3.0  # [m] longest edge that anybody plans a one-handed grasp for
SMALLEST_OBJECT = 0.002  # [m]
HAND_SIZED = 0.15  # [m] what a wrong unit is guessed against
UNITS = {0.001: "millimetres", 0.01: "centimetres", 0.0254: "inches"}


def load_mesh(path: str | os.PathLike[str], *, scale: float = 1.0) -> trimesh.Trimesh:
    """Read a triangle mesh from a file, as it is, and scale it to metres.

    Parameters
    ----------
    path : path-like
        STL, OBJ, OFF, PLY, GLB or glTF file; 3MF with the package lxml, DAE with pycollada.
        Several geometries in one file are joined.
    scale : float
        Metres per unit of the file [m], for example 0.001 for millimetres.

    Returns
    -------
    trimesh.Trimesh
        Vertices [m] and faces. Nothing is repaired yet: see `medkit.meshes.repair_mesh`.

    Raises
    ------
    InputError
        If the file is missing, cannot be read as a mesh, holds no triangle, or holds a number
        that is not finite, or if `scale` is not positive.
    """
    positive(scale, "scale")
    file = Path(path)
    if not file.exists():
        raise InputError(f"Expected a mesh file, but {file} does not exist; check the path.")
    if file.is_dir():
        raise InputError(f"Expected a mesh file, but {file} is a folder; name one file in it.")
    if file.suffix.lower() not in READABLE:
        raise InputError(
            f"Expected a mesh file ({', '.join(READABLE)}), but got {file.name};"
            " convert it to one of these formats."
        )
    _refuse_cut_off_stl(file)
    vertices, faces = _read(file)
    if len(faces) == 0:
        raise InputError(
            f"Expected at least one triangle in {file.name}, but it holds none;"
            " export the surface as triangles."
        )
    if not np.all(np.isfinite(vertices)):
        bad = int(np.count_nonzero(~np.isfinite(vertices).all(axis=1)))
        raise InputError(
            f"Expected finite vertex coordinates in {file.name}, but {bad} of {len(vertices)}"
            " vertices hold NaN or infinity; export the mesh again."
        )
    # merges the corners that an STL file repeats for every triangle
    return trimesh.Trimesh(vertices * scale, faces, process=True)


def refuse_wrong_scale(mesh: trimesh.Trimesh, *, scale: float = 1.0) -> None:
    """Refuse an object that no hand could mean: it is in other units than metres.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The object [m].
    scale : float
        The scale that it was loaded with, so that the remedy can name a better one.

    Raises
    ------
    InputError
        If the longest edge of the bounding box is above 3 m or below 2 mm.
    """
    longest = float(np.ptp(used_part(mesh)[0], axis=0).max())
    if SMALLEST_OBJECT <= longest <= LARGEST_OBJECT:
        return
    raw = longest / scale
    if longest > LARGEST_OBJECT:
        factor, unit = min(UNITS.items(), key=lambda item: abs(np.log(raw * item[0] / HAND_SIZED)))
        guess = f"--scale {factor:g} (the file looks like {unit})"
        if not SMALLEST_OBJECT <= raw * factor <= LARGEST_OBJECT:
            guess = f"--scale {HAND_SIZED / raw:.2g} for an object of {HAND_SIZED:g} m"
    else:
        guess = f"--scale {HAND_SIZED / raw:.2g} for an object of {HAND_SIZED:g} m"
    raise InputError(
        f"Expected an object between {SMALLEST_OBJECT:g} and {LARGEST_OBJECT:g} m, but its longest"
        f" edge is {longest:.4g} m with scale {scale:g}; try {guess}."
    )


def used_part(mesh: trimesh.Trimesh) -> tuple[Any, Any]:
    """Return the vertices (n, 3) [m] that some face uses, and the faces (f, 3) renumbered."""
    used, faces = np.unique(np.asarray(mesh.faces, dtype=np.int64), return_inverse=True)
    return np.asarray(mesh.vertices, dtype=float)[used], faces.reshape(-1, 3)


def missing_reader(file: Path) -> str:
    """The sentence for a file whose format needs a package that is not installed.

    Examples
    --------
    >>> missing_reader(Path("hand.dae"))[:61]
    'Expected to read hand.dae, but .dae files need the package py'
    """
    ending = file.suffix.lower()
    package = NEEDED.get(ending, "that trimesh asks for")
    return (
        f"Expected to read {file.name}, but {ending} files need the package {package}, which is not"
        f" installed; run pip install {NEEDED.get(ending, 'trimesh[all]')}, or convert the mesh to"
        " STL or GLB."
    )


def _refuse_cut_off_stl(file: Path) -> None:
    """Refuse a binary STL file that is shorter than its own header says."""
    if file.suffix.lower() != ".stl":
        return
    try:
        with file.open("rb") as stream:
            head = stream.read(84)
    except OSError:  # the reader says why
        return
    # the header of a text file is text, which has no zeros
    if len(head) < 84 or b"\0" not in head:
        return
    announced, present = int.from_bytes(head[80:], "little"), (file.stat().st_size - 84) // 50
    if present < announced:
        raise InputError(
            f"Expected the {announced} triangles that the header of {file.name} announces, but the"
            f" file ends after {present}; it was cut off, so copy or export it again."
        )


def _read(file: Path) -> tuple[Any, Any]:
    try:
        # trimesh's own processing would drop vertices that are NaN without a word
        scene = trimesh.load_scene(file, process=False)
        mesh = scene.to_mesh() if scene.geometry else None
    except ImportError as error:
        raise InputError(missing_reader(file)) from error
    except Exception as error:
        # every reader of every format raises its own kinds; all mean the same to the user
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise InputError(
            f"Expected a triangle mesh in {file.name}, but it cannot be read as one ({reason});"
            " check that the file is complete and its ending is right."
        ) from error
    if not isinstance(mesh, trimesh.Trimesh):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    return np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
