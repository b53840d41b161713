"""Recordings to human grasps to measures to a ranking; takes fingertip arrays, knows no planner."""

from medkit.similarity.grasps import HumanGrasps as HumanGrasps
from medkit.similarity.grasps import grasps_from_recordings as grasps_from_recordings
from medkit.similarity.measures import NearestHuman as NearestHuman
from medkit.similarity.measures import d_eucl as d_eucl
from medkit.similarity.measures import d_symmetric as d_symmetric
from medkit.similarity.measures import d_z as d_z
from medkit.similarity.measures import nearest_human as nearest_human
from medkit.similarity.measures import share_within as share_within
from medkit.similarity.ranking import human_reference as human_reference
from medkit.similarity.ranking import rank_grasps as rank_grasps
from medkit.similarity.symmetry import SymmetryGroup as SymmetryGroup
from medkit.similarity.symmetry_group import symmetry_group_from_mesh as symmetry_group_from_mesh
from medkit.similarity.validate import validate as validate
