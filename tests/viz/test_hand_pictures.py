"""Pictures of hands: everything is drawn, labelled with units, and told apart."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from medkit.robots import hand_names, load_hand
from medkit.viz.hands import PALM_COLOUR, finger_colours, plot_hand, plot_hand_directions


def axes3d():
    return Figure().add_subplot(projection="3d")


@pytest.mark.parametrize("name", hand_names())
def test_every_link_is_drawn_inside_labelled_axes(name):
    hand = load_hand(name)
    q = hand.preshapes["power"]
    axes = plot_hand(hand, q, ax=axes3d())
    meshes = hand.link_meshes(q)
    assert len([c for c in axes.collections if isinstance(c, Poly3DCollection)]) == len(meshes)
    low, high = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()]).T
    for mesh in meshes.values():
        assert np.all(mesh.bounds[0] >= low)
        assert np.all(mesh.bounds[1] <= high)
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x [m]", "y [m]", "z [m]"]


def test_fingers_have_colours_of_their_own_and_the_palm_none():
    hand = load_hand("armar3")
    colours = finger_colours(hand)
    tips = [colours[hand.link_names[finger.tip_link]] for finger in hand.fingers]
    assert len(set(tips)) == 5
    assert PALM_COLOUR not in tips
    assert "Hand Palm 1 R" not in colours


def test_a_moved_hand_is_drawn_where_it_is():
    hand = load_hand("wsg50")
    pose = np.eye(4)
    pose[:3, 3] = [1.0, 2.0, 3.0]
    axes = plot_hand(hand, hand.preshapes["power"], ax=axes3d(), T_world_hand=pose)
    assert 0.9 < np.mean(axes.get_xlim()) < 1.1
    assert 1.9 < np.mean(axes.get_ylim()) < 2.1


def test_new_axes_are_made_when_none_are_given_and_directions_get_a_legend():
    hand = load_hand("schunk")
    axes = plot_hand(hand, hand.preshapes["power"])
    plot_hand_directions(hand, ax=axes)
    labels = axes.get_legend_handles_labels()[1]
    assert labels == ["palm direction", "closing axis", "grasp point"]
    plt.close(axes.figure)
