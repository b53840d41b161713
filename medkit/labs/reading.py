"""What a submission defines: the statements an answer needs, and why a function is missing.

Only what the asked function needs is executed: no picture, no check, no loose call.
"""

from __future__ import annotations

import ast
import dis
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from types import CodeType
from typing import Any

#: The first line of an answer cell.
MARK = re.compile(r"^# answer: ([a-z]+-\d+)\s*$", re.M)
#: Lines that only a notebook understands: ``%time``, ``!pip``, ``np.interp?``.
NOTEBOOK_LINE = re.compile(r"^([ \t]*)(?:[%!?].*|[^#\n]*\?)[ \t]*$", re.M)


@dataclass(frozen=True)
class Cell:
    """A code cell: what it is called in a hint, its mark, its statements or why there are none."""

    place: str
    exercise: str | None
    body: tuple[ast.stmt, ...]
    error: str = ""


def read_cells(sources: Iterable[str]) -> list[Cell]:
    """Read the code cells of a notebook; one that is no Python keeps the reason."""
    cells = []
    for number, source in enumerate(sources, start=1):
        mark = MARK.search(source)
        place = f"the cell '{mark.group().strip()}'" if mark else f"code cell {number}"
        exercise = mark.group(1) if mark else None
        try:
            cells.append(Cell(place, exercise, tuple(_tree(source).body)))
        except SyntaxError as error:
            words = f"{type(error).__name__} in line {error.lineno}: {error.msg}"
            cells.append(Cell(place, exercise, (), words))
        except (ValueError, RecursionError, MemoryError) as error:
            cells.append(Cell(place, exercise, (), f"{type(error).__name__}: {error}"))
    return cells


def _tree(source: str) -> ast.Module:
    try:
        return ast.parse(source)
    except SyntaxError:
        # only now: inside a longer statement a line may begin with % in plain Python, too
        return ast.parse(NOTEBOOK_LINE.sub(r"\1pass", source))


def definitions(cells: list[Cell], wanted: str) -> dict[str, Any]:
    """Execute the statements that the function `wanted` needs, in the order of the notebook."""
    namespace: dict[str, Any] = {"__name__": "submission"}
    needed = _needed(cells, wanted)
    for cell, statement in _statements(cells):
        names = bound_names(statement)
        if not names & needed:
            continue
        try:
            exec(_code(statement, cell.place), namespace)
        except Exception:
            # a broken neighbour must not cost the exercise that is asked for
            if wanted in names:
                raise
    return namespace


def needed_modules(cells: list[Cell], wanted: str) -> list[str]:
    """Return the modules that the statements for the function `wanted` import."""
    needed = _needed(cells, wanted)
    found: list[str] = []
    for _, statement in _statements(cells):
        if isinstance(statement, ast.Import) and bound_names(statement) & needed:
            found += [alias.name for alias in statement.names]
        elif isinstance(statement, ast.ImportFrom) and bound_names(statement) & needed:
            found += [statement.module or ""]
    return found


def defines(cells: list[Cell], wanted: str) -> bool:
    """Whether a cell defines the function itself; an import of that name is no answer."""
    return any(
        wanted in bound_names(statement)
        for _, statement in _statements(cells)
        if not isinstance(statement, ast.Import | ast.ImportFrom)
    )


def why_missing(cells: list[Cell], wanted: str, exercise: str) -> str:
    """Say in one sentence where the function should be and what is there instead."""
    marked = [cell for cell in cells if cell.exercise == exercise]
    broken = [cell for cell in cells if cell.error]
    for cell in broken:
        if cell in marked or not marked:
            return f"{cell.place} is not Python yet, so {wanted} is missing: {cell.error}"
    if not marked:
        return f"no cell defines {wanted}: the cell '# answer: {exercise}' is missing; put it back"
    others = [
        statement.name
        for cell in marked
        for statement in cell.body
        if isinstance(statement, ast.FunctionDef)
    ]
    instead = f" (it defines {', '.join(others)})" if others else ""
    return f"{marked[-1].place} does not define {wanted}{instead}; keep the function's name"


def bound_names(statement: ast.stmt) -> set[str]:
    """Return the names that a statement at the top of a cell binds, or changes in place.

    Examples
    --------
    >>> sorted(bound_names(ast.parse("a.b, c[0] = d").body[0]))
    ['a', 'c']
    """
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return {(alias.asname or alias.name).split(".")[0] for alias in statement.names}
    targets: list[ast.expr] = []
    if isinstance(statement, ast.Assign):
        targets = statement.targets
    elif isinstance(statement, ast.AnnAssign | ast.AugAssign):
        targets = [statement.target]
    return {_base(part) for target in targets for part in _parts(target)} - {""}


def _parts(target: ast.expr) -> list[ast.expr]:
    if isinstance(target, ast.Tuple | ast.List):
        return [part for item in target.elts for part in _parts(item)]
    return [target.value if isinstance(target, ast.Starred) else target]


def _base(target: ast.expr) -> str:
    while isinstance(target, ast.Attribute | ast.Subscript):
        target = target.value
    return target.id if isinstance(target, ast.Name) else ""


def _statements(cells: list[Cell]) -> Iterator[tuple[Cell, ast.stmt]]:
    for cell in cells:
        for statement in cell.body:
            yield cell, statement


def _needed(cells: list[Cell], wanted: str) -> set[str]:
    """Follow the names that the function uses, through the statements that bind them."""
    uses: dict[str, set[str]] = {"*": set()}
    for cell, statement in _statements(cells):
        for name in bound_names(statement):
            uses.setdefault(name, set()).update(_used(_code(statement, cell.place)))
    needed, front = {"*"}, {wanted}
    while front:
        needed |= front
        front = {used for name in front for used in uses.get(name, ())} - needed
    return needed


def _code(statement: ast.stmt, place: str) -> CodeType:
    return compile(ast.Module([statement], []), place, "exec")


def _used(code: CodeType) -> set[str]:
    """Names that the code and the functions inside it look up outside themselves."""
    names = {
        str(step.argval)
        for step in dis.get_instructions(code)
        if step.opname in ("LOAD_NAME", "LOAD_GLOBAL")
    }
    return names.union(*(_used(part) for part in code.co_consts if isinstance(part, CodeType)))
