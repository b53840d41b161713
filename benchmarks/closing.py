"""Closing a hand: ours against a plain coal loop that stops at the first hit, in one run."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import trimesh

from medkit.datasets import load_object
from medkit.grasping import candidates_from_axis, medial_axis
from medkit.grasping.precision import PrecisionTester
from medkit.grasping.testers import PowerTester, Quality
from medkit.meshes import mass_properties
from medkit.robots import load_hand

STEP = np.radians(2.0)  # [rad] first stride of the rival's joints
HALVINGS = 10
FIGURES = (
    "{faces:6} faces: closing {ours_s:.5f} s, candidate {whole_s:.5f} s, coal {coal_s:.4f} s,"
    " ratio {ratio:.0f}"
)


def objects() -> dict[str, trimesh.Trimesh]:
    torus = trimesh.creation.torus(0.05, 0.015, major_sections=256, minor_sections=96)
    return {
        "capsule": trimesh.creation.capsule(0.12, 0.025, count=[64, 64]),
        "torus": torus,
        **{name: load_object(name) for name in ("bottle", "moon", "figure")},
    }


def run(candidates: int = 15) -> dict[str, Any]:
    """Print and return medians of the processor time [s] per candidate, and their ratio."""
    hand = load_hand("armar3")
    rows = {}
    for name, mesh in objects().items():
        found = candidates_from_axis(
            medial_axis(mesh), search_radius=0.03, hand_radii=hand.sphere_radii
        )
        body = mass_properties(mesh)
        quality = Quality(0.5, body.center_mass, body.torque_scale)
        rival = CoalLoop(hand, mesh)
        picked = np.linspace(0, len(found) - 1, candidates).astype(int)
        for grasp, kind in (("power", PowerTester), ("precision", PrecisionTester)):
            tester = kind.build(hand, np.asarray(mesh.triangles), quality)
            row = f"{name} {grasp}"
            rows[row] = {"faces": len(mesh.faces), **compared(tester, rival, found, picked)}
            print(f"{row:18}", FIGURES.format(**rows[row]))
    return rows


def compared(tester: Any, rival: CoalLoop, found: Any, picked: Any) -> dict[str, float]:
    """Medians [s] of closing and of the whole candidate, and of the rival from the same start."""
    preshape = tester.closer.arrays.preshape
    times = []
    for row, k in enumerate([picked[0], *picked]):
        args = found.grasp_point[k], found.approach[k], found.closing_axis[k], found.radius[k]
        begin = time.process_time()
        closed = tester.closed(*args)
        middle = time.process_time()
        tester.test(*args)
        end = time.process_time()
        rival.close(closed.start_pose, preshape)
        if row:  # the first one compiles
            times.append((middle - begin, end - middle, time.process_time() - end))
    ours, whole, theirs = np.median(times, axis=0)
    return {"ours_s": ours, "whole_s": whole, "coal_s": theirs, "ratio": theirs / ours}


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

    def close(self, pose: Any, preshape: Any) -> Any:
        """Joint coordinates after closing from a preshape at a pose that is free of collision."""
        q = np.array(preshape)
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
