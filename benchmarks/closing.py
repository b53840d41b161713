"""Closing a hand: ours against a plain coal loop that stops at the first hit, in one run."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import trimesh

from medkit.grasping import PowerCloser, candidates_from_axis, medial_axis, object_field
from medkit.robots import load_hand

STEP = np.radians(2.0)  # [rad] first stride of the rival's joints
HALVINGS = 10


def objects() -> dict[str, trimesh.Trimesh]:
    return {
        "capsule": trimesh.creation.capsule(0.12, 0.025, count=[64, 64]),
        "torus": trimesh.creation.torus(0.05, 0.015, major_sections=128, minor_sections=64),
    }


def run(candidates: int = 15) -> dict[str, Any]:
    """Print and return medians of the processor time [s] per candidate, and their ratio."""
    hand = load_hand("armar3")
    rows = {}
    for name, mesh in objects().items():
        found = candidates_from_axis(
            medial_axis(mesh), search_radius=0.03, hand_radii=hand.sphere_radii
        )
        picked = np.linspace(0, len(found) - 1, candidates).astype(int)
        closer = PowerCloser(hand, object_field(mesh.triangles))
        rival = CoalLoop(hand, mesh)
        ours, theirs = [], []
        for row, k in enumerate([picked[0], *picked]):
            args = found.grasp_point[k], found.approach[k], found.closing_axis[k]
            begin = time.process_time()
            grasp = closer.close(*args)
            middle = time.process_time()
            rival.close(grasp.pose)
            if row:  # the first one compiles
                ours.append(middle - begin)
                theirs.append(time.process_time() - middle)
        rows[name] = {
            "faces": len(mesh.faces),
            "ours_s": float(np.median(ours)),
            "coal_s": float(np.median(theirs)),
            "ratio": float(np.median(theirs) / np.median(ours)),
        }
        figures = "ours {ours_s:.4f} s, coal {coal_s:.4f} s, ratio {ratio:.0f}"
        print(f"{name:8} {len(mesh.faces)} faces:", figures.format(**rows[name]))
    return rows


class CoalLoop:
    """Joint by joint in steps, each link against the mesh, stop at the first hit; no retreat."""

    def __init__(self, hand: Any, mesh: trimesh.Trimesh) -> None:
        import coal

        self.hand, self.coal = hand, coal
        self.model = coal.BVHModelOBBRSS()
        self.model.beginModel(len(mesh.faces), len(mesh.vertices))
        self.model.addVertices(np.array(mesh.vertices))
        self.model.addTriangles(np.array(mesh.faces, dtype=np.int64))
        self.model.endModel()
        self.parts = []
        for body in hand.bodies:
            points = coal.StdVec_Vec3s()
            points.extend(list(body.vertices))
            self.parts.append(coal.Convex.convexHull(points, True, "Qt"))

    def hits(self, q: Any, pose: Any, bodies: Any) -> bool:
        """Whether one of the bodies meets the mesh."""
        links = self.hand.link_poses(q)
        for b in bodies:
            at = pose @ links[self.hand.bodies[b].link]
            place = self.coal.Transform3s(at[:3, :3], at[:3, 3])
            request, result = self.coal.CollisionRequest(), self.coal.CollisionResult()
            world = self.coal.Transform3s()
            if self.coal.collide(self.model, world, self.parts[b], place, request, result):
                return True
        return False

    def close(self, pose: Any) -> Any:
        """Joint coordinates after closing at a pose that is free of collision."""
        q = np.array(self.hand.preshapes["power"])
        for finger in self.hand.fingers:
            for joint, sign, bodies in zip(
                finger.joints, finger.closing, finger.moved_bodies, strict=True
            ):
                step, halved = STEP, 0
                while halved <= HALVINGS and q[joint] < np.radians(120.0):
                    q[joint] += sign * step
                    if self.hits(q, pose, bodies):
                        q[joint] -= sign * step
                        step, halved = step / 2, halved + 1
        return q


if __name__ == "__main__":
    run()
