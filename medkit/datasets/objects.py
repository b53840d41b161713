"""Named objects of the size classes that grasp planners are tested on, made by code.

The theses' meshes are not ours to ship; these are bodies of the same kinds and sizes, closed and
smooth. Every mesh is made from its recipe once, kept in the user's cache, and the same everywhere.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal
from zipfile import BadZipFile

import numpy as np
import trimesh
from numpy.typing import NDArray

from medkit.arguments import one_of
from medkit.datasets import implicit
from medkit.datasets import object_recipes_everyday as everyday
from medkit.datasets import object_recipes_hand as hand
from medkit.datasets import object_recipes_large as large
from medkit.datasets.implicit import Part, mesh_of
from medkit.errors import InputError
from medkit.files import cache_folder, whole_file
from medkit.geometry import Floats, positive

SizeClass = Literal["large", "hand", "everyday"]
Recipe = Callable[[], list[Part] | trimesh.Trimesh]


@dataclass(frozen=True)
class ObjectInfo:
    """What is known of a named object before its mesh is made.

    Attributes
    ----------
    name : str
        Its name here.
    size : {"large", "hand", "everyday"}
        Size class: ``large`` and ``hand`` are P13's object sets 1 and 2.
    longest_edge : float
        Longest edge of the bounding box [m].
    category : str
        What kind of thing it is.
    printed_name : str
        The name of its counterpart in P13's tables; empty without one.
    recipe : callable
        Makes its parts or its mesh.
    view_deg : tuple of float
        Elevation and azimuth from which it is recognised at once [deg].
    """

    name: str
    size: SizeClass
    longest_edge: float
    category: str
    printed_name: str
    recipe: Recipe
    view_deg: tuple[float, float]


_TABLE: tuple[tuple[str, SizeClass, float, str, str, Recipe], ...] = (
    ("glasses", "large", 0.80, "utensil", "glasses", large.glasses),
    ("ant", "large", 0.80, "animal", "ant", large.ant),
    ("chair", "large", 0.80, "furniture", "chair", large.chair),
    ("fish_large", "large", 0.80, "animal", "fish", large.fish_large),
    ("bird", "large", 0.80, "animal", "bird", large.bird),
    ("figure", "large", 0.80, "toy", "monster", large.figure),
    ("bust", "large", 0.80, "sculpture", "bust", large.bust),
    ("amphora", "large", 0.80, "vessel", "amphora", large.amphora),
    ("teapot", "large", 0.80, "vessel", "teapot", large.teapot),
    ("giraffe", "large", 0.80, "animal", "giraffe", large.giraffe),
    ("clown", "hand", 0.14, "toy", "clown", hand.clown),
    ("elephant", "hand", 0.14, "animal", "elephant", hand.elephant),
    ("fish", "hand", 0.13, "animal", "fish", hand.fish),
    ("gnome", "hand", 0.27, "toy", "garden_gnome", hand.gnome),
    ("dog", "hand", 0.22, "animal", "dog", hand.dog),
    ("sitting_cat", "hand", 0.13, "animal", "sitting_cat", hand.sitting_cat),
    ("lying_cat", "hand", 0.14, "animal", "lying_cat", hand.lying_cat),
    ("moon", "hand", 0.12, "toy", "moon", hand.moon),
    ("seal", "hand", 0.13, "animal", "seal", hand.seal),
    ("star", "hand", 0.11, "toy", "star", hand.star),
    ("mug", "everyday", 0.122, "vessel", "", everyday.mug),
    ("bottle", "everyday", 0.26, "vessel", "", everyday.bottle),
    ("hammer", "everyday", 0.30, "tool", "", everyday.hammer),
    ("salt_box", "everyday", 0.14, "package", "", everyday.salt_box),
    ("cereal_box", "everyday", 0.28, "package", "", everyday.cereal_box),
)
#: Elevation and azimuth [deg] for those that the usual view shows badly.
_VIEWS = {
    "glasses": (24.0, -28.0),
    "bird": (42.0, -38.0),
    "clown": (10.0, -28.0),
    "ant": (34.0, -38.0),
}
_VIEWS |= {"figure": (14.0, -34.0), "gnome": (12.0, -28.0), "bust": (10.0, -30.0)}
_VIEWS |= {
    "amphora": (14.0, -12.0),
    "star": (14.0, -70.0),
    "moon": (10.0, -72.0),
    "ant": (34.0, -38.0),
}
_USUAL = (16.0, -58.0)
_OBJECTS = {row[0]: ObjectInfo(*row, _VIEWS.get(row[0], _USUAL)) for row in _TABLE}


def object_names(size: SizeClass | None = None) -> list[str]:
    """Names of the objects that `load_object` makes.

    Parameters
    ----------
    size : {"large", "hand", "everyday"}, optional
        Only this size class; all when left out.

    Returns
    -------
    list of str
        In the order of P13's tables 5.1 and 5.2, then the everyday objects.

    Raises
    ------
    InputError
        If there is no such size class.

    Examples
    --------
    >>> object_names("everyday")
    ['mug', 'bottle', 'hammer', 'salt_box', 'cereal_box']
    """
    if size is not None:
        one_of(size, ("large", "hand", "everyday"), "a size class")
    return [name for name, info in _OBJECTS.items() if size in (None, info.size)]


def object_info(name: str) -> ObjectInfo:
    """What is known of a named object besides its mesh.

    Parameters
    ----------
    name : str
        One of `object_names`.

    Returns
    -------
    ObjectInfo
        Size class, category, longest edge [m], and its counterpart in P13, if it has one.

    Raises
    ------
    InputError
        If there is no such object.

    Examples
    --------
    >>> info = object_info("gnome")
    >>> info.size, info.longest_edge
    ('hand', 0.27)
    """
    remedy = "choose one of these, or read your own mesh file"
    return _OBJECTS[one_of(name, _OBJECTS, "an object", remedy)]


def load_object(name: str, *, scale: float = 1.0) -> trimesh.Trimesh:
    """Make (or take from the cache) the mesh of a named object.

    Parameters
    ----------
    name : str
        One of `object_names`.
    scale : float
        Factor on its size; P13's precision grasps use glasses and giraffe at 0.25.

    Returns
    -------
    trimesh.Trimesh
        Closed mesh [m], normals outwards, z upwards, the bounding box's centre at the origin.
        A copy of its own for every caller.

    Raises
    ------
    InputError
        If there is no such object or `scale` is not positive.

    Examples
    --------
    >>> box = load_object("cereal_box")
    >>> box.is_watertight, box.extents.round(3).tolist()
    (True, [0.19, 0.06, 0.28])
    """
    factor = positive(scale, "scale")
    vertices, faces = _arrays(object_info(name).name)
    return trimesh.Trimesh(vertices * factor, faces.copy(), process=False)


def make_object(name: str, *, triangles: int = 12000) -> trimesh.Trimesh:
    """Make a named object's mesh anew, about as fine as asked, without the cache.

    Parameters
    ----------
    name : str
        One of `object_names`.
    triangles : int
        About how many are wanted; objects with exact edges keep the number that they have.

    Returns
    -------
    trimesh.Trimesh
        As `load_object` gives it [m].

    Raises
    ------
    InputError
        If there is no such object.

    Examples
    --------
    >>> make_object("cereal_box").extents.round(3).tolist()
    [0.19, 0.06, 0.28]
    """
    info = object_info(name)
    body = info.recipe()
    if isinstance(body, trimesh.Trimesh):
        return _placed(body, info.longest_edge)
    return mesh_of(body, longest=info.longest_edge, triangles=triangles)


def _placed(mesh: trimesh.Trimesh, longest: float) -> trimesh.Trimesh:
    low, high = mesh.bounds
    scale = longest / float(np.max(high - low))
    return trimesh.Trimesh((mesh.vertices - (low + high) / 2.0) * scale, mesh.faces, process=False)


@lru_cache(maxsize=64)
def _arrays(name: str) -> tuple[Floats, NDArray[np.int64]]:
    path = _cache_path(name)
    cached = _read(path)
    if cached is not None:
        return cached
    mesh = make_object(name)
    arrays = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
    if path is not None:
        with suppress(InputError, OSError), whole_file(path) as draft, draft.open("wb") as out:
            np.savez_compressed(out, vertices=arrays[0], faces=arrays[1])
    return arrays


def _cache_path(name: str) -> Path | None:
    """Where the mesh is kept, or None where no cache can be written.

    The recipe's and the mesher's own text is in the file name: a changed recipe is made anew.
    """
    recipe = object_info(name).recipe
    text = "".join(
        inspect.getsource(module) for module in (inspect.getmodule(recipe), implicit) if module
    )
    key = hashlib.sha256(text.encode()).hexdigest()[:12]
    try:
        return cache_folder("objects") / f"{name}-{object_info(name).longest_edge:g}-{key}.npz"
    except OSError:
        return None


def _read(path: Path | None) -> tuple[Floats, NDArray[np.int64]] | None:
    if path is None or not path.is_file():
        return None
    try:
        with np.load(path) as stored:
            return np.asarray(stored["vertices"]), np.asarray(stored["faces"])
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None  # a broken cache file is made anew
