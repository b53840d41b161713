"""``python -m medkit.labs``: students' and solved copies of the labs, or one graded notebook."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from medkit.errors import InputError
from medkit.labs.copies import write_copies
from medkit.labs.grade import verdict_of
from medkit.labs.registry import exercises_of


def main() -> int:
    """Write copies, or print verdicts as JSON lines for the grading parent process."""
    parser = argparse.ArgumentParser(prog="python -m medkit.labs", description=__doc__)
    actions = parser.add_subparsers(dest="action", required=True)
    for name in ("students", "solutions"):
        copies = actions.add_parser(name)
        copies.add_argument("--labs", type=Path, default=Path("notebooks/labs"))
        copies.add_argument("--answers", type=Path, default=Path("tests/labs/solutions"))
        copies.add_argument("--out", type=Path, default=Path("build/labs"))
    one = actions.add_parser("submission")
    one.add_argument("path", type=Path)
    one.add_argument("lab")
    one.add_argument("seed", type=int)
    one.add_argument("--time-limit", type=float, default=None)
    args = parser.parse_args()
    try:
        if args.action == "submission":
            _grade_here(args.path, args.lab, args.seed, args.time_limit)
            return 0
        answers = args.answers if args.action == "solutions" else None
        for path in write_copies(args.labs, args.out, answers):
            print(path)
    except InputError as error:
        print(f"medkit.labs: {error}", file=sys.stderr)
        return 2
    return 0


def _grade_here(path: Path, lab: str, seed: int, time_limit: float | None) -> None:
    for exercise in exercises_of(lab):
        verdict = verdict_of(path, exercise, seed, time_limit)
        # a submission may have printed without a newline
        print("\n" + json.dumps(asdict(verdict)), flush=True)


raise SystemExit(main())
