"""Mobility (basis of free motions) and overconstraint (basis of self-stresses) of a mechanism."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag
from scipy.sparse import csgraph

from ...core.multivector import Multivector
from .loop_closure import Block, Loops
from .structure import Assembly

Array = NDArray[Any]
#: Fraction of the largest twist or wrench below which a body is at rest, or a joint is unloaded.
NOISE = 1e-9


@dataclass(frozen=True, eq=False)
class FreeMotion(Mapping[str, "Multivector"]):
    """A motion that all joints allow: twists of bodies by name, in the world.

    Attributes
    ----------
    speeds : array
        Speeds at the joints of the mechanism's tree, in the mechanism's frame.
    driver : str
        The joint or body that names the motion: the coordinate that only this motion of the basis has.
    idle : bool
        True if one body moves alone (a passive degree of freedom), as a rod between two balls spins.
    """

    mechanism: Assembly
    speeds: Array
    driver: str
    idle: bool

    def __getitem__(self, body: str) -> Multivector:
        return self.mechanism.twist_of(body, self.speeds)

    def __iter__(self) -> Iterator[str]:
        return iter(self.mechanism.bodies)

    def __len__(self) -> int:
        return len(self.mechanism.bodies)

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies that move."""
        sizes = np.abs(self.mechanism.loops.twists(self.speeds)).max(-1)
        moving = sizes > NOISE * sizes.max(initial=0)
        return [name for name, moves in zip(self.mechanism.moving, moving, strict=True) if moves]

    def __repr__(self) -> str:
        names = self.bodies
        shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        return f"<FreeMotion: {self.driver} alone>" if self.idle else f"<FreeMotion of {self.driver}: {shown}>"


@dataclass(frozen=True, eq=False)
class SelfStress(Mapping[str, "Multivector"]):
    """Wrenches that joints can bear against each other with no load: a redundant constraint.

    A mapping of joints, by label, to the wrench of the first body on the second, in the world.
    """

    wrenches: dict[str, Multivector]

    def __getitem__(self, joint: str) -> Multivector:
        return self.wrenches[joint]

    def __iter__(self) -> Iterator[str]:
        return iter(self.wrenches)

    def __len__(self) -> int:
        return len(self.wrenches)

    def __repr__(self) -> str:
        return f"<SelfStress: {', '.join(self)}>"


def passive_dof(loops: Loops, tolerance: float) -> list[tuple[int, Array]]:
    """Passive degrees of freedom, where one body moves alone: (body, speeds of the tree)."""
    tree, motions = loops.tree, []
    joints: list[list[int]] = [[] for _ in tree.parent]
    for j, ends in enumerate(tree.ends):
        for b in ends:
            if b >= 0:
                joints[b].append(j)
    children: list[list[int]] = [[] for _ in tree.parent]
    for b in tree.order:
        if tree.parent[b] >= 0:
            children[tree.parent[b]].append(b)
    for b, adjacent in enumerate(joints):
        rows = np.concatenate([loops.relations[j].rows for j in adjacent])
        if len(adjacent) < 2 or len(rows) > 6 * len(adjacent):
            continue
        _, sizes, basis = np.linalg.svd(rows)
        for twist in basis[int((sizes > tolerance * sizes.max(initial=0)).sum()) :]:
            speeds = np.zeros(loops.size)
            for child, sign in ((b, 1), *((c, -1) for c in children[b])):
                at = slice(loops.offsets[child], loops.offsets[child + 1])
                speeds[at] = sign * np.linalg.lstsq(loops.joint_subspace(child), twist, rcond=None)[0]
            if not loops.couplings or np.abs(loops.matrix @ speeds).max() <= tolerance * np.abs(speeds).max():
                motions.append((b, speeds))
    return motions


def free_basis(loops: Loops, split: list[Block], idle: list[Array]) -> list[tuple[int, Array]]:
    """Complement of the passive motions in the space of all motions, one for each independent coordinate, those near
    the fixed body first: (coordinate, speeds)."""
    motions: list[tuple[int, Array]] = []
    for columns, null in _merge_blocks(split, idle):
        passive = [v[columns] for v in idle if np.any(v[columns])]
        if passive:
            basis, _ = np.linalg.qr(np.stack(passive, 1))
            null = null - basis @ (basis.T @ null)
            left, sizes, _ = np.linalg.svd(null, full_matrices=False)
            null = left[:, sizes > 0.5]  # of a projector: ones and zeros
        for column, values in _echelon_basis(null, np.argsort(_depths(loops)[columns], kind="stable")):
            speeds = np.zeros(loops.size)
            speeds[columns] = values
            motions.append((int(columns[column]), speeds))
    return motions


def _merge_blocks(split: list[Block], idle: list[Array]) -> list[tuple[Array, Array]]:
    """Columns and null spaces of blocks, merged where a passive motion couples them."""
    of_column = {int(c): k for k, part in enumerate(split) for c in part.columns}
    links = np.array(
        [(of_column[int(v.nonzero()[0][0])], of_column[int(c)]) for v in idle for c in v.nonzero()[0]], int
    )
    rows, columns = links.reshape(-1, 2).T
    graph = sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(split), len(split)))
    groups: dict[int, list[Block]] = {}
    for part, label in zip(split, csgraph.connected_components(graph, directed=False)[1], strict=True):
        groups.setdefault(int(label), []).append(part)
    return [
        (np.concatenate([p.columns for p in own]), block_diag(*(p.null for p in own)) if len(own) > 1 else own[0].null)
        for own in groups.values()
    ]


def _depths(loops: Loops) -> Array:
    """Depth in the tree of each coordinate's joint."""
    counts = np.diff(loops.offsets)
    return np.repeat(np.array(loops.tree.depth, int), counts)


def _echelon_basis(null: Array, order: Array) -> list[tuple[int, Array]]:
    """Reduced basis of ``null``: one pivot coordinate for each vector, chosen greedily in the given order."""
    pivots: list[int] = []
    rest = null.copy()
    for row in order:
        if len(pivots) == null.shape[1]:
            break
        size = np.linalg.norm(rest[row])
        if size > 1e-3:  # smaller pivots are ill conditioned
            direction = rest[row] / size
            rest = rest - np.outer(rest @ direction, direction)
            pivots.append(int(row))
    if len(pivots) < null.shape[1]:
        return [(int(np.argmax(np.abs(v))), v) for v in null.T]
    basis = null @ np.linalg.inv(null[pivots])
    return list(zip(pivots, basis.T, strict=True))


def self_stresses(loops: Loops, split: list[Block]) -> list[Array]:
    """Basis of the self-stresses: wrenches (joints, 6) of joints, as rows on twists of the second body."""
    stresses = []
    for part in split:
        for values in part.stress.T:
            stress = np.zeros(loops.matrix.shape[0])
            stress[part.rows] = values
            stresses.append(_propagate_self_stress(loops, stress))
    return stresses


def _propagate_self_stress(loops: Loops, stress: Array) -> Array:
    """Wrenches (joints, 6) of all joints that balance a self-stress of the loop joints."""
    tree = loops.tree
    wrenches, net = np.zeros((len(tree.ends), 6)), np.zeros((len(tree.parent), 6))
    for k, j in enumerate(tree.loop_joints):
        wrenches[j] = stress[loops.loop_rows[k] : loops.loop_rows[k + 1]] @ loops.relations[j].rows
    for value, powers in zip(stress[loops.loop_rows[-1] :], loops.coupling_powers, strict=True):
        for j, power in powers.items():
            if j not in tree.child_of:
                wrenches[j] += value * power
    for j in tree.loop_joints:
        for body, sign in zip(tree.ends[j], (-1, 1), strict=True):
            if body >= 0:
                net[body] += sign * wrenches[j]
    through = tree.accumulate_up(net)
    for b, j in enumerate(tree.joint):
        wrenches[j] = -tree.sign[b] * through[b]
    values = stress[loops.loop_rows[-1] :]
    if len(values) and not np.abs(wrenches).max(initial=0) > NOISE:  # couplings against each other: one of them
        first = int(np.abs(values).argmax())
        for j, power in loops.coupling_powers[first].items():
            wrenches[j] = values[first] * power
    return wrenches
