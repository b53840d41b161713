"""Links and joints as a description names them, before they become a tree of arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from medkit.errors import InputError
from medkit.geometry import Floats, rotation_about, transform
from medkit.robots.fields import Fields, suggestion
from medkit.robots.shapes import rounded_box, sphere_points

KINDS = {"fixed": 0, "revolute": 1, "prismatic": 2}


@dataclass(frozen=True)
class Joint:
    """A moving joint: name, kind, unit axis (3,), limits (2,) [rad or m]."""

    name: str
    kind: str
    axis: Floats
    limits: Floats


@dataclass(frozen=True)
class Coupling:
    """The value of a joint is ``multiplier`` times that of joint `follows`, plus ``offset``."""

    follows: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Link:
    """A link: its parent (None for the base), placement (4, 4) [m], joint, bodies' points."""

    name: str
    parent: str | None
    placement: Floats
    joint: Joint | None = None
    bodies: tuple[Floats, ...] = ()


@dataclass(frozen=True)
class Parts:
    """Everything a hand is assembled from, apart from what its fingers are."""

    links: tuple[Link, ...]
    couplings: dict[str, Coupling] = field(default_factory=dict)

    @property
    def joints(self) -> dict[str, Joint]:
        """All moving joints by name."""
        return {link.joint.name: link.joint for link in self.links if link.joint}

    @property
    def link_names(self) -> list[str]:
        """All links, parents first."""
        return [link.name for link in self.links]


def rpy_matrix(angles: Floats) -> Floats:
    """Rotation about fixed x, y and z by three `angles` (3,) [rad], URDF's convention."""
    x, y, z = np.eye(3)
    return (
        rotation_about(z, angles[2]) @ rotation_about(y, angles[1]) @ rotation_about(x, angles[0])
    )


def read_placement(fields: Fields) -> Floats:
    """Transform (4, 4) from the keys ``xyz`` and ``rpy``, each zero when left out."""
    position = fields.vector("xyz", fields.length, default=[0, 0, 0])
    return transform(rpy_matrix(fields.vector("rpy", fields.angle, default=[0, 0, 0])), position)


def links_from_table(document: Fields) -> tuple[Link, ...]:
    """Read the links of an inline table, the base first."""
    base = Link(document.text("base", "base"), None, np.eye(4))
    links = [base]
    for fields in document.sections("links"):
        fields.allow("name", "parent", "xyz", "rpy", "joint", "body")
        name = fields.text("name")
        known = [link.name for link in links]
        parent = fields.text("parent", base.name)
        if name in known:
            raise InputError(f"The link {name!r} appears twice in {fields.place}; rename one.")
        if parent not in known:
            raise InputError(
                f"Expected the parent of link {name!r} in {fields.place} to be a link above it,"
                f" but got {parent!r}; {suggestion(parent, known)}"
            )
        joint = read_joint(fields.section("joint")) if fields.has("joint") else None
        bodies = (
            tuple(read_shape(part) for part in fields.sections("body"))
            if fields.has("body")
            else ()
        )
        links.append(Link(name, parent, read_placement(fields), joint, bodies))
    return tuple(links)


def read_joint(fields: Fields) -> Joint:
    """Read name, type, axis and limits of a joint."""
    fields.allow("name", "type", "axis", "limits")
    kind = fields.text("type", "revolute")
    if kind not in ("revolute", "prismatic"):
        raise InputError(
            f"Unknown joint type {kind!r} in {fields.place}; write revolute or prismatic."
        )
    scale = fields.angle if kind == "revolute" else fields.length
    return Joint(
        fields.text("name"), kind, fields.unit_vector("axis"), fields.pair("limits") * scale
    )


def read_shape(fields: Fields) -> Floats:
    """Points whose hull is a body: a ``box``, ``spheres``, ``points``, or a ``hull`` of these."""
    fields.allow("box", "round", "spheres", "points", "hull")
    scale = fields.length
    if fields.has("hull"):
        return np.vstack([read_shape(part) for part in fields.sections("hull")])
    if fields.has("box"):
        low, high = _rows(fields, "box", 3)
        if not np.all(low < high):
            raise InputError(
                f"Expected box: [[smallest x, y, z], [largest x, y, z]] in {fields.place}, but"
                f" got {low.tolist()} and {high.tolist()}; order the corners."
            )
        rounding = fields.vector("round", default=[0, 0, 0])
        return rounded_box(low * scale, high * scale, rounding * scale)
    if fields.has("spheres"):
        balls = _rows(fields, "spheres", 4)
        return np.vstack([sphere_points(ball[:3] * scale, ball[3] * scale) for ball in balls])
    return _rows(fields, "points", 3) * scale


def _rows(fields: Fields, key: str, columns: int) -> Floats:
    try:
        array = np.asarray(fields.get(key), dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != columns or not np.all(np.isfinite(array)):
        raise InputError(
            f"Expected rows of {columns} numbers for {key!r} in {fields.place}, but got"
            f" {fields.get(key)!r}."
        )
    if key == "box" and len(array) != 2:
        raise InputError(f"Expected two corners for 'box' in {fields.place}; got {len(array)}.")
    return array


def mirrored(parts: Parts, rename: dict[str, str]) -> Parts:
    """Mirror image in the plane y = 0, with names in which `rename` was replaced."""
    flip = np.diag([1.0, -1.0, 1.0])
    flip4 = np.diag([1.0, -1.0, 1.0, 1.0])
    links = []
    for link in parts.links:
        joint = link.joint
        if joint is not None:
            # an axis of rotation is an axial vector: a mirror also turns its sense round
            sign = -1.0 if joint.kind == "revolute" else 1.0
            axis = sign * flip @ joint.axis + 0.0
            joint = replace(joint, name=renamed(joint.name, rename), axis=axis)
        links.append(
            Link(
                renamed(link.name, rename),
                None if link.parent is None else renamed(link.parent, rename),
                flip4 @ link.placement @ flip4,
                joint,
                tuple(points @ flip for points in link.bodies),
            )
        )
    couplings = {
        renamed(name, rename): replace(rule, follows=renamed(rule.follows, rename))
        for name, rule in parts.couplings.items()
    }
    return Parts(tuple(links), couplings)


def renamed(name: str, rename: dict[str, str]) -> str:
    """Return `name` with every key of `rename` replaced by its value."""
    for old, new in rename.items():
        name = name.replace(old, new)
    return name
