"""Recipes for the large bodies: glasses, ant, chair, fish, bird, figure, bust, amphora, giraffe.

Counterparts of P13's object set 1, about 80 cm long. Lengths in centimetres; x points forwards,
y to the side, z up; `medkit.datasets.objects` scales to the stated size.
"""

from __future__ import annotations

from medkit.datasets.implicit import (
    Part,
    box,
    chain,
    ellipsoid,
    lathe,
    pair,
    plate,
    profile_through,
    torus,
)  # fmt: skip


def glasses() -> list[Part]:
    """Frame of round spectacles: two rims, bridge, nose pads, bent temples."""
    rims = pair(torus([0, 18.5, 0], [1, 0, 0], 14.5, 1.7))
    bridge = chain([(0.4, -5.5, 4.5), (1.6, 0, 7.0), (0.4, 5.5, 4.5)], 1.6).blended(1.5)
    pads = pair(ellipsoid([-2.2, 5.0, -2.5], [2.2, 1.1, 2.6]).blended(1.2))
    hinges = pair(chain([(0, 32.0, 4.0), (-1.0, 36.5, 5.0)], 2.0, steps=1).blended(1.5))
    temples = pair(
        chain(
            [(-1, 36.5, 5), (-25, 36.8, 5.5), (-50, 36, 5), (-61, 35, 1), (-69, 34, -9)],
            [1.9, 1.6, 1.6, 1.9, 1.9],
        ).blended(1.2)
    )  # fmt: skip
    return [*rims, bridge, *pads, *hinges, *temples]


def ant() -> list[Part]:
    """Ant: head, thorax, egg-shaped abdomen, six bent legs, antennae, jaws."""
    abdomen = ellipsoid([-22, 0, 21], [15.5, 10.5, 10.0])
    thorax = chain([(-5.0, 0, 19.5), (6, 0, 21)], [4.6, 5.6], steps=1).blended(2.0)
    waist = chain([(-9, 0, 20), (-5, 0, 20)], 3.2, steps=1).blended(2.0)
    head = ellipsoid([17.5, 0, 23], [8.0, 7.5, 6.8]).blended(2.0)
    legs = []
    for root, knee, foot in [(6.5, 13, 27), (1.5, 2, 3), (-3.5, -9, -24)]:
        reach = 27.0 if root != 1.5 else 31.0
        legs += pair(
            chain(
                [
                    (root, 4, 19),
                    (knee * 0.9, 15, 30),
                    (foot, reach, 9),
                    (foot * 1.12, reach + 5, 0),
                ],
                [2.5, 2.1, 1.7, 1.4],
            ).blended(1.2)
        )
    feelers = pair(chain([(22, 3.5, 27), (30, 8, 37), (41, 11, 36)], [1.7, 1.5, 1.3]).blended(1.0))
    jaws = pair(chain([(23, 3, 20), (28, 3.6, 18), (30.5, 0.9, 17)], [1.9, 1.5, 0.9]).blended(0.8))
    eyes = pair(ellipsoid([20.5, 6.0, 25.5], [2.2, 1.6, 2.2]).blended(0.4))
    return [abdomen, waist, thorax, head, *legs, *feelers, *jaws, *eyes]


def chair() -> list[Part]:
    """Kitchen chair: seat, four legs with stretchers, a back of two posts and three slats."""
    seat = box([0, 0, 38], [18.5, 18.5, 1.8], 1.2)
    front = pair(chain([(15.5, 15.5, 38), (16.5, 16.5, 1.8)], [2.1, 1.7], steps=1))
    back = pair(chain([(-17.5, 16.2, 1.8), (-15.8, 15.6, 38), (-21.5, 15.6, 78)], [1.7, 2.1, 1.7]))
    sides = pair(chain([(16, 16, 16), (-16.8, 16, 16)], 1.3, steps=1))
    cross = chain([(-0.4, -16, 16), (-0.4, 16, 16)], 1.3, steps=1)
    slats = [
        chain([(x, -15.6, z), (x - 2.0, 0, z), (x, 15.6, z)], 1.25).blended(0.4)
        for x, z in [(-17.2, 51), (-18.8, 61), (-20.6, 72)]
    ]
    return [seat, *[part.blended(0.8) for part in (*front, *back, *sides, cross)], *slats]


def fish_large() -> list[Part]:
    """Slender fish of prey: pointed snout, sickle tail, three fins above and below."""
    body = chain(
        [(38, 0, 0.5), (28, 0, 0.5), (10, 0, 0), (-10, 0, 0), (-28, 0, 0.5), (-36, 0, 1)],
        [2.2, 6.0, 10.2, 8.8, 3.6, 2.2],
        flatten=0.72,
    )
    tail = plate(
        [(-34, 2.4), (-45, 15), (-48.5, 17), (-42.5, 1), (-47, -13), (-43.5, -12), (-34, -0.6)],
        3.2, 1.4,
    ).blended(1.8)  # fmt: skip
    back = plate([(11, 8), (2, 19), (-2.5, 20), (-5, 7)], 3.2, 1.4).blended(1.5)
    rear = plate([(-17, 5), (-22.5, 11), (-25, 11.4), (-24, 3)], 2.6, 1.1).blended(1.2)
    under = plate([(-16, -5), (-21.5, -11), (-24, -11.3), (-23, -3)], 2.6, 1.1).blended(1.2)
    fins = pair(
        ellipsoid([-6.0, 0, 0], [8.0, 1.5, 3.2])
        .turned([0, 0, 1], -42.0).turned([1, 0, 0], -22.0).moved([15, 5.5, -4]).blended(1.2)
    )  # fmt: skip
    eyes = pair(ellipsoid([28.5, 3.5, 2.6], 1.5).blended(0.3))
    mouth = ellipsoid([38, 0, -1.6], [7.0, 6.0, 0.7]).carved(0.6)
    return [body, tail, back, rear, under, *fins, *eyes, mouth]


def bird() -> list[Part]:
    """Gliding bird: spread wings with bent tips, fanned tail, beak, tucked feet."""
    body = chain([(17, 0, 3.0), (8, 0, 0.5), (-4, 0, 0), (-15, 0, 1.5)], [4.0, 6.0, 5.6, 2.6])
    head = ellipsoid([21, 0, 5.0], [5.2, 4.2, 4.2]).blended(1.5)
    beak = chain([(25, 0, 4.6), (31.5, 0, 3.2)], [2.1, 0.8], steps=1).blended(0.8)
    wing = [
        (12, 3), (14.5, 14), (12, 26), (5, 36), (-3, 42), (-4, 40), (-3.5, 35),
        (-6.5, 33), (-5.8, 28), (-9, 25), (-7.5, 18), (-9, 12), (-6, 3),
    ]  # fmt: skip
    # The plate stands in the x-z plane; laid down, its height becomes the span.
    sheet = plate(wing, 2.9, 1.4).turned([1, 0, 0], -90.0).turned([1, 0, 0], 12.0)
    wings = pair(sheet.moved([0, 0, 2.0]).blended(2.0))
    fan = [(-12, 2.5), (-26, 9.5), (-29, 5.5), (-29.5, 0), (-29, -5.5), (-26, -9.5), (-12, -2.5)]
    tail = plate(fan, 2.7, 1.3).turned([1, 0, 0], 90.0).moved([0, 0, 1.8]).blended(1.5)
    feet = pair(chain([(-5, 2.4, -4), (-10, 2.6, -6.5), (-15, 2.4, -6.2)], 1.2).blended(0.6))
    eyes = pair(ellipsoid([23, 3.4, 6.2], 1.0).blended(0.2))
    return [body, head, beak, *wings, tail, *feet, *eyes]


def figure() -> list[Part]:
    """Toy monster: broad chest, bent arms with claws, horns, short legs, a thick tail."""
    chest = ellipsoid([0, 0, 47], [9.5, 15.0, 11.0])
    belly = ellipsoid([1.0, 0, 34], [8.5, 11.0, 9.5]).blended(4.0)
    head = ellipsoid([4.0, 0, 62], [7.0, 7.0, 6.6]).blended(2.5)
    jaw = ellipsoid([8.5, 0, 58.5], [4.5, 5.4, 3.4]).blended(1.5)
    horns = pair(
        chain([(2.5, 5.0, 66), (1.5, 10, 70), (3.0, 11.5, 76)], [2.3, 1.9, 0.9]).blended(0.8)
    )
    eyes = pair(ellipsoid([9.8, 3.0, 63.5], 1.5).blended(0.3))
    arms = pair(
        chain([(0, 14, 52), (-1, 22, 46), (3, 27, 37), (13, 27, 35)], [5.2, 4.2, 3.5, 3.2]).blended(
            2.0
        )
    )
    fists = pair(ellipsoid([17, 26.5, 35.5], [4.4, 3.8, 4.2]).blended(1.0))
    claws = [
        claw
        for y in (24.2, 26.6, 29.0)
        for claw in pair(
            chain([(20, y, 36), (24, y, 35.5), (25.5, y, 32.5)], [1.5, 1.2, 0.7]).blended(0.4)
        )
    ]
    legs = pair(chain([(0, 6.5, 30), (3.5, 9.5, 18), (0, 10, 5)], [6.6, 5.2, 4.2]).blended(2.0))
    feet = pair(ellipsoid([4.5, 10.5, 3.2], [8.8, 5.2, 3.2]).blended(1.0))
    tail = chain(
        [(-6, 0, 30), (-14, 0, 20), (-24, 0, 12), (-35, 0, 11)], [6.0, 4.6, 3.2, 1.6]
    ).blended(2.0)
    spikes = [
        chain([(x, 0, z), (x - 4.5, 0, z + 3.5)], [2.4, 0.7], steps=1).blended(0.6)
        for x, z in [(-3.0, 64), (-8.5, 54), (-9.2, 44), (-8.5, 35)]
    ]
    return [
        chest,
        belly,
        head,
        jaw,
        *horns,
        *eyes,
        *arms,
        *fists,
        *claws,
        *legs,
        *feet,
        tail,
        *spikes,
    ]


def bust() -> list[Part]:
    """Bust on a foot: shoulders, neck, a face, and a hat with a wide brim."""
    foot = lathe(profile_through([(0.0, 17.5), (2.5, 18.0), (5.0, 16.0), (7.5, 10.0), (12.0, 9.0)]))
    torso = ellipsoid([0, 0, 24], [13.0, 25.0, 13.5]).blended(3.0)
    cut = box([0, 0, -2], [40, 40, 2.0]).carved()
    neck = chain([(0, 0, 33), (1.5, 0, 45)], [8.0, 7.2], steps=1).blended(4.0)
    head = ellipsoid([2.0, 0, 53.5], [11.5, 9.8, 13.0]).blended(2.0)
    chin = ellipsoid([9.0, 0, 44.5], [4.8, 5.0, 3.8]).blended(2.5)
    nose = chain([(12.5, 0, 56), (15.6, 0, 51.5)], [1.5, 2.2], steps=1).blended(1.2)
    lips = ellipsoid([12.7, 0, 47.6], [1.8, 3.4, 1.1]).blended(0.6)
    sockets = pair(ellipsoid([14.0, 4.4, 56.0], [3.2, 2.4, 1.9]).carved(1.2))
    eyes = pair(ellipsoid([10.8, 4.3, 55.8], [1.9, 1.8, 1.5]).blended(0.3))
    ears = pair(ellipsoid([0.5, 10.0, 53.0], [2.6, 1.6, 4.0]).blended(0.8))
    brim = lathe(
        [(0.0, 0.0), (21.0, -0.6), (24.2, 0.4), (25.0, 1.6), (24.2, 2.7), (12.0, 2.6), (0.0, 2.6)]
    )
    brim = brim.turned([0, 1, 0], 5.0).moved([1.0, 0, 61.0])
    crown = lathe(profile_through([(60.5, 12.3), (66, 12.6), (74, 11.2), (78, 8.5), (79.5, 5)]))
    return [
        foot, torso, cut, neck, head, chin, *sockets, *eyes, nose, lips, *ears,
        brim.blended(0.8), crown.moved([0.6, 0, 0]).blended(1.5),
    ]  # fmt: skip


def amphora() -> list[Part]:
    """Amphora: foot, egg-shaped belly, narrow neck, flared lip, two high handles."""
    belly = lathe(
        profile_through(
            [
                (0.0, 8.5), (2.0, 9.2), (4.5, 6.0), (7.0, 5.0), (14, 10.0), (28, 18.0), (40, 20.5),
                (49, 17.5), (55, 10.5), (60, 7.2), (70, 6.4), (75, 7.4), (78, 10.6), (80, 11.2),
            ],
            fine=70,
        )
    )  # fmt: skip
    mouth = lathe(profile_through([(58.0, 3.4), (70.0, 4.2), (76.0, 5.4), (84.0, 10.5)]))
    handles = pair(
        chain(
            [(0, 15.0, 48), (0, 22.0, 55), (0, 22.5, 65), (0, 16.5, 72.5), (0, 6.5, 72.0)], 2.1
        ).blended(1.5)
    )
    return [belly, *handles, mouth.carved(1.0)]


def teapot() -> list[Part]:
    """Closed teapot with spout, handle and knob, as tall as the bodies of the large set."""
    body = lathe(
        profile_through(
            [
                (0.0, 0.17), (0.012, 0.185), (0.05, 0.225), (0.13, 0.262), (0.22, 0.255),
                (0.29, 0.215), (0.335, 0.16), (0.345, 0.155),
            ]
        )
    )  # fmt: skip
    lid = lathe(profile_through([(0.32, 0.15), (0.36, 0.14), (0.385, 0.09), (0.398, 0.028)]))
    knob = ellipsoid([0.0, 0.0, 0.425], [0.034, 0.034, 0.030])
    stem = chain([(0, 0, 0.385), (0, 0, 0.42)], 0.016, steps=1)
    spout = chain(
        [
            (0.215, 0, 0.085),
            (0.31, 0, 0.125),
            (0.365, 0, 0.225),
            (0.405, 0, 0.315),
            (0.44, 0, 0.350),
        ],
        [0.062, 0.048, 0.034, 0.026, 0.025],
    )
    hole = chain([(0.425, 0, 0.342), (0.462, 0, 0.366)], [0.014, 0.019], steps=1)
    handle = chain(
        [
            (-0.20, 0, 0.285), (-0.29, 0, 0.315), (-0.365, 0, 0.285), (-0.385, 0, 0.215),
            (-0.355, 0, 0.135), (-0.29, 0, 0.085), (-0.225, 0, 0.075),
        ],
        [0.022, 0.021, 0.021, 0.021, 0.021, 0.021, 0.022],
    )  # fmt: skip
    return [
        body, lid, stem.blended(0.012), knob.blended(0.012),
        spout.blended(0.03), hole.carved(0.004), handle.blended(0.03),
    ]  # fmt: skip


def giraffe() -> list[Part]:
    """Giraffe: long rising neck, short horns, thin legs with hooves, a tufted tail."""
    trunk = chain([(-11, 0, 40), (-3, 0, 41), (6, 0, 44)], [6.4, 7.0, 7.2])
    neck = chain([(7, 0, 45), (13, 0, 57), (18, 0, 71)], [5.6, 3.8, 3.1]).blended(3.0)
    head = chain([(17, 0, 74.5), (23, 0, 73), (28.5, 0, 70.5)], [3.6, 3.0, 2.2]).blended(1.5)
    horns = pair(chain([(16.5, 1.7, 76), (15.8, 2.4, 81)], [1.1, 1.1], steps=1).blended(0.6))
    knobs = pair(ellipsoid([15.8, 2.4, 81.4], 1.5).blended(0.3))
    ears = pair(chain([(15.2, 2.6, 75.5), (13.4, 7.0, 76.5)], [1.4, 0.8], steps=1).blended(0.6))
    front = pair(
        chain([(6.5, 3.6, 40), (6.8, 4.0, 22), (6.6, 4.0, 3)], [3.6, 2.1, 1.8]).blended(1.8)
    )
    hind = pair(
        chain(
            [(-12, 3.6, 39), (-10.5, 4.0, 28), (-13, 4.0, 17), (-12, 4.0, 3)], [4.4, 2.8, 2.0, 1.8]
        ).blended(1.8)
    )
    hooves = [
        *pair(ellipsoid([7.3, 4.0, 1.6], [3.0, 2.3, 1.7]).blended(0.6)),
        *pair(ellipsoid([-11.3, 4.0, 1.6], [3.0, 2.3, 1.7]).blended(0.6)),
    ]
    tail = chain([(-16.5, 0, 43), (-20.5, 0, 37), (-20.8, 0, 28)], [1.4, 1.2, 1.5]).blended(0.8)
    return [trunk, neck, head, *horns, *knobs, *ears, *front, *hind, *hooves, tail]
