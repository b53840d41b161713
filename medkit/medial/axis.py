"""The medial axis transform of a mesh by shrinking balls, all samples at once (P13 3.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.arguments import one_of
from medkit.geometry import Floats, expected, nonnegative
from medkit.medial import axis_kernels, tree_kernels
from medkit.medial.bound_kernels import bound_samples
from medkit.medial.size import in_own_frame
from medkit.medial.surface import MESH_REMEDY, SurfaceSample, sample_surface
from medkit.medial.touch_kernels import widest_touch
from medkit.medial.tree_kernels import Tree
from medkit.meshes import repair_mesh

#: How deep a sample may lie inside a medial sphere, over the spacing: facets and noise.
SLACK = 0.1
#: A surface counts as touched where moving the centre this far could reach it, over the spacing.
TOUCH = 0.5
#: A sample speaks for the surface up to this distance, over the spacing.
REACH = 1.5
#: Pairs of touch points wider than this are not searched for wider ones [rad].
ENOUGH = np.pi - 0.09
#: Where no touch is wider from the first than this, no pair can reach P13's 120 deg [rad].
MODEST = np.pi / 3.0

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
        Largest angle between two directions from the centre to touch points [rad]; where no pair
        can reach 120 deg, that between two of them, which may be less than the largest.
    touch_points : ndarray, shape (n, 2, 3)
        The two touch points that span the object angle [m].
    spacing : float
        Mean distance of the surface samples that the spheres stand on [m].
    diagonal : float
        Diagonal of the smallest box around the object, in any direction [m].
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
        The object [m]; defects are repaired by `medkit.meshes.repair_mesh` first.
    spacing : float, optional
        Mean distance of the surface samples [m]; 1.5 % of the diagonal when left out.
    side : {"interior", "exterior"}
        Spheres inside the object, or those outside that touch it twice.
    touch_tolerance : float, optional
        A sphere touches the surface wherever it would after moving its centre by no more than
        this [m]; half the spacing when left out.

    Returns
    -------
    MedialAxis
        Unfiltered: keep stable spheres with the filters of `medkit.medial.filters`.

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
    expected(mesh, trimesh.Trimesh, "a triangle mesh", MESH_REMEDY)
    sample = sample_surface(repair_mesh(mesh).mesh, spacing=spacing)
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
    expected(
        sample, SurfaceSample, "a sampled surface", "pass medkit.grasping.sample_surface(mesh)"
    )
    one_of(side, ("interior", "exterior"), "side")
    tree = sample_tree(sample, 1.0 if side == "interior" else -1.0)[1]
    slack = max(SLACK * sample.spacing, sample.facet_depth)
    shrink: Any = axis_kernels.shrink_balls
    radii, stop = shrink(tree, 0.5 * sample.diagonal, slack, slack)
    radii = axis_kernels.refine_balls(tree, radii, stop, REACH * sample.spacing)
    own = np.flatnonzero((stop >= 0) & (radii > 0.0))
    centers = tree.points[own] - radii[own, None] * tree.normals[own]
    return with_object_angles(
        sample, tree, centers, radii[own], own, stop[own], touch_tolerance=touch_tolerance
    )


def sample_tree(sample: SurfaceSample, sign: float = 1.0) -> tuple[NDArray[np.int64], Tree]:
    """Order (n,) of the samples in the tree for the kernels, and that tree.

    With a `sign` of -1 the normals are turned, so that the balls grow outside.
    """
    leaves = 1
    while leaves * tree_kernels.LEAF_SIZE < len(sample):
        leaves *= 2
    # laid out in the object's own frame, so that a turned object gets the same tree
    order, first, last = tree_kernels.sort_samples(in_own_frame(sample.points), leaves)
    points, normals = sample.points[order], sample.normals[order] * sign
    blocks, copied, fan = bound_samples(points, normals, first, last)
    start = np.append(first[leaves:], len(points))
    return order, Tree(points, normals, start, blocks, copied, fan)


def with_object_angles(
    sample: SurfaceSample,
    tree: Tree,
    centers: Floats,
    radii: Floats,
    own: NDArray[np.int64],
    stop: NDArray[np.int64],
    *,
    touch_tolerance: float | None = None,
) -> MedialAxis:
    """Complete spheres, each with two touching samples in tree order, to a medial axis."""
    tolerance = (
        TOUCH * sample.spacing
        if touch_tolerance is None
        else nonnegative(touch_tolerance, "touch_tolerance", " m")
    )
    tolerances = np.array([tolerance, max(SLACK * sample.spacing, sample.facet_depth)])
    widest: Any = widest_touch
    angles, touch_points = widest(
        centers, radii, own, stop, tree, tolerances, REACH * sample.spacing, ENOUGH, MODEST
    )
    return MedialAxis(centers, radii, angles, touch_points, sample.spacing, sample.diagonal)
