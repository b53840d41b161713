"""Fingers that do not exist, sizes, clusters, rankings and their stability."""

import numpy as np
import pytest

from medkit.errors import InputError
from medkit.geometry import rotation_about
from medkit.similarity.clusters import aligned, find_clusters
from medkit.similarity.grasps import HumanGrasps
from medkit.similarity.hands import correspondence, scaled_to_object
from medkit.similarity.ranking import (
    MEASURES,
    human_reference,
    rank_agreement,
    rank_grasps,
    ranking_stability,
)
from medkit.similarity.simulation import SHAPES, simulate_fingertips
from medkit.similarity.symmetry import revolution_group, trivial_group
from medkit.similarity.synergies import (
    JOINTS,
    load_postures,
    simulate_postures,
    synergies_from_postures,
)

CYLINDER = SHAPES[0]


def people(count=6, subjects=3) -> HumanGrasps:
    tips = [
        simulate_fingertips(CYLINDER, rng=np.random.default_rng(s), count=count)
        for s in range(subjects)
    ]
    names = np.repeat([f"S{s}" for s in range(subjects)], count)
    n = len(names)
    return HumanGrasps(
        names, np.repeat("cylinder", n), np.tile(np.arange(count), subjects),
        np.concatenate(tips), np.zeros((n, 3)), np.ones(n), np.ones(n, dtype=bool),
    )  # fmt: skip


def reference(group, **options):
    size = CYLINDER.extents
    return human_reference(people(), recorded_extents=size, extents=size, group=group, **options)


@pytest.mark.parametrize("fingers", [2, 3, 4, 5])
def test_every_human_finger_is_stood_for_exactly_once(fingers):
    weights = correspondence(fingers).weights
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert np.all((weights > 0.0).sum(axis=0) == 1)
    tips = np.random.default_rng(1).normal(size=(3, 5, 3))
    assert correspondence(fingers).human(tips).shape == (3, fingers, 3)


def test_scaling_maps_the_surface_of_one_box_onto_another():
    corner = 0.5 * np.array([[[0.09, 0.055, 0.15]] * 5])
    scaled = scaled_to_object(
        corner, recorded_extents=[0.09, 0.055, 0.15], extents=[0.19, 0.06, 0.28]
    )
    np.testing.assert_allclose(scaled, 0.5 * np.array([0.19, 0.06, 0.28]) + 0.0 * corner)
    with pytest.raises(InputError, match="sizes"):
        scaled_to_object(corner, recorded_extents=[0.0, 1.0, 1.0], extents=[1.0, 1.0, 1.0])
    with pytest.raises(InputError, match="two to five"):
        correspondence(6)


def test_a_persons_own_average_ranks_first_and_turning_the_can_changes_nothing():
    ref = reference(revolution_group([0, 0, 1]))
    rng = np.random.default_rng(4)
    mean = ref.fingertips[ref.subject == "S1"].mean(axis=0)
    planned = np.concatenate([rng.normal(scale=0.05, size=(8, 5, 3)), mean[None]])
    table = rank_grasps(planned, ref)
    assert table["grasp"][0] == 8
    assert table["subject"][0] == "S1"
    assert table["d_symmetric"][0] < 1e-12
    turned = rank_grasps(planned @ rotation_about([0, 0, 1], 2.0).T, ref)
    assert turned["grasp"].tolist() == table["grasp"].tolist()
    for measure in ("d_symmetric", "nearest", "share", "d_z"):
        np.testing.assert_allclose(turned[measure], table[measure], atol=1e-12)
    assert np.all(table["d_symmetric"] <= table["d_eucl"] + 1e-12)
    assert np.all(table["d_z"] <= table["d_eucl"])


def test_jaws_of_a_gripper_may_be_swapped():
    ref = reference(trivial_group(), fingers=2, interchangeable=True)
    planned = ref.fingertips[:3, ::-1]
    assert rank_grasps(planned, ref)["nearest"].max() < 1e-12
    one_way = reference(trivial_group(), fingers=2)
    assert rank_grasps(planned, one_way)["nearest"].min() > 0.05


def test_agreement_and_stability_are_correlations():
    ref = reference(revolution_group([0, 0, 1]))
    planned = np.random.default_rng(4).normal(scale=0.05, size=(20, 5, 3))
    table = rank_grasps(planned, ref)
    agreement = rank_agreement(table, rng=np.random.default_rng(1), draws=50)
    assert len(agreement) == 6
    assert np.all((agreement.low <= agreement.tau) & (agreement.tau <= agreement.high))
    double = table.assign(d_z=table["d_eucl"] ** 3)  # any rising function orders alike
    same = rank_agreement(double, rng=np.random.default_rng(1), measures=("d_eucl", "d_z"), draws=9)
    assert same["tau"][0] == pytest.approx(1.0)
    for what, count in (("subject", 3), ("trial", 18)):
        stability = ranking_stability(planned, ref, leave_out=what)
        assert len(stability) == count * len(MEASURES)
        assert stability["tau"].between(-1.0, 1.0).all()
    assert stability["tau"].min() > 0.5


def test_unusable_rankings_are_refused():
    ref = reference(trivial_group())
    planned = np.zeros((2, 5, 3))
    with pytest.raises(InputError, match="measure"):
        rank_grasps(planned, ref, by="beauty")
    with pytest.raises(InputError, match="subject"):
        rank_grasps(planned, ref, subject="nobody")
    with pytest.raises(InputError, match="five grasps"):
        rank_agreement(rank_grasps(planned, ref), rng=np.random.default_rng(1))
    with pytest.raises(InputError, match="leave_out"):
        ranking_stability(planned, ref, leave_out="finger")
    with pytest.raises(InputError, match="there are none"):
        people().of(subject="nobody")


@pytest.mark.parametrize(("turns", "count"), [((0.0,), 1), ((0.0, 2.1, 4.2), 3)])
def test_clusters_are_counted_and_one_group_is_no_cluster(turns, count):
    tips = simulate_fingertips(
        CYLINDER, rng=np.random.default_rng(2), count=48, azimuths=np.array(turns)
    )
    found = find_clusters(tips, rng=np.random.default_rng(3), references=8)
    assert found.count == count
    assert found.found == (count > 1)
    assert np.all(np.diff(np.bincount(found.labels)) <= 0)
    moved = find_clusters(tips + 0.3, rng=np.random.default_rng(3), references=8)
    np.testing.assert_array_equal(moved.labels, found.labels)


def test_a_ring_and_a_long_cloud_have_no_clusters():
    ring = simulate_fingertips(
        CYLINDER, rng=np.random.default_rng(3), count=60, azimuths=np.linspace(0, 6.28, 500)
    )
    rng = np.random.default_rng(5)
    cloud = rng.uniform(size=(60, 1, 1)) + 0.02 * rng.normal(size=(60, 5, 3))
    for data in (ring, cloud):
        assert not find_clusters(data, rng=np.random.default_rng(1), references=8).found
    with pytest.raises(InputError, match="ten grasps"):
        find_clusters(ring[:5], rng=rng)


def test_alignment_removes_turns_and_keeps_shapes():
    group = revolution_group([0, 0, 1])
    base = simulate_fingertips(CYLINDER, rng=np.random.default_rng(1), count=12)
    rng = np.random.default_rng(2)
    scattered = np.stack([g @ group.random_element(rng=rng).T for g in base])
    gathered = aligned(scattered, group)
    assert gathered.std(axis=0).mean() < 0.3 * scattered.std(axis=0).mean()
    pairs = [np.linalg.norm(x[:, :, None] - x[:, None], axis=3) for x in (scattered, gathered)]
    np.testing.assert_allclose(pairs[0], pairs[1], atol=1e-12)


def test_synergies_recover_directions_that_were_put_in():
    rng = np.random.default_rng(1)
    basis = np.linalg.qr(rng.normal(size=(15, 15)))[0][:2]
    weights = rng.normal(size=(400, 2)) * [0.5, 0.2]
    found = synergies_from_postures(weights @ basis + 1e-4 * rng.normal(size=(400, 15)))
    assert abs(found.components[0] @ basis[0]) > 0.99
    assert found.share[1] > 0.999
    postures = weights @ basis
    np.testing.assert_allclose(found.posture(found.weights(postures)), postures, atol=1e-12)
    np.testing.assert_allclose(found.components @ found.components.T, np.eye(15), atol=1e-12)
    with pytest.raises(InputError, match="more grasps"):
        synergies_from_postures(postures[:10])


def test_postures_are_simulated_and_read_in_the_unit_that_is_said(tmp_path):
    table = simulate_postures(12, rng=np.random.default_rng(1))
    assert table["simulated"].all()
    degrees = table.drop(columns="simulated").copy()
    degrees[list(JOINTS)] = np.rad2deg(degrees[list(JOINTS)])
    degrees.to_csv(tmp_path / "p.csv", index=False)
    again = load_postures(tmp_path / "p.csv", angle_unit="deg")
    np.testing.assert_allclose(again[list(JOINTS)], table[list(JOINTS)])
    with pytest.raises(InputError, match="unit"):
        load_postures(tmp_path / "p.csv", angle_unit="rad")
    with pytest.raises(InputError, match="rad or deg"):
        load_postures(tmp_path / "p.csv", angle_unit="grad")
    with pytest.raises(InputError, match="Expected a CSV"):
        load_postures(tmp_path / "none.csv", angle_unit="rad")
