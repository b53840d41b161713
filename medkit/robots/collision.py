"""Collision queries of link bodies against an object's mesh."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from medkit.geometry import Floats, apply, inverse, points_array
from medkit.robots.hand import Hand, Ints, LinkBody


def convex_geometry(body: LinkBody) -> coal.ConvexBase:
    """Return a link body as coal's convex polytope."""
    points = coal.StdVec_Vec3s()
    for vertex in body.vertices:
        points.append(np.asarray(vertex))
    return coal.Convex.convexHull(points, True, "Qt")


def mesh_geometry(vertices: Floats, faces: Ints) -> coal.BVHModelOBBRSS:
    """Return a mesh as coal's hierarchy of boxes."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(faces)
    model.endModel()
    return model


def coal_pose(pose: Floats) -> coal.Transform3s:
    """Return a pose (4, 4) as coal's transform."""
    return coal.Transform3s(np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3]))


@dataclass(frozen=True)
class Proximity:
    """How near a body is to the object.

    Attributes
    ----------
    distance : float
        Gap [m]; below zero the depth of the deepest point of either inside the other.
    point_on_object, point_on_body : ndarray, shape (3,)
        Nearest points, or ends of the depth [m], in the object's frame.
    """

    distance: float
    point_on_object: Floats
    point_on_body: Floats


class MeshCollider:
    """An object's mesh, to be asked about the bodies of a hand.

    Parameters
    ----------
    vertices : array-like, shape (n, 3)
        Vertices of a closed mesh [m], in the object's frame.
    faces : array-like, shape (f, 3)
        Triangles, counter-clockwise seen from outside.
    hand : Hand
        The hand whose bodies are asked about.

    Notes
    -----
    A mesh is hollow to coal: a body wholly inside touches nothing. Every answer therefore also
    asks for the winding number of a vertex of the body.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, hand: Hand) -> None:
        self.hand = hand
        self._vertices = points_array(vertices, 3, "vertices")
        self._faces = np.ascontiguousarray(faces, dtype=np.int64)
        self._mesh = mesh_geometry(self._vertices, self._faces)
        self._bodies = [convex_geometry(body) for body in hand.bodies]
        self._balls = [_ball_around(body) for body in hand.bodies]
        self._planes = [_planes(body) for body in hand.bodies]
        self._bounds = self._vertices.min(axis=0), self._vertices.max(axis=0)
        self._tree = igl.AABB()
        self._tree.init(self._vertices, self._faces)
        self._winding = igl.FastWindingNumberBVH()
        self._winding.init(self._vertices, self._faces, 2)
        self._request = coal.CollisionRequest()
        self._result = coal.CollisionResult()
        self._distance_request = coal.DistanceRequest()
        self._distance_result = coal.DistanceResult()

    def inside(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (n, 3) [m] in the object's frame lie inside the object."""
        return np.asarray(self._winding.winding_number(points_array(points, 3)) > 0.5)

    def collides(self, body: int, T_object_link: Floats) -> bool:
        """Whether a body touches the object or lies inside it.

        Parameters
        ----------
        body : int
            Index into ``hand.bodies``.
        T_object_link : ndarray, shape (4, 4)
            Pose of the body's link in the object's frame [m].

        Returns
        -------
        bool
            True from the first touch on.
        """
        center, radius = self._balls[body]
        place = T_object_link[:3, :3] @ center + T_object_link[:3, 3]
        if max((self._bounds[0] - place).max(), (place - self._bounds[1]).max()) > radius:
            return False
        return self._crosses(body, T_object_link) or self._swallowed(body, T_object_link)

    def hand_collides(
        self, q: ArrayLike, T_object_hand: Floats, bodies: ArrayLike | None = None
    ) -> bool:
        """Whether any body (or any of `bodies`) of the hand at `q` (nq,) collides; stops early."""
        poses = T_object_hand @ self.hand.link_poses(q)
        chosen = range(len(self.hand.bodies)) if bodies is None else np.asarray(bodies)
        return any(self.collides(int(b), poses[self.hand.bodies[b].link]) for b in chosen)

    def distance(self, body: int, T_object_link: Floats) -> Proximity:
        """Signed distance between a body and the object.

        Parameters
        ----------
        body : int
            Index into ``hand.bodies``.
        T_object_link : ndarray, shape (4, 4)
            Pose of the body's link in the object's frame [m].

        Returns
        -------
        Proximity
            Gap and nearest points; when they overlap, minus the depth of the deepest vertex of
            one inside the other (a lower bound of the true depth when only edges cross).
        """
        if self.collides(body, T_object_link):
            return self._depth(body, T_object_link)
        self._distance_result.clear()
        gap = coal.distance(
            self._mesh, coal.Transform3s(), self._bodies[body], coal_pose(T_object_link),
            self._distance_request, self._distance_result,
        )  # fmt: skip
        return Proximity(
            float(gap),
            np.array(self._distance_result.getNearestPoint1()),
            np.array(self._distance_result.getNearestPoint2()),
        )

    def _crosses(self, body: int, T_object_link: Floats) -> bool:
        self._result.clear()
        coal.collide(
            self._mesh, coal.Transform3s(), self._bodies[body], coal_pose(T_object_link),
            self._request, self._result,
        )  # fmt: skip
        return bool(self._result.isCollision())

    def _swallowed(self, body: int, T_object_link: Floats) -> bool:
        """Whether a body that does not cross the surface lies inside, or holds the object."""
        points = apply(T_object_link, self.hand.bodies[body].vertices)
        low, high = points.min(axis=0), points.max(axis=0)
        if np.all(low > self._bounds[0]) and np.all(high < self._bounds[1]):
            return bool(self.inside(points[:1])[0])
        if np.all(low < self._bounds[0]) and np.all(high > self._bounds[1]):
            return bool(self._body_depth(body, T_object_link, self._vertices[:1])[0] > 0.0)
        return False

    def _body_depth(self, body: int, T_object_link: Floats, points: Floats) -> Floats:
        """Depth of points (n, 3) under the nearest face of a body; below zero outside."""
        normals, offsets = self._planes[body]
        local = apply(inverse(T_object_link), points)
        return np.asarray((offsets - local @ normals.T).min(axis=1))

    def _depth(self, body: int, T_object_link: Floats) -> Proximity:
        points = apply(T_object_link, self.hand.bodies[body].vertices)
        squared, _, nearest = self._tree.squared_distance(self._vertices, self._faces, points)
        depth = np.where(self.inside(points), np.sqrt(squared), 0.0)
        deepest = int(np.argmax(depth))
        covered = self._body_depth(body, T_object_link, self._vertices)
        vertex = int(np.argmax(covered))
        if depth[deepest] >= covered[vertex]:
            return Proximity(-float(depth[deepest]), nearest[deepest], points[deepest])
        normals, offsets = self._planes[body]
        local = apply(inverse(T_object_link), self._vertices[vertex : vertex + 1])[0]
        face = int(np.argmin(offsets - normals @ local))
        outward = T_object_link[:3, :3] @ normals[face]
        start = self._vertices[vertex]
        return Proximity(-float(covered[vertex]), start, start + covered[vertex] * outward)


def _planes(body: LinkBody) -> tuple[Floats, Floats]:
    """Outward unit normals (f, 3) and offsets (f,) [m] of a body's faces."""
    a, b, c = (body.vertices[body.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, a)


def _ball_around(body: LinkBody) -> tuple[Floats, float]:
    """Centre (3,) and radius of a ball that holds a body [m]."""
    center = 0.5 * (body.vertices.min(axis=0) + body.vertices.max(axis=0))
    return center, float(np.linalg.norm(body.vertices - center, axis=1).max())
