"""Recipes for the hand-sized figures: clown, elephant, fish, gnome, dog, cats, moon, seal, star.

Counterparts of P13's object set 2 (craft-shop figures of 10 to 27 cm). Lengths in centimetres;
x points forwards, y to the side, z up; `medkit.datasets.objects` scales to the stated size.
"""

from __future__ import annotations

import numpy as np

from medkit.datasets.implicit import (
    Part,
    chain,
    ellipsoid,
    lathe,
    pair,
    plate,
    profile_through,
    torus,
)  # fmt: skip
from medkit.geometry import Floats


def clown() -> list[Part]:
    """Standing clown: pointed hat, tufts of hair, ball nose, ruff, round belly, long shoes."""
    belly = ellipsoid([0, 0, 5.2], [2.5, 2.7, 2.8])
    legs = pair(chain([(0, 1.15, 4.0), (0, 1.35, 0.9)], [1.25, 1.0], steps=1).blended(0.7))
    shoes = pair(ellipsoid([1.0, 1.5, 0.75], [2.0, 1.05, 0.75]).blended(0.3))
    ruff = torus([0, 0, 7.75], [0, 0, 1], 1.55, 0.5).blended(0.4)
    head = ellipsoid([0, 0, 9.4], [1.75, 1.7, 1.8]).blended(0.3)
    nose = ellipsoid([1.9, 0, 9.3], 0.62).blended(0.1)
    hair = pair(ellipsoid([-0.1, 1.95, 9.9], [0.95, 0.8, 0.95]).blended(0.25))
    hat = lathe(profile_through([(10.5, 1.55), (10.9, 1.4), (13.4, 0.38), (13.7, 0.3)]))
    bobble = ellipsoid([0, 0, 13.9], 0.6)
    arms = pair(
        chain([(0, 2.0, 6.9), (0.5, 3.4, 6.2), (1.2, 4.3, 7.0)], [0.85, 0.72, 0.62]).blended(0.5)
    )
    hands = pair(ellipsoid([1.45, 4.55, 7.5], [0.75, 0.6, 0.8]).blended(0.2))
    buttons = [ellipsoid([2.45, 0, 5.9], 0.33), ellipsoid([2.5, 0, 4.8], 0.33)]
    return [
        belly, *legs, *shoes, *arms, *hands, ruff, head, *hair, nose,
        hat.blended(0.2), bobble.blended(0.2), *buttons,
    ]  # fmt: skip


def elephant() -> list[Part]:
    """Standing elephant with a hanging trunk, large ears and short tusks."""
    body = ellipsoid([0, 0, 6.4], [4.4, 3.0, 3.1])
    legs = [
        *pair(chain([(2.5, 1.5, 5.2), (2.7, 1.6, 1.0)], [1.45, 1.2], steps=1).blended(0.9)),
        *pair(chain([(-2.6, 1.5, 5.2), (-2.8, 1.6, 1.0)], [1.5, 1.2], steps=1).blended(0.9)),
    ]
    feet = [ellipsoid([x, y, 0.5], [1.35, 1.35, 0.7]) for x in (2.7, -2.8) for y in (1.6, -1.6)]
    head = ellipsoid([4.7, 0, 8.6], [2.3, 2.0, 2.2]).blended(1.2)
    trunk = chain(
        [(6.2, 0, 8.4), (7.6, 0, 7.0), (8.0, 0, 4.8), (8.3, 0, 2.9), (9.3, 0, 2.3)],
        [1.25, 1.05, 0.85, 0.70, 0.62],
    ).blended(0.7)
    ears = pair(
        ellipsoid([0, 0, 0], [2.0, 0.55, 2.3])
        .turned([0, 0, 1], -32.0).moved([3.6, 2.75, 8.5]).blended(0.35)
    )  # fmt: skip
    tusks = pair(
        chain([(5.6, 1.3, 7.4), (6.9, 2.0, 6.5), (8.2, 2.2, 6.5)], [0.48, 0.38, 0.22]).blended(0.2)
    )
    tail = chain([(-4.2, 0, 7.2), (-5.0, 0, 6.0), (-5.1, 0, 4.2)], [0.4, 0.32, 0.4]).blended(0.3)
    return [body, *legs, *feet, head, trunk, *ears, *tusks, tail]


def fish() -> list[Part]:
    """Plump fish with a forked tail, back and belly fins, round eyes and an open mouth."""
    body = ellipsoid([0, 0, 0], [5.2, 2.3, 3.1])
    stem = chain([(-3.5, 0, 0), (-6.2, 0, 0)], [1.5, 0.7], steps=1).blended(1.2)
    fork = [(-5.6, 0.0), (-8.6, 3.1), (-9.2, 2.9), (-7.9, 0.0), (-9.2, -2.9), (-8.6, -3.1)]
    tail = plate(fork, 0.9, 0.35).blended(0.6)
    back = plate([(2.6, 2.0), (1.2, 4.0), (-2.4, 4.3), (-3.2, 1.6)], 0.9, 0.35).blended(0.5)
    under = plate([(-0.4, -2.2), (-2.0, -4.2), (-2.9, -4.1), (-2.6, -1.8)], 0.9, 0.3).blended(0.5)
    fins = pair(
        ellipsoid([-0.9, 0, 0], [1.5, 0.35, 0.8])
        .turned([0, 0, 1], -28.0).moved([1.2, 2.25, -0.8]).blended(0.3)
    )  # fmt: skip
    eyes = pair(ellipsoid([3.2, 1.55, 1.0], [0.6, 0.45, 0.6]).blended(0.1))
    lips = torus([5.05, 0, -0.35], [1, 0, 0], 0.62, 0.36).blended(0.25)
    mouth = ellipsoid([5.4, 0, -0.35], [1.0, 0.55, 0.55]).carved(0.2)
    return [body, stem, tail, back, under, *fins, *eyes, lips, mouth]


def gnome() -> list[Part]:
    """Garden gnome: tall bent hat, full beard, arms on the belly, boots."""
    coat = lathe(
        profile_through([(2.6, 4.2), (3.0, 4.6), (6.0, 4.4), (9.5, 4.1), (12.5, 3.0), (13.5, 2.2)])
    )
    boots = pair(ellipsoid([1.0, 2.1, 1.3], [3.1, 1.9, 1.3]).blended(0.4))
    legs = pair(chain([(0, 2.0, 3.5), (0.1, 2.1, 1.4)], 1.7, steps=1).blended(0.5))
    belt = torus([0, 0, 7.4], [0, 0, 1], 4.15, 0.62).blended(0.2)
    head = ellipsoid([0.3, 0, 15.2], [2.9, 2.8, 3.0]).blended(0.6)
    beard = chain([(2.0, 0, 14.2), (3.1, 0, 11.6), (3.5, 0, 9.0)], [2.1, 1.7, 0.45]).blended(0.7)
    nose = ellipsoid([3.3, 0, 15.5], [0.85, 0.8, 0.75]).blended(0.15)
    brim = torus([0.2, 0, 16.9], [0, 0, 1], 2.55, 0.72).blended(0.3)
    hat = chain(
        [(0.2, 0, 17.3), (0.0, 0, 20.0), (-0.4, 0, 22.8), (-1.5, 0, 25.4), (-2.6, 0, 26.6)],
        [2.75, 2.15, 1.45, 0.85, 0.55],
    ).blended(0.5)
    arms = pair(
        chain([(-0.2, 3.0, 12.0), (0.9, 4.7, 9.6), (3.4, 3.3, 8.6)], [1.3, 1.25, 1.05]).blended(0.4)
    )
    hands = pair(ellipsoid([4.1, 2.4, 8.5], [0.95, 1.1, 0.9]).blended(0.2))
    return [coat, *legs, *boots, belt, head, beard, nose, brim, hat, *arms, *hands]


def dog() -> list[Part]:
    """Standing dog with hanging ears, a long muzzle and a raised tail."""
    trunk = chain(
        [(-6.2, 0, 10.2), (-2.5, 0, 10.0), (2.5, 0, 10.0), (5.6, 0, 10.8)], [2.7, 2.6, 3.1, 3.0]
    )
    neck = chain([(5.4, 0, 11.6), (7.6, 0, 14.6)], [2.4, 2.1], steps=1).blended(1.2)
    head = ellipsoid([8.4, 0, 15.9], [2.7, 2.3, 2.3]).blended(0.6)
    muzzle = chain([(9.6, 0, 15.2), (12.6, 0, 14.7)], [1.6, 1.15], steps=1).blended(0.7)
    nose = ellipsoid([13.6, 0, 15.2], 0.6).blended(0.15)
    ears = pair(
        chain([(7.6, 1.7, 17.4), (7.3, 2.9, 16.4), (7.4, 3.0, 13.8)], [0.75, 0.8, 0.95]).blended(
            0.3
        )
    )
    front = pair(
        chain([(5.4, 1.6, 9.2), (5.2, 1.8, 5.0), (5.3, 1.8, 1.0)], [1.6, 1.1, 0.95]).blended(0.8)
    )
    hind = pair(
        chain(
            [(-5.8, 1.6, 9.4), (-5.0, 1.9, 6.4), (-6.9, 1.9, 3.8), (-6.4, 1.9, 1.0)],
            [2.0, 1.45, 0.95, 0.9],
        ).blended(0.8)
    )
    paws = [
        *pair(ellipsoid([5.9, 1.8, 0.8], [1.6, 1.1, 0.8]).blended(0.3)),
        *pair(ellipsoid([-5.8, 1.9, 0.8], [1.6, 1.1, 0.8]).blended(0.3)),
    ]
    tail = chain([(-8.0, 0, 11.4), (-10.2, 0, 13.4), (-10.6, 0, 16.4)], [1.0, 0.8, 0.5]).blended(
        0.6
    )
    return [trunk, neck, head, muzzle, nose, *ears, *front, *hind, *paws, tail]


def sitting_cat() -> list[Part]:
    """Cat sitting upright, ears pricked, the tail around its side."""
    body = chain(
        [(-1.5, 0, 2.6), (-0.9, 0, 4.6), (0.3, 0, 7.2), (0.9, 0, 8.6)], [2.7, 2.6, 2.0, 1.6]
    )
    haunches = pair(ellipsoid([-0.6, 2.0, 1.9], [2.5, 1.4, 2.0]).blended(0.5))
    head = ellipsoid([1.4, 0, 10.6], [1.95, 2.15, 1.8]).blended(0.4)
    cheeks = pair(ellipsoid([3.0, 0.5, 10.0], [0.75, 0.7, 0.55]).blended(0.3))
    ears = pair(chain([(1.2, 1.25, 11.6), (1.1, 1.65, 13.5)], [0.95, 0.22], steps=1).blended(0.25))
    legs = pair(chain([(1.4, 0.9, 6.6), (2.2, 1.0, 0.8)], [1.05, 0.75], steps=1).blended(0.5))
    paws = [
        *pair(ellipsoid([2.7, 1.0, 0.55], [1.1, 0.85, 0.6]).blended(0.2)),
        *pair(ellipsoid([1.2, 2.6, 0.55], [1.4, 0.75, 0.6]).blended(0.2)),
    ]
    tail = chain(
        [(-3.6, -0.6, 1.2), (-3.4, -3.0, 0.75), (-0.6, -4.1, 0.7), (1.8, -3.6, 0.7)],
        [0.85, 0.75, 0.70, 0.55],
    ).blended(0.3)
    return [body, *haunches, head, *cheeks, *ears, *legs, *paws, tail]


def lying_cat() -> list[Part]:
    """Cat lying on its belly, paws forwards, head up, the tail along its flank."""
    body = chain(
        [(-5.0, 0, 2.6), (-2.0, 0, 3.0), (1.6, 0, 2.9), (3.4, 0, 3.3)], [2.4, 2.6, 2.3, 2.0]
    )
    haunches = pair(ellipsoid([-3.6, 2.1, 1.9], [2.5, 1.1, 1.9]).blended(0.5))
    head = ellipsoid([5.0, 0, 5.8], [1.8, 2.0, 1.7]).blended(0.7)
    cheeks = pair(ellipsoid([6.5, 0.5, 5.3], [0.7, 0.65, 0.5]).blended(0.3))
    ears = pair(chain([(4.7, 1.15, 6.8), (4.5, 1.55, 8.4)], [0.85, 0.22], steps=1).blended(0.25))
    arms = pair(
        chain([(2.8, 1.3, 2.0), (5.0, 1.5, 0.85), (7.6, 1.3, 0.75)], [1.2, 0.9, 0.75]).blended(0.4)
    )
    feet = pair(ellipsoid([-1.0, 2.5, 0.6], [1.5, 0.75, 0.6]).blended(0.2))
    tail = chain(
        [(-7.0, -0.5, 1.2), (-7.2, -3.0, 0.8), (-4.2, -4.2, 0.7), (-0.6, -3.9, 0.7)],
        [0.9, 0.8, 0.75, 0.55],
    ).blended(0.4)
    return [body, *haunches, head, *cheeks, *ears, *arms, *feet, tail]


def moon() -> list[Part]:
    """Crescent moon with a face in profile: nose, lips and chin on its hollow side."""
    outer = np.deg2rad(np.linspace(58.0, 302.0, 44))
    rim = 6.0 * np.column_stack([np.cos(outer), np.sin(outer)])
    inner = np.deg2rad(np.linspace(270.0, 90.0, 30))
    hollow = np.column_stack([2.32 + 4.92 * np.cos(inner), 4.92 * np.sin(inner)])
    sickle = plate(np.vstack([rim, hollow]), 3.0, 1.25)
    nose = chain([(-2.9, 0, 0.9), (-1.9, 0, 0.2)], [0.75, 0.75], steps=1).blended(0.5)
    lips = [ellipsoid([-2.45, 0, z], [0.55, 0.8, 0.36]).blended(0.2) for z in (-1.1, -1.85)]
    chin = ellipsoid([-1.9, 0, -3.0], [0.7, 0.8, 0.6]).blended(0.5)
    eyes = pair(ellipsoid([-3.6, 1.35, 1.5], [0.62, 0.4, 0.42]).blended(0.1))
    return [sickle, nose, *lips, chin, *eyes]


def seal() -> list[Part]:
    """Seal resting on its belly with the head raised, flippers spread, tail flippers apart."""
    body = chain(
        [(4.2, 0, 6.2), (3.2, 0, 3.6), (0.0, 0, 2.6), (-3.6, 0, 1.8), (-6.4, 0, 1.2)],
        [1.75, 2.35, 2.6, 1.7, 0.8],
    )
    head = ellipsoid([4.9, 0, 7.3], [2.0, 1.75, 1.7]).blended(0.7)
    snout = ellipsoid([6.6, 0, 6.9], [1.0, 0.95, 0.75]).blended(0.5)
    nose = ellipsoid([7.5, 0, 7.2], 0.35).blended(0.1)
    eyes = pair(ellipsoid([5.9, 1.15, 8.0], 0.4).blended(0.1))
    flippers = pair(
        ellipsoid([0, 1.7, 0], [1.1, 2.2, 0.45])
        .turned([1, 0, 0], -24.0).turned([0, 0, 1], 28.0).moved([2.2, 1.7, 1.6]).blended(0.5)
    )  # fmt: skip
    tail = pair(
        ellipsoid([-1.3, 0, 0], [1.7, 0.75, 0.4])
        .turned([0, 0, 1], -32.0).moved([-6.5, 0.25, 1.1]).blended(0.4)
    )  # fmt: skip
    return [body, head, snout, nose, *eyes, *flippers, *tail]


def star() -> list[Part]:
    """Five-pointed star, thick in the middle, falling off towards its points."""
    outline = _star(5, 6.0, 2.75)
    flat = plate(outline, 2.0, 0.6)

    def distance(p: Floats) -> Floats:
        # A pyramid over the star: half thickness grows with the way from the outline.
        across = flat.distance(p * [1.0, 0.0, 1.0])
        lean = (np.abs(p[..., 1]) - 0.75 + 0.52 * np.maximum(across, -2.6)) / 1.13
        return np.asarray(np.maximum(across, lean) + 0.25 * np.exp(-((across - lean) ** 2) / 0.3))

    thicker = np.array([0.0, 1.5, 0.0])
    return [Part(distance, flat.low - thicker, flat.high + thicker)]


def _star(points: int, outer: float, inner: float) -> Floats:
    turn = np.pi / 2 + np.arange(2 * points) * np.pi / points
    reach = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    return np.asarray(reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]))
