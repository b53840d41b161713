"""A hand's tables: built once for hands of the same numbers, never taken for another hand's."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from medkit.grasping.closing import hand_tables
from medkit.grasping.closing.hand_tables import KEPT, closing_hand
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
