"""An object and the hand that grasps it as one GLB file, for any 3-D program."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from medkit.errors import InputError
from medkit.files import whole_file
from medkit.geometry import rotation_about, transform
from medkit.robots import Hand

if TYPE_CHECKING:
    import trimesh

#: RGBA of the object, of the palm and of the fingers in turn.
OBJECT, PALM = (184, 184, 184, 255), (154, 167, 177, 255)
FINGERS = ((0, 114, 178, 255), (230, 159, 0, 255), (0, 158, 115, 255), (213, 94, 0, 255),
           (86, 180, 233, 255))  # fmt: skip


def grasp_scene(
    object_mesh: trimesh.Trimesh, hand: Hand, grasp: Mapping[str, Any]
) -> trimesh.Scene:
    """Object and hand at one grasp, one named node per link.

    Parameters
    ----------
    object_mesh : trimesh.Trimesh
        The object [m].
    hand : Hand
        The hand.
    grasp : mapping
        Entry of ``"grasps"`` in a ``medkit.grasps/1`` document.

    Returns
    -------
    trimesh.Scene
        With y upwards, as GLB wants it; the object's z axis points up.

    Raises
    ------
    InputError
        If the grasp lacks its pose or joints, or names a joint that the hand has not.

    Examples
    --------
    >>> import trimesh
    >>> from medkit.robots import load_hand
    >>> ball, hand = trimesh.creation.icosphere(2, 0.02), load_hand("wsg50")
    >>> sorted(grasp_scene(ball, hand, {"pose": np.eye(4), "joints": {}}).geometry)
    ['housing', 'left finger', 'object', 'right finger']
    """
    import trimesh

    for key in ("pose", "joints"):
        if key not in grasp:
            raise InputError(f"Expected {key!r} in the grasp, but it is missing; pass a whole one.")
    upright = transform(rotation_about([1, 0, 0], -0.5 * np.pi), np.zeros(3))
    scene = trimesh.Scene()
    scene.add_geometry(
        _painted(object_mesh.copy(), OBJECT), "object", geom_name="object", transform=upright
    )
    pose = upright @ np.asarray(grasp["pose"], dtype=float)
    colours = _link_colours(hand)
    for name, mesh in hand.link_meshes(hand.coordinates(grasp["joints"])).items():
        link = _painted(mesh, colours.get(name, PALM))
        scene.add_geometry(link, name, geom_name=name, transform=pose)
    return scene


def write_grasp_glb(
    path: str | os.PathLike[str],
    object_mesh: trimesh.Trimesh,
    hand: Hand,
    grasp: Mapping[str, Any],
) -> None:
    """Write `grasp_scene` as a GLB file, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write.
    object_mesh, hand, grasp
        As in `grasp_scene`.

    Raises
    ------
    InputError
        As `grasp_scene`, and if the file cannot be written.
    """
    content = grasp_scene(object_mesh, hand, grasp).export(file_type="glb")
    with whole_file(path) as draft:
        draft.write_bytes(content)


def _painted(mesh: trimesh.Trimesh, colour: tuple[int, ...]) -> trimesh.Trimesh:
    import trimesh

    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=0.8
    )
    mesh.visual = trimesh.visual.TextureVisuals(material=material)
    return mesh


def _link_colours(hand: Hand) -> dict[str, tuple[int, ...]]:
    return {name: FINGERS[k % len(FINGERS)] for name, k in hand.finger_of_link().items()}
