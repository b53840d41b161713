"""The grasp browser in a cell: one frame, nothing from elsewhere, the best grasps first."""

import html

import numpy as np
import trimesh

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
