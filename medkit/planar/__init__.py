"""Outlines, their exact medial axis, antipodal pairs, and the pymunk squeeze."""

from medkit.planar.bounds import cone_half_angle, is_antipodal, min_friction, min_object_angle
from medkit.planar.filters import filter_lambda, filter_object_angle, filter_scale
from medkit.planar.materials import MATERIALS, MaterialPair, material
from medkit.planar.medial import MedialAxis, medial_axis
from medkit.planar.outlines import Outline, SmoothOutline, outline_from_loops, smooth_outline
from medkit.planar.shapes import (
    banana,
    ellipse,
    frame,
    l_shape,
    random_smooth,
    rectangle,
    regular_polygon,
    smooth_through,
    star,
    t_shape,
    triangle,
    wedge,
)

__all__ = [
    "MATERIALS",
    "MaterialPair",
    "MedialAxis",
    "Outline",
    "SmoothOutline",
    "banana",
    "cone_half_angle",
    "ellipse",
    "filter_lambda",
    "filter_object_angle",
    "filter_scale",
    "frame",
    "is_antipodal",
    "l_shape",
    "material",
    "medial_axis",
    "min_friction",
    "min_object_angle",
    "outline_from_loops",
    "random_smooth",
    "rectangle",
    "regular_polygon",
    "smooth_outline",
    "smooth_through",
    "star",
    "t_shape",
    "triangle",
    "wedge",
]
