"""``medkit lab grade``: run a lab's checks over a folder of submissions."""

from __future__ import annotations

import argparse

HELP = "run a lab's checks, with hidden cases and a time limit, over submissions"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``medkit lab``."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    grade = actions.add_parser("grade", help=HELP, description=HELP)
    grade.add_argument("folder", metavar="FOLDER", help="folder of submitted notebooks")
    grade.add_argument("--seed", type=int, default=1, help="seed of the hidden cases (default 1)")
    grade.add_argument(
        "--time-limit",
        type=float,
        default=20.0,
        help="seconds of computing an exercise may take (default 20)",
    )
    grade.add_argument("--out", metavar="GRADES.csv", help="also write the table as CSV")


def run(args: argparse.Namespace) -> int:
    """Print a line per submission, and write the table where asked."""
    import csv
    import sys
    from itertools import groupby
    from pathlib import Path

    from tqdm import tqdm

    from medkit.files import whole_file
    from medkit.geometry import positive
    from medkit.labs.grade import table

    positive(args.time_limit, "the time limit", " s")

    def bar(paths: list[Path]) -> tqdm[Path]:
        return tqdm(paths, unit="submission", leave=False)

    rows = []
    graded = table(Path(args.folder), seed=args.seed, time_limit=args.time_limit, progress=bar)
    for submission, group in groupby(graded, key=lambda row: row["submission"]):
        mine = list(group)
        rows += mine
        passed = sum(row["passed"] for row in mine)
        lines = [f"{passed}/{len(mine)}  {submission}"]
        lines += [f"      {row['exercise']}: {row['hint']}" for row in mine if not row["passed"]]
        # as soon as it is known, above the bar
        tqdm.write("\n".join(lines), file=sys.stdout)
    if args.out:
        with whole_file(args.out) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, fieldnames=["submission", "exercise", "passed", "hint"])
            writer.writeheader()
            writer.writerows(rows)
    return 0
