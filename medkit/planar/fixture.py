"""The bench of the squeeze experiments: object, guided fingers and forces in a pymunk space."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pymunk

from medkit.errors import InputError
from medkit.geometry import Floats
from medkit.planar.outlines import Outline, SmoothOutline
from medkit.planar.settings import SqueezeSettings

#: The engine works in lengths of a hundredth of the object's characteristic length.
UNITS = 100.0
#: A smooth curve is as many straight edges for the engine, and a tangent where a finger touches.
SMOOTH_EDGES = 512
TANGENT_HALF = 0.6  # [engine units]
TIP_MASS = 0.2  # [object masses]
OBJECT, FINGER = 1, 2


class Bench:
    """One experiment, ready to step. Lengths in engine units, the object's mass is one."""

    def __init__(self, space: Any, body: Any, fingers: list[Any], drive: Floats,
                 settings: SqueezeSettings) -> None:  # fmt: skip
        self.space, self.body, self.fingers = space, body, fingers
        self.settings = settings
        self.force = settings.squeeze_rate * UNITS
        self.drive = [(float(x), float(y)) for x, y in drive * self.force]
        self.start = self.pose()
        self.middle = self.tip_positions().mean(axis=0)

    def step(self, push: Floats) -> None:
        """Advance by one time step under a push [fx, fy, torque] in squeeze forces."""
        weight = self.settings.gravity_share
        self.body.force = (float(push[0]) * self.force, float(push[1] - weight) * self.force)
        self.body.torque = float(push[2]) * self.force * UNITS
        for finger, way in zip(self.fingers, self.drive, strict=True):
            finger.force = way
        self.space.step(self.settings.step)

    def pose(self) -> Floats:
        """Position [engine units] and angle [rad] of the object's centre of mass."""
        return np.array([*self.body.position, self.body.angle])

    def tip_positions(self) -> Floats:
        """Centres of the fingers, shape (f, 2) [engine units]."""
        return np.array([tuple(finger.position) for finger in self.fingers])

    def motion(self) -> tuple[float, float]:
        """Translation relative to the fingers [characteristic lengths], rotation [rad]."""
        x, y = self.body.position
        count = len(self.fingers)
        mx = sum(finger.position.x for finger in self.fingers) / count - self.middle[0]
        my = sum(finger.position.y for finger in self.fingers) / count - self.middle[1]
        moved = math.hypot(x - self.start[0] - mx, y - self.start[1] - my) / UNITS
        return moved, abs(self.body.angle - float(self.start[2]))

    def touching(self) -> bool:
        """Whether every finger has a contact with the object."""
        return all(self._touches(finger) for finger in self.fingers)

    def _touches(self, finger: Any) -> bool:
        found: list[bool] = []
        finger.each_arbiter(lambda arbiter: found.append(True))
        return bool(found)

    def contact_forces(self) -> Floats:
        """Force of every finger on the object in the last step, shape (f, 2) [squeeze forces]."""
        rows = []
        for finger in self.fingers:
            total = np.zeros(2)

            def add(arbiter: Any, finger: Any = finger, total: Floats = total) -> None:
                sign = 1.0 if arbiter.shapes[0].body is finger else -1.0
                total += sign * np.array(tuple(arbiter.total_impulse))

            finger.each_arbiter(add)
            rows.append(total / (self.settings.step * self.force))
        return np.array(rows)


def build_bench(
    outline: Outline, contacts: Floats, *, friction: float, settings: SqueezeSettings,
    fixture: str, offset: float,
) -> Bench:  # fmt: skip
    """Put object and fingers into a space, just touching."""
    scale = UNITS / outline.characteristic_length
    space = pymunk.Space()
    space.iterations = int(settings.iterations)
    space.collision_slop = settings.slop * UNITS
    points = (contacts - outline.center_mass) * scale
    body = _add_object(space, outline, scale, points)
    chord = points[1] - points[0]
    along = chord / np.linalg.norm(chord)
    side = np.array([-along[1], along[0]])
    places = _places(points, along, side, offset * scale, fixture, settings)
    fingers = []
    for place, share in places:
        way = along if share > 0 else -along
        if fixture == "flat jaws":
            fingers.append(_add_jaw(space, body, place, way, friction, settings))
        else:
            normal = outline.inward_normal_at(place / scale + outline.center_mass)
            fingers.append(_add_tip(space, place, normal, way, friction, settings))
    drive = np.array([share * along for _, share in places])
    return Bench(space, body, fingers, drive, settings)


def _places(
    points: Floats, along: Floats, side: Floats, offset: float, fixture: str,
    settings: SqueezeSettings,
) -> list[tuple[Floats, float]]:  # fmt: skip
    """Where the fingers touch, and their signed share of the squeeze force."""
    if fixture in ("points", "flat jaws"):
        return [(points[0] + offset * side, 1.0), (points[1], -1.0)]
    if fixture == "three fingers":
        apart = 10.0 * settings.tip_radius * UNITS * side
        return [(points[0] + offset * side - apart, 0.5), (points[0] + offset * side + apart, 0.5),
                (points[1], -1.0)]  # fmt: skip
    raise InputError(
        f"Expected fixture 'points', 'flat jaws' or 'three fingers', but got {fixture!r};"
        " choose one of these."
    )


def _add_object(space: Any, outline: Outline, scale: float, points: Floats) -> Any:
    body = pymunk.Body(1.0, moment_of_inertia(outline) * scale**2)
    space.add(body)
    a, b = _edges_near(outline, scale, points)
    for first, last in zip(a, b, strict=True):
        edge = pymunk.Segment(body, tuple(first), tuple(last), 0.0)
        edge.friction = 1.0
        edge.filter = pymunk.ShapeFilter(categories=OBJECT, mask=FINGER)
        space.add(edge)
    return body


def _edges_near(outline: Outline, scale: float, points: Floats) -> tuple[Floats, Floats]:
    """Edges for the engine that lie near the fingers, in engine units."""
    smooth = isinstance(outline, SmoothOutline)
    loop = outline.loops[0]
    if isinstance(outline, SmoothOutline):
        loop = outline.curve(np.arange(SMOOTH_EDGES) * (2 * np.pi / SMOOTH_EDGES))
    starts, ends = (loop, np.roll(loop, -1, axis=0)) if smooth else (outline.starts, outline.ends)
    a, b = ((p - outline.center_mass) * scale for p in (starts, ends))
    middle, reach = (a + b) / 2, np.linalg.norm(b - a, axis=1) / 2
    away = np.linalg.norm(middle[:, None] - points, axis=2).min(axis=1)
    near = away < reach + 0.6 * UNITS
    if not smooth:
        return a[near], b[near]
    # a finger must not rest on the corner between two of our edges: where it touches, the
    # curve is replaced by its tangent
    ends_away = np.linalg.norm(np.stack([a, b])[:, :, None] - points, axis=3).min(axis=(0, 2))
    near &= ends_away > TANGENT_HALF
    normals = np.array([outline.inward_normal_at(p / scale + outline.center_mass) for p in points])
    sides = TANGENT_HALF * np.column_stack([normals[:, 1], -normals[:, 0]])
    return np.vstack([a[near], points - sides]), np.vstack([b[near], points + sides])


def moment_of_inertia(outline: Outline) -> float:
    """Polar moment of inertia about the centre of mass, per mass [m^2]."""
    a, b = outline.starts - outline.center_mass, outline.ends - outline.center_mass
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    square = (a * a + a * b + b * b).sum(axis=1)
    return float((cross * square).sum() / 12.0 / outline.area)


def _guided(space: Any, shape_of: Any, place: Floats, way: Floats, friction: float) -> Any:
    body = pymunk.Body(TIP_MASS, float("inf"))
    body.position = tuple(place)
    shape = shape_of(body)
    shape.friction = friction
    shape.filter = pymunk.ShapeFilter(categories=FINGER, mask=OBJECT)
    ends = [tuple(place + reach * way) for reach in (-4 * UNITS, 4 * UNITS)]
    rail = pymunk.GrooveJoint(space.static_body, body, ends[0], ends[1], (0.0, 0.0))
    space.add(body, shape, rail)
    return body


def _add_tip(
    space: Any, place: Floats, normal: Floats, way: Floats, friction: float,
    settings: SqueezeSettings,
) -> Any:  # fmt: skip
    radius = settings.tip_radius * UNITS
    center = place - (radius - 0.5 * settings.slop * UNITS) * normal
    return _guided(space, lambda body: pymunk.Circle(body, radius), center, way, friction)


def _add_jaw(
    space: Any, target: Any, place: Floats, way: Floats, friction: float,
    settings: SqueezeSettings,
) -> Any:  # fmt: skip
    """A flat jaw, set against the part of the object that it would meet first."""
    half, thick = 0.25 * UNITS, 0.04 * UNITS
    side = np.array([-way[1], way[0]])
    corners = [half * side, -half * side, -half * side - thick * way, half * side - thick * way]
    ends = np.array([[tuple(s.a), tuple(s.b)] for s in target.shapes]) - place
    reach = _first_meeting(ends @ side, ends @ way, half)
    front = place + (reach + 0.5 * settings.slop * UNITS) * way
    return _guided(
        space, lambda body: pymunk.Poly(body, [tuple(c) for c in corners]), front, way, friction
    )


def _first_meeting(across: Floats, ahead: Floats, half: float) -> float:
    """Least advance at which a segment within the jaw's width is met, on the near side only."""
    best = 0.0
    for u, v in zip(across, ahead, strict=True):
        low, high = max(min(u), -half), min(max(u), half)
        if low > high:
            continue
        order = np.argsort(u)
        met = np.interp([low, high], u[order], v[order])
        best = min(best, float(met.min()))
    return best
