"""What a plan says about its time: named parts, none counted twice, that sum to the total."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numba import njit
from scipy.stats import qmc

from medkit.grasping import plan_power_grasps
from medkit.grasping.closing.hand_tables import halton
from medkit.grasping.parallel import processes_for
from medkit.grasping.stopwatch import STAGES, Stopwatch
from medkit.robots import load_hand


def test_the_parts_of_a_plan_sum_to_its_total():
    found = plan_power_grasps(
        trimesh.creation.capsule(0.15, 0.02),
        load_hand("armar3"),
        max_candidates=4,
        rng=np.random.default_rng(0),
    )
    assert tuple(found.timing) == STAGES
    parts = [found.timing[stage] for stage in STAGES if stage != "total"]
    assert min(parts) >= 0.0
    assert sum(parts) == pytest.approx(found.timing["total"], abs=1e-12)
    assert found.timing["preparation"] > 0.0
    assert found.timing["closing"] > 0.0


def test_compiling_is_booked_apart_from_the_lap_in_which_it_falls():
    watch = Stopwatch()
    njit(lambda x: x + 1)(1)
    watch.lap("closing")
    assert watch.laps["kernels"] > 0.0
    before = watch.laps["kernels"]
    watch.lap("closing")  # nothing was compiled since
    assert watch.laps["kernels"] == before


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_judging_is_part_of_closing_however_many_processes_share_it(jobs):
    watch = Stopwatch()
    watch.lap("closing")
    spent = watch.laps["closing"]
    for quality in (0.5 * spent, 100.0 * spent):
        stages = watch.stages(quality=quality, jobs=jobs)
        assert stages["quality"] == pytest.approx(min(quality / jobs, spent))
        assert stages["closing"] + stages["quality"] == pytest.approx(spent)
        assert stages["total"] == pytest.approx(sum(watch.laps.values()))


def test_few_candidates_are_not_worth_several_processes():
    assert [processes_for(count, 4) for count in (0, 7, 8, 400)] == [1, 1, 4, 4]
    assert processes_for(400, 1) == 1


def test_the_sequence_that_spreads_probes_is_that_of_scipy():
    for dimension in (1, 2, 11, 24):
        wanted = qmc.Halton(dimension, scramble=False).random(200)
        np.testing.assert_allclose(halton(200, dimension), wanted, atol=1e-12)
