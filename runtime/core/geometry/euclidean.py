"""Common base of CGA and PGA: motors from parameters and matrices, and parameters back as named tuples.

The mathematics is in `codegen.formulas`; here arrays are checked, statuses completed and results named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.algebra.mismatch import motor_conversion
from ...codegen.errors import GradeError, InputError, KindError, ShapeError
from ...common.validation import as_bool, real_array
from ...dispatch.formulas import ArrayOperand, evaluate, evaluate_batch, item_plan, item_value
from ...dispatch.item_statuses import invalidate, invalidate_nonfinite, merge_statuses, raise_first
from ...dispatch.multivector_data import check_multivector, statuses
from ...status import Status
from ..multivector import Algebra, Multivector
from .parameters import P, Parameters, parameters_class

#: The orientation of a single object that has no other.
ONE = np.float64(1.0)
#: Numbers whose scalar product is one thread's work: of 10 000 and more OpenBLAS wakes others, for up to 10 ms.
MOST_OF_VDOT = 8192
Translator = parameters_class("Translator", "t")
Rotor = parameters_class("Rotor", "axis", "angle", "point")
Motor = parameters_class("Motor", "axis", "angle", "point", "advance")


def _rotor_of(axis: Any, angle: Any, point: Any, advance: Any) -> Parameters:
    """A motor's parameters as those of a rotor."""
    return cast(Callable[..., Parameters], Rotor)(axis, angle, point)


class EuclideanAlgebra(Algebra):
    """An algebra whose versors move Euclidean space. Vectors of space are arrays (..., d); angles are radians."""

    #: Module of formulas for the objects.
    formulas = ""

    @property
    def space(self) -> int:
        """Dimension of the space: 3, or 2 in the plane."""
        return self._euclidean.size

    # -- calls ---------------------------------------------------------------------------------------------

    def spatial(self, value: Any, name: str) -> ArrayOperand:
        """Operand: vectors of space, an array (..., d)."""
        return ArrayOperand(value, self._euclidean, name)

    @cached_property
    def _euclidean(self) -> Kind:
        return self.kind("euclidean" if "euclidean" in self.kinds else "vector")

    def construct(self, formula: str, *operands: Multivector | ArrayOperand, strict: bool = False) -> Multivector:
        """The object that a formula makes; items that are not finite are INVALID and NaN all over.

        Raises
        ------
        SingularError
            With ``strict``, for the first item without an object.
        """
        x: Multivector | None = item_value(self, formula, operands)
        if x is None:
            x = invalidate_nonfinite(evaluate_batch(self, formula, *operands).value)
        if strict is not False and as_bool(strict, "strict"):
            raise_first(x._status, formula.rpartition(".")[2])
        return x

    def read(self, kind: Callable[..., P], formula: str, x: Multivector, orientation: Any = None) -> P:
        """Named parameters from a formula's results."""
        usual = self._read_item(formula, x) if x._status is None and not x._lead else None
        if usual is not None:
            own = ONE if orientation is None else usual.pop(orientation)
            result = kind(*usual)
            result.orientation = own  # type: ignore[assignment]
            result.status = Status.OK
            return result
        outcome = evaluate_batch(self, formula, x)
        fields = [v[..., 0] if v.shape[-1:] == (1,) else v for v in map(plain, outcome.values)]
        if orientation is not None:
            orientation = fields.pop(orientation)
        return self.named_tuple(kind, fields, x, outcome.status, orientation)

    def _read_item(self, formula: str, x: Multivector) -> list[Any] | None:
        """Rows and numbers of a single item; None where anything is not as usual."""
        plan = x._type._cache.get(formula)
        if plan is None:
            plan = x._type._cache[formula] = item_plan(self, formula, (x,))[0]
        rows: list[Any] | None = plan.rows((x._pointer or x._point(),))
        return rows

    def named_tuple(
        self, kind: Callable[..., P], fields: Sequence[Any], x: Multivector, status: Any = None, orientation: Any = None
    ) -> P:
        """A named tuple with orientation and status; INVALID and NaN where a parameter is not finite."""
        known = merge_statuses(x._status, status)
        if not _are_finite(fields, x.shape):
            fields, known = _refuse_nonfinite(fields, x.shape, known)
        result = kind(*(field[()] for field in fields))
        result.orientation = (np.ones(x.shape, x.dtype) if orientation is None else orientation)[()]
        result.status = statuses(known, x.shape)
        return result

    # -- motors --------------------------------------------------------------------------------------------

    def translator(self, t: Any, strict: bool = False) -> Multivector:
        """Translation by the vector t."""
        return self.construct("motions.translator", self.spatial(t, "t"), strict=strict)

    def rotor(self, axis: Any, angle: Any, point: Any = 0, strict: bool = False) -> Multivector:
        """Rotation by ``angle`` radians, counter-clockwise about ``axis`` through ``point``. INVALID: a zero axis."""
        operands = self.spatial(axis, "axis"), ArrayOperand(angle, 0, "angle")
        if is_origin(point):
            return self.construct("motions.rotor", *operands, strict=strict)
        return self.construct("motions.rotor_about", *operands, self.spatial(point, "point"), strict=strict)

    def motor_from_matrix(self, matrix: Any, strict: bool = False) -> Multivector:
        """Unit motor with <R>_0 >= 0 from homogeneous matrices (..., 4, 4), or rotation matrices (..., 3, 3).

        INVALID: the matrix is no rigid motion (to 1e-3; the rotation is made orthonormal within that).
        """
        if isinstance(matrix, Multivector) and (remedy := motor_conversion(matrix, self)):
            raise InputError(f"the matrix is a {matrix.kind.name} of {matrix.algebra.name}.", remedy=remedy)
        m = real_array(matrix, "the matrix")
        d = self.space
        if m.ndim < 2 or m.shape[-2:] not in ((d, d), (d + 1, d + 1)):
            raise ShapeError(f"the matrix has shape {m.shape}; it ends in ({d}, {d}) or ({d + 1}, {d + 1}).")
        columns = [self.spatial(np.ascontiguousarray(m[..., :d, j]), "a column") for j in range(m.shape[-1])]
        name = "motions.rotor_from_matrix" if len(columns) == d else "motions.motor_from_matrix"
        x = self.construct(name, *columns)
        if len(columns) > d:
            bad = (m[..., d, :d] != 0).any(-1) | (m[..., d, d] != 1)
            x = invalidate(x, bad)
        if as_bool(strict, "strict"):
            raise_first(x._status, "motor_from_matrix")
        return x

    def matrix(self, x: Multivector) -> NDArray[Any]:
        """Homogeneous matrix (..., 4, 4) of a unit motor.

        Raises
        ------
        KindError
            If x is not a motor, rotor or translator.
        """
        motor = self.as_motor(x)
        entries: NDArray[Any] = evaluate(self, "motions.motor_to_matrix", motor).value
        return entries.reshape(*x.shape, self.space + 1, self.space + 1)

    def as_motor(self, x: Multivector) -> Multivector:
        """x as a unit motor, its constraints checked."""
        check_multivector(x)
        if x._type.algebra is self and x._type.memoize("is_motor", lambda: self._is_motor(x.kind)):
            return x
        if x.algebra is not self or 0 not in x.grades:
            raise KindError(f"a {x.kind.name} of {x.algebra.name} is not a motor of {self.name}.")
        return x.as_kind("motor")

    def _is_motor(self, kind: Kind) -> bool:
        return any(n in self.kinds and self.kind(n) == kind for n in ("rotor", "translator", "motor"))

    def motor_parameters(self, x: Multivector) -> Parameters:
        """Screw of a unit motor: unit axis, angle in [0, 2 pi), point of the axis nearest the origin, advance.

        The advance is the translation along the axis. A translation has its direction as
        axis, and the angle 0; the identity (NOT_UNIQUE) the last basis vector.
        """
        motor = self.as_motor(x)
        if motor._type.kind.name == "translator":
            motor = motor.as_kind("motor")
        return self.read(Motor, "exponentials.motor_parameters", motor)

    def rotor_parameters(self, x: Multivector) -> Parameters:
        """Axis, angle and a point of the axis of a rotation about the origin."""
        return self.read(_rotor_of, "exponentials.motor_parameters", self.as_motor(x))

    def translator_parameters(self, x: Multivector) -> Parameters:
        """The vector of a translation."""
        return self.read(Translator, "motions.translator_parameters", self.as_motor(x))

    # -- parameters ----------------------------------------------------------------------------------------

    #: Kind to the method that reads its parameters.
    readers: Mapping[str, str] = {}

    def parameters(self, x: Multivector) -> Parameters:
        """Parameters of the constructor of this kind of object, as a named tuple with its fields.

        Radii are positive; ``.orientation`` is +1 or -1 (only a sphere can be turned inside out), ``.status`` that
        of each item. Objects of an unknown kind are normalised first.

        Raises
        ------
        KindError
            If x is of no kind that has parameters.
        """
        check_multivector(x)
        if x._type.algebra is not self:
            raise InputError(f"x belongs to {x.algebra.name}; ask that algebra for its parameters.")
        method = x._type._cache.get("parameters")
        if method is None:
            method = x._type.memoize("parameters", lambda: self._reader(x.kind))
        if not method:
            x = self._normalize_to_kind(x)
            method = self.readers[x.kind.name]
        read: Callable[[Multivector], Parameters] = getattr(self, method)
        return read(x)

    def _reader(self, kind: Kind) -> str:
        """The method that reads members of a kind; empty where there is none."""
        return next((method for name, method in self.readers.items() if self.kind(name) == kind), "")

    def _normalize_to_kind(self, x: Multivector) -> Multivector:
        """x normalised to the smallest kind with parameters that holds it."""
        own = {b for b, column in zip(x._type.blades, np.moveaxis(x._data, -1, 0), strict=True) if column.any()}
        fitting = [self.kind(n) for n in self.readers if own <= set(self.kind(n).blades)]
        objects = [k for k in fitting if (0 in k.blades) == (0 in own)]  # without a scalar part it is no motion
        for kind in sorted(objects, key=lambda k: k.size):
            candidate = x.as_kind(kind.layout, check=False)
            unit = candidate.normalized() if kind.constraints else candidate
            if unit.kind == kind:
                return unit
        raise KindError(
            f"this {x.kind.name} of {self.name} is of no kind that has parameters.",
            remedy=f"They are those of: {', '.join(self.readers)}; see classify()" if self.readers else "",
        )


def _are_finite(fields: Sequence[NDArray[Any]], shape: tuple[int, ...]) -> bool:
    """Whether all numbers are finite, in next to no time; some whose squares or sums are not need not be."""
    if shape:
        with np.errstate(over="ignore", invalid="ignore"):
            return all(np.isfinite(np.vdot(f, f) if f.size < MOST_OF_VDOT else f.sum()) for f in fields)
    return math.isfinite(sum(sum(field.tolist()) if field.ndim else float(field) for field in fields))


def _refuse_nonfinite(
    fields: Sequence[NDArray[Any]], shape: tuple[int, ...], known: NDArray[np.uint8] | None
) -> tuple[list[NDArray[Any]], NDArray[np.uint8]]:
    good = np.logical_and.reduce([np.isfinite(field).reshape((*shape, -1)).all(-1) for field in fields])
    known = np.zeros(shape, np.uint8) if known is None else np.broadcast_to(known, shape)
    lost = np.asarray(~good & (known == Status.OK))
    parted = [np.where(lost.reshape(shape + (1,) * (f.ndim - len(shape))), f.dtype.type(np.nan), f) for f in fields]
    return parted, np.where(lost, np.uint8(Status.INVALID), known)


def is_origin(point: Any) -> bool:
    """Test whether ``point`` is its default 0."""
    if isinstance(point, np.ndarray | np.generic):
        return point.ndim == 0 and point.dtype.kind in "iuf" and bool(point == 0)
    return isinstance(point, int | float) and point == 0


def perpendicular(direction: NDArray[Any]) -> NDArray[Any]:
    """A direction (3,) perpendicular to another, in the plane across the axis that is most across it; not unit."""
    return np.asarray(np.cross(direction, np.eye(3)[np.abs(direction).argmin()]))


def plain(value: Any) -> NDArray[Any]:
    """Coefficients of a result, multivector or array."""
    return value._data if isinstance(value, Multivector) else value


def plane_vector(logarithm: Multivector, dimension: int) -> NDArray[Any]:
    """Axis times half the angle, from b = -angle/2 (a I3) + ...: in space e23, -e13, e12 of a I3."""
    if dimension != 3:
        raise GradeError("axes of rotation are those of space; in the plane there is a point.")
    return np.stack([-logarithm["e23"], logarithm["e13"], -logarithm["e12"]], -1)


__all__ = ["EuclideanAlgebra", "Motor", "Rotor", "Translator", "is_origin", "perpendicular", "plain", "plane_vector"]
