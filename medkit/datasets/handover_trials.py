"""Handover trials: where the thesis's table lies, and any table read and checked."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from medkit.arguments import file_path, short
from medkit.datasets.handover_schema import KEY, RATINGS, table_problems, typed_keys
from medkit.errors import InputError
from medkit.geometry import expected


def handover_folder() -> Path:
    """Return the folder of the thesis's table (source: L14 figures 4.5 to 4.8).

    Raises
    ------
    InputError
        If this installation does not carry the repository's data folder.

    Examples
    --------
    >>> sorted(path.name for path in handover_folder().glob("*.csv"))
    ['anomalies.csv', 'human_references.csv', 'trials.csv']
    """
    folder = Path(__file__).resolve().parents[2] / "data" / "handover_trials"
    if not (folder / "trials.csv").is_file():
        raise InputError(
            "Expected the table data/handover_trials/trials.csv beside the package, but this"
            " installation carries none; pass the path of a table or install from a checkout."
        )
    return folder


def handover_anomalies() -> pd.DataFrame:
    """Return the nine cells that do not add up to four, with the plausible reading of each.

    Returns
    -------
    pandas.DataFrame
        One row a cell; the README beside the table describes the columns.

    Examples
    --------
    >>> handover_anomalies()["sum"].unique().tolist()
    [3]
    """
    return pd.read_csv(handover_folder() / "anomalies.csv")


def human_references() -> pd.DataFrame:
    """Return when human givers release and how long a handover between people takes.

    Returns
    -------
    pandas.DataFrame
        name, low, high [s after contact], unit, source, note. ``high`` is NaN where the source
        gives no upper bound. Figures that L14 2.7 quotes, not measured by it.

    Examples
    --------
    >>> float(human_references()["low"].min())
    -0.06
    """
    return pd.read_csv(handover_folder() / "human_references.csv")


def load_handover_table(
    path: str | os.PathLike[str] | None = None, *, ratings: Mapping[str, str] | None = None
) -> pd.DataFrame:
    """Read a trial table as printed, checked row by row, nothing dropped.

    Parameters
    ----------
    path : path-like, optional
        A CSV file in the schema; the thesis's own table when left out.
    ratings : mapping, optional
        From a lab's own scale to good, acceptable, bad, for example
        ``{"5": "good", "4": "good", "3": "acceptable", "2": "bad", "1": "bad"}``. The file then
        either has one count column per key, or one row per handover and a column ``rating``.

    Returns
    -------
    pandas.DataFrame
        Columns pose, mode, force_N [N], weight_g [g], subject, good, acceptable, bad, sum_ok.

    Raises
    ------
    InputError
        If the file cannot be read or a row breaks the schema; names the first and their number.

    Examples
    --------
    >>> len(load_handover_table())
    864
    """
    own = None if path is None else file_path(path, "a trial table")
    table = _read(handover_folder() / "trials.csv" if own is None else own)
    if ratings is not None:
        table = _mapped(table, ratings)
    problems = table_problems(table)
    if problems:
        more = len({problem.line for problem in problems})
        rows = "1 line is" if more == 1 else f"{more} lines are"
        raise InputError(f"Unusable trial table: {problems[0]}; {rows} bad, correct the file.")
    return _typed(table)


#: What the first bytes of a file say it is instead of a table in UTF-8, and what to do.
_OTHER_KINDS = {
    b"PK\x03\x04": "is an Excel workbook; save it as CSV (UTF-8)",
    b"\xd0\xcf\x11\xe0": "is an old Excel workbook; save it as CSV (UTF-8)",
    b"\xff\xfe": "is text in UTF-16; save it as CSV (UTF-8)",
    b"\xfe\xff": "is text in UTF-16; save it as CSV (UTF-8)",
}


def _read(path: Path) -> pd.DataFrame:
    """Read every cell as text, so that the complaint can quote what stands there."""
    try:
        with open(path, "rb") as file:
            start = file.read(4096)
        for mark, kind in _OTHER_KINDS.items():
            if start.startswith(mark):
                raise InputError(f"Expected a CSV table, but {path} {kind}.")
        table = pd.read_csv(
            path, dtype=str, keep_default_na=False, skipinitialspace=True, encoding="utf-8-sig"
        )
    except UnicodeDecodeError as error:
        raise InputError(
            f"Expected a CSV table in UTF-8, but byte {error.start} of {path} is"
            f" 0x{error.object[error.start]:02x}; save it again as CSV (UTF-8)."
        ) from error
    except (OSError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise InputError(
            f"Expected a readable CSV table at {path}, but reading failed ({reason});"
            " pass a file with the columns of data/handover_trials/schema.json."
        ) from error
    table.columns = [str(name).strip() for name in table.columns]
    _check_separator(table, path)
    return table


def _check_separator(table: pd.DataFrame, path: Path) -> None:
    """A table of one column whose heading holds another separator was exported with that one."""
    for mark, name in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
        if len(table.columns) == 1 and mark in table.columns[0]:
            raise InputError(
                f"Expected columns separated by commas, but {path} separates them by {name};"
                " export it with commas and points in numbers."
            )


def _mapped(table: pd.DataFrame, ratings: Mapping[str, str]) -> pd.DataFrame:
    """Translate a lab's own scale; one row per handover becomes one row per cell."""
    remedy = 'pass {"5": "good", "3": "acceptable", "1": "bad"} or the like'
    expected(ratings, Mapping, "a mapping from ratings to good, acceptable, bad", remedy)
    scale = {str(key): str(value) for key, value in ratings.items()}
    wrong = sorted(set(scale.values()) - set(RATINGS))
    if wrong:
        raise InputError(
            f"Expected a mapping onto good, acceptable and bad, but it names {short(wrong[0])};"
            " map every step of the scale to one of the three."
        )
    if "rating" in table.columns:
        return _counted(table, scale)
    absent = [name for name in scale if name not in table.columns]
    if absent:
        raise InputError(
            f"Expected a column {absent[0]!r} of counts or a column 'rating', but the table has"
            f" {', '.join(map(repr, table.columns))}; correct the mapping or the table."
        )
    counts = {
        level: sum(
            (
                pd.to_numeric(table[name], errors="coerce")
                for name, to in scale.items()
                if to == level
            ),
            start=pd.Series(0, index=table.index),
        )
        for level in RATINGS
    }
    return table[list(KEY)].assign(**counts)


def _counted(table: pd.DataFrame, scale: Mapping[str, str]) -> pd.DataFrame:
    level = table["rating"].str.strip().map(dict(scale))
    unknown = np.flatnonzero(level.isna())
    if len(unknown):
        raise InputError(
            f"Unusable trial table: line {unknown[0] + 2}, column rating: expected one of"
            f" {', '.join(scale)}, came {table['rating'].iloc[unknown[0]]!r};"
            f" {len(unknown)} lines are bad, correct the file or the mapping."
        )
    counts = pd.get_dummies(level).reindex(columns=list(RATINGS), fill_value=0).astype(int)
    return (
        pd.concat([table[list(KEY)], counts], axis=1)
        .groupby(list(KEY), sort=False)
        .sum()
        .reset_index()
    )


def _typed(table: pd.DataFrame) -> pd.DataFrame:
    """Return the canonical columns; the repetitions are the commonest sum of a row."""
    typed = typed_keys(table)
    if (typed["weight_g"] % 1 == 0).all():
        typed["weight_g"] = typed["weight_g"].astype(int)
    for level in RATINGS:
        typed[level] = table[level].astype(float).astype(int)
    total = typed[list(RATINGS)].sum(axis=1)
    typed["sum_ok"] = total == int(total.mode().max())
    return typed
