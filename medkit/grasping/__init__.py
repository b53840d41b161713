"""Surface, medial axis, grid, symmetry, candidates, closing, planners: one file a step."""

# the medial axis, its grid and local symmetry (P13 chapter 3, 4.2 and 4.3)
from medkit.grasping.filters import filter_object_angle as filter_object_angle
from medkit.grasping.filters import filter_radius_ratio as filter_radius_ratio
from medkit.grasping.grid import MedialSphereGrid as MedialSphereGrid
from medkit.grasping.grid import Neighborhoods as Neighborhoods
from medkit.grasping.medial import MedialAxis as MedialAxis
from medkit.grasping.medial import medial_axis as medial_axis
from medkit.grasping.medial import medial_axis_from_surface as medial_axis_from_surface
from medkit.grasping.surface import SurfaceSample as SurfaceSample
from medkit.grasping.surface import sample_surface as sample_surface
from medkit.grasping.symmetry import LocalSymmetry as LocalSymmetry
from medkit.grasping.symmetry import SymmetryKind as SymmetryKind
from medkit.grasping.symmetry import local_symmetry as local_symmetry
