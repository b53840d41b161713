"""A hand as the closing kernels take it: planes, surface samples and lever arms of its bodies."""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from medkit.geometry import Floats, unit
from medkit.grasping.closing.closing_steps import closing_steps, starts
from medkit.grasping.closing.hull_tables import HullTable, hull_table, least_width
from medkit.grasping.closing.self_kernels import least_gap
from medkit.grasping.closing.sight_kernels import sight
from medkit.grasping.closing.surface_table import SurfaceTable, surface_table
from medkit.robots.digest import hand_digest
from medkit.robots.hand import Hand, LinkBody

Ints = NDArray[np.int64]

#: Longest sweep of a body [m], and its share of the body's least width, of which the end alone is
#: tested against the object: so that nothing is jumped over.
WINDOW, WIDTH_SHARE = 0.008, 0.6
#: Pairs of bodies that never come closer than this in the probed configurations are dropped [m].
NEVER_NEAR, PROBES = 0.0015, 400


#: Arrays taken over from the kinematic tree.
TREE = ("parent", "placement", "axis", "kind", "coordinate", "multiplier", "offset")


class ClosingHand(NamedTuple):
    """A hand prepared for closing (arrays only, so that kernels take it).

    The first seven arrays are those of `KinematicTree`. Body b has its planes in ``hulls``, the
    least ``width`` [m], the ``window`` that it is swept at once [m] and samples of its ``surface``.
    Of closing step k: coordinate ``joint[k]`` moves with ``closing[k]``, and with it the links
    ``moved_link`` and the bodies ``moved_body``, whose points travel at most ``lever`` [m/rad or
    1] per unit.
    """

    parent: Ints
    placement: Floats
    axis: Floats
    kind: Ints
    coordinate: Ints
    multiplier: Floats
    offset: Floats
    body_link: Ints
    hulls: HullTable
    ball_center: Floats
    ball_radius: Floats
    width: Floats
    window: Floats
    surface: SurfaceTable
    partner_start: Ints
    partner: Ints
    limits: Floats
    preshape: Floats
    joint: Ints
    closing: Floats
    moved_link_start: Ints
    moved_link: Ints
    moved_body_start: Ints
    moved_body: Ints
    lever: Floats


def closing_hand(
    hand: Hand, *, preshape: str = "power", finger_order: tuple[str, ...] | None = None
) -> ClosingHand:
    """Prepare a hand for closing finger by finger, joint by joint from palm to tip (P13 4.6.2).

    Parameters
    ----------
    hand : Hand
        The hand.
    preshape : str
        Preshape from which it closes.
    finger_order : tuple of str, optional
        Names of the fingers in the order in which they close; the hand's own when left out.

    Returns
    -------
    ClosingHand
        Arrays for the kernels.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> len(closing_hand(load_hand("armar3")).joint)
    10
    """
    tables = hand_tables(hand)
    steps: dict[str, Any] = closing_steps(hand, finger_order)
    shape = np.array(hand.preshapes[preshape], dtype=float)
    built = tables.arrays._replace(preshape=shape, **steps)
    start, partner = _partners(hand, built, tables.near)
    return built._replace(partner_start=start, partner=partner)


class HandTables(NamedTuple):
    """What closing knows of a hand in any preshape and order of fingers.

    ``arrays`` has neither partners nor steps; the bodies of the pairs ``near`` (p, 2) come near
    each other in some configuration.
    """

    arrays: ClosingHand
    near: Ints


#: Tables of this many hands are kept, those asked for last; those of one take about a megabyte.
KEPT = 4
_KEPT: dict[str, HandTables] = {}


def hand_tables(hand: Hand) -> HandTables:
    """Tables of a hand, the caller's own, built once per process for hands of the same numbers.

    Looked up by `hand_digest`, since a hand may be changed under its own name.
    """
    name = hand_digest(hand)
    tables = _KEPT.pop(name, None) or _built_tables(hand)
    _KEPT[name] = tables  # now the last
    for old in list(_KEPT)[:-KEPT]:
        _KEPT.pop(old, None)
    own: HandTables = _copied(tables)  # kernels ask for writable arrays, so nothing guards these
    return own


def _copied(table: Any) -> Any:
    """A named tuple, of which no array is shared."""
    return table._make(one.copy() if isinstance(one, np.ndarray) else _copied(one) for one in table)


def _built_tables(hand: Hand) -> HandTables:
    hulls = hull_table([body.vertices for body in hand.bodies])
    width = np.array([_width(hulls, row, body) for row, body in enumerate(hand.bodies)])
    none, nowhere = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    bare = ClosingHand(
        **{name: getattr(hand.tree, name) for name in TREE},
        body_link=np.array([body.link for body in hand.bodies], dtype=np.int64),
        hulls=hulls,
        ball_center=np.array([_box_center(body) for body in hand.bodies]),
        ball_radius=np.array([_reach(body, _box_center(body)) for body in hand.bodies]),
        width=width,
        window=np.minimum(WINDOW, WIDTH_SHARE * width),
        surface=surface_table(hand.bodies),
        partner_start=nowhere,
        partner=none,
        limits=np.array(hand.limits, dtype=float),
        preshape=np.zeros(len(hand.limits)),
        joint=none,
        closing=np.zeros(0),
        moved_link_start=nowhere,
        moved_link=none,
        moved_body_start=nowhere,
        moved_body=none,
        lever=np.zeros(0),
    )
    arrays = _copied(bare)  # the tree's may be read-only, for which kernels are not compiled
    return HandTables(arrays, _near_pairs(hand, arrays))


def _box_center(body: LinkBody) -> Floats:
    return np.asarray(0.5 * (body.vertices.min(axis=0) + body.vertices.max(axis=0)))


def _reach(body: LinkBody, point: Floats) -> float:
    return float(np.linalg.norm(body.vertices - point, axis=1).max())


def _width(hulls: HullTable, row: int, body: LinkBody) -> float:
    planes = hulls.planes[hulls.plane_start[row] : hulls.plane_start[row + 1]]
    return least_width(planes, body.vertices)


def _near_pairs(hand: Hand, built: ClosingHand) -> Ints:
    """Bodies that may run into each other, from configurations spread over the joint limits."""
    spread = halton(PROBES, len(hand.limits))
    configurations = hand.limits[:, 0] + spread * (hand.limits[:, 1] - hand.limits[:, 0])
    poses = hand.tree.link_poses(configurations)
    scratch = sight()
    near = [
        (int(a), int(b))
        for a, b in hand.self_collision_pairs
        if least_gap(built, a, b, poses, NEVER_NEAR, scratch) < NEVER_NEAR
    ]
    return np.array(near, dtype=np.int64).reshape(-1, 2)


def _partners(hand: Hand, built: ClosingHand, near: Ints) -> tuple[Ints, Ints]:
    """Bodies that each body may run into, of pairs that come near each other."""
    start = hand.tree.link_poses(built.preshape)[None]
    scratch = sight()
    pairs = []
    for a, b in near.tolist():
        if least_gap(built, a, b, start, NEVER_NEAR, scratch) < -1e-4:
            continue  # bodies that overlap in the preshape are drawn that way
        pairs += [(a, b), (b, a)]
    table = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
    counts = np.bincount(table[:, 0], minlength=len(hand.bodies))
    return starts(counts.tolist()), np.ascontiguousarray(table[:, 1])


def halton(count: int, dimension: int) -> Floats:
    """First points (count, dimension) of Halton's sequence in the unit cube, from the origin on.

    Written out, since scipy.stats takes half a second to import.

    Examples
    --------
    >>> halton(4, 2).round(2).tolist()
    [[0.0, 0.0], [0.5, 0.33], [0.25, 0.67], [0.75, 0.11]]
    """
    primes: list[int] = []
    for number in itertools.count(2):
        if len(primes) == dimension:
            break
        if all(number % prime for prime in primes):
            primes.append(number)
    points = np.zeros((count, dimension))
    for column, base in enumerate(primes):
        left, share = np.arange(count), 1.0 / base
        while left.any():
            points[:, column] += share * (left % base)
            left, share = left // base, share / base
    return points


def palm_frame(palm_direction: Floats, closing_axis: Floats) -> Floats:
    """Frame (3, 3) of a hand's palm in its base frame: columns side, closing axis, direction.

    In plain numbers: this runs once a candidate, and numpy takes ten times as long for it.
    """
    forward = _scaled(*palm_direction.tolist())
    x, y, z = closing_axis.tolist()
    side = _scaled(*_cross(x, y, z, *forward))
    return np.array([side, _cross(*forward, *side), forward]).T


def hand_rotation(approach: Floats, closing_axis: Floats, palm: Floats) -> Floats:
    """Rotation that lays the hand's palm direction and closing axis onto a candidate's.

    Parameters
    ----------
    approach, closing_axis : ndarray, shape (3,)
        Directions of the candidate in the object frame; only the part of the closing axis at
        right angles to the approach counts.
    palm : ndarray, shape (3, 3)
        The hand's `palm_frame`.

    Returns
    -------
    ndarray, shape (3, 3)
        ``R_object_hand`` (P13 4.16 to 4.28, with the transpose of the palm matrix).
    """
    return palm_frame(approach, closing_axis) @ palm.T


def _cross(
    a: float, b: float, c: float, d: float, e: float, f: float
) -> tuple[float, float, float]:
    """Cross product of (a, b, c) and (d, e, f)."""
    return b * f - c * e, c * d - a * f, a * e - b * d


def _scaled(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector at length one; `InputError` if it has none."""
    length = math.sqrt(x * x + y * y + z * z)
    if not 0.0 < length < math.inf:
        x, y, z = unit([x, y, z])  # says so
    return x / length, y / length, z / length
