"""Screws of lines (thesis 3.9): sums of dual lines taken apart and put together, arguments checked, results named.

The formulas are in `codegen.formulas.motions.screws`. Twists follow the project's conventions: the motor of a screw is
exp(-angle/2 (L* + pitch m n_inf)), and the pitch is the advance per radian.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import GradeError
from ..common.deprecation import renamed_keywords
from ..common.validation import as_bool, as_instance, real_array
from ..core.geometry.parameters import Parameters
from ..core.kind_constraints import convert_to_kind
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite, raise_first
from ..dispatch.multivector_data import statuses
from ..status import Status
from .arguments import same_sort
from .closest_points import as_lines, closest_point, plain

Array = NDArray[Any]


class Screw(NamedTuple("Screw", [("axis", Multivector), ("pitch", Array), ("magnitude", Array)]), Parameters):
    """Axis, pitch and magnitude, with ``.status``."""


def screw(s: Multivector, strict: bool = False) -> Screw:
    """Axis, pitch and magnitude of a screw: s = magnitude (L* + pitch m n_inf), L the axis and m its direction.

    Parameters
    ----------
    s : Multivector, shape (...)
        Twist bivectors, for example sums of dual lines (in PGA: of lines). In CGA also sums of lines, which are
        dualised. Their scale is arbitrary.
    strict : bool
        Raise `SingularError` for the first item that is not a screw.

    Returns
    -------
    Screw
        Named tuple (axis, pitch, magnitude) with ``.status`` per item. ``axis`` is a unit line, ``pitch`` the
        advance per radian along it, ``magnitude`` ``|m|``. A translation by the bivector t n_inf has no axis of its
        own: `NOT_UNIQUE`, the line through the origin along t, infinite pitch, magnitude ``|t|``. Zero is `SINGULAR`.

    Raises
    ------
    GradeError
        If s has blades that a twist has not.

    Notes
    -----
    Thesis 3.9.3 and 3.9.4, with the signs of this project: (3.9) as printed is the line through -p. A translation is
    recognized by a rotation that is exactly zero: in a bivector alone there is nothing to measure rounding by. Of two
    lines, `screw_of_lines` can tell.
    """
    twist = _twist(s)
    outcome = evaluate(twist.algebra, "screws.screw", twist)
    return _screw(outcome.values, outcome.status, twist.shape, "screw", strict)


@renamed_keywords(first="X", second="Y")
def screw_of_lines(X: Any, Y: Any, alpha: Any = 0.5, strict: bool = False) -> tuple[Screw, Array]:
    """The screw of alpha X* + (1 - alpha) Y*, and where its axis lies between the lines.

    Parameters
    ----------
    X, Y : Multivector
        Unit lines of CGA or PGA; shapes broadcast.
    alpha : float or array
        Weight of X, one per item.

    Returns
    -------
    (Screw, array)
        The screw as in `screw`, and the fraction of the lines' common perpendicular, 0 on X and 1 on Y, at which
        the axis passes through: (b^2 + a b c)/(a^2 + b^2 + 2 a b c) with a = alpha, b = 1 - alpha and the cosine c of
        the directions. Where the directions cancel there is a translation (NOT_UNIQUE), fraction NaN.
    """
    a, b = (_lines(x, what) for x, what in ((X, "the first lines"), (Y, "the second lines")))
    same_sort(a, b)
    outcome = evaluate(a.algebra, "screws.screw_of_lines", a, b, ArrayOperand(alpha, 0, "alpha"))
    axis, pitch, magnitude, fraction = outcome.values
    found = _screw((axis, pitch, magnitude), outcome.status, axis.shape, "screw_of_lines", strict)
    return found, plain(fraction)[()]


def screw_bivector(axis: Any, pitch: Any = 0.0, magnitude: Any = 1.0) -> Multivector:
    """magnitude (L* + pitch m n_inf), the twist bivector of a screw: what `screw` takes apart.

    An infinite pitch stands for a translation along the axis of the length ``magnitude``, as `screw` gives it.
    """
    line = _lines(axis, "the axis")
    h, size = real_array(pitch, "the pitch"), real_array(magnitude, "the magnitude")
    moves = np.isinf(h)
    turning = np.where(moves, np.copysign(0.0, h), h).astype(h.dtype)
    operands = ArrayOperand(turning, 0, "the pitch"), ArrayOperand(size, 0, "the magnitude")
    found: Multivector = evaluate(line.algebra, "screws.screw_bivector", line, *operands).value
    if not moves.any():
        return invalidate_nonfinite(found)
    sign = np.sign(h)
    one = evaluate(line.algebra, "screws.screw_bivector", line, ArrayOperand(sign, 0, "the pitch"), operands[1]).value
    translation = one - found  # (L* + m n) - L*
    data = np.where(np.broadcast_to(moves, found.shape)[..., None], translation._data, found._data)
    return invalidate_nonfinite(found._make(found._type.unconstrained, data, found.shape))


def screw_motor(axis: Any, angle: Any, pitch: Any = 0.0, strict: bool = False) -> Multivector:
    """The motor that turns by ``angle`` about a line and advances by ``pitch * angle`` along it.

    Parameters
    ----------
    axis : Multivector, shape (...)
        Unit lines of CGA or PGA.
    angle, pitch : float or array
        Radians, and units of length per radian. An item that is not finite is `INVALID`.
    """
    line = _lines(axis, "the axis")
    operands = ArrayOperand(angle, 0, "the angle"), ArrayOperand(pitch, 0, "the pitch")
    motor = invalidate_nonfinite(evaluate(line.algebra, "screws.screw_motor", line, *operands).value)
    if as_bool(strict, "strict"):
        raise_first(motor._status, "screw_motor")
    return motor  # type: ignore[no-any-return]


# -- arguments and results ---------------------------------------------------------------------------------


def _twist(s: Multivector) -> Multivector:
    """s on the blades of a twist, lines of CGA dualised."""
    as_instance(s, "a screw", Multivector, "a multivector", remedy="Add dual lines: a.dual() + b.dual()")
    algebra = s.algebra
    if "twist" not in algebra.kinds:
        raise GradeError(f"{algebra.name} has no screws; they are those of cga3d and pga3d.")
    if s.grades == (3,) and not algebra.is_degenerate:
        s = convert_to_kind(s, algebra.layout("line")).dual()
    if s.grades != (2,):
        raise GradeError(
            f"a {s.kind.name} of grades {s.grades} is not a twist: a bivector, a sum of dual lines, is needed."
        )
    return convert_to_kind(s, algebra.layout("twist"))


def _lines(x: Any, what: str) -> Multivector:
    """Unit lines of CGA or PGA."""
    if isinstance(x, Multivector) and x.algebra.is_degenerate:
        if "line" not in x.algebra.kinds:
            raise GradeError(f"{what}: {x.algebra.name} has no lines.")
        return x.as_kind("line")
    return as_lines(x, what)


def _screw(values: Sequence[Any], status: Any, shape: tuple[int, ...], name: str, strict: bool) -> Screw:
    axis, pitch, magnitude = values
    if as_bool(strict, "strict"):
        raise_first(status, name)
    h = plain(pitch)
    if status is not None:
        h = np.where(status == Status.NOT_UNIQUE, h.dtype.type(np.inf), h)
    result = Screw(invalidate_nonfinite(axis), h[()], plain(magnitude)[()])
    result.status = statuses(status, shape)
    return result


__all__ = ["Screw", "closest_point", "screw", "screw_bivector", "screw_motor", "screw_of_lines"]
