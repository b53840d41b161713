"""Recipes for everyday objects: mug, bottle, hammer, salt box, cereal box.

Each recipe returns parts in metres; `medkit.datasets.objects` scales them to their stated size.
"""

from __future__ import annotations

import numpy as np
import trimesh

from medkit.datasets.implicit import Part, box, chain, lathe, mesh_of, profile_through


def mug() -> trimesh.Trimesh:
    """Mug with a handle: hollow, wall 4 mm, 9.5 cm high."""
    outside = [(0.0, 0.0), (0.018, 0.0), (0.036, 0.0), (0.039, 0.003), (0.041, 0.012)]
    rim = [(0.041, 0.0935), (0.0403, 0.0948), (0.039, 0.0953), (0.0377, 0.0948), (0.037, 0.0935)]
    inside = [(0.037, 0.014), (0.034, 0.008), (0.017, 0.006), (0.0, 0.006)]
    wall = _between(outside[-1], rim[0], 16) + rim + _between(rim[-1], inside[0], 16)
    cup = trimesh.creation.revolve(np.asarray(outside + wall + inside), sections=96)
    bow = [
        (0.0430, 0.0, 0.081), (0.055, 0.0, 0.085), (0.068, 0.0, 0.074), (0.071, 0.0, 0.055),
        (0.064, 0.0, 0.034), (0.050, 0.0, 0.023), (0.0430, 0.0, 0.021),
    ]  # fmt: skip
    handle = [chain(bow, 0.0048, flatten=1.35)]
    ring = mesh_of(handle, longest=0.0736, triangles=4500)
    low = handle[0].low
    ring.apply_translation(-ring.bounds[0] + [low[0], low[1], low[2]])
    return _united(cup, ring)


def bottle() -> trimesh.Trimesh:
    """Closed bottle with a shoulder, a neck and a screw cap, 26 cm high."""
    body = [
        (0.0, 0.033), (0.004, 0.0365), (0.15, 0.0365), (0.165, 0.036), (0.190, 0.029),
        (0.212, 0.0165), (0.225, 0.0135), (0.237, 0.0135),
    ]  # fmt: skip
    cap = [(0.0150, 0.238), (0.0155, 0.239), (0.0155, 0.249), (0.0155, 0.259), (0.0145, 0.260)]
    profile = [*profile_through(body)[:-1], *cap, (0.007, 0.260), (0.0, 0.260)]
    return trimesh.creation.revolve(np.asarray(profile), sections=96)


def hammer() -> list[Part]:
    """Claw hammer, 30 cm long: an oval handle, a square face, a bent claw."""
    handle = chain(
        [(0, 0, 0.0), (0, 0, 0.05), (0, 0, 0.11), (0, 0, 0.20), (0, 0, 0.285)],
        [0.0150, 0.0165, 0.0145, 0.0115, 0.0110],
        flatten=0.8,
    )
    head = box([0.012, 0.0, 0.281], [0.031, 0.0125, 0.0125], 0.003)
    neck = chain([(0.035, 0, 0.281), (0.056, 0, 0.281)], [0.0105, 0.0105], steps=1)
    face = lathe(
        [(0.0, 0.0), (0.0145, 0.0), (0.0155, 0.002), (0.0155, 0.016), (0.013, 0.019), (0.0, 0.019)]
    )
    face = face.turned([0, 1, 0], 90.0).moved([0.053, 0.0, 0.281])
    bend = [(-0.010, 1.0, 0.283), (-0.040, 1.2, 0.284), (-0.064, 1.5, 0.274), (-0.080, 1.7, 0.255)]
    claw = [
        chain(
            [(x, w * y, z) for x, w, z in bend],
            [0.0095, 0.0080, 0.0058, 0.0035],
        ).blended(0.006)
        for y in (-0.0068, 0.0068)
    ]  # fmt: skip
    return [handle, head.blended(0.004), neck.blended(0.004), face.blended(0.002), *claw]


def salt_box() -> trimesh.Trimesh:
    """Cylinder of 9 cm diameter and 14 cm height with sharp rims."""
    return _cylinder_mesh(0.045, 0.140)


def cereal_box() -> trimesh.Trimesh:
    """Cuboid of 19 by 6 by 28 cm with sharp edges."""
    return _box_mesh((0.190, 0.060, 0.280))


def _between(
    a: tuple[float, float], b: tuple[float, float], count: int
) -> list[tuple[float, float]]:
    """Points from `a` towards `b`, `b` left out."""
    steps = np.linspace(a, b, count + 1)[:-1]
    return [(float(r), float(z)) for r, z in steps]


def _united(a: trimesh.Trimesh, b: trimesh.Trimesh) -> trimesh.Trimesh:
    """Union of two closed bodies, exact along the seam."""
    joined = trimesh.boolean.union([a, b], engine="manifold")
    return trimesh.Trimesh(joined.vertices, joined.faces, process=False)


def _box_mesh(edges: tuple[float, float, float]) -> trimesh.Trimesh:
    """Box with exact edges, its faces cut into small triangles."""
    mesh = trimesh.creation.box(extents=edges)
    vertices, faces = trimesh.remesh.subdivide_to_size(
        mesh.vertices, mesh.faces, max_edge=max(edges) / 24.0
    )
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.merge_vertices()
    return mesh


def _cylinder_mesh(radius: float, height: float) -> trimesh.Trimesh:
    """Cylinder with exact rims: rings up the side, rings over lid and bottom."""
    rings = np.linspace(0.0, radius, 12)[1:]
    side = np.linspace(-0.5, 0.5, 30)[1:-1] * height
    profile = [(0.0, -height / 2.0), *[(r, -height / 2.0) for r in rings]]
    profile += [(radius, z) for z in side] + [(r, height / 2.0) for r in rings[::-1]]
    return trimesh.creation.revolve(np.asarray([*profile, (0.0, height / 2.0)]), sections=90)
