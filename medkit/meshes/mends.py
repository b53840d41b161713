"""Mends that add to a surface: lids for its holes, and the union of its bodies."""

from __future__ import annotations

import numpy as np

from medkit.meshes.surfaces import Ints, Surface, border_loops


def with_fans(surface: Surface) -> Surface:
    """Close every border loop by a fan around its centroid."""
    vertices, faces = surface
    new_vertices, new_faces = [vertices], [faces]
    count = len(vertices)
    for ring in border_loops(faces):
        new_vertices.append(vertices[ring].mean(axis=0, keepdims=True))
        # a border edge runs with its only face; the new face must run against it
        new_faces.append(np.column_stack([np.roll(ring, -1), ring, np.full(len(ring), count)]))
        count += 1
    return (
        np.ascontiguousarray(np.vstack(new_vertices)),
        np.ascontiguousarray(np.vstack(new_faces).astype(np.int64)),
    )


def united(surface: Surface, shells: Ints, cavities: list[bool]) -> Surface:
    """Boolean union of all solids, minus the cavities."""
    import manifold3d

    def solid(k: int) -> manifold3d.Manifold:
        vertices, faces = surface[0], surface[1][shells == k]
        if cavities[k]:
            faces = faces[:, ::-1]
        used, compact = np.unique(faces, return_inverse=True)
        return manifold3d.Manifold(
            manifold3d.Mesh64(
                vert_properties=np.ascontiguousarray(vertices[used]),
                tri_verts=np.ascontiguousarray(compact.reshape(-1, 3).astype(np.uint64)),
            )
        )

    parts = [solid(k) for k in range(len(cavities))]
    whole = manifold3d.Manifold.batch_boolean(
        [part for part, cavity in zip(parts, cavities, strict=True) if not cavity],
        manifold3d.OpType.Add,
    )
    for part, cavity in zip(parts, cavities, strict=True):
        if cavity:
            whole = whole - part
    result = whole.to_mesh64()
    vertices = np.ascontiguousarray(np.asarray(result.vert_properties)[:, :3], dtype=float)
    faces = np.ascontiguousarray(np.asarray(result.tri_verts).astype(np.int64))
    return (vertices, faces) if len(faces) else surface
