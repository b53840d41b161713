"""Surface, medial axis, grid, symmetry, candidates, closing, planners: one file a step."""

# the medial axis, its grid and local symmetry (P13 chapter 3, 4.2 and 4.3)
# candidates, closing, planners, the grasp file (P13 4.4 to 4.6)
from medkit.grasping.candidates import CandidateGrasps as CandidateGrasps
from medkit.grasping.candidates import SphereFate as SphereFate
from medkit.grasping.candidates import candidates_from_axis as candidates_from_axis
from medkit.grasping.distance_grid import ObjectField as ObjectField
from medkit.grasping.distance_grid import object_field as object_field
from medkit.grasping.filters import filter_lambda as filter_lambda
from medkit.grasping.filters import filter_object_angle as filter_object_angle
from medkit.grasping.filters import filter_radius_ratio as filter_radius_ratio
from medkit.grasping.filters import filter_scale_axis as filter_scale_axis
from medkit.grasping.grasp_file import grasp_document as grasp_document
from medkit.grasping.grasp_file import read_grasps as read_grasps
from medkit.grasping.grasp_file import write_grasps as write_grasps
from medkit.grasping.grasp_set import Grasp as Grasp
from medkit.grasping.grasp_set import GraspSet as GraspSet
from medkit.grasping.grid import MedialSphereGrid as MedialSphereGrid
from medkit.grasping.grid import Neighborhoods as Neighborhoods
from medkit.grasping.medial import MedialAxis as MedialAxis
from medkit.grasping.medial import medial_axis as medial_axis
from medkit.grasping.medial import medial_axis_from_surface as medial_axis_from_surface
from medkit.grasping.planners import plan_grasps as plan_grasps
from medkit.grasping.planners import plan_power_grasps as plan_power_grasps
from medkit.grasping.poles import medial_axis_by_poles as medial_axis_by_poles
from medkit.grasping.power import ClosedGrasp as ClosedGrasp
from medkit.grasping.power import PowerCloser as PowerCloser
from medkit.grasping.surface import SurfaceSample as SurfaceSample
from medkit.grasping.surface import sample_surface as sample_surface
from medkit.grasping.symmetry import LocalSymmetry as LocalSymmetry
from medkit.grasping.symmetry import SymmetryKind as SymmetryKind
from medkit.grasping.symmetry import local_symmetry as local_symmetry
