"""What planners can use: a mesh that encloses a volume, in metres, with outward normals."""

from __future__ import annotations

import re

import numpy as np
import trimesh

from medkit.errors import InputError
from medkit.geometry import expected
from medkit.meshes.loading import refuse_wrong_scale, used_part
from medkit.meshes.repair import FLAT_VOLUME
from medkit.meshes.surfaces import signed_volume


def refuse_unusable(mesh: trimesh.Trimesh) -> None:
    """Refuse a mesh that planners could not use.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The object [m]; it need not be watertight.

    Raises
    ------
    InputError
        If it is no triangle mesh, has no triangle or coordinates that are not finite, is not in
        metres by its size (`refuse_wrong_scale`), or is flat or inside-out (`refuse_flat`); the
        sentence says what to do.

    Examples
    --------
    >>> refuse_unusable(trimesh.creation.box((0.1, 0.1, 0.1)))
    >>> refuse_unusable(trimesh.Trimesh())
    Traceback (most recent call last):
        ...
    medkit.errors.InputError: Expected a closed body, but the mesh holds no triangle; check the \
file, then plan on medkit.meshes.repair_mesh(mesh).mesh.
    """
    remedy = (
        "read one with medkit.meshes.load_mesh(path), or take .mesh of what repair_mesh returns"
    )
    expected(mesh, trimesh.Trimesh, "a triangle mesh", remedy)
    if len(mesh.faces) == 0:
        raise InputError(
            "Expected a closed body, but the mesh holds no triangle; check the file, then plan on"
            " medkit.meshes.repair_mesh(mesh).mesh."
        )
    corners = np.asarray(mesh.vertices, dtype=float)[np.asarray(mesh.faces)]
    if not np.all(np.isfinite(corners)):
        raise InputError(
            "Expected finite vertex coordinates, but the mesh holds NaN or infinity;"
            " export it again."
        )
    refuse_flat(mesh)
    try:
        refuse_wrong_scale(mesh)
    except InputError as error:  # its remedy is an option of the command line
        advice = re.sub(r"--scale (\S+)", r"load_mesh(path, scale=\1)", str(error))
        raise InputError(advice) from None


def refuse_flat(mesh: trimesh.Trimesh) -> None:
    """Refuse a mesh of no volume, judged as `repair_mesh` does, or with inward normals.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Vertices [m] and faces; those that no face uses do not count.

    Raises
    ------
    InputError
        If the signed volume is less than `FLAT_VOLUME` times the cube of the bounding box's
        diagonal: a flat or open mesh, or one that is turned inside-out.

    Examples
    --------
    >>> box = trimesh.creation.box((0.1, 0.1, 0.1))
    >>> refuse_flat(box)
    >>> _ = box.invert()
    >>> refuse_flat(box)
    Traceback (most recent call last):
        ...
    medkit.errors.InputError: Expected a closed body with outward normals, but the mesh is \
inside-out; plan on medkit.meshes.repair_mesh(mesh).mesh.
    """
    surface = used_part(mesh)
    least = FLAT_VOLUME * float(np.linalg.norm(np.ptp(surface[0], axis=0))) ** 3
    volume = signed_volume(surface)
    if volume >= least > 0.0:
        return
    fault = "is inside-out" if volume <= -least < 0.0 else "encloses no volume"
    raise InputError(
        f"Expected a closed body with outward normals, but the mesh {fault};"
        " plan on medkit.meshes.repair_mesh(mesh).mesh."
    )
