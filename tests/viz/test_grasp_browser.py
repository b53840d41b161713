"""The grasp browser in a cell: one frame, nothing from elsewhere, the best grasps first."""

import html
import json
import re

import numpy as np
import trimesh

from medkit.geometry import unit
from medkit.grasping import plan_grasps
from medkit.robots import load_hand
from medkit.viz.browser import show_grasps


def test_the_browser_is_one_self_contained_frame():
    rod = trimesh.creation.capsule(height=0.12, radius=0.02, count=[24, 24])
    hand = load_hand("armar3")
    found = plan_grasps(rod, hand, max_candidates=8, rng=np.random.default_rng(0))
    frame = show_grasps(found, rod, hand, most=3)
    shown = frame._repr_html_()
    assert shown.count("<iframe") == 1
    page = html.unescape(shown)
    assert "http://" not in page
    assert "https://" not in page
    assert "grasp browser" in repr(frame)
    assert 'id="wrench"' in page
    check_shadows(json.loads(re.search(r'type="application/json">(.*?)</script>', page, re.S)[1]))


def check_shadows(scene):
    """The ball of radius epsilon fits into the shadows that the page draws from these numbers."""
    directions = unit(np.random.default_rng(0).normal(size=(400, 3)))
    angle = 2 * np.pi * np.arange(8) / 8
    for grasp in scene["grasps"]:
        forces, torques = [], []
        for contact in grasp["contacts"]:
            normal = unit(np.array(contact["normal"]))
            side = unit(np.cross(normal, [1, 0, 0] if abs(normal[0]) < 0.7 else [0, 1, 0]))
            across = np.outer(np.cos(angle), side) + np.outer(np.sin(angle), np.cross(normal, side))
            forces.append(normal + scene["friction"] * across)
            arm = np.array(contact["point"]) - scene["mass"]
            torques.append(np.cross(arm, forces[-1]) / scene["reach"])
        for wrenches in (np.vstack(forces), np.vstack(torques)):
            # the edges start at another angle than the planner's: its pyramid is a little wider
            least = (wrenches @ directions.T).max(axis=0).min()
            assert least > 0.9 * (grasp["epsilon"] or 0.0)
