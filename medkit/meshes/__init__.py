"""Mesh files in, checked and repaired meshes out, or one clear refusal.

Examples
--------
>>> import trimesh
>>> box = trimesh.creation.box((0.1, 0.1, 0.2))
>>> _ = box.invert()
>>> repair_mesh(box).repairs
('turned the surface outwards (it was inside-out)',)
"""

from medkit.meshes.loading import load_mesh, refuse_wrong_scale
from medkit.meshes.repair import MassProperties, RepairedMesh, mass_properties, repair_mesh

__all__ = [
    "MassProperties",
    "RepairedMesh",
    "load_mesh",
    "mass_properties",
    "refuse_wrong_scale",
    "repair_mesh",
]
