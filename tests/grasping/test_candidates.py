"""Candidates: geometry of the directions, and fates that add up."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from medkit.datasets.objects import load_object
from medkit.errors import InputError
from medkit.geometry import apply, random_rotation, transform
from medkit.grasping import (
    MedialSphereGrid,
    SphereFate,
    SymmetryKind,
    candidates_from_axis,
    local_symmetry,
    medial_axis,
    medial_axis_from_surface,
    plan_grasps,
    sample_surface,
)
from medkit.grasping.reach import way_out
from medkit.grasping.special_solids import (
    BALL_ROLLS,
    ball_directions,
    borders_of_whole_sheets,
    opposing_chords,
)
from medkit.medial.filters import MIN_OBJECT_ANGLE
from medkit.robots import load_hand


def found_for(mesh, **options):
    return candidates_from_axis(medial_axis(mesh), search_radius=0.03, **options)


@pytest.fixture(scope="module")
def sheet():
    return found_for(trimesh.creation.box([0.02, 0.12, 0.16]))


def test_directions_are_unit_and_at_right_angles(sheet):
    for vectors in (sheet.approach, sheet.closing_axis):
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0, atol=1e-9)
    across = np.einsum("ij,ij->i", sheet.approach, sheet.closing_axis)
    np.testing.assert_allclose(across, 0.0, atol=1e-9)


def test_fates_add_up_to_all_spheres(sheet):
    assert sum(sheet.fate_counts().values()) == len(sheet.fate)


def test_rim_is_approached_from_outside(sheet):
    rim = sheet.kind == SphereFate.RIM
    assert rim.any()
    # towards the middle of the sheet: from the side away from the centroid
    inwards = -np.einsum("ij,ij->i", sheet.approach[rim], sheet.grasp_point[rim])
    assert (inwards > 0.0).mean() > 0.95


def test_axis_is_approached_from_all_around_with_both_closing_axes():
    found = found_for(trimesh.creation.capsule(0.2, 0.02))
    sphere = found.sphere[found.kind == SphereFate.AXIS][0]
    rows = found.sphere == sphere
    assert rows.sum() == 8
    np.testing.assert_allclose(found.approach[rows].sum(axis=0), 0.0, atol=1e-9)
    np.testing.assert_allclose(found.closing_axis[rows].sum(axis=0), 0.0, atol=1e-9)


def test_hand_size_limits_candidates_not_the_analysis():
    mesh = trimesh.creation.capsule(0.2, 0.02)
    free, limited = found_for(mesh), found_for(mesh, hand_radii=(0.0, 0.01))
    assert len(limited) == 0
    counts = limited.fate_counts()
    assert counts["too_large_for_hand"] == free.fate_counts()["axis"]


def test_candidates_turn_with_the_object():
    mesh = trimesh.creation.box([0.03, 0.05, 0.15])
    pose = transform(random_rotation(np.random.default_rng(3)), [0.3, -0.2, 0.1])
    moved = mesh.copy()
    moved.apply_transform(pose)
    axis = medial_axis(mesh)
    # the same spheres, moved: sampling itself is not what is tested here
    turned = axis.__class__(
        **{
            **{name: getattr(axis, name) for name in axis.__dataclass_fields__},
            "centers": apply(pose, axis.centers),
            "touch_points": apply(pose, axis.touch_points.reshape(-1, 3)).reshape(-1, 2, 3),
        }
    )
    first = candidates_from_axis(axis, search_radius=0.03)
    second = candidates_from_axis(turned, search_radius=0.03)
    np.testing.assert_array_equal(first.fate, second.fate)
    np.testing.assert_allclose(first.approach @ pose[:3, :3].T, second.approach, atol=1e-6)


@pytest.mark.parametrize("shape", ["ball", "cube", "cylinder"])
def test_special_solids_get_candidates(shape):
    mesh = {
        "ball": trimesh.creation.icosphere(subdivisions=4, radius=0.03),
        "cube": trimesh.creation.box([0.05, 0.05, 0.05]),
        "cylinder": trimesh.creation.cylinder(0.025, 0.05, sections=64),
    }[shape]
    found = found_for(mesh)
    assert len(found) >= 8
    middle = np.linalg.norm(found.grasp_point - mesh.center_mass, axis=1)
    # all of them: a lonely sphere at an edge is no ball
    assert middle.max() < 0.005


def test_chords_of_a_cube_and_directions_across_them():
    chords = opposing_chords(np.vstack([np.eye(3), -np.eye(3)]), 1.0)
    assert len(chords) == 3
    approach, closing = ball_directions(chords)
    # fingers close across a chord: approach, closing axis and chord are at right angles
    across = np.cross(approach, closing)
    assert np.abs(np.abs(across @ chords.T).max(axis=1) - 1.0).max() < 1e-9


@pytest.mark.parametrize("side", [0.02, 0.06, 0.08, 0.15])
@pytest.mark.parametrize("turn", [None, 1, 2])
def test_a_cube_is_grasped_across_all_three_chords(side, turn):
    mesh = trimesh.creation.box([side] * 3)
    rotation = np.eye(3) if turn is None else random_rotation(np.random.default_rng(turn))
    mesh.vertices = mesh.vertices @ rotation.T
    found = candidates_from_axis(medial_axis(mesh), search_radius=0.03)
    assert len(found) == 3 * 4 * 2
    assert set(found.kind) == {SphereFate.DOMINANT_SPHERE}
    across = np.cross(found.approach, found.closing_axis) @ rotation
    # square across the faces, up to the distance of the samples, as often across each pair
    assert np.abs(across).max(axis=1).min() > np.cos(np.radians(3.0))
    assert np.bincount(np.abs(across).argmax(axis=1)).tolist() == [8, 8, 8]


def test_a_ball_is_approached_from_all_around_in_several_turns():
    approach, closing = ball_directions(np.zeros((0, 3)))
    directions = approach[::BALL_ROLLS]
    nearest = np.sort(directions @ directions.T, axis=1)[:, -2]
    # as far apart as a hexagonal lattice of so many directions, give or take a third
    apart = np.sqrt(4.0 * np.pi / len(directions) * 2.0 / np.sqrt(3.0))
    assert (np.arccos(nearest) > 0.67 * apart).all()
    turns = closing.reshape(-1, BALL_ROLLS, 3)
    np.testing.assert_allclose(turns.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", approach, closing), 0.0, atol=1e-12)


def test_a_tetrahedron_has_no_opposing_chord():
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
    assert len(opposing_chords(corners, 1.0)) == 0


def test_bad_parameters_are_refused():
    axis = medial_axis(trimesh.creation.capsule(0.1, 0.02))
    with pytest.raises(InputError, match="min_radius_ratio"):
        candidates_from_axis(axis, search_radius=0.03, min_radius_ratio=1.5)
    with pytest.raises(InputError, match="search_radius"):
        candidates_from_axis(axis, search_radius=0.0)


@pytest.mark.parametrize(("gap", "reached"), [(0.02, False), (0.06, True)])
def test_a_rim_is_reached_through_a_gap_that_exceeds_its_neighbourhood(gap, reached):
    # two plates in one plane: in a narrow gap between them there is no outside
    one = trimesh.creation.box([0.1, 0.16, 0.02])
    other = one.copy()
    other.apply_translation([0.1 + gap, 0.0, 0.0])
    axis = medial_axis_from_surface(sample_surface(trimesh.util.concatenate([one, other])))
    found = candidates_from_axis(axis, search_radius=0.03)
    assert set(found.kind) == {SphereFate.RIM}
    x = found.grasp_point[:, 0]
    across = np.abs(found.approach[:, 0]) > 0.9
    between = (x > 0.0) & (x < 0.1 + gap)
    assert (across & ~between).sum() > 20
    assert (across & between).any() == reached


def test_a_mug_is_held_by_its_handle():
    # the handle's ends face the mug itself, some centimetres away
    mug, hand = load_object("mug"), load_hand("armar3")
    grasps = plan_grasps(mug, hand, max_candidates=60, rng=np.random.default_rng(0))
    assert grasps.outcomes.get("force_closure", 0) > 0


def test_a_rim_ends_with_the_object_within_its_neighbourhood():
    # in a thick body the limit on the object angle cuts sheets off far from any rim
    mesh = load_object("bust")
    axis = medial_axis(mesh)
    for radius in (0.03, 0.06):
        found = candidates_from_axis(axis, search_radius=radius)
        rim = found.select(np.flatnonzero(found.kind == SphereFate.RIM))
        depth, room = way_out(axis, rim.grasp_point, -rim.approach)
        assert len(rim) > 100
        assert (room >= radius).all()
        assert (depth <= rim.radius + radius).all()


@pytest.fixture(scope="module")
def slab():
    """A flat box the size of the hand, turned askew."""
    box = trimesh.creation.box([0.05, 0.04, 0.02])
    turn = np.eye(4)
    turn[:3, :3] = random_rotation(np.random.default_rng(8))
    return box.apply_transform(turn), turn[:3, :3]


def test_a_sheet_seen_whole_is_grasped_across_its_border_from_outside(slab):
    mesh, turn = slab
    axis = medial_axis(mesh)
    wide = axis.select(np.flatnonzero(axis.object_angles > MIN_OBJECT_ANGLE))
    plain = local_symmetry(MedialSphereGrid.from_axis(wide), 0.06)
    assert set(plain.kind) <= {SymmetryKind.INTERIOR, SymmetryKind.TOO_FEW}
    found = candidates_from_axis(axis, search_radius=0.06)
    assert set(found.kind) == {SphereFate.RIM}
    ahead, along = found.approach @ turn, found.closing_axis @ turn
    place = found.grasp_point @ turn
    # the hand comes inwards, and the fingers close across the thin side
    assert (np.einsum("ij,ij->i", ahead, place) < 0.0).all()
    across = np.cross(ahead, along)
    assert np.abs(across[:, 2]).min() > 0.99


def test_spheres_on_the_border_of_a_whole_sheet_are_those_far_from_its_middle(slab):
    mesh, turn = slab
    axis = medial_axis(mesh)
    found = candidates_from_axis(axis, search_radius=0.06)
    place = np.abs(axis.centers @ turn)
    inside = found.fate == SphereFate.INSIDE_SHEET
    assert inside.sum() > 20
    assert (
        np.linalg.norm(place[inside], axis=1).max()
        < np.linalg.norm(place[found.fate == SphereFate.RIM], axis=1).max()
    )


def test_sheets_with_rims_of_their_own_are_left_as_they_are():
    axis = medial_axis(trimesh.creation.box([0.3, 0.2, 0.02]))
    wide = axis.select(np.flatnonzero(axis.object_angles > MIN_OBJECT_ANGLE))
    symmetry = local_symmetry(MedialSphereGrid.from_axis(wide), 0.03)
    assert (symmetry.kind == SymmetryKind.RIM).any()
    assert borders_of_whole_sheets(symmetry, wide.centers) is symmetry
