"""Exact medial axis of polygons: one envelope per site, put together to a graph of arcs."""

from __future__ import annotations

from dataclasses import dataclass

import networkx as nx
import numpy as np
from scipy.spatial import cKDTree

from medkit.geometry import Floats
from medkit.planar.disks import Ints, MedialAxis, angle_between, node_disk
from medkit.planar.envelope import (
    TINY,
    Sites,
    lower_envelope,
    seen_from_corner,
    seen_from_edge,
    sites_from_outline,
)
from medkit.planar.outlines import Outline

#: Ends of arcs closer than this, relative to the outline's size, are one node.
SAME_NODE = 1e-7


@dataclass(frozen=True)
class Arcs:
    """Pieces of bisectors, straight or parabolic, each seen from one of its two sites.

    Attributes
    ----------
    site, partner : ndarray of int, shape (k,)
        Site numbers; see :class:`medkit.planar.envelope.Sites`.
    begin, end : ndarray, shape (k,)
        Interval of the site's parameter: place on the edge, or tan(theta / 2) at a corner.
    """

    site: Ints
    partner: Ints
    begin: Floats
    end: Floats


def voronoi_arcs(sites: Sites, *, both_sides: bool = False) -> Arcs:
    """Arcs of the medial axis of an outline of size one.

    Parameters
    ----------
    sites : Sites
        Edges and reflex corners.
    both_sides : bool
        Return every arc twice, once as seen from each of its two sites.

    Returns
    -------
    Arcs
        All arcs; the spokes between a corner and its own edges are not part of the axis.
    """
    found: list[tuple[int, int, float, float]] = []
    for i in range(sites.n + len(sites.corners)):
        if i < sites.n:
            pieces = lower_envelope(seen_from_edge(sites, i), 0.0, float(sites.lengths[i]))
        else:
            limit = float(np.tan(sites.cone_widths[i - sites.n] / 4))
            pieces = lower_envelope(seen_from_corner(sites, i - sites.n), -limit, limit)
        found += [(i, j, a, b) for a, b, j in pieces if both_sides or i < j]
    table = np.array(found, dtype=float).reshape(-1, 4)
    return Arcs(
        table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2], table[:, 3]
    )


def disks_on_arcs(sites: Sites, site: Ints, partner: Ints, at: Floats) -> tuple[Floats, ...]:
    """Centre, radius and both touch points of the disk of `site` at parameter `at`.

    Returns
    -------
    centers : ndarray, shape (n, 2)
        Centres, in sizes of the outline, as everything here.
    radii : ndarray, shape (n,)
        Radii.
    touches : ndarray, shape (n, 2, 2)
        Touch points on site and partner.
    """
    edge = site < sites.n
    e, k = np.where(edge, site, 0), np.where(edge, 0, site - sites.n)
    corners = sites.corners if len(sites.corners) else np.zeros((1, 2))
    middles = sites.cone_middles if len(sites.corners) else np.zeros(1)
    theta = middles[k] + 2 * np.arctan(at)
    push = np.where(
        edge[:, None], sites.normals[e], np.column_stack([np.cos(theta), np.sin(theta)])
    )
    first = np.where(edge[:, None], sites.starts[e] + at[:, None] * sites.tangents[e], corners[k])
    straight = partner < sites.n
    e2, k2 = np.where(straight, partner, 0), np.where(straight, 0, partner - sites.n)
    depth = ((first - sites.starts[e2]) * sites.normals[e2]).sum(axis=1)
    gap = corners[k2] - first
    with np.errstate(divide="ignore", invalid="ignore"):
        to_line = depth / (0.5 * ((push - sites.normals[e2]) ** 2).sum(axis=1))
        to_point = (gap**2).sum(axis=1) / (2.0 * (gap * push).sum(axis=1))
    to_line = np.where(edge & straight, _from_corner(sites, e, e2, at, to_line), to_line)
    radii = np.maximum(np.where(straight, to_line, to_point), 0.0)
    centers = first + radii[:, None] * push
    foot = centers - radii[:, None] * sites.normals[e2]
    second = np.where(straight[:, None], foot, corners[k2])
    return centers, radii, np.stack([first, second], axis=1)


def _from_corner(sites: Sites, first: Ints, second: Ints, at: Floats, general: Floats) -> Floats:
    """Radii between neighbouring edges, measured from their corner; `general` for other pairs."""
    ahead, behind = sites.after[first] == second, sites.after[second] == first
    reach = np.where(ahead, sites.lengths[first] - at, at)
    bend = np.where(ahead, sites.bends[first], sites.bends[second])
    known = (ahead | behind) & (bend > TINY)
    slope = np.tan(np.where(known, bend, 1.0) / 2)
    return np.asarray(np.where(known, reach / slope, general))


def polygon_medial_axis(outline: Outline, spacing: float) -> MedialAxis:
    """Medial axis of a polygon; see :func:`medkit.planar.medial.medial_axis`."""
    size, origin = outline.characteristic_length, outline.center_mass
    unit = Outline(tuple((loop - origin) / size for loop in outline.loops))
    sites = sites_from_outline(unit)
    arcs = voronoi_arcs(sites)
    ends = [disks_on_arcs(sites, arcs.site, arcs.partner, at) for at in (arcs.begin, arcs.end)]
    arc_nodes, node_centers = _merge(np.vstack([ends[0][0], ends[1][0]]))
    tiny = arc_nodes[:, 0] == arc_nodes[:, 1]
    chains, branch_nodes, used = _chains(arc_nodes, ~tiny)
    sampled = _sample(sites, arcs, chains, spacing / size)
    nodes = _nodes(node_centers, used, arc_nodes, ends)
    centers = np.vstack([sampled[0], nodes[0]])
    renumber = np.full(len(node_centers), -1)
    renumber[used] = np.arange(len(used))
    return MedialAxis(
        outline, centers * size + origin, np.concatenate([sampled[1], nodes[1]]) * size,
        np.concatenate([sampled[2], nodes[2]]),
        np.concatenate([sampled[3], nodes[3]]) * size + origin,
        np.concatenate([sampled[4], nodes[4]]) * size,
        np.concatenate([sampled[5], np.full(len(nodes[1]), -1)]).astype(np.int64),
        node_centers[used] * size + origin, nodes[5] * size, renumber[branch_nodes],
    )  # fmt: skip


def _merge(points: Floats) -> tuple[Ints, Floats]:
    """Number the ends of arcs so that ends in the same place share a number."""
    graph: nx.Graph = nx.Graph()
    graph.add_nodes_from(range(len(points)))
    graph.add_edges_from(cKDTree(points).query_pairs(SAME_NODE))
    label = np.zeros(len(points), dtype=np.int64)
    groups = [sorted(group) for group in nx.connected_components(graph)]
    for number, group in enumerate(sorted(groups)):
        label[group] = number
    centers = np.array([points[group].mean(axis=0) for group in sorted(groups)])
    return label.reshape(2, -1).T, centers


def _chains(arc_nodes: Ints, keep: np.ndarray) -> tuple[list[list[tuple[int, bool]]], Ints, Ints]:
    """Join arcs through nodes of degree two; return chains of (arc, forward), ends, nodes."""
    at: dict[int, list[tuple[int, int]]] = {}
    for arc in np.flatnonzero(keep).tolist():
        for side in (0, 1):
            at.setdefault(int(arc_nodes[arc, side]), []).append((int(arc), side))
    stops = [node for node in sorted(at) if len(at[node]) != 2]
    loose = sorted(at)
    done: set[int] = set()
    chains: list[list[tuple[int, bool]]] = []
    ends = []
    for start in stops + loose:
        for first, first_side in at[start]:
            arc, side = first, first_side
            if arc in done or (start not in stops and len(done) == int(keep.sum())):
                continue
            chain: list[tuple[int, bool]] = []
            node = start
            while arc not in done:
                done.add(arc)
                chain.append((arc, side == 0))
                node = int(arc_nodes[arc, 1 - side])
                following = [pair for pair in at[node] if pair[0] not in done]
                if node in stops or not following:
                    break
                arc, side = following[0]
            chains.append(chain)
            ends.append((start, node))
    pairs: Ints = np.array(ends, dtype=np.int64).reshape(-1, 2)
    return chains, pairs, np.asarray(np.unique(pairs), dtype=np.int64)


def _sample(
    sites: Sites, arcs: Arcs, chains: list[list[tuple[int, bool]]], spacing: float
) -> tuple[Floats, ...]:
    arc_of, at, branch = [], [], []
    for number, chain in enumerate(chains):
        for arc, forward in chain:
            index = np.full(9, arc)
            probe = np.linspace(arcs.begin[arc], arcs.end[arc], 9)
            curve = disks_on_arcs(sites, arcs.site[index], arcs.partner[index], probe)[0]
            length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
            count = max(1, int(np.ceil(length[-1] / spacing)))
            share = (np.arange(count) + 0.5) / count * length[-1]
            places = np.interp(share, length, probe)
            at.append(places if forward else places[::-1])
            arc_of.append(np.full(count, arc))
            branch.append(np.full(count, number))
    index, where = np.concatenate(arc_of), np.concatenate(at)
    centers, radii, touches = disks_on_arcs(sites, arcs.site[index], arcs.partner[index], where)
    spokes = touches - centers[:, None]
    angles = angle_between(spokes[:, 0], spokes[:, 1])
    return centers, radii, angles, touches, radii * np.sin(angles / 2), np.concatenate(branch)


def _nodes(
    node_centers: Floats, used: Ints, arc_nodes: Ints, ends: list[tuple[Floats, ...]]
) -> tuple[Floats, ...]:
    """Disks at the nodes of positive radius, and the radii of all nodes."""
    rows, all_radii = [], []
    labels = np.concatenate([arc_nodes[:, 0], arc_nodes[:, 1]])
    radii = np.concatenate([ends[0][1], ends[1][1]])
    touches = np.concatenate([ends[0][2], ends[1][2]])
    for node in used:
        member = labels == node
        radius = float(radii[member].mean())
        all_radii.append(radius if radius > SAME_NODE else 0.0)
        if radius > SAME_NODE:
            spokes = touches[member].reshape(-1, 2)
            rows.append((node_centers[node], radius, *node_disk(node_centers[node], spokes)))
    return (
        np.array([row[0] for row in rows]).reshape(-1, 2), np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows]), np.array([row[3] for row in rows]).reshape(-1, 2, 2),
        np.array([row[4] for row in rows]), np.array(all_radii),
    )  # fmt: skip
