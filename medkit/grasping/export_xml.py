"""Grasps as XML in the layout of Simox's grasp sets, written and read."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from medkit.arguments import file_path
from medkit.errors import InputError
from medkit.files import whole_file
from medkit.geometry import Floats, inverse
from medkit.grasping.file_checks import is_rigid

MILLIMETRES = 1000.0  # [mm / m], the unit of translations in the file
#: Radians, or metres, per unit of a joint's value.
UNITS = {"radian": 1.0, "degree": float(np.pi / 180.0), "mm": 1.0 / MILLIMETRES, "m": 1.0}


def write_grasps_xml(
    path: str | os.PathLike[str],
    document: Mapping[str, Any],
    *,
    outcomes: Collection[str] | None = ("force_closure",),
    T_hand_tcp: Floats | None = None,
    preshape: str = "",
    prismatic: Collection[str] = (),
) -> int:
    """Write the grasps of a ``medkit.grasps/1`` document, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write.
    document : mapping
        Content of a grasp file.
    outcomes : collection of str or None
        Outcomes to write; None for all. What reads such a file takes every grasp in it as good.
    T_hand_tcp : ndarray, shape (4, 4), optional
        Tool frame of the reader's hand model in the hand base frame [m]; the base itself when
        left out.
    preshape : str
        Name of the preshape in the reader's hand model, if it has one.
    prismatic : collection of str
        Joints whose values are lengths (``hand.prismatic_joints``); written in millimetres.

    Returns
    -------
    int
        Number of grasps written.

    Raises
    ------
    InputError
        If the document has another schema, or the file cannot be written.

    Notes
    -----
    As in Simox, the transform is the object's pose in the tool frame, in millimetres, and joints
    are in radians or millimetres. The pre-grasp is an element of its own, which Simox does not
    know.

    Examples
    --------
    See `read_grasps_xml`.
    """
    if document.get("schema") != "medkit.grasps/1":
        raise InputError(
            f"Expected a document of schema 'medkit.grasps/1', but got {document.get('schema')!r};"
            " pass the content of a grasp file."
        )
    tool = np.eye(4) if T_hand_tcp is None else np.asarray(T_hand_tcp, dtype=float)
    chosen = [
        (k, grasp)
        for k, grasp in enumerate(document.get("grasps", []))
        if outcomes is None or grasp.get("outcome") in outcomes
    ]
    root = ET.Element("ManipulationObject", name=_object_name(document))
    hand = str(document.get("hand", ""))
    group = ET.SubElement(root, "GraspSet", name=f"medkit {hand}", RobotType=hand, EndEffector=hand)
    creation = f"medkit {document.get('planner', '')} {document.get('grasp', '')}".strip()
    for number, grasp in chosen:
        _add_grasp(group, number, grasp, creation, preshape, tool, prismatic)
    ET.indent(root)
    with whole_file(path) as draft:
        ET.ElementTree(root).write(draft, encoding="utf-8", xml_declaration=True)
    return len(chosen)


def _object_name(document: Mapping[str, Any]) -> str:
    return Path(str(document.get("object", {}).get("path", "object"))).stem


def _add_grasp(
    group: ET.Element,
    number: int,
    grasp: Mapping[str, Any],
    creation: str,
    preshape: str,
    tool: Floats,
    prismatic: Collection[str],
) -> None:
    epsilon = grasp.get("epsilon")
    element = ET.SubElement(
        group,
        "Grasp",
        name=f"Grasp {number}",
        quality=repr(0.0 if epsilon is None else float(epsilon)),
        Creation=creation,
        outcome=str(grasp.get("outcome", "")),
    )
    if preshape:
        element.set("Preshape", preshape)
    _add_transform(element, grasp["pose"], tool)
    if grasp.get("pregrasp") is not None:
        _add_transform(ET.SubElement(element, "PreGrasp"), grasp["pregrasp"], tool)
    joints = ET.SubElement(element, "Configuration", name=f"Grasp {number}")
    for name, value in grasp["joints"].items():
        unit = "mm" if name in prismatic else "radian"
        number_text = repr(float(value) / UNITS[unit])
        ET.SubElement(joints, "Node", name=str(name), unit=unit, value=number_text)


def _add_transform(parent: ET.Element, T_object_hand: Any, tool: Floats) -> None:
    pose = inverse(np.asarray(T_object_hand, dtype=float) @ tool)
    pose[:3, 3] *= MILLIMETRES
    matrix = ET.SubElement(ET.SubElement(parent, "Transform"), "Matrix4x4")
    for row, values in enumerate(pose.tolist(), start=1):
        cells = {f"c{column}": repr(value) for column, value in enumerate(values, start=1)}
        ET.SubElement(matrix, f"row{row}", cells)


def read_grasps_xml(
    path: str | os.PathLike[str], *, T_hand_tcp: Floats | None = None
) -> dict[str, Any]:
    """Read a grasp set that was written by `write_grasps_xml`, or by Simox.

    Parameters
    ----------
    path : path-like
        The file.
    T_hand_tcp : ndarray, shape (4, 4), optional
        Tool frame in which the transforms are given, in the hand base frame [m]; the base itself
        when left out.

    Returns
    -------
    dict
        ``hand``, ``object`` and ``grasps`` as in a ``medkit.grasps/1`` document, without
        contacts, which the file does not hold. A grasp without an outcome is ``"not_tested"``.

    Raises
    ------
    InputError
        If the file cannot be read or holds no grasp set, or a number, transform, joint or unit in
        it cannot be understood.

    Examples
    --------
    >>> import tempfile
    >>> grasp = {"outcome": "force_closure", "epsilon": 0.1, "pose": np.eye(4).tolist(),
    ...          "joints": {"knuckle": 0.5}}
    >>> document = {"schema": "medkit.grasps/1", "hand": "two", "grasps": [grasp]}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = write_grasps_xml(f"{folder}/grasps.xml", document)
    ...     found = read_grasps_xml(f"{folder}/grasps.xml")
    >>> written, found["hand"], found["grasps"][0]["joints"]
    (1, 'two', {'knuckle': 0.5})
    """
    path = file_path(path, "a grasp set")
    root = _read_root(path)
    group = root if root.tag == "GraspSet" else root.find(".//GraspSet")
    if group is None:
        raise InputError(f"Expected a <GraspSet> in {path.name}, but found none; pass a grasp set.")
    tool = np.eye(4) if T_hand_tcp is None else np.asarray(T_hand_tcp, dtype=float)
    return {
        "schema": "medkit.grasps/1",
        "object": {"path": root.get("name", "")},
        "hand": group.get("EndEffector", ""),
        "grasps": [_read_grasp(element, tool, path) for element in group.iter("Grasp")],
    }


def _read_root(path: Path) -> ET.Element:
    try:
        return ET.parse(path).getroot()
    except OSError as error:
        raise InputError(
            f"Expected a grasp set at {path}, but reading failed ({error.strerror}); check the"
            " path."
        ) from error
    except ET.ParseError as error:
        raise InputError(f"Expected XML in {path.name}, but parsing failed: {error}.") from error


def _read_grasp(element: ET.Element, tool: Floats, path: Any) -> dict[str, Any]:
    before = element.find("PreGrasp")
    return {
        "name": element.get("name", ""),
        "outcome": element.get("outcome", "not_tested"),
        "epsilon": _number(element, "quality", path),
        "pose": _read_transform(element, tool, path),
        "pregrasp": None if before is None else _read_transform(before, tool, path),
        "joints": {
            _named(node, path): _number(node, "value", path) * _unit(node, path)
            for node in element.iter("Node")
        },
        "contacts": [],
    }


def _named(node: ET.Element, path: Any) -> str:
    name = node.get("name")
    if not name:
        raise InputError(
            f"Expected every <Node> in {Path(path).name} to name its joint, but one does not;"
            " repair the file."
        )
    return name


def _unit(node: ET.Element, path: Any) -> float:
    unit = node.get("unit", "radian")
    if unit not in UNITS:
        raise InputError(
            f"Expected the unit of {node.get('name')!r} in {Path(path).name} to be one of"
            f" {', '.join(UNITS)}, but got {unit!r}; convert the value."
        )
    return UNITS[unit]


def _number(element: ET.Element, key: str, path: Any) -> float:
    text = element.get(key, "0")
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InputError(
            f"Expected a number as {key!r} of {element.get('name', element.tag)!r} in"
            f" {Path(path).name}, but got {text!r}; repair the file."
        )
    return value


def _read_transform(parent: ET.Element, tool: Floats, path: Any) -> list[list[float]]:
    matrix = parent.find("Transform/Matrix4x4")
    try:
        if matrix is None:
            raise ValueError("no Matrix4x4")
        rows = [matrix.find(f"row{k}") for k in range(1, 5)]
        pose = np.array(
            [[float(row.get(f"c{c}", "x")) for c in range(1, 5)] for row in rows if row is not None]
        )
        if pose.shape != (4, 4):
            raise ValueError("rows are missing")
        if not np.isfinite(pose).all():
            raise ValueError("a number is not finite")
        if not is_rigid(pose):
            raise ValueError("it is no rotation and translation")
    except ValueError as error:
        raise InputError(
            f"Expected a 4 x 4 transform in {parent.get('name', parent.tag)!r} of"
            f" {Path(path).name}, but could not read it ({error}); repair the file."
        ) from error
    pose[:3, 3] /= MILLIMETRES
    return (inverse(pose) @ inverse(tool)).tolist()
