"""Many objects at once: planned on one machine or on a cluster, written one file an object.

Needs the extra ``cluster`` (dask.distributed) for anything but the serial run.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import uuid
from collections.abc import Callable, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from medkit.arguments import file_path, short, whole
from medkit.errors import InputError
from medkit.geometry import expected
from medkit.grasping.grasp_file import read_grasps, write_grasps
from medkit.grasping.grasp_set import GraspSet
from medkit.grasping.planners import object_record, plan_grasps, with_origin
from medkit.robots.digest import hand_digest
from medkit.robots.hand import Hand
from medkit.robots.library import usable_hand

Done = Callable[[str, GraspSet], None]


def plan_many(
    objects: Mapping[str, trimesh.Trimesh] | Iterable[tuple[str, trimesh.Trimesh]],
    hand: Hand | str,
    folder: str | os.PathLike[str],
    *,
    scheduler: str | None = None,
    workers: int = 0,
    seed: int = 0,
    done: Done | None = None,
    **parameters: Any,
) -> dict[str, Path]:
    """Plan grasps of many objects; whatever a former run finished is kept.

    Parameters
    ----------
    objects : mapping or iterable of (name, mesh)
        Closed meshes [m]. The names become file names.
    hand : Hand or str
        The hand, or its name.
    folder : path-like
        Existing folder for the grasp files ``name.json``.
    scheduler : str, optional
        Address of a dask scheduler, for example ``"tcp://10.0.0.1:8786"``.
    workers : int
        Processes of a cluster on this machine; 0 for a serial run. Not used with a scheduler.
    seed : int
        Draws the candidates of every object: each gets a generator of its own from the seed and
        its name, so that neither order nor number of processes matters.
    done : callable, optional
        Called with the name and the result of each object as it is finished.
    **parameters
        Arguments of `plan_grasps`: grasp, planner, friction, search_radius, ...

    Returns
    -------
    dict of str to pathlib.Path
        The grasp file of every object, in the order given.

    Raises
    ------
    InputError
        If the folder is missing, a name cannot be a file name or comes twice, or dask.distributed
        is asked for but not installed, or nobody answers at the scheduler's address; and at the
        end, with every other object written, if some objects cannot be planned.

    Examples
    --------
    >>> import tempfile
    >>> balls = {f"ball {r} mm": trimesh.creation.icosphere(3, r / 1000) for r in (20, 30)}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files = plan_many(balls, "wsg50", folder, planner="normals", max_candidates=2)
    ...     [len(read_grasps(file)) for file in files.values()]
    [2, 2]
    """
    target = file_path(folder, "a folder for the grasps")
    if not target.is_dir():
        raise InputError(
            f"Expected an existing folder for the grasps, but {target} is not one; create it first."
        )
    hand = usable_hand(hand)
    workers, seed = whole(workers, "workers", 0), whole(seed, "seed", 0)
    pairs = _named_meshes(objects)
    files = {name: target / f"{_file_name(name)}.json" for name in pairs}
    open_ = {
        name: mesh
        for name, mesh in pairs.items()
        if not _is_finished(files[name], mesh, hand, seed, parameters)
    }
    refused: dict[str, InputError] = {}
    for name, found in _results(open_, hand, scheduler, workers, seed, parameters):
        if isinstance(found, InputError):
            refused[name] = found
            continue
        write_grasps(files[name], found)
        if done is not None:
            done(name, found)
    if refused:
        first = next(iter(refused))
        raise InputError(
            f"Expected {len(pairs)} objects that can be planned, but {len(refused)} cannot, among"
            f" them {first!r} ({refused[first]}); the others are written, repair or drop these."
        )
    return files


def _named_meshes(objects: Any) -> dict[str, trimesh.Trimesh]:
    """The meshes by name, every name once."""
    try:
        pairs = [
            (name, mesh)
            for name, mesh in (objects.items() if isinstance(objects, Mapping) else objects)
        ]
    except InputError:  # of a mesh file that is read on its turn
        raise
    except (TypeError, ValueError):
        raise InputError(
            f"Expected names with their meshes, but got {short(objects)}; pass a dictionary, or"
            " what load_folder gives."
        ) from None
    names = [name for name, _ in pairs]
    for name, mesh in pairs:
        expected(mesh, trimesh.Trimesh, f"the mesh of {name!r}", "load it with load_mesh")
        if names.count(name) > 1:
            raise InputError(
                f"Expected every name once, but {name!r} comes twice; its second file would"
                " replace the first, so rename one."
            )
    return dict(pairs)


def plan_one(
    name: str, vertices: np.ndarray, faces: np.ndarray, hand: Hand, seed: int, parameters: dict
) -> GraspSet | InputError:
    """Plan one object of a batch from its arrays (n, 3) [m] and (f, 3); what a worker runs.

    An object that cannot be used comes back as the `InputError` that says why, so that it does not
    end the others.
    """
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    rng = np.random.default_rng([seed, int(hashlib.sha256(name.encode()).hexdigest()[:8], 16)])
    try:
        found = plan_grasps(mesh, hand, rng=rng, **parameters)
    except InputError as error:
        return error
    except ValueError as error:  # a mesh too broken for the checks: told at the end, with the rest
        return InputError(f"{type(error).__name__}: {error}")
    marked = replace(found, parameters={**found.parameters, "hand_digest": hand_digest(hand)})
    return with_origin(marked, seed=seed, path=name)


def _results(
    objects: Mapping[str, trimesh.Trimesh],
    hand: Hand,
    scheduler: str | None,
    workers: int,
    seed: int,
    parameters: dict,
) -> Iterable[tuple[str, GraspSet | InputError]]:
    tasks = {
        name: (name, np.asarray(mesh.vertices), np.asarray(mesh.faces), hand, seed, parameters)
        for name, mesh in objects.items()
    }
    if scheduler is None and workers < 1:
        for name, task in tasks.items():
            yield name, plan_one(*task)
        return
    if not tasks:
        return
    with _client(scheduler, workers) as client:
        from distributed import as_completed

        # a key of its own: a shared scheduler may know the same name with other parameters
        futures = {
            client.submit(
                plan_one, *task, key=f"medkit-{name}-{uuid.uuid4().hex}", pure=False
            ): name
            for name, task in tasks.items()
        }
        for future in as_completed(futures):
            yield futures[future], future.result()


@contextmanager
def _client(scheduler: str | None, workers: int) -> Any:
    """A client of the scheduler, or of a cluster of single-threaded processes made for this."""
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise InputError(
            "Expected dask.distributed for a run on several processes, but it is not installed;"
            " install medkit[cluster], or run serially with workers=0."
        ) from error
    if scheduler is not None:
        expected(scheduler, str, "the address of a dask scheduler", "pass it as text")
        try:
            client = Client(scheduler)
        except (OSError, ValueError) as error:
            reason = " ".join(str(error).split())
            raise InputError(
                f"Expected a dask scheduler at {scheduler!r}, but {reason}; start one with"
                " 'dask scheduler' and pass its address, such as tcp://10.0.0.1:8786."
            ) from error
        with client:
            yield client
        return
    with (
        LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def _is_finished(
    file: Path, mesh: trimesh.Trimesh, hand: Hand, seed: int, parameters: Mapping[str, Any]
) -> bool:
    """Whether a file holds what would be planned: same object, hand, seed and parameters."""
    if not file.is_file():
        return False
    try:
        found = read_grasps(file)
    except InputError:
        return False  # not ours, or of an older schema: planned anew
    asked = {**_defaults(), **parameters}
    stored = {**found.parameters, "planner": found.planner, "grasp": found.grasp}
    same = all(asked[key] == value for key, value in stored.items() if key in asked)
    record = object_record(mesh, np.zeros(3))
    return (
        same
        and found.seed == seed
        and found.hand == hand.name
        and found.parameters.get("hand_digest") == hand_digest(hand)
        and (found.object.sha256 == record.sha256)
    )


def _defaults() -> dict[str, Any]:
    """What `plan_grasps` takes for an argument that is not given."""
    known = inspect.signature(plan_grasps).parameters.values()
    return {one.name: one.default for one in known if one.default is not inspect.Parameter.empty}


def _file_name(name: str) -> str:
    if not name or Path(name).name != name:
        raise InputError(
            f"Expected names that can be file names, but got {name!r}; leave out slashes."
        )
    return name
