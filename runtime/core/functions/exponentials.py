"""exp, log and square root of multivectors, by the formula for their blades.

Motors have the shortest one; every other rotor of up to five dimensions goes through invariant decomposition; exp of
anything else is a series.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.algebra.multivector import Multivector as FormulaMultivector
from ...codegen.errors import GradeError, NotARotorError
from ...codegen.trace import result_kinds
from ...common.dtypes import F32, F64
from ...common.validation import as_bool
from ...dispatch.coefficients import embed
from ...dispatch.formulas import evaluate_batch, item_value
from ...dispatch.item_statuses import invalidate, invalidate_nonfinite, raise_first
from ...status import Status
from ..operators import Operators, P
from .inverses import check_size

#: The series of `exp` runs on arguments of at most 2^-4, halved until they are.
SERIES_EXPONENT, SERIES_TERMS = 4, 12
#: From so many halvings on 2^-k, or its inverse, is no normal number.
MOST_SHARED = 120
#: Binary logarithm of the most coefficients whose sum counts.
SUM_EXPONENT = 16
#: Coefficients up to this size have squares and products of squares that are finite.
MAX_SCALE = {F64: 1e70, F32: 1e8}
#: What says of a kind that its members are all unit versors on its blades.
UNIT = ("x * ~x - 1",)


def exp(x: P, strict: bool = False) -> P:
    """exp(x): in closed form for bivectors, where there is one, else by halving and a series.

    The closed forms are for bivectors of motors in every algebra, and for all bivectors of up to five dimensions if one
    signature of the metric has at most one vector. INVALID: it is not finite.

    The series is accurate to some |x| rounding units of exp |x|, with the sum of absolute coefficients for |x|: of a
    rotation by 1e6, 10 digits are left.
    """
    formula = x._type.memoize("exp", lambda: _exp_formula(x) if x.grades == (2,) else "")
    usual = item_value(x.algebra, formula, (x,)) if formula else None
    if usual is not None and strict is False:
        made: P = _as_versor(usual)
        return made
    value = _as_versor(evaluate_batch(x.algebra, formula, x).value) if formula else _exp_series(x)
    result: P = invalidate_nonfinite(value)
    if as_bool(strict, "strict"):
        raise_first(result._status, "exp")
    return result


def _exp_formula(x: Operators) -> str:
    from ...codegen.formulas.products import exponentials, invariant

    b = result_kinds.member(x.kind.layout, 0)
    q = (b * b).grade(4)
    if not q.terms or (not _has_scalar_square(q) and exponentials.is_motion(b)):
        return "exponentials.exp_bivector"
    return "invariant.exp_bivector" if invariant.decomposes(b) else ""


def _has_scalar_square(q: FormulaMultivector) -> bool:
    """Whether q^2 is seen not to vanish by its scalar part, where q^2 itself may have millions of products."""
    if not q.algebra.is_diagonal:
        return False
    squares = [(q.ring.multiply(x, x), w) for k, x in q.terms.items() for _, w in q.algebra.product(k, k)]
    return bool(q.new({0: q.ring.combine(squares)}).terms)


def _exp_series(x: P) -> P:
    """exp(x) = exp(x / 2^k)^(2^k), for any multivector of any algebra; each item has a k of its own."""
    check_size(x, "exp")
    halvings = _halvings(x._data)
    least, most = (int(halvings.min()), int(halvings.max())) if halvings.size else (0, 0)
    small: P = x / 2.0**most if least == most < MOST_SHARED else x * np.ldexp(x.dtype.type(1), -halvings)
    total: P = small / SERIES_TERMS + 1.0
    for k in range(SERIES_TERMS - 1, 0, -1):
        total = (small * total) / k + 1.0
    for _ in range(least):
        total = total * total
    for step in range(least, most):
        total = _square_some(total, halvings > step)
    return total


def _halvings(data: NDArray[Any]) -> NDArray[np.int32]:
    """How often items are halved until their coefficients' sizes sum to 2^-4; not those that are not finite."""
    with np.errstate(over="ignore"):
        sizes = np.abs(data).sum(-1)
    more, finite = 0, np.isfinite(sizes)
    if not finite.all():  # the sum of finite numbers may be infinite
        sizes, more = np.ldexp(np.abs(data), -SUM_EXPONENT).sum(-1), SUM_EXPONENT
        finite = np.isfinite(sizes)
    fraction, exponents = np.frexp(np.where(finite, sizes, 0))
    return np.asarray(np.maximum(exponents + (more + SERIES_EXPONENT) - (fraction == 0.5), 0), np.int32)


def _square_some(x: P, some: NDArray[np.bool_]) -> P:
    """x, squared where that is selected; of few items only these are computed."""
    indices = np.flatnonzero(some)
    if 2 * len(indices) > some.size:
        square = x * x
        data = np.where(some[..., None], square._data, embed(x, square.kind))
    else:
        part = x._make(x._type, x._data.reshape(-1, x._type.size).take(indices, 0), indices.shape)
        square = part * part
        data = np.array(embed(x, square.kind))
        data.reshape(-1, square._type.size)[indices] = square._data
    result: P = x._make(square._type, data, x._lead, x._status)
    return result


def log(x: P, strict: bool = False) -> P:
    """The bivector b with exp(b) = x, of a unit rotor x; the angle of its rotation is in [0, 2 pi).

    For motors, and for all rotors of up to five dimensions of a metric that is not degenerate and has at most one
    vector of one sign: in cga3d rotations, dilations, translations, transversions and all that they make.

    Parameters
    ----------
    x : Multivector
        Unit rotors; the sign counts, exp(b) = x and not -x.
    strict : bool
        Raise for the first item without an answer.

    Returns
    -------
    Multivector
        `NOT_UNIQUE`: a full turn, alone or with a dilation or a translation; a plane that commutes with it is chosen.
        `SINGULAR` and NaN: there is no such plane, or two rotations by angles that add up to 2 pi leave none fixed.
        `INVALID` and NaN: x ~x is not 1.

    Raises
    ------
    NotARotorError
        If x has no rotor's blades, or the algebra none of these forms.

    Notes
    -----
    Next to a full turn the logarithm is ill-conditioned: at an angle of 2 pi - d a translation t across the axis is
    |t|/d times as long in it, so that exp(log(x)) has t to about 4 |t|/d rounding units: 1e-13 |t| where d is 1e-2,
    1e-5 |t| where it is 1e-10. The shorter way, log of -x, has all digits, as has `poses.log` with ``shortest=True``.
    """
    return _rotor_function(x, "log", strict)


def sqrt(x: P, strict: bool = False) -> P:
    """exp(log(x)/2), of the same rotors as `log` and with its statuses."""
    return _rotor_function(x, "sqrt", strict)


def _rotor_function(x: P, name: str, strict: bool) -> P:
    if not x._type.memoize("even", lambda: 0 in x.grades and all(g % 2 == 0 for g in x.grades)):
        raise NotARotorError(
            f"{name} of a {x.kind.name} of {x.algebra.name}: it has no rotor's blades.",
            remedy="Rotors are even, with a scalar part",
        )
    if not x.algebra.dimension:
        raise NotARotorError(f"{name} in an algebra without vectors: there are no planes to turn in.")
    formula = x._type.memoize(name, lambda: _rotor_formula(x, name))
    try:
        usual = item_value(x.algebra, formula, (x,))
        result: P = evaluate_batch(x.algebra, formula, x).value if usual is None else usual
    except GradeError as error:
        raise NotARotorError(str(error)) from None
    if not x.kind.constraints and not x._largest_coefficient() < MAX_SCALE[x.dtype]:
        with np.errstate(all="ignore"):  # no unit rotor has squares beyond the range of numbers; a formula's test has
            result = invalidate(result, ~np.isfinite(x.scalar_product(~x)._data[..., 0]))
    if x.kind.blades == result.kind.blades == (0,):  # a number's form has no term that would carry NaN
        result = invalidate(result, np.asarray(result.status == Status.INVALID))
    if strict is not False and as_bool(strict, "strict"):
        raise_first(result._status, name, NotARotorError)
    return result if name == "log" else _as_versor(result)


def _rotor_formula(x: Operators, name: str) -> str:
    from ...codegen.formulas.products import exponentials, invariant

    member = result_kinds.member(x.kind.layout, 0)
    if not exponentials.is_motor(member) and invariant.decomposes(member, invertibly=True):
        return f"invariant.{name}_rotor"
    return f"exponentials.{name}_motor"


def _as_versor(x: P) -> P:
    """x, a unit versor by mathematics, of the kind that says so.

    The exact layer does not see it in forms that select their divisors.
    """
    if x.kind.constraints:
        return x
    kind: Kind | None = x._type.memoize("versor", lambda: _versor_kind(x))
    return x if kind is None else x._make(x.algebra.type_of(kind, x.dtype), x._data, x._lead, x._status)


def _versor_kind(x: Operators) -> Kind | None:
    blades = x.kind.blades
    return next((k for k in x.algebra.kinds.values() if k.blades == blades and k.constraints == UNIT), None)


__all__ = ["exp", "log", "sqrt"]
