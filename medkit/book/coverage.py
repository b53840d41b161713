"""Every table and figure of the three theses, and where it is rebuilt, or why it is not."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from importlib.resources import files

THESES = ("P13", "L14", "R12")
#: What the theses' chapters are about, in our words.
CHAPTERS = {
    "P13": {
        "2": "the state of the art", "3": "the medial axis", "4": "from symmetry to grasps",
        "5": "experiments", "6": "two hands, and what people do", "A": "appendix",
    },
    "L14": {
        "1": "introduction", "2": "groundwork", "3": "the robot", "4": "handing over",
        "5": "conclusions",
    },
    "R12": {
        "1": "introduction", "2": "related work", "3": "contact constraints",
        "4": "good grasps by continuation", "5": "compliance", "6": "coordination",
        "7": "approach paths",
    },
}  # fmt: skip
KINDS = {"figure": "figure", "fig": "figure", "table": "table"}
NAMED = re.compile(
    r"\b(figure|fig|table)s?\.? ((?:\d|A)\.\d+[a-z]?(?:(?:, | and | to )(?:\d|A)\.\d+[a-z]?)*)"
)


@dataclass(frozen=True)
class Item:
    """One printed table or figure: what it shows, our chapters, or why there is none."""

    thesis: str
    kind: str
    number: str
    what: str
    chapters: tuple[str, ...]
    why_not: str

    @property
    def key(self) -> tuple[str, str, str]:
        """Thesis, kind and number."""
        return self.thesis, self.kind, self.number


def coverage() -> list[Item]:
    """Read the list that ships with the package, in the order of the theses.

    Examples
    --------
    >>> next(item.what for item in coverage() if item.key == ("P13", "table", "5.1"))
    'yield of power grasps, large objects'
    """
    text = files("medkit.book").joinpath("coverage.csv").read_text(encoding="utf-8")
    return [
        Item(thesis, kind, number, what, tuple(chapters.split()), why_not)
        for thesis, kind, number, what, chapters, why_not in list(csv.reader(text.splitlines()))[1:]
    ]


def items_named(source: str) -> list[tuple[str, str, str]]:
    """Return the tables and figures that the source of a replay row names.

    Parameters
    ----------
    source : str
        Thesis, then sections, tables and figures in words.

    Returns
    -------
    list of tuple of str
        Thesis, kind and number of each; a range stands for all in between.

    Examples
    --------
    >>> items_named("P13 4.2.2, figure 4.4b")
    [('P13', 'figure', '4.4')]
    >>> [number for _, _, number in items_named("L14 figures 4.20 to 4.22")]
    ['4.20', '4.21', '4.22']
    """
    thesis = source[:3]
    return [
        (thesis, KINDS[kind], number)
        for kind, numbers in NAMED.findall(source)
        for number in _spread(numbers)
    ]


def chapter_of_source(source: str) -> str:
    """Return the thesis's chapter that a source belongs to, by its first number.

    Examples
    --------
    >>> chapter_of_source("L14 figures 4.20 to 4.23"), chapter_of_source("P13 table 5.1")
    ('4', '5')
    """
    match = re.search(r"\b(\d|A)\.\d", source[3:])
    return match.group(1) if match else ""


def natural(text: str) -> list[tuple[int, str]]:
    """Key that sorts 4.9 before 4.10, and numbers before words.

    Examples
    --------
    >>> sorted(["4.10", "4.9", "A.1"], key=natural)
    ['4.9', '4.10', 'A.1']
    """
    parts = re.findall(r"\d+|[^\d]+", text)
    return [(int(part), "") if part.isdigit() else (1_000, part) for part in parts]


def _spread(numbers: str) -> list[str]:
    """``"4.5, 4.7 to 4.9"`` to its single numbers, without the letters of panels."""
    spread: list[str] = []
    for joint, number in re.findall(r"(, | and | to |^)((?:\d|A)\.\d+)", numbers):
        chapter, _, last = number.partition(".")
        first = int(spread[-1].partition(".")[2]) + 1 if joint == " to " else int(last)
        spread += [f"{chapter}.{k}" for k in range(first, int(last) + 1)]
    return spread
