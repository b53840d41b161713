"""Even samples of a triangle mesh with outward normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, expected, nonnegative, positive
from medkit.medial import surface_kernels as kernels
from medkit.medial.size import smallest_diagonal

#: Sample distance as a share of the diagonal, when none is given (P13 does not state its own).
DEFAULT_SPACING = 0.015
#: Edges that turn by less than this are facets of a smooth surface, not features [rad].
CREASE_ANGLE = np.radians(35.0)
_CANDIDATES = 6  # per square of the spacing; more gives more even samples at more cost
_THINNING = 0.8  # least distance of two samples over the spacing: about one sample per square
MESH_REMEDY = "read one with medkit.meshes.load_mesh(path)"
_MOST_SAMPLES = 20_000_000
# Limits that no ordinary shape sits on exactly: at a tie, rounding would choose, and with it the
# pose. Faces of a hexagonal prism turn by 60 deg, and equal faces end at round shares of the area.
_COMPETE = float(np.cos(np.radians(61.8)))  # normals that turn by less are of one surface
_PHASE = 0.381966


@dataclass(frozen=True)
class SurfaceSample:
    """Samples of a closed surface, evidence that it was sampled evenly.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Samples on the mesh [m], in the frame of the mesh.
    normals : ndarray, shape (n, 3)
        Outward unit normals [1], smooth across facets, sharp at creases.
    faces : ndarray, shape (n,)
        Index of the face each sample lies on.
    spacing : float
        Mean distance of neighbouring samples: one sample per square of this side [m].
    diagonal : float
        Diagonal of the smallest box around the mesh in any direction [m], the size of the object.
    facet_depth : float
        How deep flat facets lie below the smooth surface they stand for [m].
    """

    points: Floats
    normals: Floats
    faces: NDArray[np.int64]
    spacing: float
    diagonal: float
    facet_depth: float = 0.0

    def __len__(self) -> int:
        return len(self.points)


def sample_surface(
    mesh: trimesh.Trimesh, *, spacing: float | None = None, crease_angle: float = CREASE_ANGLE
) -> SurfaceSample:
    """Sample a mesh evenly: the samples move, turn and grow with the mesh.

    Many candidates are laid out along the faces in proportion to their area (a low-discrepancy
    sequence, so no random numbers), then thinned until none is nearer than 0.8 times the spacing.
    Nothing in this looks at the axes of the world: see decision 0015.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Watertight mesh with outward normals [m].
    spacing : float, optional
        Mean distance of samples [m]; 1.5 % of the size of the object when left out: of the
        diagonal of the smallest box around it, however it lies.
    crease_angle : float
        Edges sharper than this keep the normals of their faces apart [rad].

    Returns
    -------
    SurfaceSample
        Points, normals and faces.

    Raises
    ------
    InputError
        If the mesh has no area, or the spacing asks for more than 20 million samples.

    Examples
    --------
    >>> import trimesh
    >>> sample = sample_surface(trimesh.creation.box((1, 1, 1)), spacing=0.05)
    >>> 0.8 < len(sample) * 0.05**2 / 6.0 < 1.2
    True
    """
    expected(mesh, trimesh.Trimesh, "a triangle mesh", MESH_REMEDY)
    nonnegative(crease_angle, "crease_angle", " rad")
    middle, diagonal = _place_and_size(mesh)
    distance = DEFAULT_SPACING * diagonal if spacing is None else positive(spacing, "spacing", " m")
    # at unit size no tolerance inside trimesh depends on the size or place of the object
    sized = trimesh.Trimesh((mesh.vertices - middle) / diagonal, mesh.faces, process=False)
    areas = np.asarray(sized.area_faces, dtype=float)
    if not areas.sum() > 0.0:
        raise InputError(
            f"Expected a mesh with a surface, but its {len(mesh.faces)} faces have no area;"
            " check the file and its scale."
        )
    count = _CANDIDATES * areas.sum() * (diagonal / distance) ** 2
    if count > _CANDIDATES * _MOST_SAMPLES:
        raise InputError(
            f"Expected a spacing that suits the object, but {distance:g} m asks for about"
            f" {count / _CANDIDATES:.3g} samples on a diagonal of {diagonal:g} m; use a larger one."
        )
    faces, points, normals = _candidates(
        sized, areas, max(int(count + _PHASE), 4 * _CANDIDATES), crease_angle
    )
    keep = kernels.thin_samples(points, normals, _THINNING * distance / diagonal, _COMPETE)
    depth = min(facet_depth(sized, crease_angle), 0.002) * diagonal
    points = middle + diagonal * points[keep]
    return SurfaceSample(points, normals[keep], faces[keep], distance, diagonal, depth)


def _place_and_size(mesh: trimesh.Trimesh) -> tuple[Floats, float]:
    """Mean vertex (3,) and diagonal of the smallest box [m], or a refusal."""
    vertices = np.asarray(mesh.vertices, dtype=float)
    diagonal = 0.0
    if len(mesh.faces) and np.all(np.isfinite(vertices)):
        # in the order of the faces: that of the vertices may change when a mesh is repaired
        used, first = np.unique(mesh.faces, return_index=True)
        diagonal = smallest_diagonal(vertices[used[np.argsort(first)]])
    if not (np.isfinite(diagonal) and diagonal > 0.0):
        raise InputError(
            f"Expected a mesh with a surface of finite size, but got {len(mesh.faces)} faces in a"
            f" box of diagonal {diagonal:g} m; check the file and its scale."
        )
    return vertices.mean(axis=0), diagonal


def _candidates(
    mesh: trimesh.Trimesh, areas: Floats, count: int, crease_angle: float
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Faces (count,) in proportion to area, points (count, 3) on them and smooth normals there."""
    # a stride that shares no factor with the count: thinning sees all parts of the surface early
    stride = max(1, int(count / 1.618033988749895))
    while np.gcd(stride, count) != 1:
        stride += 1
    corners = np.asarray(mesh.vertices)[mesh.faces]
    normals = corner_normals(mesh, crease_angle)
    flat = np.asarray(mesh.face_normals)
    lay: Any = kernels.lay_candidates
    return lay(np.cumsum(areas), count, _PHASE, stride, corners, normals, flat)


def corner_normals(mesh: trimesh.Trimesh, crease_angle: float = CREASE_ANGLE) -> Floats:
    """Unit normal of every corner of every face, smooth up to `crease_angle` [rad].

    A corner's normal is the mean of the normals of those faces around its vertex that turn by
    less than the crease angle from its own face, weighted by their angles at the vertex.

    Returns
    -------
    ndarray, shape (faces, 3, 3)
        Normals by face and corner [1].
    """
    own = np.asarray(mesh.face_normals)
    corner_vertex = np.asarray(mesh.faces).ravel()
    corner_face = np.repeat(np.arange(len(own)), 3)
    angle = np.asarray(mesh.face_angles).ravel()
    order = np.argsort(corner_vertex, kind="stable")
    count = np.bincount(corner_vertex, minlength=len(mesh.vertices))
    begin = np.concatenate([[0], np.cumsum(count)[:-1]])
    return kernels.blend_corners(
        own, corner_vertex, corner_face, angle, order, begin, count, np.cos(crease_angle)
    ).reshape(-1, 3, 3)


def facet_depth(mesh: trimesh.Trimesh, crease_angle: float = CREASE_ANGLE) -> float:
    """Depth of a mesh's facets below the smooth surface they stand for [m].

    Across an edge that turns by t between faces of mean width w, the sagitta is w t / 8. The
    value is exceeded on 5 % of the area beside smooth edges; a box has none and gets zero.
    """
    turn = np.asarray(mesh.face_adjacency_angles)
    smooth = (turn > 1e-4) & (turn < crease_angle)
    if not np.any(smooth):
        return 0.0
    pairs = np.asarray(mesh.face_adjacency)[smooth]
    ends = mesh.vertices[np.asarray(mesh.face_adjacency_edges)[smooth]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    areas = np.asarray(mesh.area_faces)[pairs]
    width = areas.sum(axis=1) / np.maximum(length, 1e-300)
    depth = width * turn[smooth] / 8.0
    order = np.argsort(depth)
    weight = np.cumsum(areas.sum(axis=1)[order])
    return float(depth[order][np.searchsorted(weight, 0.95 * weight[-1])])
