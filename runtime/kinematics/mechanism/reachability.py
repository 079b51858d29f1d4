"""Poses that a mechanism's lengths forbid, whatever the search finds.

Joints that rotate about a shared point are nodes, and the distance between two nodes of one body is an edge. Known
positions, on the fixed body, on targets and on links of driven joints, are at most the shortest path through the graph
apart. Joints that translate, limits and angles prove nothing here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from ...core.multivector import Multivector
from ...mechanics.joints.base import Joint
from ...mechanics.joints.standard import Revolute, Rigid, Spherical
from ..serial.reachability import REACH_MARGIN
from .structure import Assembly

Array = NDArray[Any]
#: Length of an edge at least: a sparse graph has no edges of length zero.
LEAST = 1e-15


def is_too_far(
    mechanism: Assembly, driven: Mapping[int, Array], aims: Sequence[tuple[int, Any, Array]], count: int
) -> NDArray[np.bool_]:
    """Mask (count,) of the items that provably have no pose with given coordinates of joints (count, f) and targets.

    Targets are (body, point or None, numbers (count, 8 or 3)), in the mechanism's frame.
    """
    known = _prescribed_motors(mechanism, driven, aims, count)
    fixed: list[tuple[int, Array]] = []  # nodes, and places (count, 3) where they must be
    points_of: dict[int, list[tuple[int, Array]]] = {}  # nodes of the other bodies, and their places at the start
    for node, joint in enumerate(mechanism.joints):
        for name, position in zip((joint.a, joint.b), _shared_point(mechanism, joint), strict=False):
            body = mechanism.body_index(name)
            if body in known:
                point = mechanism.algebra.point(position)
                fixed.append((node, np.asarray((known[body] >> point).parameters().xyz)))
            else:
                points_of.setdefault(body, []).append((node, position))
    for node, (body, at, position) in enumerate(aims, len(mechanism.joints)):
        if at is not None and body not in known:
            fixed.append((node, position))
            points_of.setdefault(body, []).append((node, _in_frame(mechanism, at)))
    paths = _shortest(points_of, len(mechanism.joints) + len(aims))
    found = np.zeros(count, bool)
    nodes, positions = [node for node, _ in fixed], np.array([position for _, position in fixed]).reshape(-1, count, 3)
    for node, position in fixed:
        apart, most = np.linalg.norm(positions - position, axis=-1), paths[node, nodes][:, None]
        sizes = np.linalg.norm(positions, axis=-1) + np.linalg.norm(position, axis=-1)
        found |= (apart > most + REACH_MARGIN * (1 + most + sizes)).any(0)
    return found


def _in_frame(mechanism: Assembly, position: Any) -> Array:
    return np.asarray((np.asarray(position, float) - mechanism.frame.center) / mechanism.frame.unit)


def _shared_point(mechanism: Assembly, joint: Joint) -> list[Array]:
    """The shared point of a joint on its first and its second body, in the mechanism's frame; empty if it has none."""
    if not isinstance(joint, (Spherical, Revolute, Rigid)):
        return []
    for condition in joint.conditions():
        found = [_center(x) for x in (condition.x, condition.y)]
        if all(position is not None and np.isfinite(position).all() for position in found):
            return [_in_frame(mechanism, position) for position in found]
    return []


def _center(x: Multivector) -> Any:
    for kind in ("point", "sphere", "circle"):
        if kind in x.algebra.kinds and x.kind.name == kind:
            p = x.parameters()
            return p.xyz if kind == "point" else p.center
    return None


def _prescribed_motors(
    mechanism: Assembly, driven: Mapping[int, Array], aims: Sequence[tuple[int, Any, Array]], count: int
) -> dict[int, Multivector]:
    """Motors (count,) of bodies, in the mechanism's frame, that follow from coordinates and targets."""
    algebra, tree = mechanism.algebra, mechanism.tree
    kind, twists = algebra.kind("motor"), algebra.kind("twist")
    known = {-1: algebra.translator(np.zeros((count, 3))).as_kind("motor")}
    known |= {body: algebra.wrap(kind, np.ascontiguousarray(given)) for body, at, given in aims if at is None}
    for body in tree.order:
        j, parent = tree.joint[body], tree.parent[body]
        if body in known or parent not in known or j not in driven:
            continue
        if any(c.x is not c.y or c.product is not None for c in mechanism.joints[j].conditions()):
            continue  # coordinates of such a joint determine no motion
        relation = mechanism.loops.relations[j]
        way = algebra.wrap(twists, np.ascontiguousarray(driven[j] / relation.speeds @ relation.free.T))
        moved = (-0.5 * tree.sign[body] * way).exp()
        known[body] = (known[parent] * moved).as_kind("motor", check=False)
    return known


def _shortest(points_of: Mapping[int, list[tuple[int, Array]]], size: int) -> Array:
    """Lengths (size, size) of the shortest paths between nodes, through bodies; infinite where there is none."""
    edges = [
        (i, j, max(LEAST, float(np.linalg.norm(p - q))))
        for nodes in points_of.values()
        for k, (i, p) in enumerate(nodes)
        for j, q in nodes[:k]
    ]
    best: dict[tuple[int, int], float] = {}
    for i, j, length in edges:
        best[i, j] = min(length, best.get((i, j), np.inf))
    pairs = np.array(list(best), int).reshape(-1, 2).T
    graph = sparse.csr_array((list(best.values()), (pairs[0], pairs[1])), shape=(size, size))
    return np.asarray(csgraph.shortest_path(graph, directed=False))


__all__ = ["is_too_far"]
