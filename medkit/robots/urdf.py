"""Links and joints of a URDF file, as parts of a hand."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats, transform, unit
from medkit.meshes.loading import missing_reader
from medkit.robots.parts import Coupling, Joint, Link, Parts, rpy_matrix
from medkit.robots.shapes import cylinder_points, rounded_box, sphere_points

MOVING = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


def parts_from_urdf(
    path: Path, package_dirs: Sequence[Path] = (), base: str | None = None
) -> Parts:
    """Read kinematics, couplings and convex bodies of a URDF.

    Parameters
    ----------
    path : pathlib.Path
        The URDF file.
    package_dirs : sequence of pathlib.Path
        Folders in which ``package://name/...`` is looked up, as ``folder/name/...``.
    base : str, optional
        Link to take as the hand's base; the root when left out. What is not below it is dropped.

    Returns
    -------
    Parts
        Links from base to tips. Bodies come from the collision elements of a link, else from its
        visual ones; each becomes its convex hull.

    Raises
    ------
    InputError
        If the file is missing, is not a URDF, or names a mesh that cannot be found.
    """
    root = _read_xml(path)
    joints = root.findall("joint")
    _refuse_twins(root, joints, path)
    elements = {link.get("name", ""): link for link in root.findall("link")}
    children = {_end(joint, "child", elements, path): joint for joint in joints}
    roots = [name for name in elements if name not in children]
    if base is not None and base not in elements:
        raise InputError(
            f"Expected the base link to be one of {', '.join(elements)} of {path.name}, but got"
            f" {base!r}; name one of them."
        )
    if base is None and len(roots) != 1:
        raise InputError(f"Expected one root link in {path.name}, but found {roots}; name a base.")
    order = _below(base or roots[0], joints, len(elements), path)
    links = tuple(
        _link(elements[name], None if k == 0 else children[name], path, package_dirs)
        for k, name in enumerate(order)
    )
    names = {link.joint.name for link in links if link.joint}
    couplings = {
        joint.get("name", ""): _coupling(joint, path)
        for joint in joints
        if joint.find("mimic") is not None and joint.get("name") in names
    }
    return Parts(links, couplings)


def _read_xml(path: Path) -> ET.Element:
    try:
        root = ET.parse(path).getroot()
    except OSError as error:
        raise InputError(
            f"Expected a URDF at {path}, but reading failed ({error.strerror}); check the path."
        ) from error
    except ET.ParseError as error:
        raise InputError(f"Expected XML in {path}, but parsing failed: {error}.") from error
    if root.tag != "robot":
        raise InputError(
            f"Expected a URDF with a <robot> element in {path.name}, but got <{root.tag}>; a xacro"
            " file has to be expanded first."
        )
    return root


def _refuse_twins(root: ET.Element, joints: list[ET.Element], path: Path) -> None:
    """Refuse a file without links, names that come twice, and links with two parents."""
    if root.find("link") is None:
        raise InputError(f"Expected at least one link in {path.name}, but found none; add them.")
    for tag in ("link", "joint"):
        names = [element.get("name", "") for element in root.findall(tag)]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise InputError(
                f"Expected every {tag} of {path.name} to have a name of its own, but found"
                f" {twice[0]!r} twice; rename one."
            )
    ends = [joint.find("child") for joint in joints]
    below = [end.get("link", "") for end in ends if end is not None]
    twice = [name for name in below if below.count(name) > 1]
    if twice:
        raise InputError(
            f"Expected one parent for every link of {path.name}, but {twice[0]!r} is the child of"
            " several joints; a hand is a tree, cut the loop."
        )


def _end(joint: ET.Element, tag: str, links: dict[str, ET.Element], path: Path) -> str:
    element = joint.find(tag)
    name = "" if element is None else element.get("link", "")
    if name not in links:
        raise InputError(
            f"Expected the {tag} of joint {joint.get('name')!r} in {path.name} to be a link of the"
            f" file, but got {name!r}; correct the URDF."
        )
    return name


def _below(base: str, joints: list[ET.Element], count: int, path: Path) -> list[str]:
    """List the links from `base` outwards, parents first."""
    order = [base]
    for parent in order:
        for joint in joints:
            ends = [joint.find(tag) for tag in ("parent", "child")]
            if ends[0] is not None and ends[0].get("link") == parent and ends[1] is not None:
                order.append(str(ends[1].get("link")))
        if len(order) > count:
            raise InputError(f"Expected a tree of links in {path.name}, but found a loop; cut it.")
    return order


def _link(
    element: ET.Element, joint: ET.Element | None, path: Path, package_dirs: Sequence[Path]
) -> Link:
    shapes = element.findall("collision") or element.findall("visual")
    bodies = tuple(_body(shape, path, package_dirs) for shape in shapes)
    name = element.get("name", "")
    if joint is None:
        return Link(name, None, np.eye(4), None, bodies)
    parent = joint.find("parent")
    return Link(
        name,
        None if parent is None else parent.get("link"),
        _origin(joint, path),
        _joint(joint, path),
        bodies,
    )


def _joint(element: ET.Element, path: Path) -> Joint | None:
    kind = element.get("type", "")
    name = element.get("name", "")
    if kind == "fixed":
        return None
    if kind not in MOVING:
        raise InputError(
            f"Joint {name!r} in {path.name} is of type {kind!r}, which a hand cannot have here; use"
            " revolute, prismatic or fixed."
        )
    axis = element.find("axis")
    vector = np.array([1.0, 0.0, 0.0]) if axis is None else _numbers(axis, "xyz", "1 0 0", path)
    if not vector.any():
        raise InputError(
            f"Expected a direction as axis of joint {name!r} in {path.name}, but got zeros; correct"
            " the URDF."
        )
    limit = element.find("limit")
    bounds = np.array([-np.pi, np.pi])
    if kind != "continuous":
        if limit is None:
            raise InputError(f"Joint {name!r} in {path.name} has no <limit>; add one.")
        bounds = np.array([_number(limit, "lower", "0", path), _number(limit, "upper", "0", path)])
    return Joint(name, MOVING[kind], unit(vector), bounds)


def _coupling(joint: ET.Element, path: Path) -> Coupling:
    mimic = joint.find("mimic")
    assert mimic is not None
    return Coupling(
        mimic.get("joint", ""),
        _number(mimic, "multiplier", "1", path),
        _number(mimic, "offset", "0", path),
    )


def _origin(element: ET.Element, path: Path) -> Floats:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    turn = rpy_matrix(_numbers(origin, "rpy", "0 0 0", path))
    return transform(turn, _numbers(origin, "xyz", "0 0 0", path))


def _number(element: ET.Element, key: str, default: str, path: Path) -> float:
    return float(_numbers(element, key, default, path, 1)[0])


def _numbers(element: ET.Element, key: str, default: str, path: Path, count: int = 3) -> Floats:
    text = element.get(key, default)
    try:
        array = np.array([float(part) for part in text.split()])
    except ValueError:
        array = np.empty(0)
    if array.shape != (count,) or not np.all(np.isfinite(array)):
        wanted = "three numbers" if count == 3 else "a number"
        raise InputError(
            f"Expected {wanted} for {key!r} of <{element.tag}> in {path.name}, but got"
            f" {text!r}; correct the URDF."
        )
    return array


def _sizes(element: ET.Element, key: str, default: str, path: Path, count: int) -> Floats:
    sizes = _numbers(element, key, default, path, count)
    if (sizes <= 0.0).any():
        raise InputError(
            f"Expected numbers above zero for {key!r} of <{element.tag}> in {path.name}, but got"
            f" {element.get(key, default)!r}; correct the URDF."
        )
    return sizes


def _body(shape: ET.Element, path: Path, package_dirs: Sequence[Path]) -> Floats:
    geometry = shape.find("geometry")
    kinds = [] if geometry is None else list(geometry)
    if not kinds:
        raise InputError(f"A <{shape.tag}> in {path.name} has no geometry; add it or remove it.")
    element = kinds[0]
    pose = _origin(shape, path)
    points = _geometry_points(element, path, package_dirs)
    return points @ pose[:3, :3].T + pose[:3, 3]


def _geometry_points(element: ET.Element, path: Path, package_dirs: Sequence[Path]) -> Floats:
    if element.tag == "box":
        half = 0.5 * _sizes(element, "size", "", path, 3)
        return rounded_box(-half, half)
    if element.tag == "sphere":
        return sphere_points(np.zeros(3), float(_sizes(element, "radius", "0", path, 1)[0]))
    if element.tag == "cylinder":
        radius, length = (_sizes(element, key, "0", path, 1)[0] for key in ("radius", "length"))
        return cylinder_points(float(radius), float(length))
    if element.tag == "mesh":
        return _mesh_points(element, path, package_dirs)
    raise InputError(
        f"Unknown geometry <{element.tag}> in {path.name}; use box, cylinder, sphere or mesh."
    )


def _mesh_points(element: ET.Element, path: Path, package_dirs: Sequence[Path]) -> Floats:
    import trimesh

    name = element.get("filename", "")
    file = resolve(name, path.parent, package_dirs)
    try:
        mesh = trimesh.load_mesh(file)
    except ImportError as error:
        raise InputError(missing_reader(file)) from error
    except Exception as error:  # the loaders of the many formats raise whatever they like
        raise InputError(
            f"Expected a mesh in {name} of {path.name}, but reading failed: {error}."
        ) from error
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    if len(vertices) < 4:
        raise InputError(f"The mesh {name} of {path.name} holds no solid; replace it.")
    return vertices * _numbers(element, "scale", "1 1 1", path)


def resolve(name: str, folder: Path, package_dirs: Sequence[Path]) -> Path:
    """Find the file that a URDF names, directly or as ``package://``."""
    scheme, _, rest = name.rpartition("://")
    if scheme == "package":
        places = [*package_dirs, *map(Path, os.environ.get("ROS_PACKAGE_PATH", "").split(":"))]
        # some files write package:///name: an absolute path would forget the folder
        candidates = [place / rest.lstrip("/") for place in places if str(place) != "."]
    else:
        candidates = [folder / rest]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise InputError(
        f"Expected to find the mesh {name}, but looked at"
        f" {', '.join(map(str, candidates)) or 'no folder'}; name the folder that holds the package"
        " under package_dirs or with --package-dir."
    )
