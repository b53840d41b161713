"""Outlines, their exact medial axis, antipodal pairs, and the pymunk squeeze."""

from medkit.planar.bounds import cone_half_angle, is_antipodal, min_friction, min_object_angle
from medkit.planar.closure import (
    critical_friction,
    epsilon,
    is_force_closure,
    is_form_closure,
    primitive_wrenches,
    volume,
)
from medkit.planar.disks import MedialAxis
from medkit.planar.filters import filter_lambda, filter_object_angle, filter_scale
from medkit.planar.materials import MATERIALS, MaterialPair, material
from medkit.planar.medial import medial_axis
from medkit.planar.outlines import Outline, SmoothOutline, outline_from_loops, smooth_outline
from medkit.planar.regions import EdgePair, antipodal_pairs, force_closure_pairs
from medkit.planar.settings import SqueezeSettings
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
from medkit.planar.squeezing import SqueezeResult, squeeze
from medkit.planar.studies import (
    PhaseDiagram,
    agreement,
    phase_diagram,
    simulated_critical_friction,
    wedge_family,
)

__all__ = [
    "EdgePair",
    "MATERIALS",
    "MaterialPair",
    "MedialAxis",
    "Outline",
    "PhaseDiagram",
    "SmoothOutline",
    "SqueezeResult",
    "SqueezeSettings",
    "agreement",
    "antipodal_pairs",
    "banana",
    "cone_half_angle",
    "critical_friction",
    "ellipse",
    "epsilon",
    "filter_lambda",
    "filter_object_angle",
    "filter_scale",
    "force_closure_pairs",
    "frame",
    "is_antipodal",
    "is_force_closure",
    "is_form_closure",
    "l_shape",
    "material",
    "medial_axis",
    "min_friction",
    "min_object_angle",
    "outline_from_loops",
    "phase_diagram",
    "primitive_wrenches",
    "random_smooth",
    "rectangle",
    "regular_polygon",
    "simulated_critical_friction",
    "smooth_outline",
    "smooth_through",
    "squeeze",
    "star",
    "t_shape",
    "triangle",
    "volume",
    "wedge",
    "wedge_family",
]
