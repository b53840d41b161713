"""From samples to grasps: filter, movements, readers, and the simulated experiment."""

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from medkit.errors import InputError
from medkit.geometry import apply, random_rotation, transform
from medkit.similarity.grasps import grasps_from_recordings, recording_from_rows
from medkit.similarity.movements import find_movements, settled_sample
from medkit.similarity.readers import read_c3d, read_csv_recording, read_qualisys_tsv
from medkit.similarity.recordings import (
    Recording,
    frame_from_markers,
    held_to_missing,
    in_frame,
    lowpassed,
    only_forward_in_time,
    resampled,
    speeds,
)
from medkit.similarity.simulation import (
    SHAPES,
    Protocol,
    simulate_fingertips,
    simulate_recordings,
    true_end_postures,
)

SHORT = Protocol(subjects=2, trials=2)


def wave(frequency: float, rate: float = 100.0, seconds: float = 4.0) -> Recording:
    times = np.arange(int(seconds * rate)) / rate
    track = np.sin(2.0 * np.pi * frequency * times)
    return Recording(("a",), times, np.repeat(track[:, None, None], 3, axis=2))


@given(st.floats(0.5, 30.0))
@settings(max_examples=12, derandomize=True, deadline=None)
def test_filter_damps_as_butterworth_twice_and_without_delay(frequency):
    raw = wave(frequency)
    smooth = lowpassed(raw, cutoff=8.0)
    middle = slice(100, 300)
    a, b = raw.positions[middle, 0, 0], smooth.positions[middle, 0, 0]
    # bilinear transform: the analogue response holds at the warped frequency
    warped = np.tan(np.pi * frequency / 100.0) / np.tan(np.pi * 8.0 / 100.0)
    gain = 1.0 / (1.0 + warped**4)
    np.testing.assert_allclose(b, gain * a, atol=0.02)


def test_filter_leaves_gaps_as_gaps_and_constants_alone():
    raw = wave(1.0)
    raw.positions[:] = 0.25
    raw.positions[150:160] = np.nan
    smooth = lowpassed(raw)
    assert np.isnan(smooth.positions[150:160]).all()
    np.testing.assert_allclose(smooth.positions[:150], 0.25, atol=1e-12)


def test_resampling_bridges_short_gaps_and_leaves_long_ones():
    times = np.arange(0.0, 2.0, 0.01)
    line = np.repeat(times[:, None, None], 3, axis=2)
    line[50:60] = np.nan
    line[100:150] = np.nan
    even = resampled(Recording(("a",), times, line), rate=100.0, longest_gap=0.2)
    np.testing.assert_allclose(even.positions[50:60, 0, 0], even.times[50:60])
    assert np.isnan(even.positions[101:149]).all()


def test_speed_of_a_steady_movement():
    times = np.arange(0.0, 1.0, 0.01)
    places = times[:, None, None] * np.array([0.3, 0.0, 0.4])
    np.testing.assert_allclose(speeds(Recording(("a",), times, places)), 0.5)


@given(st.floats(0.2, 2.0), st.floats(0.3, 1.5))
@settings(max_examples=15, derandomize=True, deadline=None)
def test_threshold_crossings_of_a_bell_are_found(peak, duration):
    times = np.arange(0.0, duration + 1.0, 0.005)
    speed = peak * np.clip(np.sin(np.pi * (times - 0.5) / duration), 0.0, None)
    speed[(times < 0.5) | (times > 0.5 + duration)] = 0.0
    (move,) = find_movements(times, speed, shortest=0.05)
    crossing = 0.5 + duration / np.pi * np.arcsin(0.1 / peak)
    assert abs(times[move.start] - crossing) < 0.011
    assert abs(times[move.end] - (duration + 1.0 - crossing)) < 0.011
    assert move.start_seen
    assert move.end_seen
    assert move.peak_speed <= peak
    assert speed[settled_sample(move, speed, times)] <= speed[move.end]


def test_movements_at_either_end_are_said_to_be_cut_off():
    times = np.arange(0.0, 1.0, 0.01)
    (move,) = find_movements(times, np.full(100, 0.5))
    assert not move.start_seen
    assert not move.end_seen
    assert find_movements(times, np.full(100, np.nan)) == []


def test_clock_that_runs_backwards_is_refused_then_mended_on_request():
    raw = wave(1.0)
    raw.times[10:13] = raw.times[8]
    with pytest.raises(InputError, match="run forward"):
        resampled(raw, rate=100.0)
    mended, dropped = only_forward_in_time(raw)
    assert dropped == 3
    assert np.all(np.diff(mended.times) > 0.0)
    held = wave(1.0)
    held.positions[21:30] = held.positions[20]
    marked, count = held_to_missing(held)
    assert count == 9
    assert np.isnan(marked.positions[21:30]).all()


def test_object_frame_from_markers_makes_positions_independent_of_the_tracker():
    rng = np.random.default_rng(1)
    markers, points = rng.normal(size=(3, 3)), rng.normal(size=(20, 3))
    pose = transform(random_rotation(rng), rng.normal(size=3))
    times = np.arange(20) * 0.01
    results = []
    for place in (np.eye(4), pose):
        frame = frame_from_markers(*apply(place, markers))
        recording = Recording(("a",), times, apply(place, points)[:, None])
        results.append(in_frame(recording, frame).positions)
    np.testing.assert_allclose(results[0], results[1], atol=1e-12)
    with pytest.raises(InputError, match="one line"):
        frame_from_markers(np.zeros(3), np.ones(3), 2.0 * np.ones(3))


def test_pipeline_recovers_what_the_generator_aimed_at():
    table = simulate_recordings(rng=np.random.default_rng(5), protocol=SHORT)
    truth = true_end_postures(rng=np.random.default_rng(5), protocol=SHORT)
    goal = truth.sort_values(["subject", "object", "trial"], kind="stable")
    goal = goal[["x", "y", "z"]].to_numpy().reshape(-1, 6, 3)[:, :5]
    errors = {}
    for settle in (0.0, 0.3):
        grasps, failed = grasps_from_recordings(table, settle=settle)
        assert len(failed) == 0
        errors[settle] = np.linalg.norm(grasps.fingertips - goal, axis=2)
    assert np.median(errors[0.3]) < 0.0015 < np.median(errors[0.0]) < 0.010


def test_generator_follows_the_protocol_and_repeats():
    table = simulate_recordings(rng=np.random.default_rng(5), protocol=SHORT)
    again = simulate_recordings(rng=np.random.default_rng(5), protocol=SHORT)
    assert table.equals(again)
    trial = table[(table.subject == "S1") & (table.object == "box") & (table.trial == 1)]
    recording = recording_from_rows(trial)
    start = np.nanmean(recording.positions[:10, :5], axis=(0, 1))
    assert abs(start[1] + SHORT.start_distance) < 0.01
    end = np.nanmean(recording.positions[-5:, :5], axis=(0, 1))
    assert end[0] < -0.1 < 0.1 < end[1]
    tips = simulate_fingertips(SHAPES[0], rng=np.random.default_rng(1), count=20)
    radius = np.linalg.norm(tips[..., :2], axis=2)
    assert np.all(radius >= 0.035)
    with pytest.raises(InputError, match="noise"):
        simulate_recordings(rng=np.random.default_rng(1), protocol=Protocol(noise=-1.0))


def test_trials_without_a_grasp_are_named_with_the_reason():
    table = simulate_recordings(rng=np.random.default_rng(5), protocol=SHORT)
    still = (table.trial == 1) & (table.object == "box") & (table.subject == "S1")
    table.loc[still, ["x", "y", "z"]] = 0.0
    short = (table.trial == 2) & (table.object == "box") & (table.subject == "S1")
    table = table[~(short & (table.t > 0.8))]
    grasps, failed = grasps_from_recordings(table)
    assert len(grasps) == 6
    assert failed["why"].tolist()[0].startswith("the wrist never moved")
    assert "ends before" in failed["why"].tolist()[1]
    with pytest.raises(InputError, match="none of"):
        grasps_from_recordings(table[still.reindex(table.index)])


CSV = "when;ax;ay;az;run\n0;1;2;3;7\n10;2;2;3;7\n20;;;;7\n0;5;5;5;8\n10;5;5;6;8\n"


def test_wide_csv_is_read_in_the_unit_that_is_said(tmp_path):
    path = tmp_path / "wide.csv"
    path.write_text(CSV)
    layout = {"sensors": {"a": ("ax", "ay", "az")}, "time": "when", "separator": ";"}
    runs = read_csv_recording(path, length_unit="mm", time_unit="ms", trial="run", **layout)
    assert list(runs) == ["7", "8"]
    np.testing.assert_allclose(runs["7"].times, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(runs["7"].positions[0, 0], [0.001, 0.002, 0.003])
    assert np.isnan(runs["7"].positions[2]).all()
    with pytest.raises(InputError, match="unit"):
        read_csv_recording(path, length_unit="inch", **layout)
    with pytest.raises(InputError, match="bx"):
        read_csv_recording(path, length_unit="m", sensors={"b": ("bx", "by", "bz")}, time="when")
    with pytest.raises(InputError, match="Expected"):
        read_csv_recording(tmp_path / "none.csv", length_unit="m", **layout)


def test_track_manager_export_is_read(tmp_path):
    path = tmp_path / "take.tsv"
    path.write_text(
        "NO_OF_FRAMES\t2\nFREQUENCY\t50\nMARKER_NAMES\ta\tb\n"
        "Frame\tTime\ta X\ta Y\ta Z\tb X\tb Y\tb Z\t\n"
        "1\t0.0\t100\t0\t0\t0.0\t0.0\t0.0\t\n2\t0.02\t200\t0\t0\t1\t2\t3\t\n"
    )
    take = read_qualisys_tsv(path)
    assert take.sensors == ("a", "b")
    np.testing.assert_allclose(take.times, [0.0, 0.02])
    np.testing.assert_allclose(take.of("a")[:, 0, 0], [0.1, 0.2])
    assert np.isnan(take.of("b")[0]).all()
    assert take.renamed({"wrist": "b"}).sensors == ("wrist",)
    (tmp_path / "other.tsv").write_text("x\ty\n1\t2\n")
    with pytest.raises(InputError, match="FREQUENCY"):
        read_qualisys_tsv(tmp_path / "other.tsv")


def test_c3d_is_read_with_its_own_unit(tmp_path):
    content = ezc3d.c3d()
    content["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    content["parameters"]["POINT"]["LABELS"]["value"] = ["a", "b"]
    content["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    points = np.ones((4, 2, 5))
    points[0, 0] = 1000.0 * np.arange(5)
    content["data"]["points"] = points
    content.write(str(tmp_path / "take.c3d"))
    take = read_c3d(tmp_path / "take.c3d")
    np.testing.assert_allclose(take.of("a")[:, 0, 0], np.arange(5.0), atol=1e-6)
    np.testing.assert_allclose(take.times, np.arange(5) / 100.0)
    (tmp_path / "text.c3d").write_text("no")
    with pytest.raises(InputError, match="C3D"):
        read_c3d(tmp_path / "text.c3d")
    with pytest.raises(InputError, match="not there"):
        read_c3d(tmp_path / "none.c3d")
