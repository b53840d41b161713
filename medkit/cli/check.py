"""``medkit check``: what the mesh checks find, and what would be repaired."""

from __future__ import annotations

import argparse

HELP = "say what the mesh checks find, and what would be repaired"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``medkit check``."""
    parser.add_argument("mesh", metavar="MESH", help="mesh file (STL, OBJ, OFF, PLY, GLB)")
    parser.add_argument(
        "--scale", type=float, default=1.0, help="metres per unit of the file (default 1)"
    )


def run(args: argparse.Namespace) -> int:
    """Print the findings; 0 when the mesh can be planned with, else `InputError`."""
    import numpy as np

    from medkit.meshes import load_mesh, mass_properties, refuse_wrong_scale, repair_mesh

    raw = load_mesh(args.mesh, scale=args.scale)
    refuse_wrong_scale(raw, scale=args.scale)
    body = repair_mesh(raw)
    mass = mass_properties(body.mesh)
    size = " x ".join(f"{edge:.4g}" for edge in np.ptp(body.mesh.vertices, axis=0))
    center = ", ".join(f"{value:.4g}" for value in mass.center_mass)
    rows = [
        ("file", args.mesh),
        ("triangles", f"{len(raw.faces)} as read, {len(body.mesh.faces)} as used"),
        ("size", f"{size} m (bounding box, with scale {args.scale:g})"),
        ("volume", f"{mass.volume:.4g} m^3"),
        ("centre of mass", f"({center}) m"),
        ("torque scale", f"{mass.torque_scale:.4g} m (farthest point from the centre of mass)"),
    ]
    rows += [("repaired", repair) for repair in body.repairs] or [
        ("repaired", "nothing: it is sound")
    ]
    for name, text in rows:
        print(f"{name:>15}  {text}")
    return 0
