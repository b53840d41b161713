"""The grasp browser inside a notebook: scroll through grasps, filter by outcome, turn the view."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import TYPE_CHECKING

from medkit.grasping.grasp_file import grasp_document
from medkit.robots import Hand
from medkit.viz.scene import scene_html

if TYPE_CHECKING:
    import trimesh

    from medkit.grasping import GraspSet

HEIGHT = 640  # [px]


@dataclass(frozen=True)
class Frame:
    """A whole page inside a cell, apart from the notebook's own style and scripts."""

    page: str
    title: str
    height: int = HEIGHT

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.page, quote=True)}" width="100%"'
            f' height="{self.height}" style="border:1px solid #dfe3e8;border-radius:6px"'
            f' title="{html.escape(self.title, quote=True)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<{self.title}>"


def show_grasps(found: GraspSet, mesh: trimesh.Trimesh, hand: Hand, *, most: int = 24) -> Frame:
    """Show planned grasps in a cell, turned by hand and chosen from a list.

    Nothing runs in the background: the view is one self-contained page in a frame, so it works in
    a stored notebook and in the book, and there is no server to end.

    Parameters
    ----------
    found : GraspSet
        What the planner returned.
    mesh : trimesh.Trimesh
        The object that it planned for [m].
    hand : Hand
        The hand.
    most : int
        Grasps to show, the best first.

    Returns
    -------
    Frame
        What a cell displays. An untrusted notebook leaves it out: put a static picture beside it.
    """
    document = grasp_document(found)
    page = scene_html(
        mesh, hand, document["grasps"], title=f"{found.grasp} grasps", most=most,
        friction=float(found.parameters.get("friction", 0.5)), preshape=found.grasp,
    )  # fmt: skip
    return Frame(page, "grasp browser")
