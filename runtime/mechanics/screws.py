"""Twists and wrenches as multivectors, their parts and products: arguments checked, results named (thesis 6.2, 6.3).

A twist is w I3 + v n with the velocity v of the frame's origin, a wrench f I3 + tau n with the moment tau about it.
n is the null vector n_inf of CGA or e0 of PGA. The formulas are in `codegen.formulas`: `twists` and `mechanics`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..algebras import Algebra
from ..arrays import truth
from ..calls import Numbers, call, finite, raise_first
from ..checks import converted
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError
from ..euclidean import is_origin, parameters_class, plain
from ..loading import stock_algebra
from ..multivector import Multivector
from ..objects.inputs import chosen
from ..objects.screws import screw
from ..text import statuses

Array = NDArray[Any]
TwistParts = parameters_class("TwistParts", "angular", "linear")
WrenchParts = parameters_class("WrenchParts", "force", "moment")
#: Orders of a screw's six numbers: (w, v) and (f, tau), or (v, w) and (tau, f).
ORDERS = ("axis-first", "axis-last")


# -- making ------------------------------------------------------------------------------------------------


def twist(angular: Any, linear: Any = 0, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """The twist w I3 + v n of a body.

    Parameters
    ----------
    angular : array (..., 3), or 0
        Angular velocity, radians per unit of time, counter-clockwise.
    linear : array (..., 3), or 0
        Velocity of the point of the body that is at the frame's origin.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.

    Returns
    -------
    Multivector, shape (...)
        Points of the body move by dX = X x Omega, the commutator with the half. `INVALID`: not finite.
    """
    return _made("mechanics.screw_of", algebra, ("angular", angular), ("linear", linear), strict=strict)


def wrench(force: Any, point: Any = 0, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """The wrench f I3 + (p x f) n of a force (..., 3) whose line of action passes through a point (..., 3), or 0."""
    return _made("mechanics.wrench_at", algebra, ("force", force), ("point", point), strict=strict)


def couple(moment: Any, algebra: Algebra | None = None, strict: bool = False) -> Multivector:
    """The wrench tau n of a pure moment (..., 3): two opposite forces, wherever they act."""
    return _made("mechanics.screw_of", algebra, ("force", 0), ("moment", moment), strict=strict)


def screw_from_coordinates(
    values: Any, order: str = "axis-first", algebra: Algebra | None = None, strict: bool = False
) -> Multivector:
    """A screw from six numbers (..., 6): (w, v) of a twist and (f, tau) of a wrench, or axis last; see `ORDERS`."""
    home = geometry(algebra)
    operand = Numbers(values, 6, "the coordinates")
    rows = operand.rows()
    if chosen(order, ORDERS, "order") == "axis-last":
        rows = np.roll(rows, 3, -1)
    return _finished(call(home, "twists.screw_of_row", Numbers(rows, 6, operand.name)).value, "screw", strict)


# -- reading -----------------------------------------------------------------------------------------------


def twist_parts(t: Multivector) -> Any:
    """Angular velocity and the origin's velocity (..., 3): a named tuple (angular, linear) with ``.status``."""
    return _parts(TwistParts, as_screw(t, "the twist"))


def wrench_parts(w: Multivector) -> Any:
    """Force (..., 3) and moment about the origin (..., 3), a named tuple (force, moment) with ``.status``."""
    return _parts(WrenchParts, as_screw(w, "the wrench"))


def screw_coordinates(s: Multivector, order: str = "axis-first") -> Array:
    """Six numbers (..., 6) of a screw: (w, v) of a twist and (f, tau) of a wrench, or axis last: (v, w) and (tau, f).

    Featherstone has twists axis first and wrenches axis last, Pinocchio the other way round.
    """
    first = chosen(order, ORDERS, "order") == "axis-first"
    x = as_screw(s, "the screw")
    rows: Array = call(x.algebra, "twists.screw_row", x).value + 0.0  # no -0.0
    return rows if first else np.roll(rows, 3, -1)


def velocity_at(t: Multivector, point: Any) -> Array:
    """Velocity v + w x p (..., 3) of the point of a body that is at p (..., 3)."""
    x = as_screw(t, "the twist")
    return plain(call(x.algebra, "mechanics.velocity_at", x, _vector(x.algebra, "point", point, x.dtype)).value) + 0.0


def moment_about(w: Multivector, point: Any) -> Array:
    """Moment tau - p x f (..., 3) of a wrench about a point p (..., 3)."""
    x = as_screw(w, "the wrench")
    return plain(call(x.algebra, "twists.moment_about", x, _vector(x.algebra, "point", point, x.dtype)).value) + 0.0


# -- products ----------------------------------------------------------------------------------------------


def power(t: Multivector, w: Multivector) -> Array:
    """w . tau + v . f (...): the power of a wrench on a body with a twist, the coefficient of I3 n in Omega ^ W."""
    return _number("mechanics.power", *_two(t, w, "the twist", "the wrench"))


def reciprocal(a: Multivector, b: Multivector) -> Array:
    """Reciprocal product A . D + B . C (...) of screws (A, B) and (C, D): zero where they do no work on each other.

    It is the coefficient of I3 n in their outer product (6.2.3), as `power` is.
    """
    return _number("mechanics.power", *_two(a, b, "the first screw", "the second screw"))


def killing_form(a: Multivector, b: Multivector) -> Array:
    """-4 A . C (...) of screws (A, B) and (C, D): four times the scalar product."""
    return _number("twists.killing_form", *_two(a, b, "the first screw", "the second screw"))


def screw_cross(a: Multivector, b: Multivector) -> Multivector:
    """Cross product (A x C, A x D + B x C) of screws (A, B) and (C, D): less their commutator (6.2.3).

    Of a body's twist and a screw that is fixed to it, its rate.
    """
    x, y = _two(a, b, "the first screw", "the second screw")
    return finite(call(x.algebra, "twists.screw_cross", x, y).value)


# -- arguments and results ---------------------------------------------------------------------------------


def geometry(algebra: Algebra | None) -> Algebra:
    """The algebra that is asked for, one with screws.

    Raises
    ------
    InputError, GradeError
        If it is no algebra, or has no screws of space.
    """
    if algebra is None:
        return stock_algebra("cga3d")
    if not isinstance(algebra, Algebra):
        raise InputError(f"algebra is a {type(algebra).__name__}; bladesmith.cga3d or pga3d is needed.")
    if "twist" not in algebra.kinds or algebra.kind("twist").size != 6:
        raise GradeError(f"{algebra.name} has no screws of space; they are those of cga3d and pga3d.")
    return algebra


def as_screw(x: Any, what: str) -> Multivector:
    """x on the blades of a twist; items that are not finite are NaN and INVALID.

    Raises
    ------
    InputError, GradeError, KindError
        If it is no multivector, or no bivector of a motion.
    """
    if not isinstance(x, Multivector):
        raise InputError(
            f"{what} is a {type(x).__name__}; a multivector is needed.",
            remedy="Make it with dynamics.twist, dynamics.wrench or dynamics.screw_from_coordinates",
        )
    algebra = geometry(x.algebra)
    if x.grades != (2,):
        remedy = "A line of CGA is a force by dynamics.force_along(line)" if x.grades == (3,) else None
        raise GradeError(f"{what} is a {x.kind.name} of grades {x.grades}; screws are bivectors.", remedy=remedy)
    return finite(converted(x, algebra.layout("twist")))


def same_algebra(x: Multivector, y: Multivector) -> None:
    """Raise unless both belong to one algebra."""
    if x.algebra is not y.algebra:
        raise AlgebraMismatchError(f"screws of {x.algebra.name} and of {y.algebra.name} do not mix; convert one.")


def _two(a: Any, b: Any, first: str, second: str) -> tuple[Multivector, Multivector]:
    x, y = as_screw(a, first), as_screw(b, second)
    same_algebra(x, y)
    return x, y


def _vector(algebra: Algebra, name: str, value: Any, dtype: Any) -> Numbers:
    """Operand: vectors, or 0 in the precision of the other operands."""
    return Numbers(np.zeros(3, dtype) if is_origin(value) else value, algebra.kind("euclidean"), name)


def _made(formula: str, algebra: Algebra | None, *parts: tuple[str, Any], strict: bool) -> Multivector:
    home = geometry(algebra)
    dtype = arrays.precision(*(value for _, value in parts if not is_origin(value)))
    operands = [_vector(home, name, value, dtype) for name, value in parts]
    return _finished(call(home, formula, *operands).value, formula.rpartition(".")[2], strict)


def _finished(x: Multivector, name: str, strict: bool) -> Multivector:
    found = finite(x)
    if truth(strict, "strict"):
        raise_first(found._status, name)
    return found


def _number(formula: str, *operands: Multivector) -> Array:
    found: Array = plain(call(operands[0].algebra, formula, *operands).value)[..., 0]
    return found[()]


def _parts(kind: Any, x: Multivector) -> Any:
    first, second = (plain(v) + 0.0 for v in call(x.algebra, "mechanics.screw_vectors", x).values)  # no -0.0
    result = kind(first, second)
    result.status = statuses(x._status, x.shape)
    return result


__all__ = [
    "as_screw", "couple", "geometry", "killing_form", "moment_about", "power", "reciprocal", "same_algebra", "screw",
    "screw_coordinates", "screw_cross", "screw_from_coordinates", "twist", "twist_parts", "velocity_at", "wrench",
    "wrench_parts",
]  # fmt: skip
