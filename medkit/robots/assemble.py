"""From parts and what a description says of the fingers to a `Hand`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.robots.fields import Fields, suggestion
from medkit.robots.hand import Finger, Hand, LinkBody, Opposition
from medkit.robots.parts import KINDS, Coupling, Parts, read_placement, renamed
from medkit.robots.shapes import convex_body
from medkit.robots.tree import KinematicTree


def assemble(document: Fields, parts: Parts) -> Hand:
    """Return the hand that a description makes of its parts, self-collision pairs left empty."""
    actuated = _joint_order(document, parts)
    tree = build_tree(parts, actuated)
    bodies = _bodies(parts)
    joints = parts.joints
    limits = np.array([joints[name].limits for name in actuated])
    fingers = tuple(
        _finger(fields, parts, actuated, tree, bodies) for fields in document.sections("fingers")
    )
    radii = document.section("sphere_radius").allow("min", "max")
    preshapes = _preshapes(document, parts, actuated, limits)
    palm = document.unit_vector("palm_direction")
    power = read_placement(document.section("power_frame").allow("xyz", "rpy"))
    return Hand(
        name=document.text("name"),
        joint_names=actuated,
        limits=limits,
        tree=tree,
        link_names=tuple(parts.link_names),
        fingers=fingers,
        bodies=bodies,
        palm_direction=palm,
        closing_axis=document.unit_vector("closing_axis"),
        T_hand_power=on_the_palm(power, palm, tree.link_poses(preshapes["power"]), bodies),
        preshapes=preshapes,
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
        if name not in driven:
            _index(document.inside({}, "joint_order"), "joint", name, driven)
        if order.count(name) != 1:
            raise InputError(
                f"Expected every driven joint once in joint_order of {document.place}, but"
                f" {name!r} is listed {order.count(name)} times; list {', '.join(driven)}."
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
    if not bodies:
        raise InputError(
            "Expected at least one link with a body, but the hand has none; give its links"
            " collision or visual geometry, or a 'body'."
        )
    return tuple(bodies)


def on_the_palm(
    frame: Floats, palm_direction: Floats, poses: Floats, bodies: Sequence[LinkBody]
) -> Floats:
    """Draw a frame back along the palm direction until it lies on the hand.

    P13 (4.6.1) starts a power grasp with hand and object inside each other and draws the hand
    back to the first free pose, so the object ends at the palm. A frame described in front of
    the palm, at a grasp centre point say, would leave a thin object hanging in the air.

    Parameters
    ----------
    frame : ndarray, shape (4, 4)
        ``T_hand_power`` as described [m].
    palm_direction : ndarray, shape (3,)
        Unit vector in which the palm faces, hand base frame.
    poses : ndarray, shape (L, 4, 4)
        Poses of the links in the preshape [m].
    bodies : sequence of LinkBody
        Bodies of the links.

    Returns
    -------
    ndarray, shape (4, 4)
        The frame on the foremost body behind it; unchanged when there is none, or inside one.

    Examples
    --------
    >>> corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-0.2, 0.1)]
    >>> slab = LinkBody(0, *convex_body(corners))
    >>> frame = np.eye(4)
    >>> frame[2, 3] = 0.5
    >>> on_the_palm(frame, np.array([0, 0, 1.0]), np.eye(4)[None], [slab])[:3, 3].round(3).tolist()
    [0.0, 0.0, 0.1]
    """
    back = min(_way_back(frame[:3, 3], palm_direction, poses[b.link], b) for b in bodies)
    moved = frame.copy()
    if np.isfinite(back):
        moved[:3, 3] -= back * palm_direction
    return moved


def _way_back(point: Floats, direction: Floats, pose: Floats, body: LinkBody) -> float:
    """How far behind a point (3,) a body begins [m]; 0 for a point inside, infinite for none."""
    corners = body.vertices[body.faces] @ pose[:3, :3].T + pose[:3, 3]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    height = ((point - corners[:, 0]) * normals).sum(axis=1)
    slope = normals @ direction
    # after going back by w the point is inside where height <= w slope at every plane
    ahead, behind = slope > 0.0, slope < 0.0
    first = (height[ahead] / slope[ahead]).max(initial=0.0)
    last = (height[behind] / slope[behind]).min(initial=np.inf)
    beside = bool((height[slope == 0.0] > 0.0).any())
    return float("inf") if beside or first > last else float(first)


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
    tip_link = _index(fields, "link", fields.text("tip_link"), parts.link_names)
    _check_chain(fields, names, joints, tree, tip_link)
    moved = tuple(tree.links_moved_by(j) for j in joints)
    owners = np.array([body.link for body in bodies])
    tip_point = fields.vector("tip_point", fields.length)
    return Finger(
        name=fields.text("name"),
        joints=joints,
        closing=_closing(fields, len(joints)),
        moved_links=moved,
        moved_bodies=tuple(np.flatnonzero(np.isin(owners, links)) for links in moved),
        tip_link=tip_link,
        tip_point=tip_point,
        tip_normal=fields.unit_vector("tip_normal"),
        end_point=fields.vector("end_point", fields.length, default=tip_point),
    )


def _closing(fields: Fields, count: int) -> NDArray[np.int64]:
    signs = fields.get("closing") if fields.has("closing") else [1] * count
    if (
        not isinstance(signs, list)
        or len(signs) != count
        or any(isinstance(s, bool) or s not in (-1, 1) for s in signs)
    ):
        raise InputError(
            f"Expected one +1 or -1 per joint for 'closing' in {fields.place}, but got {signs!r};"
            f" give {count}, -1 where a falling value closes."
        )
    return np.array(signs, dtype=np.int64)


def _check_chain(
    fields: Fields, names: list[str], joints: NDArray[np.int64], tree: KinematicTree, tip_link: int
) -> None:
    """Refuse joints that do not move the tip, and an order other than from palm to tip."""
    driven = [int(tree.coordinate[link]) for link in reversed(tree.ancestors(tip_link))]
    for name, joint in zip(names, joints, strict=True):
        if joint not in driven:
            raise InputError(
                f"Expected every joint in {fields.place} to move its tip link"
                f" {fields.text('tip_link')!r}, but {name!r} does not; correct the joint or the"
                " link."
            )
    inwards_first = sorted(set(names), key=lambda name: driven.index(joints[names.index(name)]))
    if names != inwards_first:
        raise InputError(
            f"Expected the joints in {fields.place} once each and from palm to tip, but got"
            f" {names}; write {inwards_first}."
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
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"Expected finger names to differ in {document.place}, but got {name!r} twice;"
                " rename one."
            )
    thumb = _index(section, "finger", section.text("thumb"), names)
    others = tuple(_index(section, "finger", n, names) for n in section.names("fingers"))
    if len(set(others)) < len(others):
        raise InputError(
            f"Expected each finger once in {section.place}, but got {section.names('fingers')};"
            " leave out what is named twice."
        )
    if not others or thumb in others:
        raise InputError(
            f"Expected the thumb and at least one other finger in {section.place}, but got"
            f" {section.content['fingers']}; name who opposes the thumb."
        )
    return Opposition(thumb, others)


def mirror_hand(hand: Hand, parts: Parts, rename: dict[str, str]) -> Hand:
    """Return the mirror image of a hand whose parts were mirrored already."""
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
