"""Recordings to human grasps to measures to a ranking; takes fingertip arrays, knows no planner."""

from medkit.similarity.measures import NearestHuman as NearestHuman
from medkit.similarity.measures import d_eucl as d_eucl
from medkit.similarity.measures import d_symmetric as d_symmetric
from medkit.similarity.measures import d_z as d_z
from medkit.similarity.measures import nearest_human as nearest_human
from medkit.similarity.measures import share_within as share_within
