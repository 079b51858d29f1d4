"""Jacobians of a mechanism by split columns, and how near they are to singular (thesis 7.6, (7.25) mended)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..codegen.errors import ConstraintError, InputError, UndeterminedError
from ..dynamics.given import shown, vectors
from ..dynamics.screws import velocity_at
from ..multivector import Multivector
from .inputs import Known
from .joints import Joint

if TYPE_CHECKING:
    from .mechanism import Mechanism

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Analysis:
    """Outputs of a mechanism for its inputs.

    Attributes
    ----------
    jacobian : array (outputs, inputs)
        Where inputs are not allowed, of the nearest that are; where outputs are left open, of the least speeds.
    residual : array (inputs,)
        Share of each input that the joints do not allow: rounding at a pose that is not singular.
    open : array (outputs, k)
        Orthonormal directions in which outputs can move while all inputs rest: none at a pose that is not singular.
    lost : array (outputs, m)
        Orthonormal directions in which outputs can not move, whatever the inputs do.
    singular_values : array
        Of what is solved for the unknown speeds, in the mechanism's frame and unit, zeros left out.
    noise : float
        Shares that count as rounding.
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
        """Raise what keeps the Jacobian from being one.

        Raises
        ------
        ConstraintError
            If the joints do not allow an input: which, and how much of it.
        UndeterminedError
            If an output can move while all inputs rest: the direction in which it can.
        """
        if self.residual.max(initial=0) > self.noise:
            worst = int(self.residual.argmax())
            raise ConstraintError(
                f"the joints do not allow {self.residual[worst]:.3g} of input {worst}.",
                remedy="Give inputs that the mechanism allows, as (body, twists), or strict=False for the nearest ones",
            )
        if self.open.size:
            way = np.array2string(self.open[:, 0], precision=3, suppress_small=True)
            raise UndeterminedError(
                f"the outputs can move along {way} while all inputs rest: the pose is singular, or inputs are missing.",
                remedy="Add inputs, leave the pose, or give strict=False for the least speeds",
            )


def analysed(mechanism: Mechanism, inputs: Any, outputs: Any) -> Analysis:
    """Outputs for inputs, each as in `Mechanism.jacobian`."""
    known = Known(mechanism)
    for x in listed(inputs):
        joint = mechanism.find_joint(x)
        if joint is not None:
            known.add_joint(joint)
        else:
            known.add_body(*body_and(x, "twists"))
    found = known.solved()
    asked = [_output(mechanism, x) for x in listed(outputs)]
    if not asked:
        raise InputError("there are no outputs; a joint or a body is needed.")
    jacobian, left = (np.concatenate([m @ (rows @ s) for rows, m in asked]) for s in (found.speeds, found.open))
    unit = mechanism.noise * max(float(np.abs(m).max(initial=0)) for _, m in asked)  # of what a unit speed can do
    ways, values, _ = np.linalg.svd(left)
    open_ = ways[:, : len(values)][:, values > unit]
    ways, values, _ = np.linalg.svd(jacobian)
    lost = ways[:, int((values > unit * np.abs(found.speeds).max(initial=0)).sum()) :]
    return Analysis(jacobian, found.residual, open_, lost, found.singular_values, mechanism.noise)


def listed(x: Any) -> list[Any]:
    """One thing or several, as a list.

    Raises
    ------
    InputError
        If several have no order.
    """
    if isinstance(x, Mapping):
        return list(x.items())
    if isinstance(x, Set):
        raise InputError(f"{shown(x)} has no order.", remedy="Give a list")
    if isinstance(x, str | tuple | Joint | Multivector | None) or not isinstance(x, Iterable):
        return [x]
    return [v.item() if isinstance(v, np.generic) else v for v in x]


def body_and(x: Any, what: str) -> tuple[Any, Any]:
    """A body, and what is given with it, if anything is.

    Raises
    ------
    InputError
        If it is neither a body nor that.
    """
    if not isinstance(x, tuple):
        return x, None
    if len(x) != 2 or isinstance(x[1], str | Joint):
        raise InputError(f"{x!r} is no (body, {what}).", remedy="Give several bodies or joints as a list")
    return x


def coordinates_of(point: Multivector, what: str) -> Array:
    """Coordinates (..., 3) of points.

    Raises
    ------
    InputError
        If they are something else.
    """
    found = point.parameters()
    if not hasattr(found, "xyz"):
        raise InputError(f"{what} is a {type(found).__name__.lower()}; a point is needed.")
    return np.asarray(found.xyz)


def place_of(point: Any, what: str) -> Array:
    """The coordinates (3,) of a point, given as a multivector or by them."""
    found = np.asarray(coordinates_of(point, what) if isinstance(point, Multivector) else vectors(point, what), float)
    if not np.isfinite(found).all():
        raise InputError(f"{what} is at {found}; a finite place is needed.")
    if found.shape != (3,):
        raise InputError(f"{what} has shape {found.shape}; one point is needed.")
    return found


def _output(mechanism: Mechanism, x: Any) -> tuple[Any, Array]:
    """Rows on the tree's speeds (sparse), and the matrix that takes them to what is asked for, in the world's units."""
    joint = mechanism.find_joint(x)
    if joint is not None:
        relation = mechanism.loops.relations[joint]
        return mechanism.way_of(joint), relation.speeds[:, None] * np.linalg.pinv(relation.free)
    name, point = body_and(x, "point")
    body = mechanism.number(name)
    rows = sparse.csr_array((6, mechanism.loops.size)) if body < 0 else mechanism.loops.way(body)
    if point is None:
        return rows, mechanism.to_world
    place = place_of(point, f"the point of {name!r}")
    frame, algebra = mechanism.frame, mechanism.algebra
    units = algebra.wrap(algebra.kind("twist"), np.eye(6))
    return rows, frame.unit * velocity_at(units, (place - frame.center) / frame.unit).T
