"""Candidates, closing, planners, experiments and grasp files: one file a step.

The medial axis that candidates come from lives in `medkit.medial`; its names are offered here too,
since a grasp plan starts with them.
"""

from medkit.grasping.candidate_set import CandidateGrasps, SphereFate
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.closing.object_field import ObjectField, object_field
from medkit.grasping.grasp_file import grasp_document, read_grasps, write_grasps
from medkit.grasping.grasp_set import Grasp, GraspSet
from medkit.grasping.planners import plan_grasps, plan_power_grasps
from medkit.grasping.power import ClosedGrasp, PowerCloser
from medkit.medial import (
    LocalSymmetry,
    MedialAxis,
    MedialSphereGrid,
    Neighborhoods,
    SurfaceSample,
    SymmetryKind,
    filter_lambda,
    filter_object_angle,
    filter_radius_ratio,
    filter_scale_axis,
    local_symmetry,
    medial_axis,
    medial_axis_by_poles,
    medial_axis_from_surface,
    sample_surface,
)

__all__ = [
    "CandidateGrasps",
    "ClosedGrasp",
    "Grasp",
    "GraspSet",
    "LocalSymmetry",
    "MedialAxis",
    "MedialSphereGrid",
    "Neighborhoods",
    "ObjectField",
    "PowerCloser",
    "SphereFate",
    "SurfaceSample",
    "SymmetryKind",
    "candidates_from_axis",
    "filter_lambda",
    "filter_object_angle",
    "filter_radius_ratio",
    "filter_scale_axis",
    "grasp_document",
    "local_symmetry",
    "medial_axis",
    "medial_axis_by_poles",
    "medial_axis_from_surface",
    "object_field",
    "plan_grasps",
    "plan_power_grasps",
    "read_grasps",
    "sample_surface",
    "write_grasps",
]
