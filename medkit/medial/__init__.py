"""Mesh to even samples, medial spheres, filters, grid and local symmetry: one file a step."""

from medkit.medial.axis import MedialAxis, medial_axis, medial_axis_from_surface
from medkit.medial.filters import (
    filter_lambda,
    filter_object_angle,
    filter_radius_ratio,
    filter_scale_axis,
)
from medkit.medial.grid import MedialSphereGrid, Neighborhoods
from medkit.medial.poles import medial_axis_by_poles
from medkit.medial.surface import SurfaceSample, sample_surface
from medkit.medial.symmetry import LocalSymmetry, SymmetryKind, local_symmetry

__all__ = [
    "LocalSymmetry",
    "MedialAxis",
    "MedialSphereGrid",
    "Neighborhoods",
    "SurfaceSample",
    "SymmetryKind",
    "filter_lambda",
    "filter_object_angle",
    "filter_radius_ratio",
    "filter_scale_axis",
    "local_symmetry",
    "medial_axis",
    "medial_axis_by_poles",
    "medial_axis_from_surface",
    "sample_surface",
]
