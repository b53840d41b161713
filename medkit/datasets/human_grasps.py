"""Recordings of people grasping (P13 6.2.2), as tidy tables: one row per sensor and instant."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd

from medkit.arguments import file_path
from medkit.errors import InputError

#: Fingers in the order in which every array of fingertips holds them.
FINGERS = ("thumb", "index", "middle", "ring", "little")
#: What carries a tracker: five fingernails and the wrist.
SENSORS = (*FINGERS, "wrist")
#: Columns of the tidy table, and what they mean.
COLUMNS = {
    "subject": "name of the person",
    "object": "name of the object, as in objects.csv",
    "trial": "number of the trial, from 1, anew for every subject and object",
    "t": "time since the start of the trial [s]",
    "sensor": "thumb, index, middle, ring, little or wrist",
    "x": "position in the object's frame, to the person's right [m]; empty: not seen",
    "y": "position in the object's frame, away from the person [m]; empty: not seen",
    "z": "position in the object's frame, up [m]; empty: not seen",
    "simulated": "1 if a generator made the row, 0 if a person did",
}
#: Columns of objects.csv.
OBJECT_COLUMNS = ("object", "shape", "extent_x", "extent_y", "extent_z")
OBJECTS_FILE = "objects.csv"


def human_grasps_folder() -> Path:
    """Return the folder ``data/human_grasps`` that lies beside the package.

    Returns
    -------
    pathlib.Path
        The folder with the tables, ``objects.csv`` and a README on where every row comes from.

    Raises
    ------
    InputError
        If it is not there (the package was installed without its data).

    Examples
    --------
    >>> human_grasps_folder().name
    'human_grasps'
    """
    folder = Path(__file__).resolve().parents[2] / "data" / "human_grasps"
    if not folder.is_dir():
        raise InputError(
            "Expected the folder data/human_grasps beside the package, but it is not there;"
            " work from a checkout of the project, or pass the path of a folder of recordings."
        )
    return folder


def load_human_grasps(path: str | os.PathLike[str] | None = None) -> pd.DataFrame:
    """Read recorded grasps as one tidy table (P13 6.2.2).

    Parameters
    ----------
    path : path-like, optional
        A CSV file (``.csv`` or ``.csv.gz``) or a folder of them. Without it the tables that
        ship with medkit, which are simulated and say so in the column ``simulated``.

    Returns
    -------
    pandas.DataFrame
        Columns `COLUMNS`: subject, object, trial, t [s], sensor, x, y, z [m, in the object's
        frame, origin at its centre of mass, z up], simulated (bool). Coordinates of a sensor
        that was not seen are NaN. The table is as in the file: `medkit.similarity.validate`
        says what is wrong with it, nothing is mended here.

    Raises
    ------
    InputError
        If there is no such file, a column is missing, or a number cannot be read.

    Examples
    --------
    >>> table = load_human_grasps()
    >>> sorted(table["object"].unique()), bool(table["simulated"].all())
    (['box', 'cylinder'], True)
    """
    folder = human_grasps_folder() if path is None else file_path(path, "recordings")
    files = _recording_files(folder)
    return pd.concat([_read_table(file) for file in files], ignore_index=True)


def load_human_objects(path: str | os.PathLike[str] | None = None) -> pd.DataFrame:
    """Read ``objects.csv``: what was grasped, and how large it was.

    Parameters
    ----------
    path : path-like, optional
        The folder of the recordings, or one of its files.

    Returns
    -------
    pandas.DataFrame
        Indexed by object: shape and extent_x, extent_y, extent_z [m] in the object's frame,
        whose origin is the centre of mass.

    Raises
    ------
    InputError
        If the file or one of its columns is missing, or a size is not above zero.

    Examples
    --------
    >>> load_human_objects().loc["cylinder", "shape"]
    'cylinder'
    """
    folder = human_grasps_folder() if path is None else file_path(path, "recordings")
    file = (folder if folder.is_dir() else folder.parent) / OBJECTS_FILE
    if not file.is_file():
        raise InputError(
            f"Expected {OBJECTS_FILE} beside the recordings, but {file} is not there; write one"
            f" row per object with the columns {', '.join(OBJECT_COLUMNS)} [m]."
        )
    table = _read_csv(file)
    _check_columns(table, OBJECT_COLUMNS, file)
    twice = table["object"][table["object"].duplicated()]
    if len(twice):
        raise InputError(
            f"Expected one row per object in {file}, but {twice.iloc[0]!r} comes twice; leave one."
        )
    table = table.set_index("object")
    sizes = table[["extent_x", "extent_y", "extent_z"]].apply(pd.to_numeric, errors="coerce")
    if not bool((sizes > 0.0).all(axis=None)):
        raise InputError(
            f"Expected sizes above zero in {file}, but at least one is not; give metres."
        )
    return table


def _recording_files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError(
            f"Expected a file or folder of recordings, but {path} is not there; check the path."
        )
    files = sorted([*path.glob("*.csv"), *path.glob("*.csv.gz")])
    files = [file for file in files if file.name != OBJECTS_FILE]
    if not files:
        raise InputError(
            f"Expected at least one table (.csv or .csv.gz) in {path}, but there is none;"
            " see docs/adding_recordings.md for the columns."
        )
    return files


def _read_csv(file: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(file)
    except (OSError, ValueError, UnicodeDecodeError, EOFError) as error:
        raise InputError(
            f"Expected a table of comma-separated values in {file}, but reading it failed"
            f" ({' '.join(str(error).split())}); save it as UTF-8 CSV with one header line."
        ) from error


def _check_columns(table: pd.DataFrame, expected: tuple[str, ...], file: Path) -> None:
    missing = [column for column in expected if column not in table.columns]
    if len(table.columns) == 1 and (";" in table.columns[0] or "\t" in table.columns[0]):
        raise InputError(
            f"Expected columns separated by commas in {file}, but they are separated by"
            f" {'semicolons' if ';' in table.columns[0] else 'tabs'}; export it with commas."
        )
    if missing:
        raise InputError(
            f"Expected the columns {', '.join(expected)} in {file}, but {', '.join(missing)}"
            " is missing; see docs/adding_recordings.md."
        )


def _read_table(file: Path) -> pd.DataFrame:
    table = _read_csv(file)
    _check_columns(table, tuple(COLUMNS), file)
    table = table[list(COLUMNS)].copy()
    for column in ("t", "x", "y", "z"):
        table[column] = _numbers(table[column], file)
    trial = _numbers(table["trial"], file)
    if len(table) == 0 or not np.all(np.isfinite(trial) & (trial == np.round(trial))):
        raise InputError(
            f"Expected rows with whole trial numbers in {file}, but at least one is not whole"
            " or the table is empty; number the trials from 1."
        )
    table["trial"] = trial.astype(np.int64)
    table["simulated"] = _flags(table["simulated"], file)
    for column in ("subject", "object", "sensor"):
        nameless = np.flatnonzero(table[column].isna().to_numpy())
        if nameless.size:
            raise InputError(
                f"Expected a name in column {column} of {file}, but data row {nameless[0] + 1} has"
                " none; fill it in."
            )
        table[column] = table[column].astype(str)
    return table


def _numbers(column: pd.Series, file: Path) -> pd.Series:
    numbers = pd.to_numeric(column, errors="coerce").astype(float)
    spoilt = np.flatnonzero(numbers.isna().to_numpy() & column.notna().to_numpy())
    if spoilt.size:
        raise InputError(
            f"Expected numbers in column {column.name} of {file}, but data row {spoilt[0] + 1}"
            f" holds {column.iloc[spoilt[0]]!r}; leave the cell empty where nothing was seen."
        )
    return numbers


def _flags(column: pd.Series, file: Path) -> pd.Series:
    words = column.astype(str).str.strip().str.lower()
    truth = words.map({"1": True, "1.0": True, "true": True, "0": False, "0.0": False,
                       "false": False})  # fmt: skip
    if bool(truth.isna().any()):
        raise InputError(
            f"Expected 1 or 0 in column simulated of {file}, but at least one row holds"
            f" {words[truth.isna()].iloc[0]!r}; write 0 for people, 1 for a generator."
        )
    return truth.astype(bool)
