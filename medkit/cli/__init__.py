"""The ``medkit`` command: one thin file per subcommand, one sentence per error."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from typing import NoReturn

from medkit.errors import InputError

#: Subcommand -> module with HELP, add_arguments(parser) and run(args) -> int.
COMMANDS = {
    "plan": "medkit.cli.plan",
    "check": "medkit.cli.check",
    "handover": "medkit.cli.handover",
    "similarity": "medkit.cli.similarity",
    "check-hand": "medkit.cli.check_hand",
    "lab": "medkit.cli.lab",
}

BAD_INPUT = 2
INTERRUPTED = 130


class _OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors fit on one line."""

    def error(self, message: str) -> NoReturn:
        text = " ".join(message.split())
        self.exit(BAD_INPUT, f"{self.prog}: {text}; see {self.prog} --help\n")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command, with every subcommand."""
    from medkit import __version__

    parser = _OneLineParser(prog="medkit", description=(importlib.import_module("medkit").__doc__))
    parser.add_argument("--version", action="version", version=f"medkit {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, path in COMMANDS.items():
        module = importlib.import_module(path)
        sub = subparsers.add_parser(name, help=module.HELP, description=module.HELP)
        module.add_arguments(sub)
        sub.set_defaults(run=module.run, prog=sub.prog)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 2 bad input, 130 interrupted.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program name; the process's own when left out.

    Returns
    -------
    int
        The exit status.
    """
    args = build_parser().parse_args(argv)
    try:
        return int(args.run(args))
    except InputError as error:
        print(f"{args.prog}: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print(f"{args.prog}: interrupted; no output was written.", file=sys.stderr)
        return INTERRUPTED
