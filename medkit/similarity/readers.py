"""Readers of recordings: plain CSV, Qualisys track-manager TSV, C3D. Units are never guessed."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.similarity.recordings import Recording

#: Metres per unit of length.
LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
#: Seconds per unit of time.
TIMES = {"s": 1.0, "ms": 0.001}


def read_csv_recording(
    path: str | os.PathLike[str],
    *,
    sensors: dict[str, tuple[str, str, str]],
    time: str,
    length_unit: str,
    time_unit: str = "s",
    separator: str = ",",
    trial: str | None = None,
) -> dict[str, Recording]:
    """Read a wide table: one row per instant, three columns per tracker.

    Parameters
    ----------
    path : path-like
        The file, with one header line.
    sensors : dict
        Tracker -> its three column names.
    time : str
        Column of the time stamps.
    length_unit, time_unit : str
        "m", "cm" or "mm"; "s" or "ms". They must be said: nothing is guessed.
    separator : str
        Between columns.
    trial : str, optional
        Column that numbers the trials; without it the file is one trial.

    Returns
    -------
    dict of str to Recording
        One recording per trial, in the order of the file. Empty cells are NaN.

    Raises
    ------
    InputError
        If the file, a column or a unit is not there.
    """
    table = _table(path, separator, 0)
    wanted = [time, *(column for group in sensors.values() for column in group)]
    _require(table, [*wanted, *([trial] if trial else [])], path)
    scale = _factor(length_unit, LENGTHS), _factor(time_unit, TIMES)
    groups = table.groupby(trial, sort=False) if trial else [("1", table)]
    return {
        str(name): Recording(
            tuple(sensors),
            _column(rows, [time], path)[:, 0] * scale[1],
            _column(rows, wanted[1:], path).reshape(len(rows), len(sensors), 3) * scale[0],
            Path(path).name,
        )
        for name, rows in groups
    }


def read_qualisys_tsv(path: str | os.PathLike[str], *, length_unit: str = "mm") -> Recording:
    """Read a track-manager's 3-D export (Qualisys): header lines, then one row per frame.

    Parameters
    ----------
    path : path-like
        The ``.tsv`` file.
    length_unit : str
        Unit of the positions; the program writes millimetres, its file does not say so.

    Returns
    -------
    Recording
        All markers; NaN where one was not seen (empty cells, or zeros in all three).

    Raises
    ------
    InputError
        If the file is not such an export.
    """
    header, first = _tsv_header(path)
    names = tuple(header.get("MARKER_NAMES", "").split("\t"))
    if "FREQUENCY" not in header or names == ("",):
        raise InputError(
            f"Expected a track-manager export with FREQUENCY and MARKER_NAMES, but {path} has"
            " none; export 3-D data as TSV with header."
        )
    table = _table(path, "\t", first).iloc[:, : 2 + 3 * len(names)]
    columns = [f"{name} {axis}" for name in names for axis in "XYZ"]
    _require(table, columns, path)
    places = _column(table, columns, path).reshape(len(table), len(names), 3)
    places[np.all(places == 0.0, axis=2)] = np.nan
    times = np.arange(len(table)) / float(header["FREQUENCY"])
    scale = _factor(length_unit, LENGTHS)
    return Recording(names, times, places * scale, Path(path).name)


def read_c3d(path: str | os.PathLike[str]) -> Recording:
    """Read a C3D file (extra ``recordings``: ezc3d), whose unit stands in the file.

    Parameters
    ----------
    path : path-like
        The ``.c3d`` file.

    Returns
    -------
    Recording
        All points; NaN where one was not seen (negative residual). A point without a label is
        called by its number, ``unnamed 3``.

    Raises
    ------
    InputError
        If the file is not there, not a C3D file or cut off, if its unit is unknown, if it has
        no points or no rate, or if ezc3d is not installed.
    """
    try:
        import ezc3d
    except ImportError as error:
        raise InputError(
            "Expected the package ezc3d for C3D files, but it is not installed;"
            ' install it with pip install "medkit[recordings]".'
        ) from error
    _check_c3d_length(Path(path))
    try:
        content = ezc3d.c3d(str(path))
    except Exception as error:  # ezc3d raises its C++ exceptions under several types
        raise InputError(
            f"Expected a C3D file, but {path} could not be read ({' '.join(str(error).split())});"
            " export it again."
        ) from error
    return _recording_from_c3d(content, Path(path))


def _check_c3d_length(path: Path) -> None:
    """Refuse other files and cut ones before ezc3d sees them: on those it may end the process."""
    if not path.is_file():
        raise InputError(f"Expected a C3D file, but {path} is not there; check the path.")
    with open(path, "rb") as file:
        head = file.read(512)
        first = head[0] if head else 0
        file.seek(512 * max(first - 1, 0))
        parameters = file.read(4)
    if len(head) < 512 or head[1] != 0x50 or not first or len(parameters) < 4:
        raise InputError(
            f"Expected a C3D file, but {path} does not begin like one; export it anew."
        )
    needed = 512 * (first - 1 + parameters[2])
    if parameters[3] == 84:  # numbers as on this machine; other kinds are left to ezc3d
        points, analog, begin, end = struct.unpack_from("<HHHH", head, 2)
        scale, start = struct.unpack_from("<fH", head, 12)
        row = (4 * points + analog) * (2 if scale > 0.0 else 4)
        needed = max(needed, 512 * (start - 1) + max(end - begin + 1, 0) * row)
    if path.stat().st_size < needed:
        raise InputError(
            f"Expected a C3D file of at least {needed} bytes by its own header, but {path} has"
            f" {path.stat().st_size}; it was cut off, copy or export it again."
        )


def _recording_from_c3d(content: Any, path: Path) -> Recording:
    point = content["parameters"]["POINT"]
    data = np.asarray(content["data"]["points"], dtype=float)[:3].transpose(2, 1, 0)
    if 0 in data.shape:
        raise InputError(f"Expected 3-D points, but {path} holds no points; export them too.")
    unit_name = str(point["UNITS"]["value"][0]).strip() if point["UNITS"]["value"] else "none"
    scale, rate = _factor(unit_name, LENGTHS), float(point["RATE"]["value"][0])
    if not rate > 0.0:
        raise InputError(f"Expected a frame rate in {path}, but it says {rate:g}; export it anew.")
    residuals = np.asarray(content["data"]["meta_points"]["residuals"])[0].T
    places = np.where((residuals < 0.0)[..., None], np.nan, data) * scale
    labels = _c3d_labels(point, data.shape[1])
    return Recording(labels, np.arange(len(places)) / rate, places, path.name)


def _c3d_labels(point: Any, count: int) -> tuple[str, ...]:
    """Names of the points: a file may hold more labels than points, or leave points unnamed."""
    keys = sorted((key for key in point if key.startswith("LABELS")), key=lambda key: key[6:])
    names = [str(name).strip() for key in keys for name in point[key]["value"]][:count]
    names += [""] * (count - len(names))
    return tuple(name or f"unnamed {row + 1}" for row, name in enumerate(names))


def _tsv_header(path: str | os.PathLike[str]) -> tuple[dict[str, str], int]:
    """Header entries, and the number of lines before the table's own header."""
    entries: dict[str, str] = {}
    try:
        with open(path, encoding="utf-8") as file:
            for number, line in enumerate(file):
                key, _, value = line.rstrip("\n").partition("\t")
                if key == "Frame" or number > 50:
                    return entries, number
                entries[key] = value.strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"Expected a readable text file, but {path} is not ({error}); check the path."
        ) from error
    return entries, 0


def _table(path: str | os.PathLike[str], separator: str, skipped: int) -> pd.DataFrame:
    try:
        return pd.read_csv(path, sep=separator, skiprows=skipped)
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise InputError(
            f"Expected a table in {path}, but reading it failed ({' '.join(str(error).split())});"
            " check path and separator."
        ) from error


def _require(table: pd.DataFrame, columns: list[str], path: str | os.PathLike[str]) -> None:
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise InputError(
            f"Expected the columns {', '.join(missing)} in {path}, but they are missing; its"
            f" columns begin with {', '.join(map(str, table.columns[:6]))}."
        )


def _column(rows: pd.DataFrame, columns: list[str], path: str | os.PathLike[str]) -> Floats:
    try:
        return rows[columns].to_numpy(dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Expected numbers in the columns of {path}, but came {error}; leave cells empty"
            " where nothing was seen."
        ) from error


def _factor(name: str, known: dict[str, float]) -> float:
    if name not in known:
        raise InputError(
            f"Expected a unit among {', '.join(known)}, but got {name!r}; say which it is."
        )
    return known[name]
