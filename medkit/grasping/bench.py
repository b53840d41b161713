"""One object prepared once for many settings of planners: medial axis, closing, quality."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import trimesh

from medkit.geometry import Floats, nonnegative
from medkit.grasping.candidate_set import CandidateGrasps
from medkit.grasping.candidates import candidates_from_axis
from medkit.grasping.choosing import choose_candidates
from medkit.grasping.grasp_set import Grasp
from medkit.grasping.parallel import run_candidates
from medkit.grasping.settings import Setting
from medkit.grasping.stopwatch import Stopwatch
from medkit.grasping.strategies import (
    CANDIDATE_SOURCES,
    CHOOSERS,
    REFINERS,
    TESTERS,
    looked_up,
    radii_for,
)
from medkit.grasping.testers import Quality
from medkit.medial.axis import MedialAxis, medial_axis
from medkit.meshes import mass_properties
from medkit.meshes.usable import refuse_unusable
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand

FRICTION = 0.5  # P13 5.1.3


class ObjectBench:
    """One object prepared once for many settings: medial axis, closing, quality.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A closed mesh with outward normals [m].
    hand : Hand
        The hand.
    friction : float
        Friction coefficient of hard point contacts [1].
    """

    def __init__(
        self, mesh: trimesh.Trimesh, hand: Hand | str, *, friction: float = FRICTION
    ) -> None:
        refuse_unusable(mesh)
        body = mass_properties(mesh)
        self.mesh = mesh
        self.hand = usable_hand(hand)
        rough = nonnegative(friction, "friction")
        self.quality = Quality(rough, body.center_mass, body.torque_scale)
        self._axis: MedialAxis | None = None
        self._testers: dict[str, Any] = {}

    @property
    def axis(self) -> MedialAxis:
        """The object's medial axis, computed at the first need."""
        if self._axis is None:
            self._axis = medial_axis(self.mesh)
        return self._axis

    def tester(self, grasp: str, planner: str = "medial") -> Any:
        """What closes and judges grasps of a kind as a planner does; prepared at the first need."""
        if grasp not in self._testers:
            make = looked_up(TESTERS, grasp, "kind of grasp")
            triangles = np.asarray(self.mesh.triangles, dtype=float)
            self._testers[grasp] = make(self.hand, triangles, self.quality)
        tester = self._testers[grasp]
        if planner in REFINERS:
            return looked_up(REFINERS, planner, "planner")(tester, self.hand)
        return tester

    def candidates(self, setting: Setting) -> CandidateGrasps:
        """All candidates of a setting, as `plan_grasps` would have them."""
        if setting.planner == "medial":
            return candidates_from_axis(
                self.axis,
                search_radius=setting.search_radius,
                min_radius_ratio=setting.min_radius_ratio,
                hand_radii=radii_for(self.hand, setting.grasp),
            )
        source = looked_up(CANDIDATE_SOURCES, setting.planner, "planner")
        found: CandidateGrasps = source(
            self.mesh,
            self.hand,
            grasp=setting.grasp,
            search_radius=setting.search_radius,
            min_radius_ratio=setting.min_radius_ratio,
            watch=Stopwatch(),
        )
        return found

    def chosen(
        self, setting: Setting, *, most: int | None, rng: np.random.Generator
    ) -> CandidateGrasps:
        """At most so many candidates of a setting, drawn as its planner draws them."""
        found = self.candidates(setting)
        if setting.planner in CHOOSERS:
            drawn: CandidateGrasps = looked_up(CHOOSERS, setting.planner, "planner")(
                found, most, rng
            )
            return drawn
        return choose_candidates(found, most, rng)

    def grasps(
        self, setting: Setting, *, most: int | None, rng: np.random.Generator
    ) -> tuple[list[Grasp], Floats]:
        """Tested grasps of a setting, at most so many, and the time each took [s]."""
        chosen = self.chosen(setting, most=most, rng=rng)
        found, spent = [], []
        begin = time.process_time()
        for grasp, _ in run_candidates(self.tester(setting.grasp, setting.planner), chosen):
            found.append(grasp)
            spent.append(time.process_time() - begin)
        return found, np.diff(np.asarray([0.0, *spent]))
