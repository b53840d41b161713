"""``medkit handover``: the claims and the recommended release force, as tables or a report."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "hold a table of handover ratings against seven claims and recommend a release force"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this subcommand."""
    parser.add_argument(
        "trials", nargs="?", metavar="TRIALS.csv",
        help="a table of your own (docs/adding_trials.md); the thesis's when left out",
    )  # fmt: skip
    parser.add_argument(
        "--level", type=float, default=0.75, metavar="SCORE",
        help="expected score to keep, between 0 and 1 (default 0.75)",
    )  # fmt: skip
    parser.add_argument(
        "--irregular", choices=("drop", "keep", "best", "worst"), default="drop",
        help="what becomes of cells whose ratings do not add up (default drop)",
    )  # fmt: skip
    parser.add_argument(
        "--weight-error", type=float, default=0.1, metavar="KG",
        help="by how much the weight may be underestimated (default 0.1)",
    )  # fmt: skip
    parser.add_argument(
        "--bump", type=float, default=0.5, metavar="N",
        help="noise and bumps that must not release (default 0.5)",
    )  # fmt: skip
    parser.add_argument(
        "--subject", default="T4", help="whom claim 5 calls the least sensitive (default T4)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of bootstrap and shuffles (default 0)")
    parser.add_argument(
        "--html", metavar="FILE", help="write a report with figures, readable offline"
    )


def run(args: argparse.Namespace) -> int:
    """Run this subcommand and return its exit status."""
    import numpy as np

    from medkit.errors import InputError
    from medkit.handover import claims, describe_trials, iso_slope, load_trials, recommend_force

    if args.seed < 0:
        raise InputError(f"Expected a seed of 0 or more, came {args.seed}; pass a whole number.")
    if args.html and not Path(args.html).parent.is_dir():
        raise InputError(
            f"Expected an existing folder for the report {args.html}; create it or name another."
        )
    trials = load_trials(args.trials, irregular=args.irregular)
    force = recommend_force(
        trials, level=args.level, weight_error_kg=args.weight_error, bump_N=args.bump
    )
    slope = iso_slope(trials, args.level)
    table = claims(trials, rng=np.random.default_rng(args.seed), subject=args.subject)
    if args.html:
        from medkit.cli.handover_report import write_report

        write_report(args.html, trials, table, slope, force, level=args.level)
    print("\n\n".join([describe_trials(trials), *sections(table, slope, force, args.level)]))
    if args.html:
        print(f"\nReport: {args.html}")
    return 0


def sections(table, slope, force, level):  # type: ignore[no-untyped-def]
    """Return the printed sections: claims, slope, recommendation."""
    return [_claims_text(table), _slope_text(slope, level), _force_text(force, level)]


def _claims_text(table):  # type: ignore[no-untyped-def]
    lines = ["Claims (95 % interval for people like these; p by shuffling within a subject)"]
    width = max(len(text) for text in table["claim"])
    unit = max(len(text) for text in table["unit"])
    lines.append(
        f"   {'claim':<{width}}  {'estimate':>8}  {'low':>7}  {'high':>7}  {'p':>6}"
        f"  {'verdict':<12}  {'these only':<12}  {'agree':<13}  {'unit':<{unit}}"
    )
    for number, row in table.iterrows():
        lines.append(
            f"{number}  {row['claim']:<{width}}  {row['estimate']:8.2f}  {row['low']:7.2f}"
            f"  {row['high']:7.2f}  {row['p_permutation']:6.4f}  {row['verdict']:<12}"
            f"  {row['verdict_these']:<12}  {row['agree']:<13}  {row['unit']:<{unit}}".rstrip()
        )
    return "\n".join(lines)


def _slope_text(slope, level):  # type: ignore[no-untyped-def]
    lines = [
        f"How much more force a heavier object allows, at a score of {level:g}",
        f"   {'pose':<8}{'mode':<12}{'N/kg':>6}  {'low':>6}  {'high':>6}  proportional to the load",
    ]
    for row in slope.itertuples():
        lines.append(
            f"   {row.pose:<8}{row.mode:<12}{row.slope:6.2f}  {row.low:6.2f}  {row.high:6.2f}"
            f"  {row.proportional}"
        )
    return "\n".join(lines)


def _force_text(force, level):  # type: ignore[no-untyped-def]
    lines = [
        f"Recommended release force [N] between safety and naturalness (score {level:g})",
        f"   {'pose':<8}{'mode':<12}{'kg':>6}  {'safety':>6}  {'natural':>13}"
        f"  {'force':>6}  window",
    ]
    for row in force.itertuples():
        natural = f"{row.upper:.2f}..{row.upper_estimate:.2f}"
        lines.append(
            f"   {row.pose:<8}{row.mode:<12}{row.weight:6.3f}  {row.lower:6.2f}  {natural:>13}"
            f"  {row.force:6.2f}  {row.window}"
        )
    lines.append(
        "   open: both limits leave room; narrow: only by the estimate, not by its cautious end;"
        " closed: safety alone already asks for more than feels natural."
    )
    return "\n".join(lines)
