"""Outlines, their exact medial axis, antipodal pairs, and the pymunk squeeze."""

from medkit.planar.bounds import cone_half_angle, is_antipodal, min_friction, min_object_angle
from medkit.planar.materials import MATERIALS, MaterialPair, material

__all__ = [
    "MATERIALS",
    "MaterialPair",
    "cone_half_angle",
    "is_antipodal",
    "material",
    "min_friction",
    "min_object_angle",
]
