"""Students' copies of the lab notebooks, and instructors' copies with the answers filled in.

A lab notebook marks its answer cells by their first line, ``# answer: planar-1``. A file of answers
holds one such block per exercise; filling in replaces exactly those cells.
"""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

from medkit.errors import InputError
from medkit.files import write_text
from medkit.labs.reading import MARK

LINK = re.compile(r"\[([^\]]+)\]\((?!\w+:)([^)#]+)\)")  # to a file, not to an address


def lab_notebooks(folder: Path) -> list[Path]:
    """Return the lab notebooks of a folder, in their order."""
    found = sorted(folder.glob("*.ipynb"))
    if not found:
        raise InputError(
            f"Expected lab notebooks in {folder}, but found none; run this from the root of the"
            " project."
        )
    return found


def marked_exercise(cell: Any) -> str | None:
    """Return the exercise that a notebook cell answers, or None."""
    if cell.cell_type != "code":
        return None
    match = MARK.match(cell.source)
    return match.group(1) if match else None


def answers_in(text: str) -> dict[str, str]:
    """Split a file of answers into its blocks, one per exercise."""
    starts = list(MARK.finditer(text))
    ends = [match.start() for match in starts[1:]] + [len(text)]
    return {
        match.group(1): text[match.start() : end].strip()
        for match, end in zip(starts, ends, strict=True)
    }


def filled(notebook: Any, answers: dict[str, str]) -> Any:
    """Return a copy of a lab notebook with its answer cells replaced."""
    result = copy.deepcopy(notebook)
    for cell in result.cells:
        exercise = marked_exercise(cell)
        if exercise is not None and exercise in answers:
            cell.source = answers[exercise]
    return result


def without_outputs(notebook: Any) -> Any:
    """Return a copy without outputs and execution counts, as a student receives it."""
    result = copy.deepcopy(notebook)
    for cell in result.cells:
        if cell.cell_type == "code":
            cell["outputs"], cell["execution_count"] = [], None
    return result


def without_dead_links(notebook: Any, out: Path) -> Any:
    """Return a copy whose links to files that do not lie beside `out` are plain words."""

    def kept(link: re.Match[str]) -> str:
        return link.group(0) if (out / link.group(2)).exists() else f"*{link.group(1)}*"

    result = copy.deepcopy(notebook)
    for cell in result.cells:
        if cell.cell_type == "markdown":
            cell.source = LINK.sub(kept, cell.source)
    return result


def write_copies(labs: Path, out: Path, answers: Path | None = None) -> list[Path]:
    """Write a copy of every lab notebook into `out`, filled in where `answers` is given."""
    import nbformat

    out.mkdir(parents=True, exist_ok=True)
    written = []
    for path in lab_notebooks(labs):
        notebook = without_outputs(nbformat.read(path, as_version=4))
        if answers is not None:
            source = answers / f"{path.stem}.py"
            if not source.exists():
                raise InputError(
                    f"Expected the answers to {path.name} in {source}, but it does not exist;"
                    " write one block '# answer: NAME' per exercise."
                )
            notebook = filled(notebook, answers_in(source.read_text(encoding="utf-8")))
        notebook = without_dead_links(notebook, out)
        write_text(out / path.name, nbformat.writes(notebook) + "\n")
        written.append(out / path.name)
    return written
