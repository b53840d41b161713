"""From a description file to a `Hand`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from medkit.errors import InputError
from medkit.robots.assemble import assemble, mirror_hand
from medkit.robots.fields import Fields, read_fields, suggestion
from medkit.robots.hand import Hand
from medkit.robots.parts import Coupling, Parts, links_from_table, mirrored
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
        if document.has("mirror_of"):
            raise InputError(
                f"Expected 'mirror_of' to name a hand that is described in full, but {path.name}"
                " is a mirror image itself; name its original."
            )
    parts = _couple(_read_parts(document, path.parent, package_dirs), document)
    hand = assemble(document, _limit(parts, document))
    hand = replace(hand, name=name, source=source)
    if flip:
        hand = mirror_hand(hand, mirrored(_limit(parts, document), rename), rename)
    from medkit.robots.self_collision import self_collision_pairs

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
            narrow, given = section.pair(joint.name) * scale, joint.limits
            if narrow[0] < given[0] - 1e-9 or narrow[1] > given[1] + 1e-9:
                raise InputError(
                    f"Expected limits of joint {joint.name!r} in {section.place} within those of"
                    f" the URDF or table, {(given / scale).round(6).tolist()}, but got"
                    f" {(narrow / scale).round(6).tolist()}; narrow them, or correct the URDF."
                )
            joint = replace(joint, limits=narrow)
        if joint is not None and not joint.limits[0] < joint.limits[1]:
            raise InputError(
                f"Expected the lower limit of joint {joint.name!r} in {document.place} below the"
                f" upper one, but got {joint.limits.tolist()}; correct them."
            )
        links.append(replace(link, joint=joint))
    return Parts(tuple(links), parts.couplings)
