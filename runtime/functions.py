"""Norms, inverses, exponentials and reflections of runtime multivectors: formulas of the code generator by name.

Each gives statuses per item, and raises with ``strict=True``. What has no formula for the blades at hand is done
by products alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import checks, linear
from .arrays import truth
from .calls import Outcome, call, finite, merged, raise_first, target
from .codegen.errors import GradeError, InputError, NotInvertibleError
from .codegen.kinds import Kind
from .exponentials import exp, log, sqrt
from .general import product_table
from .rows import levelled
from .status import Status

if TYPE_CHECKING:
    from .multivector import Multivector

#: The nearest motor, line, plane or sphere.
NEAREST = "versors.normalise_flat"
#: Methods of the general inverse (thesis 1.2.5).
METHODS = ("shirokov", "hitzer", "matrix")


def norm(x: Multivector) -> NDArray[Any]:
    """sqrt |<x ~x>_0| of each item."""
    x, exponent = levelled(x)
    square = x.scalar_product(linear.mapped(x, "reverse"))
    root = np.sqrt(np.abs(square._data[..., 0]))
    return (root if exponent is None else np.ldexp(root, exponent))[()]  # type: ignore[no-any-return]


def normalized(x: Multivector, kind: str | Kind | None = None, strict: bool = False) -> Multivector:
    """Items at the scale of their kind.

    Points get weight one; what is near a motor or a line becomes the nearest one (scale and screw part); all else
    is divided by its norm. The result is of a constrained kind where every item proves to be a member: three
    points outer-multiplied become a circle, a sum of two circles stays a trivector.

    Parameters
    ----------
    x : Multivector
    kind : str or Kind, optional
        Insist on this kind: items that do not satisfy its constraints get status `INVALID` and NaN.
    strict : bool
        Raise `SingularError` instead of returning statuses.

    Returns
    -------
    Multivector
        `SINGULAR` and NaN where the norm is zero, `IMAGINARY` where the square has the wrong sign for the kind.
    """
    if isinstance(kind, str):
        kind = x.algebra.kind(kind)
    if kind is not None and kind != x.kind:
        result = _of_kind(levelled(checks.converted(x, kind.layout))[0], kind)
    elif x.kind.constraints:
        result = x
    else:
        result = _scaled(levelled(x)[0])
    if truth(strict, "strict"):
        raise_first(result._status, "normalized")
    return result


def _scaled(x: Multivector) -> Multivector:
    """x at unit scale, of the first kind that holds its blades and whose members all items are."""
    for kind in checks.kinds_on(x):
        scaled = _for_kind(checks.converted(x, kind.layout), kind)
        answered = ~np.isnan(scaled._data).all(-1)
        proved = scaled.kind == kind
        if answered.any() and (proved or checks.holds(kind, scaled._data[answered]).all()):
            return x._make(x.algebra.type_of(kind, x.dtype), scaled._data, x._lead, scaled._status)
    return _over_norm(x)


def _for_kind(x: Multivector, kind: Kind) -> Multivector:
    """x, on the kind's blades, scaled in its way: by its weight, to its nearest member, or else by its norm."""
    weights = checks.linear_scale(kind)
    if weights:
        return _by_weight(x, weights)
    if x._type.remembered(("repairs", kind), lambda: _is_repaired(x, kind)):
        return call(x.algebra, NEAREST, x).value  # type: ignore[no-any-return]
    return _over_norm(x)


def _of_kind(x: Multivector, kind: Kind) -> Multivector:
    """x scaled to a kind; items that are no members are invalid."""
    scaled = _for_kind(x, kind)
    answered = ~np.isnan(scaled._data).all(-1)
    bad = answered & ~checks.holds(kind, scaled._data)
    status = merged(scaled._status, np.where(bad, np.uint8(Status.INVALID), np.uint8(Status.OK)))
    data = np.where(bad[..., None], np.nan, scaled._data).astype(x.dtype)
    return x._make(x.algebra.type_of(kind, x.dtype), data, x._lead, status)


def _by_weight(x: Multivector, weights: tuple[float, ...]) -> Multivector:
    """x over the linear form that is 1 for members."""
    row = np.array(weights, x.dtype)
    with np.errstate(all="ignore"):
        weight = x._data @ row
        noise = checks.tolerance(x.dtype) * (np.abs(x._data) @ np.abs(row))
        regular = np.abs(weight) > noise
        data = x._data / np.where(regular, weight, np.nan)[..., None]
    status = np.where(regular, np.uint8(Status.OK), np.uint8(Status.SINGULAR))
    return x._make(x._type, data.astype(x.dtype), x._lead, np.asarray(status, np.uint8))


def _is_repaired(x: Multivector, kind: Kind) -> bool:
    try:
        return target(x.algebra, NEAREST, (x.kind,)).outputs[0].kind == kind
    except GradeError:
        return False


def _over_norm(x: Multivector) -> Multivector:
    value: Multivector = call(x.algebra, "versors.normalise", x).value
    return value


def inverse(x: Multivector, method: str = "shirokov", strict: bool = False) -> Multivector:
    """The y with x y = 1.

    Versors and blades of constrained kinds need no method: their inverse is the reverse, up to sign.

    Raises
    ------
    NotInvertibleError
        With ``strict``, for the first item that has none; else that item is `SINGULAR` and NaN.
    """
    if method not in METHODS:
        raise InputError(f"method is {method!r}; it is one of {', '.join(METHODS)}.")
    refuses = truth(strict, "strict")
    sign = x._type.remembered("unit", lambda: _unit_square(x))
    if sign:
        reverse = linear.mapped(x, "reverse")
        return reverse if sign > 0 else -reverse
    level, exponent = levelled(x)
    outcome = by_matrix(level) if method == "matrix" else _by_adjugate(level, method)
    value: Multivector = outcome.value
    if exponent is not None:
        with np.errstate(all="ignore"):
            data = np.ldexp(value._data, -exponent[..., None])
        value = finite(value._make(value._type.free, data, value._lead, value._status))
    if refuses:
        raise_first(value._status, "inverse", NotInvertibleError)
    return value


def _by_adjugate(x: Multivector, method: str) -> Outcome:
    """Shirokov's or Hitzer's inverse: a stock kernel where there is one, else the formula on these very products."""
    from .codegen.formulas import inverses

    formula = f"inverses.{method}"
    if x.algebra.stock is not None and formula in x.algebra.stock.entries:
        return call(x.algebra, formula, x)
    adjugate: Any = {"shirokov": inverses.shirokov_adjugate, "hitzer": inverses.hitzer_adjugate}[method](x)  # type: ignore[arg-type]
    with np.errstate(all="ignore"):
        value = adjugate / x.scalar_product(adjugate)["1"]
        residual = np.abs((x * value - 1)._data).sum(-1)
        finite = np.isfinite(x._data).all(-1)
        regular = finite & (residual <= float(inverses.RESIDUAL))
    status = np.where(regular, Status.OK, np.where(finite, Status.SINGULAR, Status.INVALID)).astype(np.uint8)
    data = np.where(regular[..., None], value._data, np.nan).astype(x.dtype)
    return Outcome((x._make(value._type, data, x.shape, status),), status)


def by_matrix(x: Multivector) -> Outcome:
    """Inverse through the matrix of y -> x y on the blades that products of x reach (thesis 1.2.5)."""
    matrix, blades = _left_matrix(x)
    unit = np.zeros((*x.shape, len(blades), 1), x.dtype)
    unit[..., blades.index(0), :] = 1
    finite = np.isfinite(x._data).all(-1)
    safe = np.where(finite[..., None, None], matrix, 0)
    with np.errstate(all="ignore"):
        row_scale = np.abs(safe).max(-1, keepdims=True)
        scaled = safe / np.where(row_scale > 0, row_scale, 1)
        condition = np.linalg.cond(scaled, 1) if x.size else np.zeros(x.shape)
        regular = finite & (condition < 1 / checks.tolerance(x.dtype))
        eye = np.eye(len(blades), dtype=x.dtype)
        data = np.linalg.solve(np.where(regular[..., None, None], safe, eye), unit)[..., 0]
    status = np.where(regular, Status.OK, np.where(finite, Status.SINGULAR, Status.INVALID)).astype(np.uint8)
    data = np.where(regular[..., None], data, np.nan).astype(x.dtype)
    out = x.algebra.type_of(x.algebra.layout_of(blades), x.dtype)
    return Outcome((x._make(out, data, x.shape, status),), status)


def _left_matrix(x: Multivector) -> tuple[NDArray[Any], tuple[int, ...]]:
    """The matrix of y -> x y, and its blades: those that the powers of x can have."""
    blades, entries = x._type.remembered("left matrix", lambda: _matrix_entries(x))
    rows, columns, sources, weights = entries
    matrix = np.zeros((*x.shape, len(blades), len(blades)), x.dtype)
    flat = matrix.reshape(*x.shape, len(blades) ** 2)
    for place, source, weight in zip(rows * len(blades) + columns, sources, weights, strict=True):
        flat[..., place] += x._data[..., source] * x.dtype.type(weight)
    return matrix, blades


def _matrix_entries(x: Multivector) -> tuple[tuple[int, ...], tuple[NDArray[Any], ...]]:
    algebra, reached = x.algebra, {0}
    while True:
        found = reached.union(*(product_table(algebra, "geometric", x._type.blades, algebra.order(reached)).blades,))
        if found == reached:
            break
        reached = found
    blades = algebra.order(reached)
    table = product_table(algebra, "geometric", x._type.blades, blades, blades)
    rows = np.repeat(np.arange(len(blades)), np.diff(table.starts))
    return blades, (rows, table.right, table.left, table.weights)


def _unit_square(x: Multivector) -> int:
    """+1 or -1 where x ~x is that for every member of the kind, else 0."""
    from . import proofs

    if not x.kind.constraints:
        return 0
    member = proofs.member(x.kind, 0)
    square = member * ~member
    return next((sign for sign in (1, -1) if not (square - sign).terms), 0)


def reflect(x: Multivector, mirror: Multivector, strict: bool = False) -> Multivector:
    """x reflected, or inverted, in the blade ``mirror`` (thesis 1.3.4).

    Raises
    ------
    GradeError
        If the mirror is not of one grade.
    """
    if len(mirror.grades) != 1:
        raise GradeError(f"the mirror has the grades {mirror.grades}; a blade has one.", remedy="Use .grade(k)")
    outcome = call(x.algebra, "versors.reflect", x, levelled(mirror)[0])
    if truth(strict, "strict"):
        raise_first(outcome.status, "reflect")
    return outcome.value  # type: ignore[no-any-return]


__all__ = ["exp", "inverse", "log", "norm", "normalized", "reflect", "sqrt"]
