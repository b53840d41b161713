"""``medkit check-hand``: its arguments and its output."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from medkit.geometry import Floats
    from medkit.robots import Hand
    from medkit.robots.check import Finding

HELP = "check the description of a hand, and draw it open, closed and as it pinches"


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
    findings = [*check_hand(hand), precision_finding(hand)]
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


def precision_finding(hand: Hand) -> Finding:
    """Over which openings the pads of a precision grasp oppose each other.

    Parameters
    ----------
    hand : Hand
        The hand.

    Returns
    -------
    Finding
        Opposed means that the line between the pads lies within a friction cone of 0.5 around
        the grip axis; a note when that ends while the pads are more than half of the largest
        ball apart, or when the hand has no precision grip at all.
    """
    from medkit.errors import InputError
    from medkit.grasping.precision_grip import precision_grip
    from medkit.robots.check import NOTE, OK, Finding

    try:
        grip = precision_grip(hand, idle="power")
    except InputError as error:
        return Finding(NOTE, "precision grip", str(error))
    opposed = grip.faces(grip.openings)
    narrowest = float(grip.openings[opposed].min(initial=grip.widest))
    text = (
        f"pads oppose each other from {1000 * grip.widest:.0f} to {1000 * narrowest:.0f} mm apart"
    )
    if opposed.any() and narrowest <= hand.max_sphere_radius:
        return Finding(OK, "precision grip", text)
    advice = "; closer, they pass each other: bend or turn joints in the precision preshape"
    return Finding(NOTE, "precision grip", text + advice)


def _write_picture(hand: Hand, path: str) -> None:
    from matplotlib.figure import Figure

    from medkit.files import whole_file
    from medkit.robots.check import closed_configuration
    from medkit.viz.hands import plot_hand, plot_hand_directions

    figure = Figure(figsize=(15, 5), dpi=100, layout="constrained")
    shapes = {
        "power preshape": hand.preshapes["power"],
        "closed": closed_configuration(hand),
        **_pinching(hand),
    }
    for column, (title, q) in enumerate(shapes.items(), start=1):
        axes = figure.add_subplot(1, 3, column, projection="3d")
        plot_hand(hand, q, ax=axes)
        axes.set_title(f"{hand.name}: {title}")
        if column == 1:
            plot_hand_directions(hand, ax=axes)
            axes.legend(loc="upper left", fontsize=8)
    with whole_file(path) as draft:
        figure.savefig(draft, format="png")


def _pinching(hand: Hand) -> dict[str, Floats]:
    """The hand with its pads as far apart as the radius of its largest ball; empty without pads."""
    import numpy as np

    from medkit.errors import InputError
    from medkit.grasping.precision_grip import precision_grip

    try:
        grip = precision_grip(hand, idle="power")
    except InputError:
        return {}
    amount = grip.amount_for(np.array([hand.max_sphere_radius]))
    opening = 1000 * float(np.interp(amount, grip.amounts, grip.openings)[0])
    return {f"precision, pads {opening:.0f} mm apart": grip.configuration(hand, amount)[0]}
