"""Numbers printed in the theses' tables, as tables: facts to compare with, copied as printed."""

from __future__ import annotations

from importlib import resources
from typing import TYPE_CHECKING

from medkit.arguments import one_of

if TYPE_CHECKING:
    import pandas as pd

#: Name of a table here, and the tables it holds.
PRINTED = {
    "yield_power_large": "P13 table 5.1",
    "yield_power_handsized_mat": "P13 tables 5.2 and 5.3",
    "yield_power_handsized_normals": "P13 table 5.4",
    "yield_precision": "P13 table 5.5",
    "yield_printed_averages": "P13 tables 5.1 to 5.5, last rows",
    "timing_symmetry": "P13 table 5.6",
    "timing_candidate_test": "P13 table 5.7",
}


def printed_names() -> list[str]:
    """Names of the printed tables that `load_printed` reads.

    Returns
    -------
    list of str
        In the order of P13's tables 5.1 to 5.7.

    Examples
    --------
    >>> printed_names()[0]
    'yield_power_large'
    """
    return list(PRINTED)


def load_printed(name: str) -> pd.DataFrame:
    """Read a table of numbers as printed in a thesis.

    Parameters
    ----------
    name : str
        One of `printed_names`.

    Returns
    -------
    pandas.DataFrame
        Columns are described, with units, in the README beside the files. ``attrs["source"]``
        names the printed table.

    Raises
    ------
    InputError
        If there is no such table.

    Examples
    --------
    >>> table = load_printed("yield_power_large")
    >>> table[table.planner == "MAT"].yield_pct.mean().round(1), table.attrs["source"]
    (np.float64(73.2), 'P13 table 5.1')
    """
    import pandas as pd

    one_of(name, PRINTED, "a printed table")
    file = resources.files("medkit.datasets") / "theses" / f"{name}.csv"
    with file.open("r", encoding="utf-8") as text:
        table = pd.read_csv(text)
    table.attrs["source"] = PRINTED[name]
    return table
