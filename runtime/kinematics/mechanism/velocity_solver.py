"""Velocities of a mechanism from known ones: speeds of joints, twists of bodies (7.23, 7.24)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ...codegen.errors import InputError, ShapeError
from ...common.validation import finite_array
from ...mechanics.arguments import multivector_of
from .loop_closure import decompose
from .structure import Assembly

Array = NDArray[Any]


@dataclass(frozen=True)
class VelocitySolution:
    """Speeds that follow from known ones.

    Attributes
    ----------
    speeds : array (size, k)
        Least speeds at the joints of the tree.
    residual : array (k,)
        Fraction of the known speeds that the joints do not allow.
    open : array (size, m)
        Orthonormal basis of the speeds that are possible when all known ones are zero.
    singular_values : array
    """

    speeds: Array
    residual: Array
    open: Array
    singular_values: Array


@dataclass
class KnownVelocities:
    """Known velocities of a mechanism in columns: coordinates of the tree by index, all others as rows."""

    mechanism: Assembly
    count: int = 0
    _joints: set[int] = field(default_factory=set)
    _columns: list[tuple[Array, Array, int]] = field(default_factory=list)
    _rows: list[tuple[Any, Array, int]] = field(default_factory=list)

    def add_joint(self, joint: int, speeds: Any = None) -> None:
        """Add speeds at a joint, in the world's units; default: each unit speed."""
        loops = self.mechanism.loops
        relation = loops.relations[joint]
        values = np.diag(1 / relation.speeds)
        if speeds is not None:
            numbers = np.atleast_1d(finite_array(speeds, f"the speed of {self.mechanism.joint_names[joint]}"))
            if numbers.shape != relation.speeds.shape:
                raise InputError(
                    f"{self.mechanism.joint_names[joint]} takes {len(relation.speeds)} numbers for its speed; "
                    f"{numbers.size} are given."
                )
            values = (numbers / relation.speeds)[:, None]
        body = loops.tree.child_of.get(joint)
        if body is not None:
            if joint in self._joints:
                raise InputError(f"{self.mechanism.joint_names[joint]} is given twice.")
            self._joints.add(joint)
            columns = np.arange(loops.offsets[body], loops.offsets[body + 1])
            self._columns.append((columns, values, self.count))
        else:
            self._rows.append((self.mechanism.joint_jacobian(joint), relation.free @ values, self.count))
        self.count += values.shape[1]

    def add_body(self, name: str, twists: Any = None) -> None:
        """Add twists of a body, one or several, each a column; default: its six unit twists."""
        body, matrix = self.mechanism.body_index(name), np.eye(6)
        if body < 0:
            raise InputError(f"{name!r} is fixed, and cannot be given a speed.")
        if twists is not None:
            matrix = twist_columns(self.mechanism, name, twists)
        self._rows.append((self.mechanism.loops.body_jacobian(body), self.mechanism.from_world @ matrix, self.count))
        self.count += matrix.shape[1]

    def solve(self, together: bool = False) -> VelocitySolution:
        """All speeds, for each column separately or for their sum."""
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
        remaining = right - matrix @ speeds
        sizes = np.sqrt(np.maximum((right**2).sum(0) + (speeds**2).sum(0), (remaining**2).sum(0)))
        return _least_norm(matrix, remaining, speeds, np.flatnonzero(~known), sizes, self.mechanism.rank_rtol)


def twist_columns(mechanism: Assembly, name: str, twists: Any) -> Array:
    """Coefficients (6, k) of one twist or several of a body."""
    what = f"the twist of {name!r}"
    x = multivector_of(twists, mechanism.algebra, what).as_kind("twist")
    if x.ndim > 1:
        raise ShapeError(f"{what} has shape {x.shape}; one twist, or (k,) of them, is needed.")
    return finite_array(x.values, what).reshape(-1, 6).T


def _least_norm(
    matrix: Any, right: Array, speeds: Array, free: Array, sizes: Array, tolerance: float
) -> VelocitySolution:
    """Solution of least norm in the free coordinates, block by block, written into the speeds."""
    missed, null_spaces, singular = np.zeros(right.shape[1]), [], [np.zeros(0)]
    for block in decompose(matrix[:, free], tolerance):
        rows, columns = right[block.rows], free[block.columns]
        speeds[columns] = block.right.T @ ((block.left.T @ rows) / block.sizes[:, None])
        missed += ((block.stress.T @ rows) ** 2).sum(0)
        singular.append(block.sizes)
        basis = np.zeros((len(speeds), block.null.shape[1]))
        basis[columns] = block.null
        null_spaces.append(basis)
    residual = np.divide(np.sqrt(missed), sizes, out=np.zeros_like(sizes), where=sizes > 0)
    null = np.concatenate(null_spaces, 1) if null_spaces else np.zeros((len(speeds), 0))
    return VelocitySolution(speeds, residual, null, np.concatenate(singular))
