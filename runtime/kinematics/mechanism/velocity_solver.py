"""Speeds of a mechanism that are known: coordinates of joints, and twists of bodies; the others follow (7.23, 7.24)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..codegen.errors import InputError
from ..dynamics.given import finite, of_algebra
from .loops import parts

if TYPE_CHECKING:
    from .mechanism import Mechanism

Array = NDArray[Any]


@dataclass(frozen=True)
class Solved:
    """Speeds that follow from known ones.

    Attributes
    ----------
    speeds : array (size, k)
        At the joints of the tree, the least that do.
    residual : array (k,)
        Share of what is known that the joints do not allow.
    open : array (size, m)
        Orthonormal speeds that are left when all that is known rests.
    singular_values : array
    """

    speeds: Array
    residual: Array
    open: Array
    singular_values: Array


@dataclass
class Known:
    """Known speeds of a mechanism, column by column: coordinates of the tree by number, all else as rows."""

    mechanism: Mechanism
    count: int = 0
    _joints: set[int] = field(default_factory=set)
    _columns: list[tuple[Array, Array, int]] = field(default_factory=list)
    _rows: list[tuple[Any, Array, int]] = field(default_factory=list)

    def add_joint(self, joint: int, speeds: Any = None) -> None:
        """Speeds at a joint, in the world's units; each by itself, if not given."""
        loops = self.mechanism.loops
        relation = loops.relations[joint]
        values = np.diag(1 / relation.speeds)
        if speeds is not None:
            given = np.atleast_1d(finite(speeds, f"the speed of {self.mechanism.joint_names[joint]}"))
            if given.shape != relation.speeds.shape:
                raise InputError(
                    f"{self.mechanism.joint_names[joint]} takes {len(relation.speeds)} numbers for its speed; "
                    f"{given.size} are given."
                )
            values = (given / relation.speeds)[:, None]
        body = loops.tree.hung_by.get(joint)
        if body is not None:
            if joint in self._joints:
                raise InputError(f"{self.mechanism.joint_names[joint]} is given twice.")
            self._joints.add(joint)
            columns = np.arange(loops.starts[body], loops.starts[body + 1])
            self._columns.append((columns, values, self.count))
        else:
            self._rows.append((self.mechanism.way_of(joint), relation.free @ values, self.count))
        self.count += values.shape[1]

    def add_body(self, name: str, twists: Any = None) -> None:
        """Twists of a body, one or several, of which each is a column; its six unit twists, if not given."""
        body, matrix = self.mechanism.number(name), np.eye(6)
        if body < 0:
            raise InputError(f"{name!r} is fixed, and can not be given a speed.")
        if twists is not None:
            matrix = twist_columns(self.mechanism, name, twists)
        self._rows.append((self.mechanism.loops.way(body), self.mechanism.from_world @ matrix, self.count))
        self.count += matrix.shape[1]

    def solved(self, together: bool = False) -> Solved:
        """All speeds, for each column by itself or for their sum."""
        loops = self.mechanism.loops
        speeds, known = np.zeros((loops.size, self.count)), np.zeros(loops.size, bool)
        for columns, values, at in self._columns:
            speeds[columns, at : at + values.shape[1]] = values
            known[columns] = True
        matrix = sparse.vstack([loops.matrix, *(rows for rows, _, _ in self._rows)]).tocsr()
        right = np.zeros((matrix.shape[0], self.count))
        at = loops.matrix.shape[0]
        for rows, values, first in self._rows:
            right[at : at + len(values), first : first + values.shape[1]] = values
            at += rows.shape[0]
        if together:
            speeds, right = speeds.sum(1, keepdims=True), right.sum(1, keepdims=True)
        left = right - matrix @ speeds
        asked = np.sqrt(np.maximum((right**2).sum(0) + (speeds**2).sum(0), (left**2).sum(0)))
        return _least(matrix, left, speeds, np.flatnonzero(~known), asked, self.mechanism.share)


def twist_columns(mechanism: Mechanism, name: str, twists: Any) -> Array:
    """Coefficients (6, k) of one twist of a body, or of several."""
    what = f"the twist of {name!r}"
    x = of_algebra(twists, mechanism.algebra, what).as_kind("twist")
    if x.ndim > 1:
        raise InputError(f"{what} has shape {x.shape}; one twist, or (k,) of them, are needed.")
    return finite(x.values, what).reshape(-1, 6).T


def _least(matrix: Any, right: Array, speeds: Array, free: Array, asked: Array, tolerance: float) -> Solved:
    """The least speeds of the free coordinates, part by part, written into those that are known."""
    missed, open_, sizes = np.zeros(right.shape[1]), [], [np.zeros(0)]
    for part in parts(matrix[:, free], tolerance):
        own, columns = right[part.rows], free[part.columns]
        speeds[columns] = part.right.T @ ((part.left.T @ own) / part.sizes[:, None])
        missed += ((part.stress.T @ own) ** 2).sum(0)
        sizes.append(part.sizes)
        full = np.zeros((len(speeds), part.null.shape[1]))
        full[columns] = part.null
        open_.append(full)
    residual = np.divide(np.sqrt(missed), asked, out=np.zeros_like(asked), where=asked > 0)
    left = np.concatenate(open_, 1) if open_ else np.zeros((len(speeds), 0))
    return Solved(speeds, residual, left, np.concatenate(sizes))
