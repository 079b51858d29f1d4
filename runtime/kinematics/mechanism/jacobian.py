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
    """

    jacobian: Array
    residual: Array
    open: Array
    lost: Array
    singular_values: Array
    noise: float

    @property
    def condition(self) -> float:
        """The largest of the singular values over the smallest."""
        values = self.singular_values
        return float(values.max() / values.min()) if len(values) else 1.0

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
                f"input {worst} violates the joint constraints (relative residual {self.residual[worst]:.3g}).",
                remedy="Give inputs that the mechanism allows, as (body, twists), or strict=False for the nearest ones",
            )
        if self.open.size:
            direction = np.array2string(self.open[:, 0], precision=3, suppress_small=True)
            raise UndeterminedError(
                f"the outputs can move along {direction} while all inputs rest: the pose is singular, or inputs are "
                "missing.",
                remedy="Add inputs, take another pose, or give strict=False for the least speeds",
            )


def analyze(mechanism: Assembly, inputs: Any, outputs: Any) -> Analysis:
    """Jacobian and its defects, for inputs and outputs as in `Mechanism.jacobian`."""
    known = KnownVelocities(mechanism)
    for x in as_list(inputs):
        joint = mechanism.find_joint(x)
        if joint is not None:
            known.add_joint(joint)
        else:
            known.add_body(*body_and_value(x, "twists"))
    solution = known.solve()
    maps = [_output(mechanism, x) for x in as_list(outputs)]
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
    return Analysis(jacobian, solution.residual, open_, lost, solution.singular_values, mechanism.velocity_tol)


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
