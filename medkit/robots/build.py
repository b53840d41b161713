"""From a description file to a `Hand`: the only place that assembles one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.robots.fields import Fields, read_fields, suggestion
from medkit.robots.hand import Finger, Hand, LinkBody, Opposition
from medkit.robots.parts import (
    KINDS,
    Coupling,
    Parts,
    links_from_table,
    mirrored,
    read_placement,
    renamed,
)
from medkit.robots.shapes import convex_body
from medkit.robots.tree import KinematicTree
from medkit.robots.urdf import parts_from_urdf

KEYS = (
    "schema", "name", "source", "units", "urdf", "package_dirs", "package", "base", "links",
    "mirror_of", "rename", "palm_direction", "closing_axis", "power_frame", "sphere_radius",
    "joint_order", "fingers", "opposition", "couplings", "limits", "preshapes",
)  # fmt: skip
SCHEMA = "medkit.hand/1"


def hand_from_file(path: Path, package_dirs: Sequence[Path] = ()) -> Hand:
    """Build a hand from its description.

    Parameters
    ----------
    path : pathlib.Path
        A YAML file as docs/adding_a_hand.md describes it.
    package_dirs : sequence of pathlib.Path
        Folders in which ``package://`` of a URDF is looked up, besides those the file names.

    Returns
    -------
    Hand
        The hand.

    Raises
    ------
    InputError
        If anything in the file cannot be used; the message names the key.
    """
    document = read_fields(path).allow(*KEYS)
    if document.text("schema") != SCHEMA:
        raise InputError(
            f"Expected schema {SCHEMA!r} in {path.name}, but got {document.text('schema')!r}."
        )
    flip = document.has("mirror_of")
    if flip:
        document.allow("schema", "name", "source", "mirror_of", "rename")
    rename: dict[str, str] = {}
    name, source = document.text("name"), document.text("source", "not stated")
    if flip:
        rename = {k: str(v) for k, v in document.section("rename").content.items()}
        path = path.parent / document.text("mirror_of")
        document = read_fields(path).allow(*KEYS)
    parts = _couple(_read_parts(document, path.parent, package_dirs), document)
    hand = _assemble(document, _limit(parts, document))
    hand = replace(hand, name=name, source=source)
    if flip:
        hand = _mirror_hand(hand, mirrored(_limit(parts, document), rename), rename)
    from medkit.robots.collision import self_collision_pairs

    return replace(hand, self_collision_pairs=self_collision_pairs(hand))


def _read_parts(document: Fields, folder: Path, package_dirs: Sequence[Path]) -> Parts:
    if document.has("links") == document.has("urdf"):
        raise InputError(
            f"Expected either 'urdf' or 'links' in {document.place}; give exactly one of them."
        )
    if document.has("links"):
        return Parts(links_from_table(document))
    root = _distribution_folder(document) if document.has("package") else folder
    names = document.names("package_dirs") if document.has("package_dirs") else []
    base = document.text("base") if document.has("base") else None
    dirs = [*package_dirs, *(root / name for name in names), root]
    return parts_from_urdf(root / document.text("urdf"), dirs, base)


def _distribution_folder(document: Fields) -> Path:
    """Folder into which the PyPI package that the description names was installed."""
    from importlib.metadata import PackageNotFoundError, distribution

    name = document.text("package")
    try:
        return Path(str(distribution(name).locate_file("")))
    except PackageNotFoundError as error:
        raise InputError(
            f"Expected the PyPI package {name!r} of {document.place} to be installed, but it is"
            f" not; run pip install {name}."
        ) from error


def _couple(parts: Parts, document: Fields) -> Parts:
    """Add the couplings of the description to those of the URDF, and check all."""
    couplings = dict(parts.couplings)
    section = document.section("couplings")
    for name in section.content:
        fields = section.section(name).allow("follows", "multiplier", "offset")
        couplings[name] = Coupling(
            fields.text("follows"),
            fields.number("multiplier", 1.0),
            fields.number("offset", 0.0, fields.angle),
        )
    for name, rule in couplings.items():
        for joint in (name, rule.follows):
            if joint not in parts.joints:
                raise InputError(
                    f"Unknown joint {joint!r} in the couplings of {document.place};"
                    f" {suggestion(joint, parts.joints)}"
                )
        if rule.follows in couplings:
            raise InputError(
                f"Joint {name!r} follows {rule.follows!r}, which follows another joint itself, in"
                f" {document.place}; let both follow the driven one."
            )
    return Parts(parts.links, couplings)


def _limit(parts: Parts, document: Fields) -> Parts:
    """Replace joint limits that the description narrows, and check all."""
    section = document.section("limits").allow(*parts.joints)
    links = []
    for link in parts.links:
        joint = link.joint
        if joint is not None and section.has(joint.name):
            scale = section.angle if joint.kind == "revolute" else section.length
            joint = replace(joint, limits=section.pair(joint.name) * scale)
        if joint is not None and not joint.limits[0] < joint.limits[1]:
            raise InputError(
                f"Expected the lower limit of joint {joint.name!r} in {document.place} below the"
                f" upper one, but got {joint.limits.tolist()}; correct them."
            )
        links.append(replace(link, joint=joint))
    return Parts(tuple(links), parts.couplings)


def _assemble(document: Fields, parts: Parts) -> Hand:
    actuated = _joint_order(document, parts)
    tree = build_tree(parts, actuated)
    bodies = _bodies(parts)
    joints = parts.joints
    limits = np.array([joints[name].limits for name in actuated])
    fingers = tuple(
        _finger(fields, parts, actuated, tree, bodies) for fields in document.sections("fingers")
    )
    radii = document.section("sphere_radius").allow("min", "max")
    return Hand(
        name=document.text("name"),
        joint_names=actuated,
        limits=limits,
        tree=tree,
        link_names=tuple(parts.link_names),
        fingers=fingers,
        bodies=bodies,
        palm_direction=document.unit_vector("palm_direction"),
        closing_axis=document.unit_vector("closing_axis"),
        T_hand_power=read_placement(document.section("power_frame").allow("xyz", "rpy")),
        preshapes=_preshapes(document, parts, actuated, limits),
        opposition=_opposition(document, fingers),
        sphere_radii=(
            radii.number("min", scale=radii.length),
            radii.number("max", scale=radii.length),
        ),
        self_collision_pairs=np.empty((0, 2), dtype=np.int64),
        source=document.text("source", "not stated"),
    )


def _joint_order(document: Fields, parts: Parts) -> tuple[str, ...]:
    driven = [name for name in parts.joints if name not in parts.couplings]
    if not document.has("joint_order"):
        return tuple(driven)
    order = document.names("joint_order")
    for name in [*order, *driven]:
        if name not in driven or order.count(name) != 1:
            raise InputError(
                f"Expected every driven joint once in joint_order of {document.place}, but"
                f" {name!r} is not; {suggestion(name, driven)}"
            )
    return tuple(order)


def build_tree(parts: Parts, actuated: Sequence[str]) -> KinematicTree:
    """Return the struct of arrays for `parts`, with the joints `actuated` as coordinates."""
    count = len(parts.links)
    names = parts.link_names
    tree = {
        "parent": np.array(
            [-1 if k.parent is None else names.index(k.parent) for k in parts.links], dtype=np.int64
        ),
        "placement": np.ascontiguousarray([link.placement for link in parts.links]),
        "axis": np.zeros((count, 3)),
        "kind": np.zeros(count, dtype=np.int64),
        "coordinate": np.full(count, -1, dtype=np.int64),
        "multiplier": np.ones(count),
        "offset": np.zeros(count),
    }
    for k, link in enumerate(parts.links):
        if link.joint is None:
            continue
        rule = parts.couplings.get(link.joint.name, Coupling(link.joint.name, 1.0, 0.0))
        tree["axis"][k] = link.joint.axis
        tree["kind"][k] = KINDS[link.joint.kind]
        tree["coordinate"][k] = list(actuated).index(rule.follows)
        tree["multiplier"][k], tree["offset"][k] = rule.multiplier, rule.offset
    return KinematicTree(**tree)


def _bodies(parts: Parts) -> tuple[LinkBody, ...]:
    bodies = []
    for k, link in enumerate(parts.links):
        try:
            bodies += [LinkBody(k, *convex_body(points)) for points in link.bodies]
        except InputError as error:
            raise InputError(f"The body of link {link.name!r} cannot be used: {error}") from error
    return tuple(bodies)


def _finger(
    fields: Fields,
    parts: Parts,
    actuated: Sequence[str],
    tree: KinematicTree,
    bodies: Sequence[LinkBody],
) -> Finger:
    fields.allow("name", "joints", "closing", "tip_link", "tip_point", "tip_normal", "end_point")
    names = fields.names("joints")
    if not names:
        raise InputError(f"Expected at least one joint for {fields.place}, but got none; name it.")
    joints = np.array([_index(fields, "joint", name, actuated) for name in names])
    closing = np.ones(len(joints), dtype=np.int64)
    if fields.has("closing"):
        closing = np.asarray(fields.get("closing"))
    if closing.shape != joints.shape or not np.all(np.isin(closing, (-1, 1))):
        raise InputError(
            f"Expected one +1 or -1 per joint for 'closing' in {fields.place}, but got"
            f" {fields.get('closing')!r}."
        )
    tip_link = _index(fields, "link", fields.text("tip_link"), parts.link_names)
    moved = tuple(tree.links_moved_by(j) for j in joints)
    owners = np.array([body.link for body in bodies])
    tip_point = fields.vector("tip_point", fields.length)
    return Finger(
        name=fields.text("name"),
        joints=joints,
        closing=closing.astype(np.int64),
        moved_links=moved,
        moved_bodies=tuple(np.flatnonzero(np.isin(owners, links)) for links in moved),
        tip_link=tip_link,
        tip_point=tip_point,
        tip_normal=fields.unit_vector("tip_normal"),
        end_point=fields.vector("end_point", fields.length, default=tip_point),
    )


def _index(fields: Fields, what: str, name: str, known: Sequence[str]) -> int:
    if name not in known:
        raise InputError(f"Unknown {what} {name!r} in {fields.place}; {suggestion(name, known)}")
    return list(known).index(name)


def _preshapes(
    document: Fields, parts: Parts, actuated: tuple[str, ...], limits: Floats
) -> dict[str, Floats]:
    section = document.section("preshapes").allow("power", "precision")
    joints = parts.joints
    preshapes = {}
    for key in ("power", "precision"):
        values = section.section(key)
        q = np.clip(0.0, limits[:, 0], limits[:, 1])
        for name in values.content:
            k = _index(values, "joint", name, actuated)
            scale = values.angle if joints[name].kind == "revolute" else values.length
            q[k] = values.number(name, scale=scale)
            if not limits[k, 0] - 1e-9 <= q[k] <= limits[k, 1] + 1e-9:
                raise InputError(
                    f"Expected joint {name!r} within its limits {(limits[k] / scale).tolist()} in"
                    f" {values.place}, but got {q[k] / scale:g}; change one of them."
                )
        preshapes[key] = q
    return preshapes


def _opposition(document: Fields, fingers: Sequence[Finger]) -> Opposition:
    section = document.section("opposition").allow("thumb", "fingers")
    names = [finger.name for finger in fingers]
    thumb = _index(section, "finger", section.text("thumb"), names)
    others = tuple(_index(section, "finger", n, names) for n in section.names("fingers"))
    if not others or thumb in others:
        raise InputError(
            f"Expected the thumb and at least one other finger in {section.place}, but got"
            f" {section.content['fingers']}; name who opposes the thumb."
        )
    return Opposition(thumb, others)


def _mirror_hand(hand: Hand, parts: Parts, rename: dict[str, str]) -> Hand:
    flip = np.array([1.0, -1.0, 1.0])
    flip4 = np.diag([1.0, -1.0, 1.0, 1.0])
    names = tuple(renamed(name, rename) for name in hand.joint_names)
    return replace(
        hand,
        joint_names=names,
        tree=build_tree(parts, names),
        link_names=tuple(parts.link_names),
        bodies=_bodies(parts),
        palm_direction=hand.palm_direction * flip,
        closing_axis=hand.closing_axis * flip + 0.0,
        T_hand_power=flip4 @ hand.T_hand_power @ flip4,
        fingers=tuple(
            replace(
                f,
                tip_point=f.tip_point * flip,
                tip_normal=f.tip_normal * flip,
                end_point=f.end_point * flip,
            )
            for f in hand.fingers
        ),
    )
