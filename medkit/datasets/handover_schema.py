"""What a table of handover trials must look like, and row-wise complaints where it does not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

RATINGS = ("good", "acceptable", "bad")
KEY = ("pose", "mode", "force_N", "weight_g", "subject")

# Kept in the package so that an installation without the data folder can check a lab's table too;
# data/handover_trials/schema.json is the same for other programs (a test holds them together).
_FIELDS: tuple[dict[str, Any], ...] = (
    {
        "name": "pose",
        "type": "string",
        "unit": "1",
        "required": True,
        "meaning": "how the robot holds the object out; P1, P2 or any short name",
    },
    {
        "name": "mode",
        "type": "string",
        "unit": "1",
        "required": True,
        "meaning": "how the arm is controlled; position, impedance or any short name",
    },
    {
        "name": "force_N",
        "type": "number",
        "unit": "N",
        "required": True,
        "above": 0,
        "at_most": 200,
        "meaning": "release force: what is applied beyond the load to open the gripper",
    },
    {
        "name": "weight_g",
        "type": "number",
        "unit": "g",
        "required": True,
        "above": 0,
        "at_most": 50000,
        "meaning": "mass of the object handed over",
    },
    {
        "name": "subject",
        "type": "string",
        "unit": "1",
        "required": True,
        "meaning": "a name that stands for one person throughout the table",
    },
    {
        "name": "good",
        "type": "count",
        "unit": "ratings",
        "required": True,
        "meaning": "repetitions of this cell rated good",
    },
    {
        "name": "acceptable",
        "type": "count",
        "unit": "ratings",
        "required": True,
        "meaning": "repetitions of this cell rated acceptable",
    },
    {
        "name": "bad",
        "type": "count",
        "unit": "ratings",
        "required": True,
        "meaning": "repetitions of this cell rated bad",
    },
    {
        "name": "sum_ok",
        "type": "flag",
        "unit": "1",
        "required": False,
        "meaning": "whether the counts add up to the table's repetitions; worked out when read",
    },
)


@dataclass(frozen=True)
class RowProblem:
    """One thing wrong with one row of a trial table.

    Attributes
    ----------
    line : int
        Line in the file, the heading being line 1.
    column : str
        The column concerned.
    message : str
        What was expected and what came.
    """

    line: int
    column: str
    message: str

    def __str__(self) -> str:
        return f"line {self.line}, column {self.column}: {self.message}"


def handover_schema() -> dict[str, Any]:
    """Return the schema that every trial table is checked against.

    Returns
    -------
    dict
        ``fields`` (name, type, unit, limits, meaning), ``key`` and ``ratings``.

    Examples
    --------
    >>> [field["unit"] for field in handover_schema()["fields"] if field["type"] == "number"]
    ['N', 'g']
    """
    return {
        "schema": "medkit.handover_trials/1",
        "key": list(KEY),
        "ratings": list(RATINGS),
        "fields": [dict(field) for field in _FIELDS],
    }


def table_problems(table: pd.DataFrame) -> list[RowProblem]:
    """Return everything wrong with a trial table, in the order of its rows.

    Parameters
    ----------
    table : pandas.DataFrame
        As read from a file, before any typing.

    Returns
    -------
    list of RowProblem
        Empty when the table is good.

    Examples
    --------
    >>> row = {"pose": "P1", "mode": "position", "force_N": -1, "weight_g": 100, "subject": "A"}
    >>> print(*table_problems(pd.DataFrame([row | {"good": 4, "acceptable": 0, "bad": 0}])))
    line 2, column force_N: expected a number above 0 and at most 200, came '-1'
    """
    required = [field for field in _FIELDS if field["required"]]
    missing = [field["name"] for field in required if field["name"] not in table.columns]
    if missing:
        return [
            RowProblem(1, name, f"expected a column named {name}, none came") for name in missing
        ]
    if table.empty:
        return [RowProblem(2, "pose", "expected at least one row, the table is empty")]
    problems = [problem for field in required for problem in _field_problems(table, field)]
    if not problems:
        problems = _kilograms(table) + _empty_cells(table) + _repeated_cells(table)
    return sorted(problems, key=lambda problem: problem.line)


def _field_problems(table: pd.DataFrame, field: Mapping[str, Any]) -> list[RowProblem]:
    text = table[field["name"]].astype(str).str.strip()
    if field["type"] == "string":
        bad, expected = (text == "").to_numpy(), "a name"
    else:
        value = pd.to_numeric(text, errors="coerce").to_numpy(dtype=float)
        if field["type"] == "count":
            bad, expected = (
                ~((value >= 0) & (value % 1 == 0) & (value < 1e6)),
                "a whole number of 0 or more",
            )
        else:
            bad = ~((value > field["above"]) & (value <= field["at_most"]))
            expected = f"a number above {field['above']} and at most {field['at_most']}"
    return [
        RowProblem(int(row) + 2, field["name"], f"expected {expected}, came {text.iloc[row]!r}")
        for row in np.flatnonzero(bad)
    ]


def _kilograms(table: pd.DataFrame) -> list[RowProblem]:
    """A table in which nothing weighs more than a sheet of paper was written in kilograms."""
    weight = table["weight_g"].astype(float).to_numpy()
    row = int(weight.argmax())
    if weight[row] >= 5.0:
        return []
    message = f"expected grams, but the heaviest object weighs {weight[row]:g}; kilograms?"
    return [RowProblem(row + 2, "weight_g", message)]


def _empty_cells(table: pd.DataFrame) -> list[RowProblem]:
    total = table[list(RATINGS)].astype(float).sum(axis=1).to_numpy()
    return [
        RowProblem(int(row) + 2, "good", "expected at least one rating in the row, came none")
        for row in np.flatnonzero(total == 0)
    ]


def _repeated_cells(table: pd.DataFrame) -> list[RowProblem]:
    keys = typed_keys(table)
    return [
        RowProblem(int(row) + 2, "subject", "expected every cell once, this one came before")
        for row in np.flatnonzero(keys.duplicated().to_numpy())
    ]


def typed_keys(table: pd.DataFrame) -> pd.DataFrame:
    """Return the columns that name a cell, as numbers and trimmed text."""
    numbers = {"force_N": float, "weight_g": float}
    return pd.DataFrame(
        {
            name: table[name].astype(float)
            if name in numbers
            else table[name].astype(str).str.strip()
            for name in KEY
        }
    )
