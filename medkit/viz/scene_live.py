"""A meshcat scene that follows the program and cleans up after itself.

One server for each kernel. It ends with `LiveScene.close`, with the scene's last reference, with
the interpreter, and with a kernel that is killed. What a notebook stores is a still picture.
"""

from __future__ import annotations

import io
import subprocess
import sys
import weakref
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from medkit.errors import InputError
from medkit.geometry import Floats, transform
from medkit.robots import Hand
from medkit.viz.hands import PALM_COLOUR, add_mesh, finger_colours, frame_axes
from medkit.viz.style import OBJECT_GREY
from medkit.viz.widgets import WIDGET, figure_png

if TYPE_CHECKING:
    import trimesh

HEIGHT = 420  # [px]
HALF_ANGLE = np.radians(37.5)  # of meshcat's camera, upwards; sidewards it sees more
LOOK_FROM = np.array([0.75, -0.55, 0.4])  # from the middle of the scene, z up
PATIENCE_MS = 10_000  # for an answer of the server
GONE = "<em>This scene is closed; run its cell again.</em>"


class LiveScene:
    """Meshes and hands in a meshcat view that moves as the program says.

    Use it as a context manager, call `close`, or let it go. A second scene takes the first one's
    place. For grasps to be leafed through, and for pages, take `medkit.viz.browser.show_grasps`,
    which needs no server.

    Attributes
    ----------
    url : str
        Address of the view, on this machine only.

    Examples
    --------
    >>> import trimesh
    >>> with LiveScene() as scene:
    ...     scene.add("box", trimesh.creation.box((0.1, 0.1, 0.1)))
    ...     scene.move("box", np.eye(4))
    ...     scene.url.startswith("http://127.0.0.1:")
    True
    >>> scene.closed
    True
    """

    _open: weakref.ref[LiveScene] | None = None

    def __init__(self) -> None:
        from meshcat import Visualizer

        before = LiveScene._open() if LiveScene._open is not None else None
        if before is not None:
            before.close()
        process, zmq_url, self.url = _start_server()
        with redirect_stdout(io.StringIO()):  # meshcat prints the address
            self._view = Visualizer(zmq_url=zmq_url)
        _impatient(self._view.window.zmq_socket)
        self._parts: dict[str, _Part] = {}
        self._widgets: list[Any] = []
        self._end = weakref.finalize(self, _stop, process, self._view.window.zmq_socket)
        for place in ("top_color", "bottom_color"):
            self._view["/Background"].set_property(place, [0.97, 0.98, 0.99])
        for thing in ("/Grid", "/Axes"):  # in metres, they dwarf what a hand can hold
            self._view[thing].set_property("visible", False)
        LiveScene._open = weakref.ref(self)

    @property
    def closed(self) -> bool:
        """Whether the server is gone."""
        return not self._end.alive

    def add(self, name: str, mesh: trimesh.Trimesh, *, pose: ArrayLike | None = None,
            colour: str = OBJECT_GREY, opacity: float = 1.0) -> None:  # fmt: skip
        """Add a mesh [m] under a name, or put it in the place of the one that has the name."""
        triangles, normals = np.asarray(mesh.triangles), np.asarray(mesh.face_normals)
        self._put(name, _Part(triangles, normals, _pose(pose), colour, opacity))

    def add_hand(self, name: str, hand: Hand, q: ArrayLike, *, pose: ArrayLike | None = None,
                 opacity: float = 1.0) -> None:  # fmt: skip
        """Add a hand at joint coordinates `q` [rad or m], its base at `pose`."""
        colours = finger_colours(hand)
        for path, body, place in _bodies(name, hand, q, _pose(pose)):
            triangles = body.vertices[body.faces]
            colour = colours.get(hand.link_names[body.link], PALM_COLOUR)
            self._put(path, _Part(triangles, _normals(triangles), place, colour, opacity))

    def move(self, name: str, pose: ArrayLike) -> None:
        """Put the mesh `name` at a pose, a 4 x 4 matrix [m]."""
        self._set_pose(name, _pose(pose))

    def move_hand(
        self, name: str, hand: Hand, q: ArrayLike, *, pose: ArrayLike | None = None
    ) -> None:
        """Put the hand `name` at joint coordinates `q` and its base at `pose`."""
        for path, _, place in _bodies(name, hand, q, _pose(pose)):
            self._set_pose(path, place)

    def fit_view(self) -> None:
        """Turn the camera to the scene as it stands; showing the scene does it once."""
        middle, eye = fitting_camera(self._corners())
        self._node("/Cameras/default").set_transform(transform(np.eye(3), middle))
        # meshcat's camera stands in a frame of its own, whose y points up
        x, y, z = eye - middle
        self._node("/Cameras/default/rotated/<object>").set_property("position", [x, z, -y])

    def still(self) -> str:
        """Draw the scene as it stands; return a PNG as base64 text."""
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(6.0, 4.6), subplot_kw={"projection": "3d"})
        for part in self._parts.values():
            normals = part.normals @ part.pose[:3, :3].T
            add_mesh(axes, part.placed(), normals, part.colour, part.opacity)
        frame_axes(axes, self._corners())
        picture = figure_png(figure)
        plt.close(figure)
        return picture

    def close(self) -> None:
        """End the server and free its ports; calling it again does no harm."""
        self._end()
        for widget in self._widgets:
            widget.value = GONE
        self._widgets.clear()

    def __enter__(self) -> LiveScene:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _put(self, path: str, part: _Part) -> None:
        from meshcat.geometry import MeshLambertMaterial, TriangularMeshGeometry

        node = self._node(path)
        # a vertex of its own for each corner keeps the edges of a body sharp
        corners = part.triangles.reshape(-1, 3).astype(np.float32)
        faces = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
        colour = int(part.colour.lstrip("#"), 16)
        look = MeshLambertMaterial(
            color=colour, opacity=part.opacity, transparent=part.opacity < 1.0
        )
        node.set_object(TriangularMeshGeometry(corners, faces), look)
        node.set_transform(part.pose)
        self._parts[path] = part

    def _set_pose(self, path: str, pose: Floats) -> None:
        if path not in self._parts:
            known = ", ".join(sorted({name.partition("/")[0] for name in self._parts})) or "nothing"
            raise InputError(
                f"Expected a part of the scene ({known}), but got {path.partition('/')[0]!r}; add"
                " it first."
            )
        self._node(path).set_transform(pose)
        self._parts[path] = replace(self._parts[path], pose=pose)

    def _corners(self) -> Floats:
        placed = [part.placed().reshape(-1, 3) for part in self._parts.values()]
        return np.vstack(placed) if placed else np.array([[-0.05] * 3, [0.05] * 3])

    def _node(self, path: str) -> Any:
        if self.closed:
            raise InputError("Expected an open scene, but this one is closed; make a new one.")
        return self._view[path]

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        data = {"image/png": self.still(), "text/plain": "<live scene>"}
        if not self.closed:
            from ipywidgets import HTML, Layout

            self.fit_view()
            frame = (
                f"<iframe src='{self.url}' title='live scene' width='100%' height='{HEIGHT}'"
                " style='border:1px solid #dfe3e8;border-radius:6px'></iframe>"
            )
            widget = HTML(value=frame, layout=Layout(width="100%"))
            self._widgets.append(widget)
            data[WIDGET] = widget._repr_mimebundle_()[WIDGET]
        return data


@dataclass(frozen=True)
class _Part:
    """What is drawn under one path: corners and normals in its own frame, and its pose."""

    triangles: Floats
    normals: Floats
    pose: Floats
    colour: str
    opacity: float

    def placed(self) -> Floats:
        """Corners in the world's frame, shape (n, 3, 3) [m]."""
        return self.triangles @ self.pose[:3, :3].T + self.pose[:3, 3]


def fitting_camera(points: Floats) -> tuple[Floats, Floats]:
    """Where to look and where from, so that all points lie within the picture.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Corners of the scene [m], world frame, z up.

    Returns
    -------
    middle, eye : ndarray, shape (3,)
        Point to look at and place of the camera [m].

    Examples
    --------
    >>> middle, eye = fitting_camera(np.array([[0.0, 0, 0], [0.2, 0, 0]]))
    >>> middle, bool(np.linalg.norm(eye - middle) > 0.1)
    (array([0.1, 0. , 0. ]), True)
    """
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = max(float(np.linalg.norm(points - middle, axis=1).max()), 0.01)
    away = LOOK_FROM / np.linalg.norm(LOOK_FROM)
    return middle, middle + radius / np.sin(HALF_ANGLE) * away


def _start_server() -> tuple[subprocess.Popen[str], str, str]:
    process = subprocess.Popen(
        [sys.executable, "-m", "medkit.viz.scene_server"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        start_new_session=True,  # an interrupted cell shall not end the view
    )  # fmt: skip
    assert process.stdout is not None
    addresses = [process.stdout.readline().strip() for _ in range(2)]
    if not all(addresses):
        process.kill()
        process.wait()
        raise InputError(
            "Expected the server of the live scene to start, but it ended; use show_grasps, which"
            " needs none."
        )
    return process, addresses[0], addresses[1]


def _stop(process: subprocess.Popen[str], socket: Any) -> None:
    socket.close(linger=0)
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            stream.close()
    try:
        process.wait(timeout=2.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _impatient(socket: Any) -> None:
    """Let a lost server be an error instead of a wait without end."""
    import zmq

    socket.setsockopt(zmq.RCVTIMEO, PATIENCE_MS)
    socket.setsockopt(zmq.LINGER, 0)


def _bodies(name: str, hand: Hand, q: ArrayLike, pose: Floats) -> list[tuple[str, Any, Floats]]:
    places = pose @ hand.link_poses(q)
    return [(f"{name}/{k}", body, places[body.link]) for k, body in enumerate(hand.bodies)]


def _pose(value: ArrayLike | None) -> Floats:
    pose = np.eye(4) if value is None else np.asarray(value, dtype=float)
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise InputError(
            f"Expected a pose as a finite 4 x 4 matrix [m], but got shape {pose.shape}; build it"
            " with medkit.geometry.transform(rotation, translation)."
        )
    return pose


def _normals(triangles: Floats) -> Floats:
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.maximum(length, 1e-30)
