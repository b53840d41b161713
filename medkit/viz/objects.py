"""Pictures of objects: shaded views and the contact sheet of the zoo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh

from medkit.datasets.objects import load_object, object_info
from medkit.geometry import Floats, unit
from medkit.viz.style import axes_or_new


def shaded_view(
    mesh: trimesh.Trimesh,
    *,
    elevation_deg: float = 20.0,
    azimuth_deg: float = -60.0,
    pixels: int = 220,
) -> Floats:
    """Brightness image of a mesh seen in parallel projection.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        What to look at.
    elevation_deg, azimuth_deg : float
        Where the eye stands: above the x-y plane, and around z from the x axis [deg].
    pixels : int
        Width and height of the picture; the object fills it.

    Returns
    -------
    ndarray, shape (pixels, pixels)
        Brightness from 0 to 1, not a number where there is no object; row 0 is at the top.

    Examples
    --------
    >>> picture = shaded_view(trimesh.creation.icosphere(), pixels=60)
    >>> picture.shape, bool(np.isnan(picture[0, 0])), bool(picture[30, 30] > 0)
    ((60, 60), True, True)
    """
    right, up, eye = _camera(elevation_deg, azimuth_deg)
    flat = mesh.vertices @ np.stack([right, up, eye]).T
    low, high = flat.min(axis=0), flat.max(axis=0)
    zoom = (pixels - 8) / float(np.max((high - low)[:2]))
    flat = (flat - (low + high) / 2.0) * zoom
    points, normals = _dense(flat[mesh.faces], mesh.vertex_normals[mesh.faces])
    columns = np.clip((points[:, 0] + pixels / 2.0).astype(int), 0, pixels - 1)
    rows = np.clip((pixels / 2.0 - points[:, 1]).astype(int), 0, pixels - 1)
    order = np.argsort(points[:, 2])  # the nearest is written last
    light = unit(0.45 * right * -1.0 + 0.75 * up + 0.65 * eye)
    shade = 0.30 + 0.62 * np.clip(normals @ light, 0.0, 1.0) + 0.08 * np.abs(normals @ eye)
    picture = np.full((pixels, pixels), np.nan)
    depth = np.full((pixels, pixels), -np.inf)
    picture[rows[order], columns[order]] = shade[order]
    depth[rows[order], columns[order]] = points[order, 2]
    return np.where(_edges(depth, pixels), 0.12, picture)


def plot_object(mesh: trimesh.Trimesh, *, ax: Any = None, title: str = "", **view: Any) -> Any:
    """Draw a mesh shaded into `ax`; `view` goes to `shaded_view`. Returns the axes."""
    ax = axes_or_new(ax)
    ax.imshow(shaded_view(mesh, **view), cmap="gray", vmin=0.0, vmax=1.0)
    ax.set_axis_off()
    ax.set_title(title, loc="center", fontsize=9)
    return ax


def plot_contact_sheet(names: Sequence[str], *, columns: int = 5, pixels: int = 200) -> Any:
    """Draw named objects in a table, each filling its cell, its longest edge below its name.

    Parameters
    ----------
    names : sequence of str
        Objects of `medkit.datasets.object_names`.
    columns : int
        Pictures in a row.
    pixels : int
        Size of one picture.

    Returns
    -------
    matplotlib.figure.Figure
        The sheet.
    """
    import matplotlib.pyplot as plt

    rows = -(-len(names) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(1.75 * columns, 1.95 * rows), squeeze=False)
    for ax in axes.flat:
        ax.set_axis_off()
    for name, ax in zip(names, axes.flat, strict=False):
        info = object_info(name)
        elevation, azimuth = info.view_deg
        plot_object(
            load_object(name), ax=ax, pixels=pixels, elevation_deg=elevation, azimuth_deg=azimuth,
            title=f"{name.replace('_', ' ')}\n{100 * info.longest_edge:.0f} cm",
        )  # fmt: skip
    return figure


def _camera(elevation_deg: float, azimuth_deg: float) -> tuple[Floats, Floats, Floats]:
    e, a = np.deg2rad([elevation_deg, azimuth_deg])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(eye, right), eye


def _dense(corners: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Points on projected triangles (n, 3, 3), close enough to leave no pixel open."""
    edges = np.linalg.norm((corners - np.roll(corners, 1, axis=1))[..., :2], axis=-1).max(axis=1)
    pieces = np.ceil(1.6 * edges).astype(int) + 1
    points, turned = [], []
    for count in np.unique(pieces):
        chosen = pieces == count
        u, v = np.meshgrid(*(2 * [(np.arange(count) + 0.5) / count]))
        inside = (u + v <= 1.0 + 1e-9).ravel()
        weights = np.stack([1.0 - u - v, u, v], axis=-1).reshape(-1, 3)[inside]
        points.append(np.einsum("wk,tkd->twd", weights, corners[chosen]).reshape(-1, 3))
        turned.append(np.einsum("wk,tkd->twd", weights, normals[chosen]).reshape(-1, 3))
    return np.vstack(points), np.vstack(turned)


def _edges(depth: Floats, pixels: int) -> np.ndarray:
    """Pixels of the object beside a jump in depth: outlines and limbs before the body."""
    jump = np.zeros(depth.shape, dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            behind = np.roll(depth, step, axis=axis)
            with np.errstate(invalid="ignore"):
                jump |= depth - behind > 0.045 * pixels
    return jump & np.isfinite(depth)
