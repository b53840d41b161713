"""What a planner needs of a mesh: one closed body with outward normals, or a clear refusal.

The generalised winding number of the surface decides: one inside, zero outside, and anything else
names a defect. Repairs keep the triangles where they can (cleaning, turning, closing small holes,
uniting bodies) and remesh only where they cannot.
"""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
import trimesh

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.meshes.loading import used_part
from medkit.meshes.mends import united, with_fans
from medkit.meshes.remesh import remesh_by_winding_number
from medkit.meshes.surfaces import (
    Ints,
    Surface,
    edge_defects,
    enclosed,
    face_areas,
    shell_of_faces,
    shell_volumes,
    signed_volume,
    wrong_side_share,
)

MERGE_DISTANCE = 1e-7  # share of the diagonal under which two vertices are one
FLAT_VOLUME = 1e-6  # share of diagonal^3 under which a surface encloses nothing
CRUMB_VOLUME = 1e-3  # share of the whole volume under which a separate body is dropped
SMALL_HOLES = 0.05  # share of the area that a hole's lid may have
OPEN_VIEW = 0.10  # share of the area that may see a wrong winding number through holes
SELF_OVERLAP = 0.005  # share of the area above which a closed surface is remeshed


@dataclass(frozen=True)
class RepairedMesh:
    """A closed, outward-oriented body, and what was done to get it (empty: nothing)."""

    mesh: trimesh.Trimesh
    repairs: tuple[str, ...]


@dataclass(frozen=True)
class MassProperties:
    """Centre of mass (3,) [m], volume [m^3], and the farthest surface point's distance [m]."""

    center_mass: Floats
    volume: float
    torque_scale: float


def mass_properties(mesh: trimesh.Trimesh) -> MassProperties:
    """Centre of mass, volume and torque scale of a closed body of uniform density.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m], as `repair_mesh` returns it.

    Returns
    -------
    MassProperties
        `torque_scale` is the length by which torques are divided (P13 4.6.2).

    Examples
    --------
    >>> float(mass_properties(trimesh.creation.box((2.0, 2.0, 2.0))).torque_scale.round(3))
    1.732
    """
    center = np.asarray(mesh.center_mass, dtype=float)
    scale = np.linalg.norm(mesh.vertices - center, axis=1).max()
    return MassProperties(center, float(mesh.volume), scale)


def repair_mesh(mesh: trimesh.Trimesh) -> RepairedMesh:
    """Return the mesh as one closed body with outward normals, repaired where that is safe.

    Duplicate vertices and faces and degenerate faces go; orientation is made consistent and
    outward; small holes are closed; overlapping bodies are united; a surface that overlaps
    itself is remeshed by its winding number; crumbs are dropped. A cavity stays.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Any triangle mesh [any unit]; it is not changed.

    Returns
    -------
    RepairedMesh
        The body and a tuple of sentences, one per repair.

    Raises
    ------
    InputError
        If the surface is empty, encloses no volume, is open beyond small holes, or falls into
        several separate bodies.
    """
    if len(mesh.faces) == 0:
        raise InputError("Expected at least one triangle, but the mesh is empty; check the file.")
    vertices, faces = used_part(mesh)
    if not np.all(np.isfinite(vertices)):
        raise InputError(
            "Expected finite vertex coordinates, but the mesh holds NaN or infinity;"
            " export it again."
        )
    middle = vertices.mean(axis=0)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if diagonal == 0.0:
        raise InputError(
            "Expected a closed body, but all vertices coincide (zero volume); check the file."
        )
    repairs: list[str] = []
    # everything is decided at unit size about the origin, so that no tolerance knows a unit
    surface = _clean(np.ascontiguousarray((vertices - middle) / diagonal), faces, repairs)
    surface = _oriented(surface, repairs)
    surface = _closed(surface, repairs)
    surface = _one_body(surface, repairs)
    surface = _without_self_overlap(surface, repairs)
    if signed_volume(surface) < FLAT_VOLUME:
        raise _flat(signed_volume(surface))
    body = trimesh.Trimesh(surface[0] * diagonal + middle, surface[1], process=False)
    return RepairedMesh(body, tuple(repairs))


def _clean(vertices: Floats, faces: Ints, repairs: list[str]) -> Surface:
    """Merge equal vertices; drop degenerate and duplicate faces and loose vertices."""
    cell = np.round(vertices / MERGE_DISTANCE).astype(np.int64)
    _, first, label = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    faces = label.reshape(-1)[faces]
    vertices = vertices[first]
    area = face_areas((vertices, faces))
    collapsed = (
        (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    )
    if collapsed.any():
        repairs.append(f"dropped {int(collapsed.sum())} degenerate faces")
    faces, area = faces[~collapsed], area[~collapsed]
    _, kept = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    if len(kept) < len(faces):
        repairs.append(f"dropped {len(faces) - len(kept)} duplicate faces")
    faces = faces[np.sort(kept)]
    if len(faces) == 0 or area.max(initial=0.0) == 0.0:
        raise _flat(0.0)
    used, compact = np.unique(faces, return_inverse=True)
    return np.ascontiguousarray(vertices[used]), np.ascontiguousarray(compact.reshape(-1, 3))


def _oriented(surface: Surface, repairs: list[str]) -> Surface:
    """Turn neighbouring faces the same way round, and the outermost shells outwards."""
    vertices, faces = surface
    turned, _ = igl.bfs_orient(faces)
    turned = np.ascontiguousarray(turned.astype(np.int64))
    shells = shell_of_faces(turned)
    turned_volumes = shell_volumes((vertices, turned), shells)
    original_volumes = shell_volumes(surface, shells)
    inconsistent = 0
    inverted = 0
    for k, (volume, original) in enumerate(zip(turned_volumes, original_volumes, strict=True)):
        mine = shells == k
        changed = int(np.count_nonzero((turned[mine] != faces[mine]).any(axis=1)))
        minority = min(changed, int(mine.sum()) - changed)
        inconsistent += minority
        cavity = minority == 0 and original < 0.0 and enclosed(vertices, turned, shells, k)
        if (volume < 0.0) != cavity:
            turned[mine] = turned[mine][:, ::-1]
        inverted += int(minority == 0 and original < 0.0 and not cavity)
    if inconsistent:
        repairs.append(f"turned {inconsistent} faces that were the wrong way round")
    if inverted:
        repairs.append("turned the surface outwards (it was inside-out)")
    return vertices, turned


def _closed(surface: Surface, repairs: list[str]) -> Surface:
    """Close small holes by fans; hand what is not manifold to the remesher; refuse the rest."""
    faces = surface[1]
    border, crowded = edge_defects(faces)
    if border == 0 and crowded == 0:
        return surface
    filled = with_fans(surface)
    lids = float(face_areas((filled[0], filled[1][len(faces) :])).sum() / face_areas(surface).sum())
    wrong = wrong_side_share(surface)
    if lids > SMALL_HOLES or wrong > OPEN_VIEW:
        if abs(signed_volume(surface)) < FLAT_VOLUME:
            raise _flat(abs(signed_volume(surface)))
        raise InputError(
            f"Expected a closed surface, but this one is open: {border} edges have a face on one"
            f" side only, the lids they need make {100 * lids:.0f} % of its area, and"
            f" {100 * wrong:.0f} % of it lacks a clear inside;"
            " close or thicken it in a mesh editor."
        )
    if edge_defects(filled[1]) == (0, 0):
        repairs.append(f"closed small holes with {len(filled[1]) - len(faces)} faces")
        return filled
    repairs.append(
        f"remeshed by winding number ({border} open edges, {crowded} edges with over two faces)"
    )
    return _remeshed(surface)


def _one_body(surface: Surface, repairs: list[str]) -> Surface:
    """Unite overlapping bodies, swallow shells inside others, drop crumbs, refuse the rest."""
    shells = shell_of_faces(surface[1])
    count = int(shells.max()) + 1
    if count == 1:
        return surface
    cavities = shell_volumes(surface, shells) < 0.0
    if np.count_nonzero(~cavities) > 1:
        surface = united(surface, shells, cavities.tolist())
        left = int(shell_of_faces(surface[1]).max()) + 1
        if left < count:
            repairs.append(f"united {count} overlapping or nested shells into {left}")
    surface = _without_crumbs(surface, repairs)
    volumes = shell_volumes(surface, shell_of_faces(surface[1]))
    bodies = int(np.count_nonzero(volumes > 0.0))
    if bodies > 1:
        raise InputError(
            f"Expected one body, but the mesh falls into {bodies} separate ones; keep the one you"
            " mean, or join them in a mesh editor."
        )
    return surface


def _without_self_overlap(surface: Surface, repairs: list[str]) -> Surface:
    share = wrong_side_share(surface)
    if share <= SELF_OVERLAP:
        return surface
    repairs.append(f"remeshed {100 * share:.1f} % self-intersecting area by winding number")
    return _without_crumbs(_remeshed(surface), repairs)


def _remeshed(surface: Surface) -> Surface:
    vertices, faces = remesh_by_winding_number(*surface)
    if len(faces) == 0:
        raise _flat(0.0)
    return vertices, faces


def _without_crumbs(surface: Surface, repairs: list[str]) -> Surface:
    vertices, faces = surface
    shells = shell_of_faces(faces)
    volumes = np.abs(shell_volumes(surface, shells))
    crumbs = np.flatnonzero(volumes < CRUMB_VOLUME * volumes.max())
    if len(crumbs) == 0:
        return surface
    repairs.append(f"dropped {len(crumbs)} crumbs of less than 0.1 % of the volume")
    faces = faces[~np.isin(shells, crumbs)]
    used, compact = np.unique(faces, return_inverse=True)
    return np.ascontiguousarray(vertices[used]), np.ascontiguousarray(compact.reshape(-1, 3))


def _flat(volume: float) -> InputError:
    return InputError(
        f"Expected a closed body, but the surface encloses zero volume ({volume:.1g} of its"
        " diagonal cubed); give it thickness in a mesh editor."
    )
