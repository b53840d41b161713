"""Plain numpy twins of the medial kernels, and the sampled shapes they are compared on."""

import numpy as np
import pytest
import trimesh

from medkit.grasping import sample_surface
from medkit.medial.axis import MODEST, REACH, SLACK
from medkit.medial.axis_kernels import THIN
from medkit.medial.touch_kernels import SLANTED, STEPS

create = trimesh.creation


def step():
    """A block with a step: convex and reentrant edges."""
    low, high = create.box((0.1, 0.06, 0.03)), create.box((0.05, 0.06, 0.06))
    high.apply_translation([0.025, 0.0, 0.015])
    return trimesh.boolean.union([low, high], engine="manifold")


def bumpy():
    ball = create.icosphere(4, 0.05)
    x, y, z = 120.0 * ball.vertices.T
    height = 1.0 + 0.1 * np.sin(x) * np.sin(y + 1.0) * np.sin(z + 2.0)
    return trimesh.Trimesh(ball.vertices * height[:, None], ball.faces)


SAMPLES = {
    "box": sample_surface(create.box((0.2, 0.1, 0.05)), spacing=0.008),
    "ball": sample_surface(create.icosphere(4, 0.05), spacing=0.006),
    "torus": sample_surface(create.torus(0.08, 0.03), spacing=0.007),
    "step": sample_surface(step(), spacing=0.005),
    "bumpy": sample_surface(bumpy(), spacing=0.005),
    "leaf": sample_surface(create.box((0.1, 0.1, 0.004)), spacing=0.006),
}
each = pytest.mark.parametrize("name", SAMPLES)


def slack_of(sample):
    return max(SLACK * sample.spacing, sample.facet_depth)


def pair_bounds(points, normals, slack):
    """Radius (n, n) of the ball tangent at the row's sample that the column's allows."""
    away = points[:, None] - points[None]
    d2 = np.sum(away**2, axis=2)
    h = np.einsum("ijk,ik->ij", away, normals)
    allowed = np.where(normals @ normals.T > 0.0, slack, np.minimum(slack, THIN * h))
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = (d2 - allowed**2) / (2.0 * (h - allowed))
    return np.where((h > allowed) & (d2 > 0.0), bound, np.inf)


def plain_refine(points, normals, radii, stop, reach):
    refined = np.full(len(points), np.inf)
    two_point = pair_bounds(points, normals, 0.0)
    for i in np.flatnonzero(stop >= 0):
        j = stop[i]
        along = normals[j] @ (points[j] - points[i])
        dot = normals[i] @ normals[j]
        refined[i] = min(radii[i], two_point[i, j])
        if dot >= 0.9:
            continue
        if abs(along) <= 1e-9 * reach:
            refined[i] = 0.0
            continue
        r = along / (1.0 - dot)
        foot = points[i] - r * normals[i] + r * normals[j]
        if 0.0 < r < refined[i] and np.sum((foot - points[j]) ** 2) <= reach**2:
            refined[i] = r
    return refined


def plain_balls(sample, tree):
    """Refined spheres of a sample: centres, radii, own and stopping sample."""
    bound = pair_bounds(tree.points, tree.normals, slack_of(sample))
    stop = np.argmin(bound, axis=1)
    radii = bound[np.arange(len(stop)), stop]
    stop[radii > 0.5 * sample.diagonal] = -1
    radii = plain_refine(tree.points, tree.normals, radii, stop, REACH * sample.spacing)
    own = np.flatnonzero((stop >= 0) & (radii > 0.0))
    centers = tree.points[own] - radii[own, None] * tree.normals[own]
    return centers, radii[own], own, stop[own]


def foot_directions(center, tree, reach):
    """For all samples: whether the foot on its plane counts, distance and unit direction."""
    away = tree.points - center
    d2 = np.sum(away**2, axis=1)
    h = np.einsum("nk,nk->n", away, tree.normals)
    foot = (h > 0.0) & (d2 - h**2 <= reach**2)
    direct = away / np.maximum(np.sqrt(d2), 1e-300)[:, None]
    return foot, np.where(foot, h, np.sqrt(d2)), np.where(foot[:, None], tree.normals, direct)


def plain_touches(center, radius, own, stop, tree, tolerances, reach):
    """Directions to all touches of one sphere; the first two are those it always has."""
    wide = foot_directions(center, tree, max(reach, 0.3 * radius))[2][stop]
    near, direction = sample_touches(center, radius, own, stop, tree, tolerances, reach)
    return np.vstack([[tree.normals[own], wide], direction[near]])


def sample_touches(center, radius, own, stop, tree, tolerances, reach):
    """Which samples touch a sphere (n,), and the directions (n, 3) in which they would."""
    wide = foot_directions(center, tree, max(reach, 0.3 * radius))[2][stop]
    seeds = np.array([tree.normals[own], wide])
    foot, distance, direction = foot_directions(center, tree, reach)
    chord = np.sqrt(np.maximum(0.0, 2.0 - 2.0 * (direction @ seeds.T).max(axis=1)))
    slanted = np.einsum("nk,nk->n", direction, tree.normals) < SLANTED
    near = np.where(
        foot,
        distance <= radius + tolerances[0] * chord,
        slanted & (distance <= radius + tolerances[1]),
    )
    return near & (distance >= radius - 2.0 * tolerances[1]), direction


def plain_angle(touches):
    """Widest from the first direction, widest from that, and so on; from `MODEST` on [rad]."""
    cosine = touches @ touches[0]
    if cosine.min() >= np.cos(MODEST):
        return float(np.arccos(cosine[1]))
    best, partner = cosine.min(), touches[np.argmin(cosine)]
    for _ in range(STEPS - 1):
        cosine = touches @ partner
        if cosine.min() >= best:
            break
        best, partner = cosine.min(), touches[np.argmin(cosine)]
    return float(np.arccos(np.clip(best, -1.0, 1.0)))
