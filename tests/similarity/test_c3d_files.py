"""C3D files written byte by byte after the format's description, not by the library that reads."""

import struct

import numpy as np
import pytest

from medkit.errors import InputError
from medkit.similarity.readers import read_c3d


def _group(number, name):
    return struct.pack("<bb", len(name), -number) + name + struct.pack("<hb", 3, 0)


def _parameter(number, name, kind, dimensions, data):
    rest = struct.pack("<bb", kind, len(dimensions)) + bytes(dimensions) + data + b"\x00"
    head = struct.pack("<bb", len(name), number) + name
    return head + struct.pack("<h", 2 + len(rest)) + rest


def _text(number, name, lines):
    width = max(map(len, lines))
    padded = "".join(line.ljust(width) for line in lines).encode()
    return _parameter(number, name, -1, [width, len(lines)], padded)


def _word(number, name, value):
    return _parameter(number, name, 2, [], struct.pack("<h", value))


def _real(number, name, value):
    return _parameter(number, name, 4, [], struct.pack("<f", value))


def c3d_bytes(counts, seen, labels, *, scale, units="mm", rate=120.0, analog=0):
    """One file: counts (frames, points, 3) are stored as whole numbers if scale > 0, else floats.

    `analog` channels of three samples a frame stand between the frames' points.
    """
    frames, points = seen.shape
    body = b"".join([
        _group(1, b"POINT"), _word(1, b"USED", points), _real(1, b"SCALE", scale),
        _real(1, b"RATE", rate), _word(1, b"DATA_START", 5), _word(1, b"FRAMES", frames),
        _text(1, b"UNITS", [units]), _text(1, b"LABELS", labels),
        _group(2, b"ANALOG"), _word(2, b"USED", analog), _real(2, b"GEN_SCALE", 1.0),
        _real(2, b"RATE", 3 * rate),
        _parameter(2, b"SCALE", 4, [analog], struct.pack(f"<{analog}f", *[1.0] * analog)),
        _parameter(2, b"OFFSET", 2, [analog], struct.pack(f"<{analog}h", *[0] * analog)),
        _text(2, b"LABELS", [f"A{channel}" for channel in range(analog)] or ["none"]),
    ])  # fmt: skip
    parameters = (struct.pack("<BBBB", 1, 0x50, 3, 84) + body + bytes(2)).ljust(3 * 512, b"\x00")
    header = struct.pack("<BBhhhhhfhhf", 2, 0x50, points, 3 * analog, 1, frames, 0, scale, 5, 3,
                         rate)  # fmt: skip
    whole = scale > 0
    code, data = ("<4h" if whole else "<4f"), b""
    for frame in range(frames):
        for point in range(points):
            row = (*counts[frame, point], 0) if seen[frame, point] else (0, 0, 0, -1)
            data += struct.pack(code, *(int(v) if whole else float(v) for v in row))
        sample = "<h" if whole else "<f"
        data += b"".join(struct.pack(sample, 100 + k) for k in range(3 * analog))
    return header.ljust(512, b"\x00") + parameters + data.ljust(-(-len(data) // 512) * 512, b"\x00")


@pytest.fixture
def take():
    rng = np.random.default_rng(1)
    counts = rng.integers(-9000, 9000, size=(7, 3, 3))
    seen = np.ones((7, 3), dtype=bool)
    seen[2:4, 1] = seen[0, 2] = False
    return counts, seen, ["thumb", "index", "wrist"]


@pytest.mark.parametrize("scale", [0.05, 0.5, -0.05])
@pytest.mark.parametrize("analog", [0, 4])
@pytest.mark.parametrize(("units", "metre"), [("mm", 1e-3), ("m", 1.0), ("cm", 1e-2)])
def test_scale_units_analog_and_missing_markers(tmp_path, take, scale, analog, units, metre):
    counts, seen, labels = take
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d_bytes(counts, seen, labels, scale=scale, units=units, analog=analog))
    found = read_c3d(path)
    places = counts * (scale if scale > 0 else 1.0) * metre
    assert found.sensors == tuple(labels)
    np.testing.assert_allclose(found.times, np.arange(7) / 120.0)
    assert np.array_equal(np.isfinite(found.positions).all(axis=2), seen)
    np.testing.assert_allclose(found.positions[seen], places[seen], rtol=1e-6)


def test_a_unit_that_is_unknown_is_asked_for(tmp_path, take):
    counts, seen, labels = take
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d_bytes(counts, seen, labels, scale=-1.0, units="in"))
    with pytest.raises(InputError, match="'in'"):
        read_c3d(path)


def test_a_file_cut_off_anywhere_is_refused_and_ends_nothing(tmp_path, take):
    counts, seen, labels = take
    whole = c3d_bytes(counts, seen, labels, scale=0.1, analog=2)
    path = tmp_path / "take.c3d"
    for length in (0, 1, 300, 512, 515, 700, 1600, 2048, len(whole) - 400):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"cut off|does not begin like one"):
            read_c3d(path)
    path.write_bytes(bytes(range(256)) * 8)
    with pytest.raises(InputError, match="does not begin like one"):
        read_c3d(path)


def test_points_without_a_label_are_numbered_and_labels_without_a_point_ignored(tmp_path, take):
    counts, seen, labels = take
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d_bytes(counts, seen, labels[:2], scale=-1.0))
    assert read_c3d(path).sensors == ("thumb", "index", "unnamed 3")
    path.write_bytes(c3d_bytes(counts, seen, [*labels, "ghost"], scale=-1.0))
    assert read_c3d(path).sensors == tuple(labels)


def test_a_file_without_points_or_rate_is_refused(tmp_path, take):
    counts, seen, labels = take
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d_bytes(counts[:, :0], seen[:, :0], ["none"], scale=-1.0, analog=2))
    with pytest.raises(InputError, match="no points"):
        read_c3d(path)
    path.write_bytes(c3d_bytes(counts, seen, labels, scale=-1.0, rate=0.0))
    with pytest.raises(InputError, match="rate"):
        read_c3d(path)
