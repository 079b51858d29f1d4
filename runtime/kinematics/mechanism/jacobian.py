"""Jacobians of a mechanism by split columns, and their singularities (thesis 7.6, (7.25) corrected)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ...codegen.errors import ConstraintError, InputError, UndeterminedError
from ...mechanics.screws import velocity_at
from .arguments import as_list, body_and_value, position_of
from .structure import Assembly
from .velocity_solver import KnownVelocities

Array = NDArray[Any]
#: Names of inputs or outputs that the text of an analysis has at most.
MOST = 3
#: Parts of a direction below this fraction of its largest are not in its text.
SMALL = 1e-6


@dataclass(frozen=True, eq=False)
class Analysis:
    """Jacobian of a mechanism, with its defects.

    Attributes
    ----------
    jacobian : array (outputs, inputs)
        For the nearest inputs that are allowed, and the least speeds of undetermined outputs.
    residual : array (inputs,)
        Fraction of each input that the joints do not allow: rounding at a regular pose.
    open : array (outputs, k)
        Orthonormal directions in which outputs can move while all inputs rest: none at a regular pose.
    lost : array (outputs, m)
        Orthonormal directions in which outputs cannot move, for any inputs.
    singular_values : array
        Nonzero singular values of the system for the unknown speeds, in the mechanism's frame and unit.
    noise : float
        Fractions that count as rounding.
    inputs, outputs : tuple of str
        Names of the columns and rows of the Jacobian.
    """

    jacobian: Array
    residual: Array
    open: Array
    lost: Array
    singular_values: Array
    noise: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def condition(self) -> float:
        """The largest of the singular values over the smallest."""
        values = self.singular_values
        return float(values.max() / values.min()) if len(values) else 1.0

    @property
    def singular(self) -> bool:
        """Whether the pose is singular: outputs can move while all inputs rest, or move in too few directions.

        The first is a forward singularity, and holds at every pose where inputs are missing. The second is an inverse
        one: fewer directions than there are outputs and inputs that the joints allow. Printed, the analysis says which.
        """
        return bool(self.open.size or self.idle_inputs.size)

    @property
    def idle_inputs(self) -> Array:
        """Orthonormal combinations (inputs, k) of inputs that move no output, where as many outputs could move."""
        rank = len(self.outputs) - self.lost.shape[1]
        if rank >= min(len(self.outputs), int((self.residual <= self.noise).sum())):
            return np.zeros((len(self.inputs), 0))
        return np.asarray(np.linalg.svd(self.jacobian)[2][rank:].T)

    def __str__(self) -> str:
        kinds = [word for word, found in (("forward", self.open), ("inverse", self.idle_inputs)) if found.size]
        what = f"singular ({' and '.join(kinds)})" if kinds else f"regular, condition {self.condition:.3g}"
        lines = [f"{_listed(self.inputs)} -> {_listed(self.outputs)}: {what}"]
        if kinds:
            lost = self.lost if len(self.outputs) <= len(self.inputs) else np.zeros((0, 0))  # else never few
            for text, names, directions in (
                ("moves while all inputs rest", self.outputs, self.open),
                ("does not move, for any inputs", self.outputs, lost),
                ("has no effect", self.inputs, self.idle_inputs),
            ):
                lines += [f"  {text}: {_combination(x, names)}" for x in directions.T]
        for k in np.flatnonzero(self.residual > self.noise):
            lines.append(f"  the joints forbid: {self.inputs[k]} ({self.residual[k]:.0%} of it)")
        return "\n".join(lines)

    def check(self) -> None:
        """Check that the inputs are allowed and determine the outputs.

        Raises
        ------
        ConstraintError
            If the joints do not allow an input: its index and residual.
        UndeterminedError
            If an output can move while all inputs rest: the direction in which it can.
        """
        if self.residual.max(initial=0) > self.noise:
            worst = int(self.residual.argmax())
            raise ConstraintError(
                f"input {worst} ({self.inputs[worst]}) violates the joint constraints (relative residual "
                f"{self.residual[worst]:.3g}).",
                remedy="Give inputs that the mechanism allows, as (body, twists), or strict=False for the nearest ones",
            )
        if self.open.size:
            raise UndeterminedError(
                f"outputs can move ({_combination(self.open[:, 0], self.outputs)}) while all inputs rest: the pose is "
                "singular, or inputs are missing.",
                remedy="Add inputs, take another pose, or give strict=False for the least speeds",
            )


def analyze(mechanism: Assembly, inputs: Any, outputs: Any) -> Analysis:
    """Jacobian and its defects, for inputs and outputs as in `Mechanism.jacobian`."""
    known, names = KnownVelocities(mechanism), list[str]()
    for x in as_list(inputs):
        joint = mechanism.find_joint(x)
        if joint is not None:
            known.add_joint(joint)
        else:
            known.add_body(*body_and_value(x, "twists"))
        names += _names(mechanism, x, known.count - len(names))
    solution = known.solve()
    maps = [_output(mechanism, x) for x in as_list(outputs)]
    rows = [name for x, (_, m) in zip(as_list(outputs), maps, strict=True) for name in _names(mechanism, x, len(m))]
    if not maps:
        raise InputError("there are no outputs; a joint or a body is needed.")
    jacobian, undetermined = (
        np.concatenate([m @ (rows @ s) for rows, m in maps]) for s in (solution.speeds, solution.open)
    )
    unit = mechanism.velocity_tol * max(float(np.abs(m).max(initial=0)) for _, m in maps)
    directions, values, _ = np.linalg.svd(undetermined)
    open_ = directions[:, : len(values)][:, values > unit]
    directions, values, _ = np.linalg.svd(jacobian)
    lost = directions[:, int((values > unit * np.abs(solution.speeds).max(initial=0)).sum()) :]
    return Analysis(
        jacobian, solution.residual, open_, lost, solution.singular_values, mechanism.velocity_tol, tuple(names),
        tuple(rows),
    )  # fmt: skip


def _names(mechanism: Assembly, x: Any, count: int) -> list[str]:
    """Names of the speeds of an input or output."""
    joint = mechanism.find_joint(x)
    name, value = (mechanism.joint_names[joint], None) if joint is not None else body_and_value(x, "value")
    if count == 1:
        return [name]
    if joint is not None or (value is not None and count != 3):
        return [f"{name}[{k}]" for k in range(count)]
    algebra = mechanism.algebra
    parts = list("xyz") if count == 3 else [algebra.blade_name(blade) for blade in algebra.kind("twist").blades]
    return [f"{name} {part}" for part in parts]


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")


def _combination(direction: Array, names: tuple[str, ...]) -> str:
    """Text of a combination of named speeds, the largest of which is 1."""
    shares = direction / direction[np.abs(direction).argmax()]
    terms = [
        f"{'-' if x < 0 else '+'} {'' if f'{abs(x):.3g}' == '1' else f'{abs(x):.3g} '}{name}"
        for x, name in zip(shares, names, strict=True)
        if abs(x) > SMALL
    ]
    return " ".join(terms).removeprefix("+ ")


def _output(mechanism: Assembly, x: Any) -> tuple[Any, Array]:
    """Rows in the tree's speeds (sparse), and the matrix from them to an output in the world's units."""
    joint = mechanism.find_joint(x)
    if joint is not None:
        relation = mechanism.loops.relations[joint]
        return mechanism.joint_jacobian(joint), relation.to_coordinates
    name, point = body_and_value(x, "point")
    body = mechanism.body_index(name)
    rows = sparse.csr_array((6, mechanism.loops.size)) if body < 0 else mechanism.loops.body_jacobian(body)
    if point is None:
        return rows, mechanism.to_world
    position = position_of(point, f"the point of {name!r}")
    frame, algebra = mechanism.frame, mechanism.algebra
    units = algebra.wrap(algebra.kind("twist"), np.eye(6))
    return rows, frame.unit * velocity_at(units, (position - frame.center) / frame.unit).T
