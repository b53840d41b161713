"""The medial axis transform of a mesh by shrinking balls, all samples at once (P13 3.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats, nonnegative
from medkit.grasping import medial_kernels as kernels
from medkit.grasping.surface import SurfaceSample, sample_surface

#: How deep a sample may lie inside a medial sphere, over the spacing: facets and noise.
SLACK = 0.1
#: How far beyond the radius the surface may be and still count as touched, over the spacing.
TOUCH = 0.5
#: A sample speaks for the surface up to this distance, over the spacing.
REACH = 1.0
#: Pairs of touch points wider than this are not searched for wider ones [rad].
ENOUGH = np.radians(179.0)

Side = Literal["interior", "exterior"]


@dataclass(frozen=True)
class MedialAxis:
    """Medial spheres of an object: centre, radius, touch points and object angle (P13 3.4).

    Attributes
    ----------
    centers : ndarray, shape (n, 3)
        Sphere centres in the frame of the mesh [m].
    radii : ndarray, shape (n,)
        Radii [m].
    object_angles : ndarray, shape (n,)
        Largest angle between two directions from the centre to touch points [rad].
    touch_points : ndarray, shape (n, 2, 3)
        The two touch points that span the object angle [m].
    spacing : float
        Mean distance of the surface samples that the spheres stand on [m].
    diagonal : float
        Diagonal of the object's bounding box [m].
    """

    centers: Floats
    radii: Floats
    object_angles: Floats
    touch_points: Floats
    spacing: float
    diagonal: float

    def __len__(self) -> int:
        return len(self.radii)

    def select(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> MedialAxis:
        """Keep some of the spheres, by a mask (n,) or by indices, in that order."""
        return replace(
            self,
            centers=self.centers[which],
            radii=self.radii[which],
            object_angles=self.object_angles[which],
            touch_points=self.touch_points[which],
        )


def medial_axis(
    mesh: trimesh.Trimesh,
    *,
    spacing: float | None = None,
    side: Side = "interior",
    touch_tolerance: float | None = None,
) -> MedialAxis:
    """Medial spheres of a mesh, one per surface sample.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The object [m].
    spacing : float, optional
        Mean distance of the surface samples [m]; 1.5 % of the diagonal when left out.
    side : {"interior", "exterior"}
        Spheres inside the object, or those outside that touch it twice.
    touch_tolerance : float, optional
        A sphere touches the surface where the gap is no larger [m]; half the spacing by default.

    Returns
    -------
    MedialAxis
        Unfiltered: keep stable spheres with the filters of `medkit.grasping.filters`.

    Raises
    ------
    InputError
        If the mesh cannot be repaired into one with an inside, or an argument is out of range.

    Examples
    --------
    >>> import trimesh
    >>> ball = medial_axis(trimesh.creation.icosphere(4, 0.05))
    >>> bool(np.all(np.linalg.norm(ball.centers, axis=1) < 0.001))
    True
    """
    sample = sample_surface(mesh, spacing=spacing)
    return medial_axis_from_surface(sample, side=side, touch_tolerance=touch_tolerance)


def medial_axis_from_surface(
    sample: SurfaceSample, *, side: Side = "interior", touch_tolerance: float | None = None
) -> MedialAxis:
    """Medial spheres of a sampled surface: the largest empty ball tangent at every sample.

    Parameters and errors as in `medial_axis`, which samples a mesh and calls this.

    Returns
    -------
    MedialAxis
        Spheres in an order in which neighbours are near each other in space.
    """
    if side not in ("interior", "exterior"):
        raise InputError(f"Expected side 'interior' or 'exterior', but got {side!r}; use one.")
    tolerance = (
        TOUCH * sample.spacing
        if touch_tolerance is None
        else nonnegative(touch_tolerance, "touch_tolerance", " m")
    )
    reach = REACH * sample.spacing
    leaves = 1
    while leaves * kernels.LEAF_SIZE < len(sample):
        leaves *= 2
    order, points, first, last, boxes = kernels.build_tree(sample.points, leaves)
    normals = sample.normals[order] * (1.0 if side == "interior" else -1.0)
    tree = (points, normals, first, last, boxes)
    radii, stop = kernels.shrink_balls(*tree, 0.5 * sample.diagonal, SLACK * sample.spacing)
    radii = kernels.refine_balls(points, normals, radii, stop, reach)
    own = np.flatnonzero(stop >= 0)
    centers = points[own] - radii[own, None] * normals[own]
    angles, touch_points = kernels.widest_touch(
        centers, radii[own], own, stop[own], *tree, tolerance, reach, ENOUGH
    )
    return MedialAxis(centers, radii[own], angles, touch_points, sample.spacing, sample.diagonal)
