"""``medkit plan``: its arguments and its output."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from medkit.grasping.grasp_set import GraspSet
    from medkit.robots import Hand

HELP = "plan grasps of an object: every tested candidate with its outcome and quality"

#: What each outcome means, for the table.
MEANING = {
    "force_closure": "holds against every small disturbance",
    "not_force_closure": "touches, but can be shaken loose",
    "start_collision": "hand and object overlap before closing",
    "too_few_contacts": "fewer than three points touch",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this subcommand."""
    parser.add_argument("mesh", metavar="MESH", help="triangle mesh of the object")
    parser.add_argument("--scale", type=float, default=1.0, help="metres per unit of the file (1)")
    parser.add_argument("--hand", default="armar3", help="armar3, schunk, wsg50 or a hand file")
    parser.add_argument(
        "--package-dir",
        action="append",
        default=[],
        metavar="FOLDER",
        help="folder in which package:// paths of a hand's URDF are looked up; may be repeated",
    )
    parser.add_argument(
        "--planner", default="medial", help="medial, medial-plus, normals or boxes (medial)"
    )
    parser.add_argument("--grasp", default="power", choices=("power", "precision"))
    parser.add_argument("--friction", type=float, default=0.5, help="friction coefficient (0.5)")
    parser.add_argument(
        "--search-radius", type=float, default=0.03, help="radius of the symmetry analysis [m]"
    )
    parser.add_argument(
        "--min-radius-ratio",
        type=float,
        default=0.5,
        help="drop spheres below this share of the largest (0.5)",
    )
    parser.add_argument(
        "--max-candidates", type=int, default=400, metavar="N", help="candidates to test (400)"
    )
    parser.add_argument("--seed", type=int, default=0, help="draws the candidates (0)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes (1)")
    parser.add_argument("--out", metavar="FILE", help="write all grasps as JSON")
    parser.add_argument("--xml", metavar="FILE", help="write the force-closure grasps as XML")
    parser.add_argument("--html", metavar="FILE", help="write a page that shows the grasps")
    parser.add_argument("--glb", metavar="FILE", help="write object and hand at the best grasp")


def run(args: argparse.Namespace) -> int:
    """Run this subcommand and return its exit status."""
    check_arguments(args)
    import numpy as np

    from medkit.grasping.planners import plan_grasps, with_origin
    from medkit.grasping.strategies import CANDIDATE_SOURCES, looked_up
    from medkit.meshes import load_mesh, refuse_wrong_scale, repair_mesh
    from medkit.robots import load_hand

    looked_up(CANDIDATE_SOURCES, args.planner, "planner")
    hand = load_hand(args.hand, package_dirs=args.package_dir)
    mesh = load_mesh(args.mesh, scale=args.scale)
    refuse_wrong_scale(mesh, scale=args.scale)
    repaired = repair_mesh(mesh)
    found = plan_grasps(
        repaired.mesh,
        hand,
        grasp=args.grasp,
        planner=args.planner,
        friction=args.friction,
        search_radius=args.search_radius,
        min_radius_ratio=args.min_radius_ratio,
        max_candidates=args.max_candidates,
        rng=np.random.default_rng(args.seed),
        jobs=args.jobs,
        progress=_bar,
    )
    found = with_origin(
        found,
        seed=args.seed,
        path=args.mesh,
        sha256=_file_hash(args.mesh),
        scale=args.scale,
        repairs=repaired.repairs,
    )
    write_outputs(args, found, repaired.mesh, hand)
    print(summary(found, passing=passing_pads(found, hand)))
    return 0


def check_arguments(args: argparse.Namespace) -> None:
    """Refuse what cannot work before any long work begins."""
    from medkit.errors import InputError
    from medkit.geometry import nonnegative, positive

    nonnegative(args.friction, "--friction")
    positive(args.scale, "--scale")
    positive(args.search_radius, "--search-radius", " m")
    if not 0.0 <= args.min_radius_ratio <= 1.0:
        raise InputError(
            f"Expected --min-radius-ratio between 0 and 1, but got {args.min_radius_ratio:g};"
            " it is a share of the largest radius."
        )
    for name, value in (("--max-candidates", args.max_candidates), ("--jobs", args.jobs)):
        if value < 1:
            raise InputError(f"Expected {name} of at least 1, but got {value}; give a larger one.")
    if args.seed < 0:
        raise InputError(f"Expected --seed of zero or more, but got {args.seed}; give another.")
    outputs = [path for path in (args.out, args.xml, args.html, args.glb) if path is not None]
    for path in outputs:
        check_writable(path)
    if len({Path(path).resolve() for path in outputs}) < len(outputs):
        raise InputError(
            f"Expected another file for each output, but {outputs[-1]} and another are the same;"
            " one would replace the other."
        )


def check_writable(path: str) -> None:
    """Refuse an output that could not be written; nothing is left behind."""
    from medkit.files import whole_file

    with contextlib.suppress(_Enough), whole_file(path):
        raise _Enough


class _Enough(Exception):
    """Ends a trial of writing before anything appears."""


def write_outputs(args: argparse.Namespace, found: GraspSet, mesh: Any, hand: Any) -> None:
    """Write the files that were asked for."""
    from medkit.grasping.grasp_file import grasp_document, write_grasps
    from medkit.grasping.grasp_set import FORCE_CLOSURE

    document = grasp_document(found)
    if args.out:
        write_grasps(args.out, found)
    if args.xml:
        from medkit.grasping.export_xml import write_grasps_xml

        write_grasps_xml(args.xml, document, preshape=found.grasp, prismatic=hand.prismatic_joints)
    if args.glb and found.best():
        from medkit.grasping.export_glb import write_grasp_glb

        entries = document["grasps"]
        best = max(entries, key=lambda entry: (entry["outcome"] == FORCE_CLOSURE, entry["epsilon"]))
        write_grasp_glb(args.glb, mesh, hand, best)
    if args.html:
        from medkit.viz.scene import write_scene_html

        write_scene_html(
            args.html,
            title=f"{found.grasp} grasps of {Path(args.mesh).name}",
            subtitle=f"{hand.name}, planner {found.planner}",
            object_mesh=mesh,
            hand=hand,
            grasps=document["grasps"],
            friction=args.friction,
            preshape=found.grasp,
        )


def passing_pads(found: GraspSet, hand: Hand) -> int:
    """How many precision grasps touch too little where the hand's pads pass each other.

    Parameters
    ----------
    found : GraspSet
        The result.
    hand : Hand
        The hand that it was planned for.

    Returns
    -------
    int
        Candidates with too few contacts from spheres at whose diameter the pads do not oppose
        each other, see `PrecisionGrip.faces`; 0 for other kinds of grasps.
    """
    from medkit.grasping.grasp_set import TOO_FEW_CONTACTS
    from medkit.grasping.precision_grip import precision_grip

    radii = [grasp.sphere_radius for grasp in found.grasps if grasp.outcome == TOO_FEW_CONTACTS]
    diameters = [2.0 * radius for radius in radii if radius > 0.0]
    if found.grasp != "precision" or not diameters:
        return 0
    return int((~precision_grip(hand).faces(diameters)).sum())


def summary(found: GraspSet, *, passing: int = 0) -> str:
    """The result as a table for the terminal; `passing` is from `passing_pads`."""
    record, total = found.object, len(found)
    size = " x ".join(f"{1000 * edge:.0f}" for edge in record.extents)
    lines = [f"{Path(record.path).name}: {size} mm, hand {found.hand}, planner {found.planner}"]
    lines += [f"  repaired: {repair}" for repair in record.repairs]
    fates = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in found.sphere_counts.items())
    if fates:
        lines.append(f"  {sum(found.sphere_counts.values())} starting points: {fates}")
    lines.append(f"  {found.candidates_found} candidates, {total} tested:")
    for outcome, count in found.outcomes.items():
        meaning = MEANING.get(outcome, "")
        if outcome == "too_few_contacts" and passing:
            meaning += f"; for {passing} of them this hand's pads pass each other"
        lines.append(
            f"  {count:6d}  {100 * count / total:5.1f} %  {outcome:20s} {meaning}".rstrip()
        )
    lines += _advice(found)
    best = found.best()
    if not best:
        lines.append("  no candidate holds, so there is no best grasp to write")
    else:
        lines.append(f"  best epsilon {best[0].epsilon:.4f}, {len(best[0].points)} contacts")
    times = ", ".join(f"{name} {value:.2f} s" for name, value in found.timing.items())
    return "\n".join([*lines, f"  {times}"])


def _advice(found: GraspSet) -> list[str]:
    """Say so when the hand is too small or too large for nearly all of the object."""
    fates, spheres = found.sphere_counts, sum(found.sphere_counts.values())
    usable = sum(fates.get(name, 0) for name in ("axis", "rim", "ball", "dominant_sphere"))
    large, small = fates.get("too_large_for_hand", 0), fates.get("too_small_for_hand", 0)
    if spheres and large + small > 4 * usable:
        word = "thicker" if large >= small else "thinner"
        return [f"  the object is {word} than the hand can hold nearly everywhere"]
    return []


def _bar(results: Iterable[Any], total: int) -> Iterable[Any]:
    from tqdm import tqdm

    # disable=None: no bar where standard error is not a terminal
    return tqdm(results, total=total, desc="closing", file=sys.stderr, leave=False, disable=None)


def _file_hash(path: str) -> str:
    import hashlib

    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
