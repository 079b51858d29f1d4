"""Loops and couplings of trees: rows that vanish, as their algorithms take them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ...codegen.algorithms.trees.loops import AXIS, CLOSES, COUPLES, FREE
from ...codegen.algorithms.trees.motion_records import IN_BALL, PLAIN, Loop, LoopRow
from ...mechanics.joints.freedoms import Freedoms
from ...mechanics.system import System
from .spanning_tree import SpanningTree

Array = NDArray[Any]
#: All rotations are forbidden.
ALL = 2.0
#: Of a loop's largest row, one that is less wherever the tree goes says nothing.
NOTHING = 1e-9
#: Positions of a tree at which this is tried.
TRIALS = 3


@dataclass
class LoopParameters:
    """Rows of loops and couplings.

    Attributes
    ----------
    loops : array (size, loops, k)
    rows : array (rows, k)
    places : integer array (rows, 8)
        See `LoopRow`.
    firsts : integer array (rows,)
        First row that each has to do with.
    """

    loops: Array
    rows: Array
    places: Array
    firsts: Array


def loop_parameters(system: System, tree: SpanningTree, origin: Array, length: float) -> LoopParameters | str:
    """Rows of a system's loops and couplings; or the reason why they are none.

    Parameters
    ----------
    origin : array (size, 3)
        Of the world in which links move.
    length : float
        What counts as a radian.
    """
    ranges, trials = tree.ranges(), [_Trial(tree, seed) for seed in range(TRIALS if tree.cuts else 0)]
    number = {name: i for i, name in enumerate(system.bodies)} | {system.fixed: -1}
    loops, found = Loop.zeros(len(origin), len(tree.cuts)), list[tuple[list[int], Array]]()
    for i, index in enumerate(tree.cuts):
        joint, freedoms = system.joints[index], system.freedoms[index]
        assert freedoms is not None
        rows = _forbidden(freedoms, length)
        if rows is None:
            return f"{joint.label} closes a loop"
        a, b = (-1 if number[name] < 0 else int(tree.carriers[number[name]]) for name in (joint.a, joint.b))
        loop = loops[:, i]
        loop.point, loop.other_point = (
            freedoms.position - (origin if link < 0 else tree.positions[link]) for link in (a, b)
        )
        turning = freedoms.axes[freedoms.turns]
        loop.rotations = FREE if freedoms.is_ball else AXIS if len(turning) else ALL
        loop.axis = turning[0] if len(turning) else 0.0
        rows = _telling(rows, np.hstack([trial.powers(rows, freedoms.position, a, b) for trial in trials]))
        found += [([CLOSES, a, b, i, *_ranges(ranges, a, b)], row) for row in rows]
    for coupling in system.couplings:
        row = _coupling(system, tree, ranges, coupling)
        if isinstance(row, str):
            return row
        found.append(row)
    found.sort(key=lambda each: (min(each[0][4], each[0][6]) if each[0][7] else each[0][4], each[0][4:]))
    places = np.array([each[0] for each in found], np.int64).reshape(-1, 8)
    rows = LoopRow.zeros(len(found))
    numbers = np.array([each[1] for each in found]).reshape(-1, 6)
    rows.angular, rows.linear = numbers[:, :3], numbers[:, 3:]
    return LoopParameters(np.asarray(loops), np.asarray(rows), places, _envelope(places))


def _forbidden(freedoms: Freedoms, length: float) -> Array | None:
    """Rates (m, 6), angular and linear, that a joint forbids, in radians and lengths that count as one."""
    turning, sliding = freedoms.axes[freedoms.turns], freedoms.axes[~freedoms.turns]
    if len(turning) == 2 or freedoms.pitch:
        return None
    linear = _across(sliding) / length
    angular = np.zeros((0, 3)) if freedoms.is_ball else _across(turning)
    return np.vstack([np.hstack([0 * linear, linear]), np.hstack([angular, 0 * angular])])


def _across(axes: Array) -> Array:
    """Directions (3 - k, 3) across axes (k, 3)."""
    if not len(axes):
        return np.eye(3)
    return np.asarray(np.linalg.svd(axes)[2][len(axes) :])


def _ranges(ranges: Array, a: int, b: int) -> list[int]:
    """Ranges of what two links hang together with, the second one empty if they are one."""
    own, other = ([0, 0] if link < 0 else ranges[link].tolist() for link in (a, b))
    return [*own, *([0, 0] if own == other else other)]


def _coupling(
    system: System, tree: SpanningTree, ranges: Array, coupling: Any
) -> tuple[list[int], Array] | str:
    """The row of a coupling of one or two speeds."""
    terms = list[tuple[int, float]]()
    for (index, freedom), factor in coupling.items():
        joint = tree.of_joint(index)
        label = system.joints[index].label
        if joint is None:
            return f"{label} closes a loop, and is coupled"
        if joint.freedoms.is_ball:
            return f"{label} is coupled, and turns about a point"
        # of a joint in a mechanism rotations come first
        turns = joint.freedoms.turns[::-1] if joint.is_reversed else joint.freedoms.turns
        order = [*np.flatnonzero(turns), *np.flatnonzero(~turns)]
        at = int(order[freedom])
        terms.append((joint.first + (len(turns) - 1 - at if joint.is_reversed else at), float(factor)))
    if len(terms) > 2:
        return "a coupling is of more than two joints"
    (a, first), (b, second) = terms if len(terms) == 2 else (*terms, (-1, 0.0))
    return [COUPLES, a, b, 0, *_ranges(ranges, a, b)], np.array([first, second, 0, 0, 0, 0])


def _envelope(places: Array) -> Array:
    """The first row whose links hang together with each row's."""
    firsts = np.arange(len(places))
    by_root: dict[int, int] = {}
    for i, place in enumerate(places.tolist()):
        for first, last in (place[4:6], place[6:8]):
            if last > first:
                firsts[i] = min(firsts[i], by_root.setdefault(first, i))
    return firsts


def _telling(rows: Array, powers: Array) -> Array:
    """Combinations of rows that say something anywhere: all, or fewer, as of a loop whose joints are parallel."""
    combinations, sizes, _ = np.linalg.svd(powers)
    rank = int((sizes > NOTHING * sizes.max(initial=0)).sum())
    return rows if rank == len(rows) else np.asarray(combinations[:, :rank].T @ rows)


class _Trial:
    """Poses of all links at coordinates by chance, and what rows say about the speeds there."""

    def __init__(self, tree: SpanningTree, seed: int) -> None:
        rng, n = np.random.default_rng(seed), tree.count
        self.tree, self.turns, self.positions = tree, np.empty((n, 3, 3)), np.empty((n, 3))
        reach = np.ptp(tree.positions, axis=0).max() or 1.0
        for j, parent in enumerate(tree.parents.tolist()):
            turn, place = (np.eye(3), np.zeros(3)) if parent < 0 else (self.turns[parent], self.positions[parent])
            offset = tree.positions[j] - (tree.positions[parent] if parent >= 0 else 0.0)
            x, axis = rng.uniform(-1, 1), tree.axes[j]
            own = np.eye(3)
            if tree.balls[j] >= 0:
                own = Rotation.from_rotvec(rng.uniform(-1, 1, 3)).as_matrix()
            elif tree.balls[j] != IN_BALL and tree.turns[j]:
                own = Rotation.from_rotvec(x * axis).as_matrix()
            elif tree.balls[j] == PLAIN:
                offset = offset + x * reach * axis
            self.turns[j], self.positions[j] = turn @ own, place + turn @ offset

    def powers(self, rows: Array, position: Array, a: int, b: int) -> Array:
        """Rates of rows (m, n') for unit speeds of the joints between two links."""
        turn = self.turns[a] if a >= 0 else np.eye(3)
        place = position if b < 0 else self.positions[b] + self.turns[b] @ (position - self.tree.positions[b])
        angular, linear = rows[:, :3] @ turn.T, rows[:, 3:] @ turn.T
        columns = list[Array]()
        paths = [self._path(link) for link in (a, b)]
        for j in sorted(set(paths[0]) ^ set(paths[1])):
            axis = self.turns[j] @ self.tree.axes[j]
            if self.tree.turns[j]:
                columns.append(angular @ axis + linear @ np.cross(axis, place - self.positions[j]))
            else:
                columns.append(linear @ axis)
        return np.stack(columns, -1) if columns else np.zeros((len(rows), 0))

    def _path(self, link: int) -> list[int]:
        path = []
        while link >= 0:
            path.append(link)
            link = int(self.tree.parents[link])
        return path
