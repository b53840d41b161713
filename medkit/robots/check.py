"""What a look at a hand description finds before anything is planned with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from medkit.geometry import Floats
from medkit.robots.hand import Finger, Hand
from medkit.robots.self_collision import SelfCollision

OK, NOTE, PROBLEM = "ok", "note", "problem"


@dataclass(frozen=True)
class Finding:
    """One result: `level` (ok, note or problem), `topic`, and a sentence."""

    level: str
    topic: str
    text: str


def check_hand(hand: Hand) -> list[Finding]:
    """Check a hand for the mistakes that descriptions are prone to.

    Parameters
    ----------
    hand : Hand
        The hand.

    Returns
    -------
    list of Finding
        In a fixed order. A hand with a problem cannot be planned with as it is meant.

    Examples
    --------
    >>> from medkit.robots import load_hand
    >>> {finding.level for finding in check_hand(load_hand("wsg50"))}
    {'ok'}
    """
    checks = (_directions, _limits, _size, _bodies, _closing, _opposition, _couplings, _preshapes)
    return [finding for check in checks for finding in check(hand)]


def _finding(good: bool, topic: str, text: str, otherwise: str = PROBLEM) -> Finding:
    return Finding(OK if good else otherwise, topic, text)


def _directions(hand: Hand) -> Iterator[Finding]:
    cosine = float(abs(hand.palm_direction @ hand.closing_axis))
    angle = float(np.degrees(np.arccos(min(cosine, 1.0))))
    yield _finding(
        angle > 85.0,
        "directions",
        f"palm direction and closing axis stand at {angle:.1f} degrees"
        + ("" if angle > 85.0 else "; they have to be at right angles"),
    )


def _limits(hand: Hand) -> Iterator[Finding]:
    sliding = hand.prismatic_joints
    revolute = np.array([name not in sliding for name in hand.joint_names])
    odd = [
        name
        for name, limit, turns in zip(hand.joint_names, hand.limits, revolute, strict=True)
        if np.abs(limit).max() > (2.1 * np.pi if turns else 1.0)
    ]
    if odd:
        text = (
            f"{', '.join(odd)}: beyond a whole turn or a metre; degrees or millimetres taken for"
            " radians or metres?"
        )
        yield Finding(PROBLEM, "limits", text)
    elif revolute.any() and np.ptp(hand.limits[revolute], axis=1).max() < 0.1:
        yield Finding(NOTE, "limits", "no joint turns by 6 degrees; radians taken for degrees?")
    else:
        yield Finding(OK, "limits", f"{len(hand.joint_names)} joints within a turn or a metre")


def _size(hand: Hand) -> Iterator[Finding]:
    tips = np.array(list(hand.fingertips(hand.preshapes["power"]).values()))
    reach = float(np.linalg.norm(tips, axis=1).max())
    good = 0.03 < reach < 1.0
    advice = "" if good else "; check the unit of length"
    yield _finding(good, "reach", f"fingertips up to {1000 * reach:.0f} mm from the base{advice}")
    low, high = hand.sphere_radii
    good = 0.0 <= low < high < reach
    yield _finding(
        good,
        "ball size",
        f"holds balls of radius {1000 * low:.0f} to {1000 * high:.0f} mm"
        + ("" if good else "; give smallest before largest, and less than the reach"),
    )


def _bodies(hand: Hand) -> Iterator[Finding]:
    for finger in hand.fingers:
        bodies = [body for body in hand.bodies if body.link == finger.tip_link]
        if not bodies:
            name = hand.link_names[finger.tip_link]
            text = f"{finger.name}: its tip link {name} has no body, so it cannot touch"
            yield Finding(NOTE, "pads", text)
            continue
        reaches = [((b.vertices - finger.tip_point) @ finger.tip_normal).max() for b in bodies]
        gap = 1000 * float(max(reaches))
        good = abs(gap) < 3.0
        where = "inside" if gap > 0 else "off"
        text = "on the surface" if good else f"{abs(gap):.1f} mm {where} the body along its normal"
        yield _finding(good, "pads", f"{finger.name}: pad {text}", NOTE)


def _pad(hand: Hand, finger: Finger, q: Floats) -> tuple[Floats, Floats]:
    return hand.pads(q)[finger.name]


def _closing(hand: Hand) -> Iterator[Finding]:
    for finger in hand.fingers:
        q = hand.preshapes["power"].copy()
        limits = hand.limits[finger.joints]
        q[finger.joints] += 0.3 * (np.where(finger.closing > 0, *limits.T[::-1]) - q[finger.joints])
        step = q.copy()
        step[finger.joints] += 1e-3 * finger.closing
        before, normal = _pad(hand, finger, q)
        move = _pad(hand, finger, step)[0] - before
        length = float(np.linalg.norm(move))
        leads = length > 0.0 and float(move @ normal) > 0.2 * length
        text = f"{finger.name}: closing moves the pad" + (
            " ahead" if leads else " sideways or backwards; check 'closing' and 'tip_normal'"
        )
        yield _finding(leads, "closing", text)


def _opposition(hand: Hand) -> Iterator[Finding]:
    opened = hand.preshapes["power"]
    half = opened.copy()
    for finger in hand.fingers:
        limits = hand.limits[finger.joints]
        goal = np.where(finger.closing > 0, *limits.T[::-1])
        start = opened[finger.joints]
        half[finger.joints] = start + 0.35 * (goal - start)  # fingers may share a joint
    wide, narrow = _opening(hand, opened), _opening(hand, half)
    text = f"pads {1000 * wide:.0f} mm apart open, {1000 * narrow:.0f} mm when a third closed"
    good = narrow < wide
    yield _finding(good, "opposition", text if good else f"{text}; thumb does not oppose")


def _opening(hand: Hand, q: Floats) -> float:
    pads = [point for point, _ in hand.pads(q).values()]
    others = np.mean([pads[k] for k in hand.opposition.fingers], axis=0)
    return float(np.linalg.norm(pads[hand.opposition.thumb] - others))


def _couplings(hand: Hand) -> Iterator[Finding]:
    moving = hand.tree.coordinate[hand.tree.coordinate >= 0]
    coupled = len(moving) - len(np.unique(moving))
    plain = len(hand.joint_names) == len(np.unique(moving))
    yield _finding(plain, "couplings", f"{coupled} joints follow another one")


def _preshapes(hand: Hand) -> Iterator[Finding]:
    check = SelfCollision(hand)
    for name, q in hand.preshapes.items():
        pairs = check.touching(q)
        names = [
            " with ".join(hand.link_names[hand.bodies[body].link] for body in pair)
            for pair in pairs[:3]
        ]
        text = "links touch: " + ", ".join(names) if names else "no link touches another"
        yield _finding(not names, f"preshape {name}", text)


def closed_configuration(hand: Hand, steps: int = 60) -> Floats:
    """Joint coordinates (nq,) after closing finger by finger, its joints alike, until links touch.

    Parameters
    ----------
    hand : Hand
        The hand, closed from its power preshape; nothing is in it.
    steps : int
        Steps from limit to limit.

    Returns
    -------
    ndarray, shape (nq,)
        A fist, for pictures [rad or m].
    """
    check = SelfCollision(hand)
    q = hand.preshapes["power"].copy()
    for finger in hand.fingers[1:] + hand.fingers[:1]:
        start = q[finger.joints]
        goal = np.where(finger.closing > 0, *hand.limits[finger.joints].T[::-1])
        for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
            trial = q.copy()
            trial[finger.joints] = start + share * (goal - start)
            if check.collides(trial):
                break
            q = trial
    return q
