"""A hand: kinematic tree, convex link bodies, fingers, preshapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.arguments import one_of, short
from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.robots.tree import PRISMATIC, REVOLUTE, KinematicTree

if TYPE_CHECKING:
    import trimesh

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Finger:
    """One finger of a hand.

    Attributes
    ----------
    name : str
        For example ``"thumb"``.
    joints : ndarray, shape (k,)
        Its flexion joints as indices into `q`, from palm to tip.
    closing : ndarray, shape (k,)
        +1 where a growing coordinate closes the finger, -1 where a falling one does.
    moved_links, moved_bodies : tuple of k arrays
        For each flexion joint the links, and the bodies, that it moves.
    tip_link : int
        Index of the link that carries the pad.
    tip_point, tip_normal : ndarray, shape (3,)
        Predefined contact point on the pad [m] and outward unit normal there, in the frame of
        the tip link (P13 4.7, figure 4.14).
    end_point : ndarray, shape (3,)
        Far end of the finger in the same frame [m].
    """

    name: str
    joints: Ints
    closing: Ints
    moved_links: tuple[Ints, ...]
    moved_bodies: tuple[Ints, ...]
    tip_link: int
    tip_point: Floats
    tip_normal: Floats
    end_point: Floats


@dataclass(frozen=True)
class LinkBody:
    """A convex body that moves with a link: vertices (m, 3) [m] in its frame, faces (f, 3)."""

    link: int
    vertices: Floats
    faces: Ints


@dataclass(frozen=True)
class Opposition:
    """Which finger is the thumb of a precision grasp, and which oppose it (indices)."""

    thumb: int
    fingers: tuple[int, ...]


@dataclass(frozen=True)
class Hand:
    """A hand as the planners see it; they know none by name.

    Attributes
    ----------
    name : str
        Name of the hand.
    joint_names : tuple of str, length nq
        Actuated joints, in the order of `q`.
    limits : ndarray, shape (nq, 2)
        Lower and upper joint limits [rad or m].
    tree : KinematicTree
        Kinematics, coupled joints included.
    link_names : tuple of str, length L
        Links, in the order of the tree.
    fingers : tuple of Finger
        The fingers.
    bodies : tuple of LinkBody
        Convex bodies of the links.
    palm_direction : ndarray, shape (3,)
        Unit vector in which the palm faces, in the hand base frame (P13 4.20).
    closing_axis : ndarray, shape (3,)
        Unit vector of the hand's orientation in the same frame, laid along the axis of what
        is grasped (P13 4.21).
    T_hand_power : ndarray, shape (4, 4)
        Frame on the palm whose origin is put at the grasp point of a power grasp, before the
        hand is drawn back until it is free of the object [m].
    preshapes : mapping of str to ndarray, shape (nq,)
        Joint coordinates to start from: ``"power"`` and ``"precision"``.
    opposition : Opposition
        Thumb and opposing fingers of a precision grasp.
    sphere_radii : tuple of float
        Smallest and largest radius of a ball that the hand can enclose [m].
    self_collision_pairs : ndarray, shape (p, 2)
        Pairs of bodies that can touch; neighbours in the tree and pairs that always touch are
        left out.
    source : str
        Where the numbers come from, and which are assumed.
    """

    name: str
    joint_names: tuple[str, ...]
    limits: Floats
    tree: KinematicTree
    link_names: tuple[str, ...]
    fingers: tuple[Finger, ...]
    bodies: tuple[LinkBody, ...]
    palm_direction: Floats
    closing_axis: Floats
    T_hand_power: Floats
    preshapes: Mapping[str, Floats]
    opposition: Opposition
    sphere_radii: tuple[float, float]
    self_collision_pairs: Ints
    source: str

    def __post_init__(self) -> None:
        # hands are shared: nobody may change another one's preshape
        for array in (self.limits, *self.preshapes.values()):
            array.setflags(write=False)

    @property
    def max_sphere_radius(self) -> float:
        """Largest radius of a ball that the hand can enclose [m]."""
        return self.sphere_radii[1]

    @property
    def min_sphere_radius(self) -> float:
        """Smallest radius of a ball that the hand can hold [m]."""
        return self.sphere_radii[0]

    @property
    def prismatic_joints(self) -> tuple[str, ...]:
        """Names of the joints whose coordinate is a length [m], not an angle."""
        sliding = self.tree.coordinate[self.tree.kind == PRISMATIC]
        turning = self.tree.coordinate[self.tree.kind == REVOLUTE]
        return tuple(
            name for k, name in enumerate(self.joint_names) if k in sliding and k not in turning
        )

    def finger_of_link(self) -> dict[str, int]:
        """Index of the finger that each moving link belongs to, by link name.

        Links between palm and tip belong to that tip's finger; side branches and fingers that
        share a joint go to the first finger that moves them.
        """
        owner: dict[str, int] = {}
        for k, finger in enumerate(self.fingers):
            moved = set(np.concatenate(finger.moved_links).tolist())
            for link in moved.intersection(self.tree.ancestors(finger.tip_link)):
                owner[self.link_names[link]] = k
        for k, finger in enumerate(self.fingers):
            for link in np.concatenate(finger.moved_links):
                owner.setdefault(self.link_names[link], k)
        return owner

    def finger(self, name: str) -> Finger:
        """Return the finger called `name`; `InputError` when there is none."""
        for finger in self.fingers:
            if finger.name == name:
                return finger
        known = ", ".join(finger.name for finger in self.fingers)
        raise InputError(f"Expected a finger of {self.name} ({known}), but got {name!r}; name one.")

    def link_poses(self, q: ArrayLike) -> Floats:
        """Poses ``T_hand_link`` of shape (L, 4, 4), or (B, L, 4, 4) for `q` (B, nq) [m]."""
        return self.tree.link_poses(q)

    def fingertips(self, q: ArrayLike) -> dict[str, Floats]:
        """Far ends of the fingers in the hand base frame.

        Parameters
        ----------
        q : array-like, shape (nq,) or (B, nq)
            Joint coordinates [rad or m].

        Returns
        -------
        dict of str to ndarray, shape (3,) or (B, 3)
            Position of each finger's end [m].

        Examples
        --------
        >>> from medkit.robots import load_hand
        >>> hand = load_hand("armar3")
        >>> hand.fingertips(np.zeros(11))["thumb"].round(5)
        array([-0.1479 ,  0.     ,  0.06525])
        """
        poses = self.link_poses(q)
        return {
            f.name: poses[..., f.tip_link, :3, :3] @ f.end_point + poses[..., f.tip_link, :3, 3]
            for f in self.fingers
        }

    def pads(self, q: ArrayLike) -> dict[str, tuple[Floats, Floats]]:
        """Contact point [m] and outward unit normal of each finger's pad, in the hand base frame.

        Parameters
        ----------
        q : array-like, shape (nq,) or (B, nq)
            Joint coordinates [rad or m].

        Returns
        -------
        dict of str to (ndarray, ndarray), each of shape (3,) or (B, 3)
            Point and normal by finger (P13 4.7).
        """
        poses = self.link_poses(q)
        turns, places = poses[..., :3, :3], poses[..., :3, 3]
        return {
            f.name: (
                turns[..., f.tip_link, :, :] @ f.tip_point + places[..., f.tip_link, :],
                turns[..., f.tip_link, :, :] @ f.tip_normal,
            )
            for f in self.fingers
        }

    def link_meshes(self, q: ArrayLike) -> dict[str, trimesh.Trimesh]:
        """Meshes of the links that have a body, in the hand base frame.

        Parameters
        ----------
        q : array-like, shape (nq,)
            Joint coordinates [rad or m].

        Returns
        -------
        dict of str to trimesh.Trimesh
            One mesh per link, of all its convex bodies [m].
        """
        import trimesh

        poses = self.link_poses(q)
        if poses.ndim != 3:
            raise InputError(
                f"Expected q of one configuration, but got shape {np.shape(q)}; pass one row of it."
            )
        parts: dict[str, list[trimesh.Trimesh]] = {}
        for body in self.bodies:
            mesh = trimesh.Trimesh(body.vertices, body.faces, process=False)
            mesh.apply_transform(poses[body.link])
            parts.setdefault(self.link_names[body.link], []).append(mesh)
        joined = {name: trimesh.util.concatenate(meshes) for name, meshes in parts.items()}
        return cast("dict[str, trimesh.Trimesh]", joined)

    def joint_values(self, q: ArrayLike) -> dict[str, float]:
        """Joint coordinates `q` (nq,) by name [rad or m]."""
        values = np.asarray(q, dtype=float)
        if values.shape != (len(self.joint_names),):
            raise InputError(
                f"Expected q of shape ({len(self.joint_names)},), but got shape {values.shape};"
                " pass one value per joint in the order of joint_names."
            )
        return dict(zip(self.joint_names, values.tolist(), strict=True))

    def coordinates(self, values: Mapping[str, float], preshape: str = "power") -> Floats:
        """Joint coordinates (nq,) from values by name; joints left out stay at the preshape.

        Parameters
        ----------
        values : mapping of str to float
            Joint values by name [rad or m].
        preshape : str
            The preshape to start from.

        Returns
        -------
        ndarray, shape (nq,)
            Joint coordinates [rad or m].

        Raises
        ------
        InputError
            If a joint or the preshape is unknown, or a value is no number.
        """
        q = np.array(self.preshapes[one_of(preshape, self.preshapes, "a preshape")])
        for name, value in values.items():
            if name not in self.joint_names:
                raise InputError(
                    f"Expected a joint of {self.name} ({', '.join(self.joint_names)}), but got"
                    f" {name!r}; use one of these names."
                )
            if not isinstance(value, int | float | np.number) or not np.isfinite(value):
                raise InputError(
                    f"Expected the value of {name!r} to be a finite number, but got {short(value)};"
                    " give one [rad or m]."
                )
            q[self.joint_names.index(name)] = value
        return q
