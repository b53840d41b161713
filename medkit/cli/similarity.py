"""``medkit similarity``: rank the grasps of a grasp file by their likeness to people's."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

    from medkit.grasping.grasp_set import GraspSet
    from medkit.similarity.symmetry import SymmetryGroup

HELP = "rank planned grasps by human-likeness"
MEASURES = ("d_symmetric", "d_eucl", "d_z", "nearest")
SHOWN = 10  # findings about the recordings that are printed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this subcommand."""
    parser.add_argument("grasps", metavar="GRASPS.json", help="from medkit plan --out")
    parser.add_argument("human", metavar="HUMAN_DIR", help="recordings, e.g. data/human_grasps")
    parser.add_argument("--object", help="recorded object to compare with (found from the mesh)")
    parser.add_argument("--mesh", help="mesh of the planned object (the path in the grasp file)")
    parser.add_argument("--subject", help="one person's average (every person's, nearest counts)")
    parser.add_argument("--by", choices=MEASURES, default="d_symmetric", help="sort (d_symmetric)")
    parser.add_argument(
        "--upright", action="store_true", help="only symmetries that keep the object's z up"
    )
    parser.add_argument("--all", action="store_true", help="also grasps without force closure")
    parser.add_argument("--top", type=int, default=10, metavar="N", help="rows printed (10)")
    parser.add_argument("--out", metavar="FILE", help="write the whole ranking, .csv or .json")


def run(args: argparse.Namespace) -> int:
    """Run this subcommand and return its exit status."""
    from medkit.errors import InputError
    from medkit.grasping.grasp_file import read_grasps

    if args.out and Path(args.out).suffix not in (".csv", ".json"):
        raise InputError(f"Expected --out to end in .csv or .json, but got {args.out}.")
    if args.top < 1:
        raise InputError(f"Expected --top of one or more, but got {args.top}.")
    found = read_grasps(args.grasps)
    group, known = _symmetry(found, args.mesh)
    table, people = _ranking(found, group, known, args)
    print(_report(table, people, args))
    if args.out:
        _write(table, args.out)
    return 0


def _symmetry(found: GraspSet, mesh_path: str | None) -> tuple[SymmetryGroup, bool]:
    """The object's group about its centre of mass, and whether a mesh was there to find it in."""
    from dataclasses import replace

    import numpy as np

    from medkit.errors import InputError
    from medkit.meshes import load_mesh
    from medkit.similarity.symmetry import trivial_group
    from medkit.similarity.symmetry_group import symmetry_group_from_mesh

    path = Path(mesh_path or found.object.path or "")
    if not path.is_file():
        if mesh_path:
            raise InputError(f"Expected a mesh, but {path} is not there; check --mesh.")
        return trivial_group(), False
    mesh = load_mesh(path, scale=found.object.scale)
    extents = np.asarray(found.object.extents)
    if not np.allclose(mesh.extents, extents, rtol=0.02):
        raise InputError(
            f"Expected the mesh of the grasp file, of extents {extents.round(4)} m, but {path} has"
            f" {mesh.extents.round(4)} m; pass the right one with --mesh."
        )
    group = symmetry_group_from_mesh(mesh)
    return replace(group, center=group.center - np.asarray(found.object.center_mass)), True


def _ranking(
    found: GraspSet, group: SymmetryGroup, known: bool, args: argparse.Namespace
) -> tuple[pd.DataFrame, str]:
    from medkit.datasets.human_grasps import load_human_grasps, load_human_objects
    from medkit.similarity.grasps import grasps_from_recordings
    from medkit.similarity.ranking import human_reference, rank_grasps

    recordings, objects = load_human_grasps(args.human), load_human_objects(args.human)
    _check(recordings, objects)
    name = args.object or _matching_object(group, known, objects)
    humans, failed = grasps_from_recordings(recordings)
    for row in failed.itertuples():
        print(f"left out: {row.subject}, {row.object}, {row.trial}: {row.why}", file=sys.stderr)
    humans = humans.of(object=name)
    shape = _shape(objects, name)
    if not known:
        group = _group_of_shape(shape)
    if args.upright:
        group = group.keeping([0.0, 0.0, 1.0])
    tips, rows, gripper = _fingertips(found, everything=args.all)
    reference = human_reference(
        humans, recorded_extents=objects.loc[name, ["extent_x", "extent_y", "extent_z"]],
        extents=found.object.extents, group=group, fingers=tips.shape[1], interchangeable=gripper,
    )  # fmt: skip
    table = rank_grasps(tips, reference, subject=args.subject, by=args.by)
    table["grasp"] = [rows[i] for i in table["grasp"]]
    table["epsilon"] = [found.grasps[i].epsilon for i in table["grasp"]]
    kind = "SIMULATED recordings" if reference.simulated else "recordings"
    people = (
        f"{found.object.path or 'object'}, hand {found.hand}, against {len(humans)} {kind} of the"
        f" {name}; symmetry {group.name}{'' if known else ' (of the recorded shape: no mesh)'}"
    )
    return table, people


def _check(recordings: pd.DataFrame, objects: pd.DataFrame) -> None:
    """Say what is wrong with the recordings; refuse them if anything makes them unusable."""
    from medkit.errors import InputError
    from medkit.similarity.validate import validate

    findings = validate(recordings, objects)
    # errors first, and no more of them than fit on a screen
    shown = findings.sort_values("severity", kind="stable").head(SHOWN)
    for row in shown.itertuples():
        print(f"{row.severity}: {row.rows}: {row.problem}; {row.advice}", file=sys.stderr)
    if len(findings) > len(shown):
        print(f"and {len(findings) - len(shown)} findings more", file=sys.stderr)
    errors = int((findings["severity"] == "error").sum())
    if errors:
        raise InputError(
            f"Expected usable recordings, but found {errors} errors in them (the first stand"
            " above); mend them or leave those trials out."
        )


def _shape(objects: pd.DataFrame, name: str) -> str:
    from medkit.errors import InputError

    if name not in objects.index:
        raise InputError(
            f"Expected an object among {', '.join(objects.index)}, but got {name!r};"
            " choose one with --object."
        )
    return str(objects.loc[name, "shape"])


def _matching_object(group: SymmetryGroup, known: bool, objects: pd.DataFrame) -> str:
    """The recorded object of the planned one's kind: a body of revolution, or a box."""
    from medkit.errors import InputError

    kind = "cylinder" if group.continuous == "axis" else "box"
    names = objects.index[objects["shape"] == kind].tolist()
    if not known or not names:
        why = f"no recorded object has the shape {kind}" if known else "its mesh was not found"
        raise InputError(
            f"Expected to match the planned object with a recorded one, but {why};"
            f" choose with --object among {', '.join(objects.index)}, or pass --mesh."
        )
    return str(names[0])


def _group_of_shape(shape: str) -> SymmetryGroup:
    from medkit.similarity.symmetry import dihedral_group, revolution_group, trivial_group

    if shape == "cylinder":
        return revolution_group([0, 0, 1], flips=True)
    return dihedral_group([0, 0, 1], 2, [1, 0, 0]) if shape == "box" else trivial_group()


def _fingertips(found: GraspSet, *, everything: bool) -> tuple[Any, list[int], bool]:
    """Fingertips (n, k, 3) [m] about the centre of mass, their rows, and whether jaws may swap."""
    import numpy as np

    from medkit.errors import InputError
    from medkit.robots import load_hand

    hand = load_hand(found.hand)
    rows = [i for i, g in enumerate(found.grasps) if everything or g.outcome == "force_closure"]
    if not rows:
        raise InputError(
            f"Expected force-closure grasps among the {len(found.grasps)} of the file, but there"
            " is none; plan more, or rank the others with --all."
        )
    joints = np.stack([found.grasps[i].q for i in rows])
    poses = np.stack([found.grasps[i].pose for i in rows])
    tips = np.stack(list(hand.fingertips(joints).values()), axis=1)
    placed = np.einsum("nab,nkb->nka", poses[:, :3, :3], tips) + poses[:, None, :3, 3]
    return placed - np.asarray(found.object.center_mass), rows, len(hand.fingers) == 2


def _report(table: pd.DataFrame, people: str, args: argparse.Namespace) -> str:
    lines = [
        people,
        "rank grasp  d_symmetric   d_eucl      d_z  nearest  within   epsilon  subject",
    ]
    lines.append("                    [mm]     [mm]     [mm]     [mm] 100 mm")
    for row in table.head(args.top).to_dict("records"):
        lengths = [1e3 * row[name] for name in MEASURES]
        lines.append(
            f"{row['rank']:4d} {row['grasp']:5d} {lengths[0]:12.1f}"
            + "".join(f" {length:8.1f}" for length in lengths[1:])
            + f" {100 * row['share']:5.0f} % {row['epsilon']:9.4f}  {row['subject']}"
        )
    if len(table) > args.top:
        lines.append(f"... {len(table) - args.top} more; --top {len(table)} prints them all")
    return "\n".join(lines)


def _write(table: pd.DataFrame, target: str) -> None:
    from medkit.files import write_text

    columns = ["rank", "grasp", *MEASURES, "share", "epsilon", "subject"]
    if Path(target).suffix == ".json":
        text = table[columns].to_json(orient="records", indent=1) + "\n"
    else:
        text = table[columns].to_csv(index=False)
    write_text(target, text)
