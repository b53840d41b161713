"""The medial axis by Voronoi poles, an independent check of the shrinking balls (P13 3.2.2)."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from medkit.geometry import Floats, expected
from medkit.medial.axis import MedialAxis, sample_tree, with_object_angles
from medkit.medial.surface import MESH_REMEDY, SurfaceSample, sample_surface
from medkit.meshes import repair_mesh


def medial_axis_by_poles(mesh: trimesh.Trimesh, *, spacing: float | None = None) -> MedialAxis:
    """Medial spheres of a mesh from the Voronoi diagram of its samples (Amenta's inner poles).

    The inner pole of a sample is the corner of its Voronoi cell that is farthest from it, on the
    side away from the normal. The sphere about it through the sample holds no sample inside. The
    object angles are then taken over all touch points, as for the shrinking balls.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The object [m]; defects are repaired by `medkit.meshes.repair_mesh` first.
    spacing : float, optional
        Mean distance of the surface samples [m]; 1.5 % of the diagonal when left out.

    Returns
    -------
    MedialAxis
        One sphere per sample that has an inner pole.

    Raises
    ------
    InputError
        If the mesh cannot be repaired into one with an inside.

    Examples
    --------
    >>> import trimesh
    >>> axis = medial_axis_by_poles(trimesh.creation.icosphere(4, 0.05))
    >>> bool(0.045 < np.median(axis.radii) < 0.0505)
    True
    """
    expected(mesh, trimesh.Trimesh, "a triangle mesh", MESH_REMEDY)
    return poles_from_surface(sample_surface(repair_mesh(mesh).mesh, spacing=spacing))


def poles_from_surface(sample: SurfaceSample) -> MedialAxis:
    """Inner poles of a sampled surface; see `medial_axis_by_poles`."""
    # far corners close the cells of the hull's samples
    middle = 0.5 * (sample.points.min(axis=0) + sample.points.max(axis=0))
    far = middle + 20.0 * sample.diagonal * np.vstack([np.eye(3), -np.eye(3)])
    cells = Delaunay(np.vstack([sample.points, far]))
    corners, tets = _circumcenters(cells.points, cells.simplices)
    owner = tets.ravel()
    center = np.repeat(np.arange(len(corners)), 4)
    own = owner < len(sample)
    owner, center = owner[own], center[own]
    away = corners[center] - sample.points[owner]
    depth = -np.einsum("nk,nk->n", away, sample.normals[owner])
    distance = np.linalg.norm(away, axis=1)
    inner = (depth > 0.0) & (distance < 0.5 * sample.diagonal)
    owner, center, distance = owner[inner], center[inner], distance[inner]
    # the last entry of each sample, sorted by distance, is its pole
    order = np.lexsort((distance, owner))
    last = np.flatnonzero(np.diff(owner[order], append=-1) != 0)
    pole = center[order][last]
    radii = distance[order][last]
    corner = tets[pole]
    # of the four samples on the sphere, the one farthest from its own spans the first angle
    apart = np.linalg.norm(cells.points[corner] - cells.points[owner[order][last], None], axis=2)
    stop = corner[np.arange(len(corner)), np.argmax(apart, axis=1)]
    tree_order, tree = sample_tree(sample)
    place = np.empty(len(sample), np.int64)
    place[tree_order] = np.arange(len(sample))
    own = place[owner[order][last]]
    return with_object_angles(sample, tree, corners[pole], radii, own, place[stop])


def _circumcenters(
    points: Floats, tetrahedra: NDArray[np.int32]
) -> tuple[Floats, NDArray[np.int32]]:
    """Circumcentres (m, 3) of those tetrahedra that have a volume, and their corners (m, 4)."""
    base = points[tetrahedra[:, 0]]
    edges = points[tetrahedra[:, 1:]] - base[:, None]
    size = np.prod(np.linalg.norm(edges, axis=2), axis=1)
    solid = np.abs(np.linalg.det(edges)) > 1e-10 * size
    edges, base, tetrahedra = edges[solid], base[solid], tetrahedra[solid]
    half = 0.5 * np.einsum("nij,nij->ni", edges, edges)
    return base + np.linalg.solve(edges, half[..., None])[..., 0], tetrahedra
