"""Twists and wrenches as multivectors, their parts and products (thesis 6.2, 6.3).

A twist is w I3 + v n with the velocity v of the frame's origin, a wrench f I3 + tau n with the moment tau about it.
n is the null vector n_inf of CGA or e0 of PGA. The formulas are in `codegen.formulas`: `twists` and `mechanics`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, cast, overload

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import AlgebraMismatchError, GradeError
from ..common.deprecation import renamed_keywords
from ..common.dtypes import common_precision
from ..common.validation import as_bool, as_choice, as_instance
from ..core.geometry.euclidean import EuclideanAlgebra, is_origin, plain
from ..core.geometry.parameters import P, Parameters
from ..core.kind_constraints import convert_to_kind
from ..core.multivector import Algebra, Multivector
from ..core.registry import stock_algebra
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import array_result, invalidate_nonfinite, merge_statuses, raise_first, unsigned_zeros
from ..dispatch.multivector_data import Statuses, statuses
from ..objects.screws import screw

Array = NDArray[Any]
#: Orders of a screw's six coordinates: (w, v) and (f, tau), or (v, w) and (tau, f).
ORDERS = ("axis-first", "axis-last")


class TwistParts(NamedTuple("TwistParts", [("angular", Array), ("linear", Array)]), Parameters):
    """Angular velocity and the origin's velocity (..., 3), with ``.status``."""


class WrenchParts(NamedTuple("WrenchParts", [("force", Array), ("moment", Array)]), Parameters):
    """Force and moment about the origin (..., 3), with ``.status``."""


# -- construction ------------------------------------------------------------------------------------------------


def twist(angular: Any, linear: Any = 0, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """Twist w I3 + v n of a body.

    Parameters
    ----------
    angular : array (..., 3), or 0
        Angular velocity, radians per unit of time, counter-clockwise.
    linear : array (..., 3), or 0
        Velocity of the point of the body at the frame's origin.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.

    Returns
    -------
    Multivector, shape (...)
        Points of the body move by dX = X x Omega, the commutator with the half. `INVALID`: not finite.
    """
    return _screw_of_vectors("mechanics.screw_of", algebra, ("angular", angular), ("linear", linear), strict=strict)


def wrench(force: Any, point: Any = 0, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """Wrench f I3 + (p x f) n of a force (..., 3) whose line of action passes through a point (..., 3), or 0."""
    return _screw_of_vectors("mechanics.wrench_at", algebra, ("force", force), ("point", point), strict=strict)


def couple(moment: Any, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """Wrench tau n of a pure moment (..., 3), two opposite forces; it has no line of action."""
    return _screw_of_vectors("mechanics.screw_of", algebra, ("force", 0), ("moment", moment), strict=strict)


def screw_from_coordinates(
    values: Any, order: str = "axis-first", algebra: Algebra | None = None, strict: bool = False
) -> Multivector:
    """Screw from six coordinates (..., 6): (w, v) of a twist and (f, tau) of a wrench, or axis last; see `ORDERS`."""
    home = geometry(algebra)
    operand = ArrayOperand(values, 6, "the coordinates")
    rows = operand.rows()
    if as_choice(order, "order", ORDERS) == "axis-last":
        rows = np.roll(rows, 3, -1)
    return finite_screw(
        evaluate(home, "twists.screw_of_row", ArrayOperand(rows, 6, operand.name)).value, "screw", strict
    )


# -- parts -----------------------------------------------------------------------------------------------


def twist_parts(t: Multivector, strict: bool = False) -> TwistParts:
    """Angular velocity and the origin's velocity (..., 3): a named tuple (angular, linear) with ``.status``."""
    return _parts(TwistParts, as_screw(t, "the twist"), "twist_parts", strict)


def wrench_parts(w: Multivector, strict: bool = False) -> WrenchParts:
    """Force (..., 3) and moment about the origin (..., 3), a named tuple (force, moment) with ``.status``."""
    return _parts(WrenchParts, as_screw(w, "the wrench"), "wrench_parts", strict)


@overload
def screw_coordinates(
    s: Multivector, order: str = ..., *, status: Literal[False] = ..., strict: bool = ...
) -> Array: ...
@overload
def screw_coordinates(
    s: Multivector, order: str = ..., *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def screw_coordinates(
    s: Multivector, order: str = "axis-first", *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Coordinates (..., 6) of a screw: (w, v) of a twist and (f, tau) of a wrench, or axis last: (v, w) and (tau, f).

    Featherstone has twists axis first and wrenches axis last, Pinocchio the other way round. Options as of
    `velocity_at`.
    """
    first = as_choice(order, "order", ORDERS) == "axis-first"
    x = as_screw(s, "the screw")
    rows: Array = unsigned_zeros(evaluate(x.algebra, "twists.screw_row", x).value)
    return array_result(rows if first else np.roll(rows, 3, -1), x._status, "screw_coordinates", status, strict, 1)


@overload
def velocity_at(t: Multivector, point: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def velocity_at(
    t: Multivector, point: Any, *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...  # fmt: skip
def velocity_at(
    t: Multivector, point: Any, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Velocity v + w x p (..., 3) of the point of a body that is at p (..., 3).

    Parameters
    ----------
    t : Multivector, shape (...)
        Twists.
    point : array (..., 3), or 0
    status : bool
        Return (velocity, status): `bladesmith.Status` (...), `INVALID` where an operand or the result is not finite.
    strict : bool
        Raise `SingularError` for the first such item.
    """
    x = as_screw(t, "the twist")
    velocity = evaluate(x.algebra, "mechanics.velocity_at", x, _vector(x.algebra, "point", point, x.dtype)).value
    return array_result(unsigned_zeros(plain(velocity)), x._status, "velocity_at", status, strict, 1)


@overload
def moment_about(w: Multivector, point: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def moment_about(
    w: Multivector, point: Any, *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...  # fmt: skip
def moment_about(
    w: Multivector, point: Any, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Moment tau - p x f (..., 3) of a wrench about a point p (..., 3); options as of `velocity_at`."""
    x = as_screw(w, "the wrench")
    moment = evaluate(x.algebra, "twists.moment_about", x, _vector(x.algebra, "point", point, x.dtype)).value
    return array_result(unsigned_zeros(plain(moment)), x._status, "moment_about", status, strict, 1)


# -- products ----------------------------------------------------------------------------------------------


@overload
def power(t: Multivector, w: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def power(t: Multivector, w: Multivector, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def power(
    t: Multivector, w: Multivector, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Power w . tau + v . f (...) of a wrench on a body with a twist: the coefficient of I3 n in Omega ^ W.

    Options as of `velocity_at`.
    """
    return _number("power", "mechanics.power", _as_screws(t, w, "the twist", "the wrench"), status, strict)


@overload
def reciprocal(X: Multivector, Y: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def reciprocal(
    X: Multivector, Y: Multivector, *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
@renamed_keywords(a="X", b="Y")
def reciprocal(
    X: Multivector, Y: Multivector, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Reciprocal product A . D + B . C (...) of screws (A, B) and (C, D): zero where they do no work on each other.

    It is the coefficient of I3 n in their outer product (6.2.3), as `power` is. Options as of `velocity_at`.
    """
    return _number("reciprocal", "mechanics.power", _as_screws(X, Y), status, strict)


@overload
def killing_form(X: Multivector, Y: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def killing_form(
    X: Multivector, Y: Multivector, *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
@renamed_keywords(a="X", b="Y")
def killing_form(
    X: Multivector, Y: Multivector, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Killing form -4 A . C (...) of screws (A, B) and (C, D): four times the scalar product.

    Options as of `velocity_at`.
    """
    return _number("killing_form", "twists.killing_form", _as_screws(X, Y), status, strict)


@renamed_keywords(a="X", b="Y")
def screw_cross(X: Multivector, Y: Multivector, strict: bool = False) -> Multivector:
    """Cross product (A x C, A x D + B x C) of screws (A, B) and (C, D): their negative commutator (6.2.3).

    The cross product of a body's twist and a screw that is fixed to the body is the rate of the screw.
    """
    x, y = _as_screws(X, Y)
    return finite_screw(evaluate(x.algebra, "twists.screw_cross", x, y).value, "screw_cross", strict)


# -- arguments and results ---------------------------------------------------------------------------------


def geometry(algebra: Algebra | None, name: str = "algebra") -> EuclideanAlgebra:
    """Algebra with screws of space; `cga3d` by default.

    Raises
    ------
    InputError, GradeError
        If it is not an algebra, or has no screws of space.
    """
    if algebra is None:
        algebra = stock_algebra("cga3d")
    as_instance(algebra, name, Algebra, "bladesmith.cga3d or pga3d")
    if "twist" not in algebra.kinds or algebra.kind("twist").size != 6:
        raise GradeError(f"{algebra.name} has no screws of space; they are those of cga3d and pga3d.")
    return cast(EuclideanAlgebra, algebra)


def as_screw(x: Any, what: str) -> Multivector:
    """Multivector on the blades of a twist; items that are not finite are NaN and INVALID.

    Raises
    ------
    InputError, GradeError, KindError
        If it is not a multivector, or not a bivector of a motion.
    """
    remedy = "Make it with dynamics.twist, dynamics.wrench or dynamics.screw_from_coordinates"
    bivector = as_instance(x, what, Multivector, "a multivector", remedy=remedy)
    algebra = geometry(bivector.algebra)
    if x.grades != (2,):
        hint = "A line of CGA is a force by dynamics.force_along(line)" if x.grades == (3,) else None
        raise GradeError(f"{what} is a {x.kind.name} of grades {x.grades}; screws are bivectors.", remedy=hint)
    return invalidate_nonfinite(convert_to_kind(bivector, algebra.layout("twist")))


def same_algebra(x: Multivector, y: Multivector) -> None:
    """Raise `AlgebraMismatchError` unless both belong to one algebra."""
    if x.algebra is not y.algebra:
        raise AlgebraMismatchError(f"screws of {x.algebra.name} and of {y.algebra.name} do not mix; convert one.")


def _as_screws(
    a: Any, b: Any, first: str = "the first screw", second: str = "the second screw"
) -> tuple[Multivector, Multivector]:
    x, y = as_screw(a, first), as_screw(b, second)
    same_algebra(x, y)
    return x, y


def _vector(algebra: Algebra, name: str, value: Any, dtype: Any) -> ArrayOperand:
    """Operand of vectors; 0 takes the precision of the other operands."""
    return ArrayOperand(np.zeros(3, dtype) if is_origin(value) else value, algebra.kind("euclidean"), name)


def _screw_of_vectors(formula: str, algebra: Algebra | None, *parts: tuple[str, Any], strict: bool) -> Multivector:
    home = geometry(algebra)
    dtype = common_precision(*(value for _, value in parts if not is_origin(value)))
    operands = [_vector(home, name, value, dtype) for name, value in parts]
    return finite_screw(evaluate(home, formula, *operands).value, formula.rpartition(".")[2], strict)


def finite_screw(x: Multivector, name: str, strict: bool) -> Multivector:
    """Screws, NaN and INVALID where they are not finite; with ``strict`` an error for the first that has no answer."""
    screw = invalidate_nonfinite(x)
    if as_bool(strict, "strict"):
        raise_first(screw._status, name)
    return screw


def _number(
    name: str, formula: str, screws: tuple[Multivector, Multivector], status: bool, strict: bool
) -> Array | tuple[Array, Statuses]:
    values: Array = plain(evaluate(screws[0].algebra, formula, *screws).value)[..., 0]
    return array_result(values[()], merge_statuses(*(x._status for x in screws)), name, status, strict)


def _parts(kind: Callable[..., P], x: Multivector, name: str, strict: bool) -> P:
    if as_bool(strict, "strict"):
        raise_first(x._status, name)
    first, second = (unsigned_zeros(plain(v)) for v in evaluate(x.algebra, "mechanics.screw_vectors", x).values)
    result = kind(first, second)
    result.status = statuses(x._status, x.shape)
    return result


__all__ = [
    "as_screw", "couple", "finite_screw", "geometry", "killing_form", "moment_about", "power", "reciprocal",
    "same_algebra", "screw", "screw_coordinates", "screw_cross", "screw_from_coordinates", "twist", "twist_parts",
    "velocity_at", "wrench", "wrench_parts",
]  # fmt: skip
