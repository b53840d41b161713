"""What of an object a hand meets on its way: read from the medial spheres, which fill it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats
from medkit.grasping import reach_kernels as kernels
from medkit.medial.axis import MedialAxis


def way_out(axis: MedialAxis, points: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """How deep points lie in the object, and how long the straight way is free after that.

    Parameters
    ----------
    axis : MedialAxis
        All spheres of the object; their union is the object up to the sampling.
    points, directions : ndarray, shape (n, 3)
        Where the ways begin [m], and unit directions in which they go.

    Returns
    -------
    depth : ndarray, shape (n,)
        Where the object first ends, gaps of less than the spacing of the samples left out [m].
    room : ndarray, shape (n,)
        From there to where the object begins again, infinite where it does not [m].

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import medial_axis
    >>> axis = medial_axis(trimesh.creation.box((0.1, 0.2, 0.02)))
    >>> depth, room = way_out(axis, np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]))
    >>> round(float(depth[0]), 2), float(room[0])
    (0.05, inf)
    """
    depth, room = np.zeros(len(points)), np.zeros(len(points))
    kernels.ways_out(points, directions, axis.centers, axis.radii, axis.spacing, depth, room)
    return depth, room


def local_thickness(axis: MedialAxis, points: Floats) -> Floats:
    """Radius of the largest inscribed sphere that holds each point, shape (n,) [m].

    Parameters
    ----------
    axis : MedialAxis
        All spheres of the object.
    points : ndarray, shape (n, 3)
        Points [m].

    Returns
    -------
    ndarray, shape (n,)
        Half the local thickness; 0 outside the object.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import medial_axis
    >>> axis = medial_axis(trimesh.creation.capsule(0.2, 0.02))
    >>> local_thickness(axis, np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 1.0]])).round(3).tolist()
    [0.02, 0.0]
    """
    largest = np.zeros(len(points))
    kernels.thickest(points, axis.centers, axis.radii, largest)
    return largest


def blocked(axis: MedialAxis, places: Floats) -> NDArray[np.bool_]:
    """Whether any of the places that a hand needs lies inside the object.

    Parameters
    ----------
    axis : MedialAxis
        All spheres of the object.
    places : ndarray, shape (n, m, 3)
        m places for each of n hands [m].

    Returns
    -------
    ndarray of bool, shape (n,)
        True where at least one place is inside.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import medial_axis
    >>> axis = medial_axis(trimesh.creation.capsule(0.2, 0.02))
    >>> places = np.array([[[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]], [[0.0, 0.1, 0.0], [0.1, 0.0, 0.0]]])
    >>> blocked(axis, places).tolist()
    [True, False]
    """
    inside = np.zeros(len(places), dtype=np.bool_)
    middle = places.mean(axis=1)
    reach = np.linalg.norm(places - middle[:, None], axis=2).max(axis=1, initial=0.0)
    kernels.any_inside(places, middle, reach, axis.centers, axis.radii, inside)
    return inside
