"""Pictures of grasps: what is drawn, where, with units, and what is refused."""

import numpy as np
import pytest
import trimesh
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from medkit.errors import InputError
from medkit.grasping import (
    PowerCloser,
    SphereFate,
    candidates_from_axis,
    medial_axis,
    object_field,
)
from medkit.robots import load_hand
from medkit.viz.grasps import FATES, plot_candidates, plot_fates, plot_grasp


def axes3d():
    return Figure().add_subplot(projection="3d")


@pytest.fixture(scope="module")
def hand():
    return load_hand("armar3")


@pytest.fixture(scope="module")
def bar():
    return trimesh.creation.cylinder(0.02, 0.2)


@pytest.fixture(scope="module")
def found(bar):
    axis = medial_axis(bar)
    return axis, candidates_from_axis(axis, search_radius=0.03)


def arrows(axes):
    return sum(len(c._segments3d) for c in axes.collections if type(c) is Line3DCollection)


def test_a_closed_grasp_shows_object_hand_and_an_arrow_for_each_contact(hand, bar):
    closer = PowerCloser(hand, object_field(bar.triangles))
    grasp = closer.close(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    axes = plot_grasp(grasp, bar, hand, ax=axes3d(), around=None)
    (dots,) = axes.lines
    np.testing.assert_allclose(np.array(dots.get_data_3d()), 100.0 * grasp.contacts.points.T)
    assert arrows(axes) == 3 * len(grasp.contacts.points)  # a shaft and two barbs
    assert axes.get_zlim()[0] < -10.0
    assert axes.get_zlim()[1] > 10.0
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == [
        "x [cm]",
        "y [cm]",
        "z [cm]",
    ]


def test_a_bare_pose_shows_the_open_hand_without_contacts(hand, bar):
    axes = plot_grasp(np.eye(4), bar, hand, ax=axes3d())
    assert not axes.lines
    assert len([c for c in axes.collections if isinstance(c, Poly3DCollection)]) == 1
    with pytest.raises(InputError, match="shape"):
        plot_grasp(np.eye(3), bar, hand, ax=axes3d())


def test_every_fate_has_a_look_of_its_own():
    assert set(FATES) == set(SphereFate)
    assert len({look[:2] for look in FATES.values()}) == len(FATES)
    assert len({words for _, _, words in FATES.values()}) == len(FATES)


def test_all_spheres_are_drawn_and_counted(bar, found):
    axis, candidates = found
    axes = plot_fates(axis, candidates, bar, ax=axes3d(), counts=True)
    dots = [c for c in axes.collections if not isinstance(c, Poly3DCollection)]
    assert sum(len(c._offsets3d[0]) for c in dots) == len(axis.centers)
    assert f"({candidates.fate_counts()['axis']})" in axes.get_legend_handles_labels()[1][0]
    with pytest.raises(InputError, match="same object"):
        plot_fates(axis.select(np.arange(3)), candidates, ax=axes3d())


def test_candidates_are_arrows_and_bars_of_so_many_spheres(found):
    candidates = found[1]
    axes = plot_candidates(candidates, most=5, length=0.05, ax=axes3d())
    shown = np.unique(candidates.sphere)
    shown = shown[np.linspace(0, len(shown) - 1, 5).round().astype(int)]
    drawn = np.isin(candidates.sphere, shown)
    assert len(axes.collections) == 1 + len(set(candidates.kind[drawn]))
    assert arrows(axes) == (3 + 3) * drawn.sum()  # shaft and two barbs; a bar has barbs of length 0
