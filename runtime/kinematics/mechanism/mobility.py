"""What a mechanism can still do, and what it asks for twice: free motions and self-stresses, each told in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag
from scipy.sparse import csgraph

from .loops import Loops, Part, parts

if TYPE_CHECKING:
    from ..multivector import Multivector
    from .mechanism import Mechanism

Array = NDArray[Any]
#: Share of the largest twist or wrench below which a body is at rest, and a joint bears nothing.
NOISE = 1e-9


@dataclass(frozen=True, eq=False)
class FreeMotion(Mapping[str, "Multivector"]):
    """A motion that all joints allow: twists of bodies by name, in the world.

    Attributes
    ----------
    speeds : array
        At the joints of the mechanism's tree, in the mechanism's frame.
    driver : str
        The joint or body that it is named after: the coordinate that only this motion, of those in the list, has.
    idle : bool
        Whether one body moves alone, as a rod between two balls spins.
    """

    mechanism: Mechanism
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
        """Those that move."""
        sizes = np.abs(self.mechanism.loops.twists(self.speeds)).max(-1)
        moving = sizes > NOISE * sizes.max(initial=0)
        return [name for name, moves in zip(self.mechanism.moving, moving, strict=True) if moves]

    def __repr__(self) -> str:
        names = self.bodies
        shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        return f"<FreeMotion: {self.driver} alone>" if self.idle else f"<FreeMotion of {self.driver}: {shown}>"


@dataclass(frozen=True, eq=False)
class SelfStress(Mapping[str, "Multivector"]):
    """Wrenches that joints can bear against each other with no load: a constraint that is there twice.

    A mapping of joints, by label, to the wrench that the first body puts on the second, in the world.
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


def idle_speeds(loops: Loops, tolerance: float) -> list[tuple[int, Array]]:
    """Motions in which one body moves alone: (body, speeds of the tree)."""
    tree, found = loops.tree, []
    joints: list[list[int]] = [[] for _ in tree.parent]
    for j, ends in enumerate(tree.ends):
        for b in ends:
            if b >= 0:
                joints[b].append(j)
    hanging: list[list[int]] = [[] for _ in tree.parent]
    for b in tree.order:
        if tree.parent[b] >= 0:
            hanging[tree.parent[b]].append(b)
    for b, own in enumerate(joints):
        rows = np.concatenate([loops.relations[j].rows for j in own])
        if len(own) < 2 or len(rows) > 6 * len(own):
            continue
        _, sizes, basis = np.linalg.svd(rows)
        for twist in basis[int((sizes > tolerance * sizes.max(initial=0)).sum()) :]:
            speeds = np.zeros(loops.size)
            for child, sign in ((b, 1), *((c, -1) for c in hanging[b])):
                at = slice(loops.starts[child], loops.starts[child + 1])
                speeds[at] = sign * np.linalg.lstsq(loops.step(child), twist, rcond=None)[0]
            found.append((b, speeds))
    return found


def free_basis(loops: Loops, split: list[Part], idle: list[Array]) -> list[tuple[int, Array]]:
    """A basis of all motions, the idle ones first, then one for each coordinate that is free to choose, those near
    the fixed body first: (coordinate, speeds)."""
    made: list[tuple[int, Array]] = []
    for columns, null in _together(split, idle):
        own = [v[columns] for v in idle if np.any(v[columns])]
        if own:
            basis, _ = np.linalg.qr(np.stack(own, 1))
            null = null - basis @ (basis.T @ null)
            left, sizes, _ = np.linalg.svd(null, full_matrices=False)
            null = left[:, sizes > 0.5]  # of an orthonormal basis less one of its subspaces: ones and zeros
        for column, values in _reduced(null, np.argsort(_rank_of(loops)[columns], kind="stable")):
            speeds = np.zeros(loops.size)
            speeds[columns] = values
            made.append((int(columns[column]), speeds))
    return made


def _together(split: list[Part], idle: list[Array]) -> list[tuple[Array, Array]]:
    """Columns and null spaces of parts, of those that an idle motion moves as one."""
    of_column = {int(c): k for k, part in enumerate(split) for c in part.columns}
    links = np.array(
        [(of_column[int(v.nonzero()[0][0])], of_column[int(c)]) for v in idle for c in v.nonzero()[0]], int
    )
    rows, columns = links.reshape(-1, 2).T
    graph = sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(split), len(split)))
    groups: dict[int, list[Part]] = {}
    for part, label in zip(split, csgraph.connected_components(graph, directed=False)[1], strict=True):
        groups.setdefault(int(label), []).append(part)
    return [
        (np.concatenate([p.columns for p in own]), block_diag(*(p.null for p in own)) if len(own) > 1 else own[0].null)
        for own in groups.values()
    ]


def _rank_of(loops: Loops) -> Array:
    """How far from the fixed body each coordinate's joint is."""
    counts = np.diff(loops.starts)
    return np.repeat(np.array(loops.tree.depth, int), counts)


def _reduced(null: Array, order: Array) -> list[tuple[int, Array]]:
    """A basis in which each of some coordinates, the first ones in an order that will do, is one vector's alone."""
    chosen: list[int] = []
    rest = null.copy()
    for row in order:
        if len(chosen) == null.shape[1]:
            break
        size = np.linalg.norm(rest[row])
        if size > 1e-3:  # less is a poor one to name a motion after
            way = rest[row] / size
            rest = rest - np.outer(rest @ way, way)
            chosen.append(int(row))
    if len(chosen) < null.shape[1]:
        return [(int(np.argmax(np.abs(v))), v) for v in null.T]
    basis = null @ np.linalg.inv(null[chosen])
    return list(zip(chosen, basis.T, strict=True))


def self_stresses(loops: Loops, split: list[Part]) -> list[Array]:
    """Wrenches (joints, 6), as rows on twists of the second body, that joints bear against each other."""
    tree, found = loops.tree, []
    for part in split:
        for values in part.stress.T:
            stress = np.zeros(int(loops.cut_rows[-1]))
            stress[part.rows] = values
            found.append(_borne(loops, stress))
    return found if len(tree.cuts) else []


def _borne(loops: Loops, stress: Array) -> Array:
    tree = loops.tree
    wrenches, net = np.zeros((len(tree.ends), 6)), np.zeros((len(tree.parent), 6))
    for k, j in enumerate(tree.cuts):
        wrench = stress[loops.cut_rows[k] : loops.cut_rows[k + 1]] @ loops.relations[j].rows
        wrenches[j] = wrench
        for body, sign in zip(tree.ends[j], (-1, 1), strict=True):
            if body >= 0:
                net[body] += sign * wrench
    through = tree.gathered(net)
    for b, j in enumerate(tree.joint):
        wrenches[j] = -tree.sign[b] * through[b]
    return wrenches


__all__ = ["FreeMotion", "SelfStress", "free_basis", "idle_speeds", "parts", "self_stresses"]
