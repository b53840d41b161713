"""The simulated squeeze: it repeats itself, follows the bound, and gets easier with friction."""

import numpy as np
import pytest

from medkit import planar
from medkit.errors import InputError
from medkit.planar.squeezing import SqueezeSettings


def ratio_on(outline, touch, bound, **settings):
    found = planar.simulated_critical_friction(
        outline, *touch, low=0.5 * bound, high=2.0 * bound, tolerance=4e-3,
        settings=SqueezeSettings(**settings),
    )  # fmt: skip
    return found / bound


def test_wedge_family_follows_the_bound():
    family = planar.wedge_family(np.radians([90.0, 120.0, 150.0, 175.0]))
    assert family["deviation"].abs().max() < 0.03
    assert family["deviation"].abs().median() < 0.01


@pytest.mark.parametrize(
    "settings", [{"step": 1 / 300}, {"iterations": 10}, {"slop": 1e-5}, {"tip_radius": 0.03}]
)
def test_numerical_settings_do_not_move_the_critical_friction(settings):
    outline, touch = planar.wedge(np.radians(130.0))
    bound = planar.min_friction(np.radians(130.0))
    assert ratio_on(outline, touch, bound, **settings) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("outline", [planar.ellipse(), planar.banana()], ids=lambda o: o.name)
def test_smooth_shapes_follow_the_bound_too(outline):
    axis = planar.medial_axis(outline)
    fit = np.flatnonzero((axis.object_angles > 2.0) & (axis.object_angles < 2.8))
    for index in fit[[2, -3]]:
        bound = planar.min_friction(axis.object_angles[index])
        assert ratio_on(outline, axis.touch_points[index], bound) == pytest.approx(1.0, abs=0.01)


def test_same_call_gives_the_same_trajectory():
    outline, touch = planar.wedge(np.radians(120.0))
    first, second = (planar.squeeze(outline, *touch, friction=0.5, frames=20) for _ in range(2))
    assert np.array_equal(first.poses, second.poses)
    assert np.array_equal(first.tips, second.tips)
    assert not first.held
    assert first.reason == second.reason


def test_shape_may_lie_anywhere_and_have_any_size():
    outline, touch = planar.wedge(np.radians(120.0))
    moved = planar.outline_from_loops(10.0 * outline.loops[0] + [3.0, -1.0])
    for friction, held in ((0.55, False), (0.6, True)):
        assert planar.squeeze(outline, *touch, friction=friction).held == held
        away = planar.squeeze(moved, *(10.0 * touch + [3.0, -1.0]), friction=friction)
        assert away.held == held


def test_heavy_objects_slip_where_light_ones_do_not():
    outline = planar.rectangle(0.08, 0.04)
    grip = [[-0.04, 0.0], [0.04, 0.0]]
    light, heavy = (SqueezeSettings(gravity_share=share) for share in (0.5, 0.7))
    # two fingers carry at most twice friction times squeeze force
    assert planar.squeeze(outline, *grip, friction=0.3, settings=light).held
    assert not planar.squeeze(outline, *grip, friction=0.3, settings=heavy).held


def test_fingers_off_the_chord_need_more_friction():
    outline = planar.rectangle(0.08, 0.04)
    grip = [[0.0, -0.02], [0.0, 0.02]]
    assert planar.squeeze(outline, *grip, friction=0.1).held
    assert not planar.squeeze(outline, *grip, friction=0.1, offset=0.006).held
    assert planar.squeeze(outline, *grip, friction=0.2, offset=0.006).held


def test_three_fingers_and_flat_jaws_hold_a_bar():
    outline = planar.rectangle(0.08, 0.04)
    for fixture in ("three fingers", "flat jaws"):
        result = planar.squeeze(outline, [0, -0.02], [0, 0.02], friction=0.2, fixture=fixture)
        assert result.held, result.reason


@pytest.mark.parametrize(
    "arguments",
    [
        {"p1": [0, -0.02], "p2": [0, 0.02], "friction": -0.1},
        {"p1": [0, 0.0], "p2": [0, 0.02], "friction": 0.3},
        {"p1": [0, 0.02], "p2": [0, 0.02], "friction": 0.3},
        {"p1": [0, -0.02], "p2": [0, 0.02], "friction": 0.3, "fixture": "chopsticks"},
    ],
)
def test_bad_input_is_refused(arguments):
    with pytest.raises(InputError):
        planar.squeeze(planar.rectangle(0.08, 0.04), **arguments)
    with pytest.raises(InputError):
        SqueezeSettings(step=0.0)


def test_phase_diagram_matches_the_bound_away_from_it_and_jobs_do_not_matter():
    angles, frictions = np.radians([100.0, 140.0]), [0.2, 0.6, 1.0]
    one = planar.phase_diagram(angles, frictions)
    two = planar.phase_diagram(angles, frictions, jobs=2)
    assert one.disagreements == 0
    assert np.array_equal(one.held, two.held)


def test_agreement_table_has_three_opinions():
    table = planar.agreement([planar.triangle()], {"low": 0.2, "high": 0.9}, disks=3)
    assert len(table) == 6
    assert (table["bound"] == table["wrench"]).all()
    assert (table["bound"] == table["simulation"]).all()
