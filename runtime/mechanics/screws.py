"""Twists and wrenches as multivectors, their parts and products (thesis 6.2, 6.3).

A twist is w I3 + v n with the velocity v of the frame's origin, a wrench f I3 + tau n with the moment tau about it.
n is the null vector n_inf of CGA or e0 of PGA. The formulas are in `codegen.formulas`: `twists` and `mechanics`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, cast

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
from ..dispatch.formulas import ArrayOperand, evaluate, invalidate_nonfinite, raise_first
from ..dispatch.multivector_data import statuses
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
    return _finite_screw(
        evaluate(home, "twists.screw_of_row", ArrayOperand(rows, 6, operand.name)).value, "screw", strict
    )


# -- parts -----------------------------------------------------------------------------------------------


def twist_parts(t: Multivector) -> TwistParts:
    """Angular velocity and the origin's velocity (..., 3): a named tuple (angular, linear) with ``.status``."""
    return _parts(TwistParts, as_screw(t, "the twist"))


def wrench_parts(w: Multivector) -> WrenchParts:
    """Force (..., 3) and moment about the origin (..., 3), a named tuple (force, moment) with ``.status``."""
    return _parts(WrenchParts, as_screw(w, "the wrench"))


def screw_coordinates(s: Multivector, order: str = "axis-first") -> Array:
    """Coordinates (..., 6) of a screw: (w, v) of a twist and (f, tau) of a wrench, or axis last: (v, w) and (tau, f).

    Featherstone has twists axis first and wrenches axis last, Pinocchio the other way round.
    """
    first = as_choice(order, "order", ORDERS) == "axis-first"
    x = as_screw(s, "the screw")
    rows: Array = evaluate(x.algebra, "twists.screw_row", x).value + 0.0  # no -0.0
    return rows if first else np.roll(rows, 3, -1)


def velocity_at(t: Multivector, point: Any) -> Array:
    """Velocity v + w x p (..., 3) of the point of a body that is at p (..., 3)."""
    x = as_screw(t, "the twist")
    return (
        plain(evaluate(x.algebra, "mechanics.velocity_at", x, _vector(x.algebra, "point", point, x.dtype)).value) + 0.0
    )


def moment_about(w: Multivector, point: Any) -> Array:
    """Moment tau - p x f (..., 3) of a wrench about a point p (..., 3)."""
    x = as_screw(w, "the wrench")
    return plain(evaluate(x.algebra, "twists.moment_about", x, _vector(x.algebra, "point", point, x.dtype)).value) + 0.0


# -- products ----------------------------------------------------------------------------------------------


def power(t: Multivector, w: Multivector) -> Array:
    """Power w . tau + v . f (...) of a wrench on a body with a twist: the coefficient of I3 n in Omega ^ W."""
    return _number("mechanics.power", *_as_screws(t, w, "the twist", "the wrench"))


@renamed_keywords(a="X", b="Y")
def reciprocal(X: Multivector, Y: Multivector) -> Array:
    """Reciprocal product A . D + B . C (...) of screws (A, B) and (C, D): zero where they do no work on each other.

    It is the coefficient of I3 n in their outer product (6.2.3), as `power` is.
    """
    return _number("mechanics.power", *_as_screws(X, Y, "the first screw", "the second screw"))


@renamed_keywords(a="X", b="Y")
def killing_form(X: Multivector, Y: Multivector) -> Array:
    """Killing form -4 A . C (...) of screws (A, B) and (C, D): four times the scalar product."""
    return _number("twists.killing_form", *_as_screws(X, Y, "the first screw", "the second screw"))


@renamed_keywords(a="X", b="Y")
def screw_cross(X: Multivector, Y: Multivector) -> Multivector:
    """Cross product (A x C, A x D + B x C) of screws (A, B) and (C, D): their negative commutator (6.2.3).

    The cross product of a body's twist and a screw that is fixed to the body is the rate of the screw.
    """
    x, y = _as_screws(X, Y, "the first screw", "the second screw")
    return invalidate_nonfinite(evaluate(x.algebra, "twists.screw_cross", x, y).value)  # type: ignore[no-any-return]


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


def _as_screws(a: Any, b: Any, first: str, second: str) -> tuple[Multivector, Multivector]:
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
    return _finite_screw(evaluate(home, formula, *operands).value, formula.rpartition(".")[2], strict)


def _finite_screw(x: Multivector, name: str, strict: bool) -> Multivector:
    screw = invalidate_nonfinite(x)
    if as_bool(strict, "strict"):
        raise_first(screw._status, name)
    return screw


def _number(formula: str, *operands: Multivector) -> Array:
    values: Array = plain(evaluate(operands[0].algebra, formula, *operands).value)[..., 0]
    return values[()]


def _parts(kind: Callable[..., P], x: Multivector) -> P:
    first, second = (plain(v) + 0.0 for v in evaluate(x.algebra, "mechanics.screw_vectors", x).values)  # no -0.0
    result = kind(first, second)
    result.status = statuses(x._status, x.shape)
    return result


__all__ = [
    "as_screw", "couple", "geometry", "killing_form", "moment_about", "power", "reciprocal", "same_algebra", "screw",
    "screw_coordinates", "screw_cross", "screw_from_coordinates", "twist", "twist_parts", "velocity_at", "wrench",
    "wrench_parts",
]  # fmt: skip
