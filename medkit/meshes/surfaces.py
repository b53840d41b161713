"""What a triangle surface is made of: shells, borders, areas, and where its inside fails."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats

Ints = NDArray[np.int64]
#: Vertices, shape (n, 3), and triangles, shape (m, 3).
Surface = tuple[Floats, Ints]

WRONG_SIDE = 0.3  # how far the winding number may be from 1 inside and 0 outside


def border_loops(faces: Ints) -> list[Ints]:
    """Closed loops of border edges, each running the way of its only face."""
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    base = int(faces.max()) + 1
    border = edges[~np.isin(edges[:, 0] * base + edges[:, 1], edges[:, 1] * base + edges[:, 0])]
    onward: dict[int, list[int]] = {}
    for start, end in border.tolist():
        onward.setdefault(start, []).append(end)
    loops = []
    while onward:
        ring = [next(iter(onward))]
        # as many border edges leave a vertex as arrive, so the walk ends where it began
        while ring[-1] in onward:
            ends = onward[ring[-1]]
            ring.append(ends.pop())
            if not ends:
                del onward[ring[-2]]
        loops.append(np.asarray(ring[:-1], dtype=np.int64))
    return loops


def shell_of_faces(faces: Ints) -> Ints:
    """Label (m,) of the connected shell each triangle belongs to."""
    return np.asarray(igl.facet_components(faces)[1], dtype=np.int64)


def enclosed(vertices: Floats, faces: Ints, shells: Ints, k: int) -> bool:
    """Whether shell `k` lies inside some other shell."""
    others = np.ascontiguousarray(faces[shells != k])
    if len(others) == 0:
        return False
    probe = np.ascontiguousarray(vertices[faces[shells == k][0]].mean(axis=0, keepdims=True))
    return bool(abs(igl.fast_winding_number(vertices, others, probe)[0]) > 0.5)


def edge_defects(faces: Ints) -> tuple[int, int]:
    """Count the edges with one face, and those with more than two."""
    edges = np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    keys = edges[:, 0] * (int(faces.max()) + 1) + edges[:, 1]
    _, count = np.unique(keys, return_counts=True)
    return int((count == 1).sum()), int((count > 2).sum())


def wrong_side_share(surface: Surface, most: int = 20_000) -> float:
    """Share of the area whose winding number is not one inside and zero outside."""
    vertices, faces = surface
    if len(faces) > most:
        chosen = np.linspace(0, len(faces) - 1, most).astype(np.int64)
    else:
        chosen = np.arange(len(faces))
    corners = vertices[faces[chosen]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    sound = doubled > 0.0
    corners, normals, doubled = corners[sound], normals[sound], doubled[sound]
    offset = 1e-4 * normals / doubled[:, None]
    middle = corners.mean(axis=1)
    inside = igl.fast_winding_number(vertices, faces, np.ascontiguousarray(middle - offset))
    outside = igl.fast_winding_number(vertices, faces, np.ascontiguousarray(middle + offset))
    wrong = (np.abs(inside - 1.0) > WRONG_SIDE) | (np.abs(outside) > WRONG_SIDE)
    return float(doubled[wrong].sum() / doubled.sum())


def face_areas(surface: Surface) -> Floats:
    """Area (m,) of each triangle, in the vertices' unit squared."""
    corners = surface[0][surface[1]]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(sides, axis=1))


def shell_volumes(surface: Surface, shells: Ints) -> Floats:
    """Volume that each shell encloses, by its label; negative when its normals point inwards."""
    vertices, faces = surface
    _, first = np.unique(shells, return_index=True)
    # measured from a vertex of the shell's own, so that far shells keep their digits
    corners = vertices[faces] - vertices[faces[first[shells], 0]][:, None]
    parts = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return np.asarray(np.bincount(shells, weights=parts, minlength=len(first)) / 6.0)


def signed_volume(surface: Surface) -> float:
    """Volume that the surface encloses, negative when its normals point inwards."""
    return float(shell_volumes(surface, np.zeros(len(surface[1]), dtype=np.int64))[0])
