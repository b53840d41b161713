"""Check values of the ARMAR-III hand, in millimetres, from its published joint table."""

import numpy as np
import pytest

from medkit.errors import InputError
from medkit.robots import load_hand

FINGERS = ("thumb", "index", "middle", "ring", "pinky")


def configuration(palm, finger):
    return np.r_[palm, np.full(10, finger)]


CHECKS = {
    (0.0, 0.0): [
        (-147.90, 0.00, 65.25), (-8.70, -13.50, 204.45), (-8.70, 13.50, 204.65),
        (-8.70, 37.50, 197.15), (-8.70, 59.50, 189.65),
    ],
    (0.0, 0.5): [
        (-115.95, 0.00, 134.00), (-77.45, -13.50, 172.50), (-77.45, 13.50, 172.70),
        (-71.14, 37.50, 168.65), (-64.83, 59.50, 164.59),
    ],
    (0.5, 0.0): [
        (-147.90, 0.00, 65.25), (-75.44, -13.50, 187.41), (-75.53, 13.50, 187.59),
        (-71.94, 37.50, 181.00), (-68.34, 59.50, 174.42),
    ],
    (0.3, 0.3): [
        (-135.83, 0.00, 110.33), (-89.34, -13.50, 173.38), (-89.40, 13.50, 173.57),
        (-83.52, 37.50, 168.91), (-77.65, 59.50, 164.25),
    ],
}  # fmt: skip


@pytest.mark.parametrize("pose", CHECKS)
def test_fingertips_are_where_the_table_says(pose):
    tips = load_hand("armar3").fingertips(configuration(*pose))
    np.testing.assert_allclose(
        [1000 * tips[name] for name in FINGERS], CHECKS[pose], atol=0.0051, rtol=0
    )


def test_the_left_hand_is_the_mirror_image():
    right, left = load_hand("armar3"), load_hand("armar3_left")
    q = np.linspace(-0.2, 1.3, 11)
    for name, tip in right.fingertips(q).items():
        np.testing.assert_allclose(left.fingertips(q)[name], tip * [1, -1, 1], atol=1e-12)
    for (_, one), (_, other) in zip(
        right.link_meshes(q).items(), left.link_meshes(q).items(), strict=True
    ):
        np.testing.assert_allclose(other.bounds[:, [0, 2]], one.bounds[:, [0, 2]], atol=1e-9)
        np.testing.assert_allclose(other.bounds[::-1, 1], -one.bounds[:, 1], atol=1e-9)
        assert other.volume == pytest.approx(one.volume)


def test_an_unknown_hand_lists_the_known_ones():
    with pytest.raises(InputError, match=r"armar3, armar3_left.*did you mean 'armar3'"):
        load_hand("armar")
