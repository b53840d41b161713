"""Which way a hand's pads face each other best over all the openings at which they are used.

P13 4.7.1 solves the opposition once, in the hand's widest opening, and moves thumb and fingers by
equal angles from there. On a hand whose thumb is no mirror image of its fingers the pads then pass
each other long before they meet. Here the same few numbers are chosen for the whole way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from medkit.geometry import Floats
from medkit.grasping.pad_ways import (
    SAMPLES,
    PadWays,
    grip_directions,
    opposing_fingers,
    pad_ways,
)
from medkit.robots.hand import Hand

#: Opening of the preshape over the diameter of the sphere (P13 5.1.6: k = 2 in 4.30).
OPENING_FACTOR = 2.0
#: Friction [1] at which the line between opposed pads has to lie in their cones (P13 5.1.3).
FRICTION = 0.5
#: How much better than the published opposition another one has to be, as a share of the use [1].
GAIN = 0.01
#: Samples of the common way of thumb and fingers.
STEPS = 60
#: First grid: tilts of the grip axis, bends of middle joints as shares of their room, late starts
#: as shares of the first joint's room, and how much faster one side moves than the other.
TILTS = np.deg2rad(np.linspace(-80.0, 80.0, 65))
BENDS = np.array([0.0, 0.25, 0.5, 0.75])
LATE = np.array([0.1, 0.2, 0.3])
RATIOS = np.exp(np.linspace(-np.log(3.0), np.log(3.0), 11))
#: Times that the grid is laid anew around the best point, three times finer each time.
ZOOMS = 3


@dataclass(frozen=True)
class PadSetting:
    """The numbers that decide how pads come together.

    Attributes
    ----------
    tilt : float
        Turn of grip axis and approach about the hand's closing axis, from the palm [rad].
    bends : tuple of float
        Bend of the thumb's and the fingers' joints between the first and the last, as a share
        of the room from the preshape to the limit [1].
    late : tuple of float
        Where the first joints of thumb and fingers begin, as such a share [1].
    ratio : float
        How much faster the fingers' first joints move than the thumb's [1].
    """

    tilt: float
    bends: tuple[float, float] = (0.0, 0.0)
    late: tuple[float, float] = (0.0, 0.0)
    ratio: float = 1.0


def best_setting(hand: Hand, q: Floats) -> PadSetting:
    """Choose how the pads of a hand come together: as published, unless they pass each other.

    The setting of P13 4.7.1 has equal speeds, no bends and nothing late, and its tilt makes the
    pads face each other at the widest opening. Another one is taken when its share of use, see
    `use_shares`, is larger by more than `GAIN`.

    Parameters
    ----------
    hand : Hand
        Any hand with a thumb and opposing fingers.
    q : ndarray, shape (nq,)
        The preshape to start from [rad or m].

    Returns
    -------
    PadSetting
        The setting.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> hand = load_hand("wsg50")
    >>> best_setting(hand, hand.preshapes["precision"])
    PadSetting(tilt=0.0, bends=(0.0, 0.0), late=(0.0, 0.0), ratio=1.0)
    """
    published = PadSetting(_published_tilt(hand, q))
    none = (np.zeros(1), np.zeros(1))
    usual, _ = _best_of(hand, q, np.array([published.tilt]), none, [(0.0, 0.0)], np.ones(1))
    middle = [len(finger.joints) > 2 for finger in opposing_fingers(hand)]
    bends = [BENDS if has else BENDS[:1] for has in (middle[0], any(middle[1:]))]
    # To start both late would only lose the widest openings.
    late = [(0.0, 0.0), *((x, 0.0) for x in LATE), *((0.0, x) for x in LATE)]
    share, best = _best_of(hand, q, TILTS, bends, late, RATIOS)
    for zoom in range(1, ZOOMS + 1):
        around = np.linspace(-1.0, 1.0, 5) / 3.0 ** (zoom - 1)
        near = np.clip([bend + 0.125 * around for bend in best.bends], 0.0, 1.0)
        bends = [near[k] if len(bends[k]) > 1 else bends[k] for k in (0, 1)]
        side = 0 if best.late[0] > 0.0 else 1
        shift = np.unique(np.clip(best.late[side] + 0.05 * around, 0.0, 1.0))
        late = [(x, 0.0) if side == 0 else (0.0, x) for x in shift]
        tilts = best.tilt + np.deg2rad(2.5) * around
        ratios = best.ratio * np.exp(0.11 * around)
        share, best = _best_of(hand, q, tilts, bends, late, ratios)
    return best if share > usual + GAIN else published


def use_shares(
    thumb: PadWays, fingers: list[PadWays], late: Floats, ratios: Floats, largest: float
) -> Floats:
    """How much of its use a grip opposes its pads in, for many settings at once.

    A ball of radius r is met at an opening of 2 k r and held at 2 r, so the grips of all balls up
    to the largest pass each opening in its measure. Of an opening counts 1 less the square of the
    tangent of the angle by which the pads miss each other and less the pads' skewness, at least 0;
    openings that are not reached count nothing.

    Parameters
    ----------
    thumb : PadWays
        The thumb.
    fingers : list of PadWays
        The fingers that oppose it, sampled at the same tilts.
    late, ratios : ndarray, shape (c, 2), (c,)
        See `PadSetting`.
    largest : float
        Radius of the largest ball [m].

    Returns
    -------
    ndarray, shape (t, c)
        Shares between 0 and 1 [1].
    """
    speeds = side_speeds(ratios)
    ends = thumb.travel[-1], max(way.travel[-1] for way in fingers)
    begins = late * np.array(ends)
    amounts = np.linspace(0.0, 1.0, STEPS) * np.max((ends - begins) / speeds, axis=1)[:, None]
    own = [begins[:, [k]] + speeds[:, [k]] * amounts for k in (0, 1)]
    each = np.array([_along(way, own[1]) for way in fingers])
    sides = [_along(thumb, own[0]), each.mean(axis=0)]
    opening, miss, _ = sides[1] - sides[0]
    # A finger that lags behind the others must still be able to come as near as they are.
    nearest = each[:, 0].min(axis=3).max(axis=0)
    reached = nearest[..., None] <= sides[1][0]
    closing = np.diff(opening, axis=2, prepend=np.inf) < -1e-9
    kept = np.logical_and.accumulate(closing & (opening > 0.0) & reached, axis=2)
    askew = np.maximum(sides[0][2], sides[1][2])
    steep = miss / np.maximum(FRICTION * opening, 1e-6)
    good = 1.0 - np.minimum(steep**2 + askew, 1.0)
    # Measure of the radii r with 2 r < opening < 2 k r; its integral is (k - 1) largest^2.
    radii = np.minimum(largest, 0.5 * opening) - 0.5 * opening / OPENING_FACTOR
    value = np.where(kept, good * np.maximum(radii, 0.0), 0.0)
    widths = -np.diff(opening, axis=2) * kept[..., 1:]
    held = np.sum(0.5 * (value[..., 1:] + value[..., :-1]) * widths, axis=2)
    return np.asarray(held / ((OPENING_FACTOR - 1.0) * largest**2))


def side_speeds(ratios: Floats) -> Floats:
    """Speeds of thumb and fingers (c, 2) for `ratios` (c,): the faster one's is 1 [1]."""
    return np.stack([np.minimum(1.0, 1.0 / ratios), np.minimum(1.0, ratios)], axis=1)


def _best_of(
    hand: Hand,
    q: Floats,
    tilts: Floats,
    bends: Sequence[Floats],
    late: Sequence[tuple[float, float]],
    ratios: Floats,
) -> tuple[float, PadSetting]:
    """The setting of largest share in a grid, and that share."""
    axes, approaches = grip_directions(hand, q, tilts)
    count = len(opposing_fingers(hand))
    thumbs = {bend: pad_ways(hand, q, 0, axes, approaches, bend) for bend in bends[0]}
    others = {
        bend: [pad_ways(hand, q, row, axes, approaches, bend) for row in range(1, count)]
        for bend in bends[1]
    }
    pairs = list(product(late, ratios))
    begins, speeds = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    best, share = PadSetting(float(tilts[0])), -1.0
    for one, other in product(thumbs, others):
        found = use_shares(thumbs[one], others[other], begins, speeds, hand.max_sphere_radius)
        t, c = np.unravel_index(int(np.argmax(found)), found.shape)
        if found[t, c] > share:
            share = float(found[t, c])
            start = (float(begins[c, 0]), float(begins[c, 1]))
            bent = (float(one), float(other))
            best = PadSetting(float(tilts[t]), bent, start, float(speeds[c]))
    return share, best


def _published_tilt(hand: Hand, q: Floats) -> float:
    """Tilt at which the thumb's pad faces the middle of the fingers' at the widest opening."""
    axes, approaches = grip_directions(hand, q, TILTS)
    rows = range(len(opposing_fingers(hand)))
    thumb, *others = (pad_ways(hand, q, row, axes, approaches, 0.0).deep[:, 0] for row in rows)
    return _root(TILTS, np.mean(others, axis=0) - thumb)


def _root(at: Floats, values: Floats) -> float:
    """Where a sampled function is zero, nearest to the middle; its least size without a root."""
    cross = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    if len(cross) == 0:
        flat = np.flatnonzero(np.abs(values) <= np.abs(values).min() + 1e-9)
        return float(at[flat[np.argmin(np.abs(at[flat]))]])
    k = cross[np.argmin(np.abs(at[cross]))]
    return float(at[k] - values[k] * (at[k + 1] - at[k]) / (values[k + 1] - values[k]))


def _along(way: PadWays, travel: Floats) -> Floats:
    """Place along, depth and skewness (3, t, ...) where the first joint has come to `travel`."""
    place = np.clip(travel / max(way.travel[-1], 1e-12), 0.0, 1.0) * (SAMPLES - 1)
    k = np.minimum(place.astype(np.int64), SAMPLES - 2)
    share = place - k
    values = np.stack([way.along, way.deep, way.askew])
    return np.asarray(values[:, :, k] * (1.0 - share) + values[:, :, k + 1] * share)
