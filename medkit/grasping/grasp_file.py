"""The grasp file: JSON of schema ``medkit.grasps/1``, written whole or not at all."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from medkit.arguments import file_path, short
from medkit.errors import InputError
from medkit.files import write_text
from medkit.grasping import file_checks as checks
from medkit.grasping.grasp_set import Grasp, GraspSet, ObjectRecord

SCHEMA = "medkit.grasps/1"
#: Keys that a grasp file must have, with the type of their values.
TOP: dict[str, type | tuple[type, ...]] = {
    "schema": str,
    "object": dict,
    "hand": str,
    "planner": str,
    "grasp": str,
    "parameters": dict,
    "counts": dict,
    "timing_s": dict,
    "grasps": list,
}
OBJECT = ("path", "sha256", "scale", "extents", "center_mass", "repairs")


def grasp_document(found: GraspSet) -> dict[str, Any]:
    """A grasp set as a document of schema ``medkit.grasps/1``.

    Parameters
    ----------
    found : GraspSet
        The grasps, failed ones included.

    Returns
    -------
    dict
        Lists, numbers and texts only; lengths in metres, poses ``T_object_hand`` as four rows.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.grasping import plan_grasps
    >>> ball = trimesh.creation.icosphere(3, 0.03)
    >>> asked = {"planner": "normals", "max_candidates": 2}
    >>> found = plan_grasps(ball, "wsg50", rng=np.random.default_rng(0), **asked)
    >>> document = grasp_document(found)
    >>> document["schema"], document["hand"], len(document["grasps"])
    ('medkit.grasps/1', 'wsg50', 2)
    """
    record = found.object
    return {
        "schema": SCHEMA,
        "object": {
            "path": record.path,
            "sha256": record.sha256,
            "scale": record.scale,
            "extents": record.extents.tolist(),
            "center_mass": record.center_mass.tolist(),
            "repairs": list(record.repairs),
        },
        "hand": found.hand,
        "planner": found.planner,
        "grasp": found.grasp,
        "parameters": dict(found.parameters),
        "seed": found.seed,
        "counts": {
            "spheres": int(sum(found.sphere_counts.values())),
            "sphere_fates": dict(found.sphere_counts),
            "candidates_found": found.candidates_found,
            "candidates": len(found),
            **found.outcomes,
        },
        "timing_s": {name: round(value, 6) for name, value in found.timing.items()},
        "grasps": [_grasp_entry(grasp, found.joint_names) for grasp in found.grasps],
    }


def write_grasps(path: str | os.PathLike[str], found: GraspSet) -> None:
    """Write a grasp set to a file, whole or not at all.

    Parameters
    ----------
    path : path-like
        The JSON file to write.
    found : GraspSet
        The grasps.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.

    Examples
    --------
    See `read_grasps`.
    """
    write_text(path, json.dumps(grasp_document(found), allow_nan=False) + "\n")


def read_grasps(path: str | os.PathLike[str]) -> GraspSet:
    """Read a grasp file and check it.

    Parameters
    ----------
    path : path-like
        A JSON file of schema ``medkit.grasps/1``.

    Returns
    -------
    GraspSet
        What was written.

    Raises
    ------
    InputError
        If the file is missing, is no JSON, or breaks the schema; the message names the place.

    Examples
    --------
    >>> import tempfile
    >>> import trimesh
    >>> from medkit.grasping import plan_grasps
    >>> ball = trimesh.creation.icosphere(3, 0.03)
    >>> asked = {"planner": "normals", "max_candidates": 2}
    >>> found = plan_grasps(ball, "wsg50", rng=np.random.default_rng(0), **asked)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_grasps(f"{folder}/grasps.json", found)
    ...     again = read_grasps(f"{folder}/grasps.json")
    >>> bool((again.grasps[0].pose == found.grasps[0].pose).all())
    True
    """
    file = file_path(path, "a grasp file")
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"Expected a grasp file, but {file} cannot be read ({error.strerror}); check the path."
        ) from error
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"Expected JSON in {file.name}, but {error}; write it with medkit plan."
        ) from error
    return grasps_from_document(document, name=file.name)


def grasps_from_document(document: Any, *, name: str = "the document") -> GraspSet:
    """Check a document of schema ``medkit.grasps/1`` and build the grasp set.

    Parameters
    ----------
    document : mapping
        Content of a grasp file, as `json.load` gives it.
    name : str
        What the sentences of refusal call it.

    Returns
    -------
    GraspSet
        The grasps.

    Raises
    ------
    InputError
        If it breaks the schema: a key is missing, a number is not finite, a pose is not rigid, a
        direction is not of length one (within 1e-4, as files round). The message names the place.

    Examples
    --------
    >>> try:
    ...     grasps_from_document({"schema": "grasps/0"}, name="old.json")
    ... except InputError as error:
    ...     print(error)
    Expected schema 'medkit.grasps/1' in old.json, but got 'grasps/0'; plan it anew.
    """
    _check_top(document, name)
    known, place = document["object"], f"object of {name}"
    entries = document["grasps"]
    joints = _joint_names(entries[0]) if entries else ()
    grasps = tuple(
        _grasp(entry, joints, f"grasps[{k}] of {name}") for k, entry in enumerate(entries)
    )
    counts = {"candidates_found": len(grasps), **document["counts"]}
    timing = document["timing_s"]
    return GraspSet(
        object=ObjectRecord(
            str(known["path"]),
            str(known["sha256"]),
            checks.number(known, "scale", place, least=np.nextafter(0.0, 1.0)),
            checks.numbers(known, "extents", (3,), place),
            checks.numbers(known, "center_mass", (3,), place),
            checks.texts(known, "repairs", place),
        ),
        hand=document["hand"],
        planner=document["planner"],
        grasp=document["grasp"],
        joint_names=joints,
        parameters=document["parameters"],
        seed=None if document.get("seed") is None else checks.whole(document, "seed", name),
        sphere_counts=checks.counted(counts, "sphere_fates", f"counts of {name}"),
        candidates_found=checks.whole(counts, "candidates_found", f"counts of {name}"),
        timing={key: checks.number(timing, key, f"timing_s of {name}") for key in timing},
        grasps=grasps,
    )


def _joint_names(entry: Any) -> tuple[str, ...]:
    joints = entry.get("joints") if isinstance(entry, Mapping) else None
    return tuple(joints) if isinstance(joints, Mapping) else ()


def _grasp_entry(grasp: Grasp, joint_names: Sequence[str]) -> dict[str, Any]:
    return {
        "outcome": grasp.outcome,
        "pose": grasp.pose.tolist(),
        "joints": dict(zip(joint_names, grasp.q.tolist(), strict=True)),
        "approach": grasp.approach.tolist(),
        "closing_axis": grasp.closing_axis.tolist(),
        "grasp_point": grasp.grasp_point.tolist(),
        "sphere_radius": grasp.sphere_radius,
        "contacts": [
            {"point": point.tolist(), "normal": normal.tolist(), "link": link}
            for point, normal, link in zip(grasp.points, grasp.normals, grasp.links, strict=True)
        ],
        "epsilon": grasp.epsilon,
        "pregrasp": grasp.pregrasp.tolist(),
    }


def _check_top(document: Any, name: str) -> None:
    if not isinstance(document, Mapping) or document.get("schema") != SCHEMA:
        came = document.get("schema") if isinstance(document, Mapping) else type(document).__name__
        raise InputError(
            f"Expected schema {SCHEMA!r} in {name}, but got {short(came)}; plan it anew."
        )
    for key, kind in TOP.items():
        if not isinstance(document.get(key), kind):
            raise InputError(
                f"Expected {key!r} in {name} to be a {getattr(kind, '__name__', kind)}, but got"
                f" {type(document.get(key)).__name__}; write the file with medkit plan."
            )
    missing = [key for key in OBJECT if key not in document["object"]]
    if missing:
        raise InputError(
            f"Expected {missing[0]!r} in the object of {name}, but it is missing; add it."
        )


def _grasp(entry: Any, joint_names: Sequence[str], place: str) -> Grasp:
    if not isinstance(entry, Mapping) or not isinstance(entry.get("outcome"), str):
        raise InputError(f"Expected an outcome in {place}, but there is none; add it.")
    joints = entry.get("joints")
    if not isinstance(joints, Mapping) or tuple(joints) != tuple(joint_names):
        raise InputError(
            f"Expected the joints {', '.join(joint_names)} in {place}, but got {short(joints)};"
            " every grasp names the same joints."
        )
    contacts = entry.get("contacts")
    if not isinstance(contacts, list):
        raise InputError(
            f"Expected a list of contacts in {place}, but got {short(contacts)}; add one."
        )
    points = [checks.numbers(contact, "point", (3,), place) for contact in contacts]
    normals = [checks.unit_vector(contact, "normal", place) for contact in contacts]
    return Grasp(
        outcome=entry["outcome"],
        pose=checks.rigid(entry, "pose", place),
        pregrasp=checks.rigid(entry, "pregrasp", place),
        q=np.array([checks.number(joints, joint, f"joints of {place}") for joint in joints]),
        approach=checks.unit_vector(entry, "approach", place),
        closing_axis=checks.unit_vector(entry, "closing_axis", place),
        grasp_point=checks.numbers(entry, "grasp_point", (3,), place),
        sphere_radius=checks.number(entry, "sphere_radius", place, least=0.0),
        points=np.array(points).reshape(-1, 3),
        normals=np.array(normals).reshape(-1, 3),
        links=tuple(str(contact.get("link")) for contact in contacts),
        epsilon=checks.number(entry, "epsilon", place, least=0.0),
    )
