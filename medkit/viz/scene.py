"""One page that shows an object, a hand and its grasps in 3-D, and needs no other file."""

from __future__ import annotations

import base64
import html
import json
import os
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

from medkit.errors import InputError
from medkit.files import write_text
from medkit.geometry import Floats
from medkit.robots import Hand
from medkit.viz.hands import PALM_COLOUR, finger_colours
from medkit.viz.style import BLACK, BLUE, OBJECT_GREY, ORANGE, PURPLE, YELLOW

if TYPE_CHECKING:
    import trimesh

#: More triangles than this are merged for the page only, so that it stays small.
MOST_FACES = 40_000
MOST_GRASPS = 300
SCRIPTS = ("scene.js", "scene_wrench.js")


def write_scene_html(
    path: str | os.PathLike[str],
    *,
    title: str,
    object_mesh: trimesh.Trimesh,
    hand: Hand,
    grasps: Sequence[Mapping[str, Any]],
    subtitle: str = "",
    friction: float = 0.5,
    preshape: str = "power",
) -> None:
    """Write the page of `scene_html` to `path`, whole or not at all."""
    page = scene_html(
        object_mesh,
        hand,
        grasps,
        title=title,
        subtitle=subtitle,
        friction=friction,
        preshape=preshape,
    )
    write_text(path, page)


def scene_html(
    object_mesh: trimesh.Trimesh,
    hand: Hand,
    grasps: Sequence[Mapping[str, Any]],
    *,
    title: str,
    subtitle: str = "",
    friction: float = 0.5,
    preshape: str = "power",
    most: int = MOST_GRASPS,
) -> str:
    """Return a self-contained HTML page: object, hand in its grasps, contacts, to be turned.

    Parameters
    ----------
    object_mesh : trimesh.Trimesh
        The object, in the frame in which the grasps are given [m].
    hand : Hand
        The hand that grasps.
    grasps : sequence of mapping
        Entries of ``"grasps"`` in a ``medkit.grasps/1`` file; the best by epsilon come first.
    title, subtitle : str
        Heading of the page, and a line below it.
    friction : float
        Friction coefficient, for the opening of the friction cones [1].
    preshape : str
        Preshape in which the hand is shown at the pre-grasp.
    most : int
        Largest number of grasps on the page.

    Returns
    -------
    str
        The page. It asks for no script, style or font from elsewhere.

    Raises
    ------
    InputError
        If a grasp lacks its pose or joints, or names a joint that the hand does not have.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> box = trimesh.creation.box((0.1, 0.1, 0.1))
    >>> page = scene_html(box, load_hand("wsg50"), [], title="Box")
    >>> page.startswith("<!DOCTYPE html>"), "http" in page
    (True, False)
    """
    ranked = sorted(enumerate(grasps), key=lambda item: (-_epsilon(item[1]), item[0]))[:most]
    entries = [_grasp_entry(hand, number, grasp, preshape) for number, grasp in ranked]
    data = _scene_data(object_mesh, hand, preshape) | {"grasps": entries, "friction": friction}
    if not subtitle:
        subtitle = f"{hand.name} hand, {len(entries)} of {len(grasps)} tested candidates"
    return _page(title, subtitle, data, object_mesh, hand)


def _epsilon(grasp: Mapping[str, Any]) -> float:
    value = grasp.get("epsilon")
    closed = grasp.get("outcome") == "force_closure"
    return (-1.0 if value is None else float(value)) + (1000.0 if closed else 0.0)


def _base64(array: Any, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")


def _columns(poses: Floats) -> Floats:
    """Column-major matrices, as WebGL takes them."""
    return np.swapaxes(poses, -1, -2)


def _mesh_entry(vertices: Any, faces: Any, colour: str) -> dict[str, Any]:
    return {"points": _base64(vertices, "<f4"), "faces": _base64(faces, "<u4"), "colour": colour}


def _scene_data(object_mesh: trimesh.Trimesh, hand: Hand, preshape: str) -> dict[str, Any]:
    vertices, faces = _light_mesh(object_mesh)
    colours = finger_colours(hand)
    poses = hand.link_poses(hand.preshapes[preshape])
    low, high = object_mesh.bounds
    hand_points = np.vstack([body.vertices + poses[body.link, :3, 3] for body in hand.bodies])
    reach = float(np.ptp(hand_points, axis=0).max())
    span = max(float(np.linalg.norm(high - low)), reach)
    return {
        "object": _mesh_entry(vertices, faces, OBJECT_GREY),
        "links": [
            _mesh_entry(b.vertices, b.faces, colours.get(hand.link_names[b.link], PALM_COLOUR))
            for b in hand.bodies
        ],
        "preshape": _base64(_columns(poses[[b.link for b in hand.bodies]]), "<f4"),
        "centre": (0.5 * (low + high)).round(6).tolist(),
        "size": round(span, 6),
        "mark": round(0.02 * reach, 6),
        "mass": np.round(object_mesh.center_mass, 9).tolist(),
        "reach": round(_reach(object_mesh), 9),
        "colours": {
            "contact": PURPLE,
            "normal": BLACK,
            "cone": YELLOW,
            "hull": BLUE,
            "ball": ORANGE,
        },
    }


def _reach(mesh: trimesh.Trimesh) -> float:
    """Largest distance from the centre of mass [m], by which torques are divided."""
    return float(np.linalg.norm(mesh.vertices - mesh.center_mass, axis=1).max())


def _grasp_entry(
    hand: Hand, number: int, grasp: Mapping[str, Any], preshape: str
) -> dict[str, Any]:
    for key in ("pose", "joints"):
        if key not in grasp:
            raise InputError(
                f"Expected {key!r} in grasp {number}, but it is missing; pass the entries of a"
                " medkit.grasps/1 file."
            )
    T_object_hand = _matrix(grasp["pose"], "pose", number)
    poses = T_object_hand @ hand.link_poses(hand.coordinates(grasp["joints"], preshape))
    before = grasp.get("pregrasp")
    pregrasp = None if before is None else _matrix(before, "pregrasp", number)
    epsilon, radius = grasp.get("epsilon"), grasp.get("sphere_radius")
    return {
        "number": number,
        "outcome": str(grasp.get("outcome", "not tested")),
        "epsilon": None if epsilon is None else round(float(epsilon), 6),
        "radius": None if radius is None else round(float(radius), 6),
        "poses": _base64(_columns(poses[[b.link for b in hand.bodies]]), "<f4"),
        "pregrasp": None if pregrasp is None else pregrasp.T.ravel().round(6).tolist(),
        "contacts": [
            {
                "point": [round(float(v), 6) for v in contact["point"]],
                "normal": [round(float(v), 6) for v in contact["normal"]],
                "link": str(contact.get("link", "")),
            }
            for contact in grasp.get("contacts") or ()
        ],
    }


def _matrix(value: Any, name: str, number: int) -> Floats:
    pose = np.asarray(value, dtype=float)
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise InputError(
            f"Expected {name!r} of grasp {number} as a 4 x 4 matrix, but got shape {pose.shape}."
        )
    return pose


def _light_mesh(mesh: trimesh.Trimesh) -> tuple[Any, Any]:
    """Vertices and faces for the page; a very fine mesh is merged on coarser lattices."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    cell = float(np.ptp(vertices, axis=0).max()) / 400.0
    while len(faces) > MOST_FACES:
        _, first, merged = np.unique(
            np.round(vertices / cell).astype(np.int64),
            axis=0,
            return_index=True,
            return_inverse=True,
        )
        faces = merged.ravel()[faces]
        vertices = vertices[first]
        solid = (np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)
        faces = faces[solid]
        cell *= 1.5
    return vertices, faces


def _legend(hand: Hand) -> str:
    colours = finger_colours(hand)
    marks = [("object", OBJECT_GREY), ("palm", PALM_COLOUR)]
    marks += [(f.name, colours[hand.link_names[f.tip_link]]) for f in hand.fingers]
    marks += [("contact", PURPLE), ("push", BLACK), ("friction cone", YELLOW)]
    return "".join(
        f'<span><i style="background:{colour}"></i>{html.escape(name)}</span>'
        for name, colour in marks
    )


def _page(
    title: str, subtitle: str, data: dict[str, Any], mesh: trimesh.Trimesh, hand: Hand
) -> str:
    room = files("medkit.viz")
    edges = " × ".join(f"{edge:.3g}" for edge in np.ptp(np.asarray(mesh.bounds), axis=0))
    payload = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    parts = {
        "TITLE": html.escape(title),
        "SUBTITLE": html.escape(subtitle),
        "EDGES": edges,
        "LEGEND": _legend(hand),
        "STYLE": room.joinpath("scene.css").read_text(encoding="utf-8"),
        "SCRIPT": "".join(room.joinpath(name).read_text(encoding="utf-8") for name in SCRIPTS),
        "DATA": payload,
    }
    page = room.joinpath("scene.html").read_text(encoding="utf-8")
    for name, text in parts.items():
        page = page.replace("{{" + name + "}}", text)
    return page
