"""``medkit plan``: its arguments and its output."""

from __future__ import annotations

import argparse

HELP = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this subcommand."""


def run(args: argparse.Namespace) -> int:
    """Run this subcommand and return its exit status."""
    return 0
