"""``python -m medkit.labs``: students' and solved copies of the labs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from medkit.errors import InputError
from medkit.labs.copies import write_copies


def main() -> int:
    """Write copies of the labs; exit status 2 on bad input."""
    parser = argparse.ArgumentParser(prog="python -m medkit.labs", description=__doc__)
    actions = parser.add_subparsers(dest="action", required=True)
    for name in ("students", "solutions"):
        copies = actions.add_parser(name)
        copies.add_argument("--labs", type=Path, default=Path("notebooks/labs"))
        copies.add_argument("--answers", type=Path, default=Path("tests/labs/solutions"))
        copies.add_argument("--out", type=Path, default=Path("build/labs"))
    args = parser.parse_args()
    try:
        answers = args.answers if args.action == "solutions" else None
        for path in write_copies(args.labs, args.out, answers):
            print(path)
    except InputError as error:
        print(f"medkit.labs: {error}", file=sys.stderr)
        return 2
    return 0


raise SystemExit(main())
