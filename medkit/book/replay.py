"""A printed value of a thesis beside our own, with a verdict that a rule gives.

A notebook ends a cell with one of these; the book collects them from the stored outputs into the
replay page, so that no value there is typed in.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from medkit.errors import InputError

MIME = "application/vnd.medkit.replay+json"
Verdict = Literal[
    "reproduced", "better", "worse", "contradicted", "not decided", "cannot be rebuilt"
]


@dataclass(frozen=True)
class Replay:
    """One printed value or statement, ours, and the verdict; a small table in a notebook."""

    source: str
    quantity: str
    printed: str
    ours: str
    interval: str
    verdict: Verdict
    note: str = ""

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        kept = [(name, value) for name, value in asdict(self).items() if value]
        cells = "".join(f"<tr>{_cell(name, 'th')}{_cell(value)}</tr>" for name, value in kept)
        return {
            "text/plain": "\n".join(f"{name:>9}: {value}" for name, value in kept),
            "text/html": f"<table class='replay'>{cells}</table>",
            MIME: asdict(self),
        }


@dataclass(frozen=True)
class ReplayTable:
    """Several rows under one head, as a notebook shows them; made by `replay_table`."""

    rows: tuple[Replay, ...]

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        rows = [asdict(row) for row in self.rows]
        heads = [name for name in rows[0] if any(row[name] for row in rows)]
        lines = [heads, *([row[name] for name in heads] for row in rows)]
        head, *body = (
            "<tr>" + "".join(_cell(value, tag) for value in line) + "</tr>"
            for line, tag in zip(lines, ["th"] + ["td"] * len(rows), strict=True)
        )
        return {
            "text/plain": "\n".join(" | ".join(line) for line in lines),
            "text/html": f"<table class='replay'>{head}{''.join(body)}</table>",
            MIME: rows,
        }


def _cell(value: str, tag: str = "td") -> str:
    return f"<{tag} style='text-align:left'>{html.escape(value)}</{tag}>"


def replay_table(rows: Iterable[Replay]) -> ReplayTable:
    """Put several rows into one table.

    Parameters
    ----------
    rows : iterable of Replay
        What `replay`, `replay_statement` and `replay_missing` gave; at least one.

    Returns
    -------
    ReplayTable
        For the end of a cell; the replay page takes each row of it.

    Raises
    ------
    InputError
        If there is no row.

    Examples
    --------
    >>> half, one = (
    ...     replay("P13 4.2.1", f"object angle at mu = {mu}", printed=angle, ours=angle,
    ...            low=angle - 0.1, high=angle + 0.1, unit="deg")
    ...     for mu, angle in ((0.5, 127), (1, 90))
    ... )
    >>> len(replay_table([half, one]).rows)
    2
    """
    kept = tuple(rows)
    if not kept:
        raise InputError("Expected at least one row, but got none; pass what replay() returns.")
    return ReplayTable(kept)


def rows_of(data: Mapping[str, Any]) -> list[dict[str, str]]:
    """Rows that one stored output of a cell holds, in order; empty for any other output."""
    found = data.get(MIME, [])
    return found if isinstance(found, list) else [found]


def replay(
    source: str,
    quantity: str,
    *,
    printed: float,
    ours: float,
    low: float,
    high: float,
    unit: str = "",
    better: Literal["higher", "lower"] | None = None,
    digits: int = 3,
    note: str = "",
) -> Replay:
    """Hold a printed number against our estimate and its interval.

    Parameters
    ----------
    source : str
        Short name and place, for example ``"P13 table 5.1"``.
    quantity : str
        What the number is, for example ``"mean yield of power grasps, large objects"``.
    printed, ours : float
        The thesis's value and ours, in the same `unit`.
    low, high : float
        Our interval (for a deterministic value: the stated tolerance around it).
    unit : str
        Unit of all four numbers.
    better : {"higher", "lower"}, optional
        Which side counts as an improvement. Without it, a printed value outside the interval is
        contradicted.
    digits : int
        Significant digits shown.
    note : str
        Simulated data, other objects, other hand: whatever the reader must know.

    Returns
    -------
    Replay
        With verdict *reproduced* when `printed` lies within the interval, else *better*,
        *worse* or *contradicted*.

    Raises
    ------
    InputError
        If `low` <= `ours` <= `high` does not hold.

    Examples
    --------
    >>> replay("P13 4.2.1", "object angle at mu = 1", printed=90, ours=90, low=89.9, high=90.1,
    ...        unit="deg").verdict
    'reproduced'
    """
    if not low <= ours <= high:
        raise InputError(
            f"Expected an interval that holds our value, but {ours:g} is not within"
            f" [{low:g}, {high:g}]; pass low <= ours <= high."
        )
    verdict: Verdict
    if low <= printed <= high:
        verdict = "reproduced"
    elif better is None:
        verdict = "contradicted"
    else:
        verdict = "better" if (ours > printed) == (better == "higher") else "worse"

    def shown(value: float) -> str:
        return f"{value:.{digits}g} {unit}".strip()

    interval = f"{low:.{digits}g} to {high:.{digits}g} {unit}".strip()
    return Replay(source, quantity, shown(printed), shown(ours), interval, verdict, note)


def replay_statement(
    source: str, statement: str, *, holds: bool | None, evidence: str, note: str = ""
) -> Replay:
    """Hold a printed statement or figure against what we computed.

    Parameters
    ----------
    source, statement : str
        Place in the thesis and what it says or draws.
    holds : bool or None
        Computed, never typed: True gives *reproduced*, False *contradicted*, None *not decided*.
    evidence : str
        The figures behind the verdict, with units.
    note : str
        Whatever else the reader must know.

    Returns
    -------
    Replay
        The row for the replay page.
    """
    verdict: Verdict = "not decided" if holds is None else "reproduced" if holds else "contradicted"
    return Replay(source, statement, "as stated", evidence, "", verdict, note)


def replay_missing(source: str, quantity: str, *, printed: str, why: str) -> Replay:
    """Name a printed value that cannot be rebuilt, and why."""
    return Replay(source, quantity, printed, "", "", "cannot be rebuilt", why)
