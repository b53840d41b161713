"""A hand's tables: built once for hands of the same numbers, never taken for another hand's."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from medkit.grasping.closing import hand_tables, hull_tables
from medkit.grasping.closing.hand_tables import KEPT, closing_hand
from medkit.grasping.closing.surface_table import _fine_corners, _thinned
from medkit.robots import load_hand


@pytest.fixture
def built(monkeypatch):
    """Names of the hands whose tables are built, with nothing kept from before."""
    names = []
    real = hand_tables._built_tables
    monkeypatch.setattr(hand_tables, "_KEPT", {})
    monkeypatch.setattr(
        hand_tables, "_built_tables", lambda hand: names.append(hand.name) or real(hand)
    )
    return names


def same(one, two):
    """Whether two nests of named tuples hold the same arrays."""
    return all(
        same(a, b) if isinstance(a, tuple) else a.dtype == b.dtype and np.array_equal(a, b)
        for a, b in zip(one, two, strict=True)
    )


def shifted(hand, way):
    """A hand of the same name whose last body is elsewhere."""
    *others, last = hand.bodies
    return replace(hand, bodies=(*others, replace(last, vertices=last.vertices + way)))


def test_preshapes_and_orders_share_one_build(built):
    hand = load_hand("armar3")
    order = tuple(finger.name for finger in reversed(hand.fingers))
    fresh = closing_hand(hand, preshape="precision", finger_order=order)
    closing_hand(hand)
    again = closing_hand(replace(hand), preshape="precision", finger_order=order)
    assert built == ["armar3"]
    assert same(fresh, again)
    assert np.array_equal(again.preshape, hand.preshapes["precision"])


def test_a_changed_hand_of_the_same_name_gets_its_own_tables(built):
    hand = load_hand("wsg50")
    first, second = closing_hand(hand), closing_hand(shifted(hand, 0.01))
    assert built == ["wsg50", "wsg50"]
    assert not same(first.hulls, second.hulls)
    assert same(closing_hand(hand), first)


def test_a_hand_changed_in_place_gets_its_own_tables(built):
    hand = shifted(load_hand("wsg50"), 0.0)
    closing_hand(hand)
    hand.bodies[-1].vertices[:] += 0.01
    assert same(closing_hand(hand), closing_hand(shifted(load_hand("wsg50"), 0.01)))
    assert len(built) == 2


def test_nobody_can_write_into_what_is_kept(built):
    hand = load_hand("wsg50")
    first, second = closing_hand(hand), closing_hand(hand)
    first.hulls.planes[:] = 0.0
    first.width[:] = 0.0
    assert same(closing_hand(hand), second)


def test_tables_of_a_few_hands_are_kept_and_no_hand(built):
    hands = [shifted(load_hand("wsg50"), 0.001 * k) for k in range(KEPT + 2)]
    for hand in hands:
        closing_hand(hand)
    assert len(hand_tables._KEPT) == KEPT
    closing_hand(hands[-1])
    assert len(built) == KEPT + 2
    alive = weakref.ref(hands[-1])
    del hands, hand
    gc.collect()
    assert alive() is None


@pytest.mark.parametrize("name", ["armar3", "wsg50"])
def test_corners_of_fine_faces_are_those_of_trimesh(name):
    for body in load_hand(name).bodies:
        for longest in (0.002, 0.0071):
            expected, _ = trimesh.remesh.subdivide_to_size(
                body.vertices, body.faces, max_edge=longest, max_iter=20
            )
            assert np.array_equal(_fine_corners(body.vertices, body.faces, longest), expected)


def test_cells_are_those_of_sorted_rows():
    points = np.random.default_rng(0).uniform(-0.02, 0.02, (3000, 3))
    rows, cell = np.unique(np.floor(points / 0.004), axis=0, return_inverse=True)
    means = np.array([points[cell.ravel() == k].mean(axis=0) for k in range(len(rows))])
    kept = _thinned(points, 0.004)
    assert np.array_equal(np.floor(kept / 0.004), rows)
    nearest = [
        np.linalg.norm(points[cell.ravel() == k] - means[k], axis=1).min() for k in range(len(rows))
    ]
    assert np.allclose(np.linalg.norm(kept - means, axis=1), nearest)


def test_hints_name_the_highest_plane_whatever_the_stretch(monkeypatch):
    bodies = [body.vertices for body in load_hand("wsg50").bodies]
    table = hull_tables.hull_table(bodies)
    monkeypatch.setattr(hull_tables, "STRETCH", 10**9)
    assert same(table, hull_tables.hull_table(bodies))
