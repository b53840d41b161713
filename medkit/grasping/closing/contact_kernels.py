"""Compiled contacts: where bodies of the closed hand lie on the object's faces."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from medkit.grasping.closing.body_kernels import apart, clip_to_body, to_link
from medkit.grasping.closing.kernel_options import inner
from medkit.grasping.closing.sight_kernels import height_over
from medkit.grasping.closing.tree_kernels import collect_faces

#: Columns of a row: point (3), inward normal (3), body, gap, face, squared distance to the rows
#: of the same body that are taken.
COLUMNS = 10
#: Most candidate points kept of one body before the choice.
SPOTS = 4096
#: How far [m] a contact is drawn from the border of its face towards the middle of the patch.
NUDGE = 2e-5
#: Gaps [m] this close count as equal when the deepest contact is chosen.
TIE = 1e-5


class Reading(NamedTuple):
    """What counts as a contact, see `hand_contacts`, and room for candidates and contacts."""

    wanted: np.ndarray
    tolerance: float
    separation: float
    least: float
    most: int
    spots: np.ndarray
    contacts: np.ndarray


@inner
def _gap_and_alignment(
    field: Any, hand: Any, face: int, pose: np.ndarray, p: np.ndarray, active: int, work: Any
) -> tuple[float, float]:
    """Height [m] of a point of a link over its body, and how far both surfaces oppose (cosine)."""
    top, best = -1e9, 0
    for e in range(active):
        f = work.clip.active[e]
        height = height_over(hand.hulls.planes, f, p[0], p[1], p[2])
        if height > top:
            top, best = height, f
    cosine = 0.0
    for a in range(3):
        turned = 0.0
        for b in range(3):
            turned += pose[a, b] * hand.hulls.planes[best, b]
        cosine -= turned * field.normals[face, a]
    return top, cosine


@inner
def _spots_of_face(
    field: Any,
    hand: Any,
    body: int,
    face: int,
    tolerance: float,
    least: float,
    spots: np.ndarray,
    count: int,
    work: Any,
) -> int:
    """Append corners and middle of a face's part within `tolerance` [m] of a body to `spots`."""
    pose = work.poses[hand.body_link[body]]
    clip = work.clip
    to_link(pose, field.triangles[face], clip.local)
    if apart(hand.hulls, body, tolerance, clip.local):
        return count
    corners = clip_to_body(hand.hulls, body, tolerance, clip)
    if corners == 0:
        return count
    active = clip.active_count[0]
    middle, p = clip.local[0], clip.local[1]
    for a in range(3):
        middle[a] = 0.0
        for v in range(corners):
            middle[a] += clip.polygon[v, a] / corners
    for v in range(corners + 1):
        if count >= len(spots) or active == 0:
            break
        length = 0.0
        for a in range(3):
            p[a] = clip.polygon[v, a] if v < corners else middle[a]
            length += (p[a] - middle[a]) ** 2
        inwards = min(0.05, NUDGE / max(np.sqrt(length), 1e-9))
        for a in range(3):
            p[a] += inwards * (middle[a] - p[a])
        gap, cosine = _gap_and_alignment(field, hand, face, pose, p, active, work)
        if cosine < least or gap > tolerance:
            continue
        for a in range(3):
            spots[count, a] = pose[a, 3]
            for b in range(3):
                spots[count, a] += pose[a, b] * p[b]
            spots[count, 3 + a] = -field.normals[face, a]
        spots[count, 6] = body
        spots[count, 7] = gap
        spots[count, 8] = face
        count += 1
    return count


@inner
def _deepest(spots: np.ndarray, count: int, pose: np.ndarray) -> int:
    """The spot of least gap; among equals the one furthest along a fixed skew direction."""
    least = 1e9
    for s in range(count):
        least = min(least, spots[s, 7])
    best, furthest = 0, -1e9
    for s in range(count):
        if spots[s, 7] > least + TIE:
            continue
        along = 0.0
        for a in range(3):
            skew = 0.83 * pose[a, 0] + 0.47 * pose[a, 1] + 0.31 * pose[a, 2]
            along += skew * spots[s, a]
        if along > furthest:
            best, furthest = s, along
    return best


@inner
def _spots_of_body(
    field: Any,
    hand: Any,
    body: int,
    tolerance: float,
    least: float,
    spots: np.ndarray,
    work: Any,
) -> int:
    """Fill `spots` with all that a body may touch; how many."""
    pose = work.poses[hand.body_link[body]]
    count: Any = np.int64(0)  # a plain 0 would compile the callee twice
    for e in range(collect_faces(field.tree, hand.hulls, body, pose, tolerance, work)):
        face = work.faces[e]
        if (
            field.normals[face, 0] != 0.0
            or field.normals[face, 1] != 0.0
            or field.normals[face, 2] != 0.0
        ):
            count = _spots_of_face(field, hand, body, face, tolerance, least, spots, count, work)
    return count


@inner
def _furthest_from(spots: np.ndarray, count: int, taken: int) -> int:
    """Take the spot `taken`; the one that is now furthest from all taken."""
    best, widest = 0, -1.0
    for s in range(count):
        squared = 0.0
        for a in range(3):
            squared += (spots[s, a] - spots[taken, a]) ** 2
        spots[s, 9] = min(spots[s, 9], squared)
        if spots[s, 9] > widest:
            best, widest = s, spots[s, 9]
    return best


@inner
def hand_contacts(field: Any, hand: Any, reading: Any, work: Any) -> int:
    """Contacts of a closed hand as rows of ``reading.contacts``; how many.

    Of every body: the face part within ``tolerance`` [m] whose outward normal opposes the body's
    own by at least the cosine ``least``; of it the deepest point, then each time the point
    furthest from those taken, while it keeps ``separation`` [m], at most ``most`` of a body.
    Expects the links placed in `work.poses`, and `work.slack` as these poses leave it.
    """
    spots, contacts, total = reading.spots, reading.contacts, 0
    for body in range(hand.body_link.shape[0]):
        if not reading.wanted[body] or work.slack[body] > reading.tolerance:
            continue
        count = _spots_of_body(field, hand, body, reading.tolerance, reading.least, spots, work)
        if count == 0:
            continue
        for s in range(count):
            spots[s, 9] = 1e9
        chosen = _deepest(spots, count, work.poses[hand.body_link[body]])
        first = total
        while total - first < reading.most and spots[chosen, 9] >= reading.separation**2:
            for c in range(COLUMNS):
                contacts[total, c] = spots[chosen, c]
            total += 1
            chosen = _furthest_from(spots, count, chosen)
    return total
