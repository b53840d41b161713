"""``python -m medkit.book build|execute``: behind ``make book`` and ``make notebooks``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from medkit.book.build import DOCUMENTS, write_book
from medkit.book.notebooks import Executed, execute_all, find_notebooks, read, store
from medkit.book.replay_page import departures, replay_rows
from medkit.errors import InputError


def main() -> int:
    """Build the book, or execute the notebooks in place; exit status 2 on bad input."""
    parser = argparse.ArgumentParser(prog="python -m medkit.book", description=__doc__)
    parser.add_argument("action", choices=("build", "execute"))
    parser.add_argument("names", nargs="*", help="notebooks to execute (default: all)")
    parser.add_argument("--notebooks", type=Path, default=Path("notebooks"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--out", type=Path, default=Path("build/book"))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    try:
        paths = [Path(name) for name in args.names] or find_notebooks(args.notebooks)
        executed = []
        for chapter in tqdm(execute_all(paths, jobs=args.jobs), total=len(paths), unit="notebook"):
            executed.append(chapter)
            _say_departures(chapter)
            if args.action == "execute":
                store(chapter)
        if args.action == "build":
            _build(executed, args.docs, args.out)
    except InputError as error:
        print(f"medkit.book: {error}", file=sys.stderr)
        return 2
    return 0


def _say_departures(chapter: Executed) -> None:
    """Name the verdicts that this execution changed, before they are stored or printed."""
    before = Executed(chapter.path, read(chapter.path), 0.0)
    for sentence in departures(replay_rows([before]), replay_rows([chapter])):
        print(f"medkit.book: a verdict changed: {sentence}", file=sys.stderr)


def _build(executed: list[Executed], docs: Path, out: Path) -> None:
    documents = [docs / name for name in DOCUMENTS if (docs / name).exists()]
    index = write_book(executed, documents, out)
    print(f"The book lies at {index.resolve()}: open it in any browser, offline.")


raise SystemExit(main())
