"""``medkit check-hand``: its arguments and its output."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from medkit.robots import Hand

HELP = "check the description of a hand, and draw it open and closed"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this subcommand."""
    parser.add_argument("hand", metavar="FILE", help="YAML description, or the name of a hand")
    parser.add_argument("--picture", metavar="FILE.png", help="where to draw the hand")
    parser.add_argument(
        "--package-dir",
        action="append",
        default=[],
        metavar="FOLDER",
        help="folder in which package:// paths of a URDF are looked up; may be repeated",
    )


def run(args: argparse.Namespace) -> int:
    """Print the findings and write the picture; exit status 2 when a problem was found."""
    from medkit.errors import InputError
    from medkit.robots import load_hand
    from medkit.robots.check import PROBLEM, check_hand

    hand = load_hand(args.hand, package_dirs=args.package_dir)
    findings = check_hand(hand)
    print(f"{hand.name}: {len(hand.joint_names)} joints, {len(hand.fingers)} fingers")
    for finding in findings:
        print(f"  {finding.level:8} {finding.topic:20} {finding.text}")
    if args.picture:
        _write_picture(hand, args.picture)
    problems = [finding for finding in findings if finding.level == PROBLEM]
    if problems:
        first = problems[0]
        raise InputError(
            f"Expected a hand that can be planned with, but {len(problems)} of {len(findings)}"
            f" checks of {hand.name} found a problem, the first under {first.topic}: {first.text};"
            " correct the description."
        )
    return 0


def _write_picture(hand: Hand, path: str) -> None:
    from matplotlib.figure import Figure

    from medkit.files import whole_file
    from medkit.robots.check import closed_configuration
    from medkit.viz.hands import plot_hand, plot_hand_directions

    figure = Figure(figsize=(11, 5.5), dpi=100, layout="constrained")
    shapes = {"power preshape": hand.preshapes["power"], "closed": closed_configuration(hand)}
    for column, (title, q) in enumerate(shapes.items(), start=1):
        axes = figure.add_subplot(1, 2, column, projection="3d")
        plot_hand(hand, q, ax=axes)
        axes.set_title(f"{hand.name}: {title}")
        if column == 1:
            plot_hand_directions(hand, ax=axes)
            axes.legend(loc="upper left", fontsize=8)
    with whole_file(path) as draft:
        figure.savefig(draft, format="png")
