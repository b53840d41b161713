"""Notebooks on disk: their order, their titles, and their execution from scratch in parallel."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from medkit.errors import InputError
from medkit.files import write_text

CHAPTERS = {
    "0": "First contact",
    "1": "In the plane",
    "2": "The medial axis",
    "3": "Grasps",
    "4": "What can go wrong",
    "5": "Human-likeness",
    "6": "Handover",
}
WIDGET = "application/vnd.jupyter.widget-view+json"
TIMEOUT = 150  # [s] a cell; a whole chapter is meant to take less than 60


@dataclass(frozen=True)
class Executed:
    """One notebook after execution: its node (nbformat), and how long it took [s]."""

    path: Path
    node: Any
    seconds: float

    @property
    def name(self) -> str:
        """File name without its ending; also the name of its page."""
        return self.path.stem

    @property
    def title(self) -> str:
        """First heading of the notebook."""
        return notebook_title(self.node, self.path)


def find_notebooks(folder: Path) -> list[Path]:
    """Return the numbered chapters of `folder` in the order of the walk."""
    found = sorted(folder.glob("[0-9][0-9]_*.ipynb"))
    if not found:
        raise InputError(
            f"Expected numbered notebooks such as 11_two_contacts.ipynb in {folder}, but found"
            " none; run this from the root of the project."
        )
    return found


def notebook_title(node: Any, path: Path) -> str:
    """Return the first markdown heading, or an `InputError` that asks for one."""
    for cell in node.cells:
        if cell.cell_type == "markdown" and (match := re.search(r"^#\s+(.+)$", cell.source, re.M)):
            return match.group(1).strip()
    raise InputError(f"Expected a heading in the first cell of {path.name}; add '# The question'.")


def chapter_of(name: str) -> str:
    """Return the chapter's title that a numbered file belongs to."""
    return CHAPTERS.get(name[:1], "More")


def read(path: Path) -> Any:
    """Read a notebook as it is stored; `InputError` where there is none."""
    import nbformat

    try:
        return nbformat.read(path, as_version=4)
    except OSError as error:
        raise InputError(
            f"Expected a notebook, but {path} cannot be read ({error.strerror}); give a path such"
            " as notebooks/00_start_here.ipynb."
        ) from None
    except (nbformat.reader.NotJSONError, nbformat.ValidationError):
        raise InputError(
            f"Expected a notebook, but {path} is none; give the path of an .ipynb file."
        ) from None


def execute(path: Path) -> Executed:
    """Run one notebook from top to bottom in a fresh kernel.

    A kernel that falls silent (a message lost between it and us; seen about once in a hundred
    runs) gets a second try. A cell that fails does not.
    """
    from nbclient.exceptions import CellTimeoutError, DeadKernelError

    try:
        return _execute_once(path)
    except (CellTimeoutError, DeadKernelError):
        return _execute_once(path)


def _execute_once(path: Path) -> Executed:
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError

    node = read(path)
    start = time.perf_counter()
    client = NotebookClient(
        node, timeout=TIMEOUT, kernel_name="python3", record_timing=False,
        resources={"metadata": {"path": str(path.parent)}},
        extra_arguments=["--IPKernelApp.log_level=40"],
    )  # fmt: skip
    try:
        client.execute()
    except CellExecutionError as error:
        lines = [line for line in str(error).splitlines() if line.strip()]
        raise InputError(f"Expected {path.name} to run, but a cell failed: {lines[-1]}") from error
    return Executed(path, normalised(node), time.perf_counter() - start)


def execute_all(paths: list[Path], *, jobs: int) -> Iterator[Executed]:
    """Run notebooks in parallel processes and yield each as it is done."""
    # each notebook has its own kernel; the longest start first where their sizes tell
    with ProcessPoolExecutor(max_workers=max(1, jobs)) as pool:
        running = {pool.submit(execute, path) for path in paths}
        try:
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def normalised(node: Any) -> Any:
    """Drop what differs between machines and runs, so that stored outputs only change for cause."""
    node.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for number, cell in enumerate(node.cells):
        cell["id"] = f"cell-{number:02d}"
        cell.metadata.pop("execution", None)
        cell.metadata.pop("ExecuteTime", None)
        if cell.cell_type == "code":
            cell["outputs"] = [o for o in _joined_streams(cell.outputs) if not _is_noise(o)]
            for output in cell["outputs"]:
                _without_a_dead_widget(output)
    return node


def store(executed: Executed) -> None:
    """Write an executed notebook back to its file, whole or not at all."""
    import nbformat

    write_text(executed.path, nbformat.writes(executed.node) + "\n")


def _joined_streams(outputs: list[Any]) -> list[Any]:
    joined: list[Any] = []
    for output in outputs:
        last = joined[-1] if joined else output
        kinds = (last.output_type, output.output_type)
        if joined and kinds == ("stream", "stream") and last.name == output.name:
            last["text"] += output.text
        else:
            joined.append(output)
    return joined


def _without_a_dead_widget(output: Any) -> None:
    """Drop the reference to a widget of a kernel that is gone, where something else is shown."""
    data = output.get("data", {})
    if WIDGET in data and set(data) - {WIDGET, "text/plain"}:
        del data[WIDGET]


def _is_noise(output: Any) -> bool:
    return bool(output.output_type == "stream" and output.name == "stderr")
