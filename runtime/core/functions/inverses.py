"""Inverses of general multivectors: by recursion, closed form or matrix, and the choice between them by a residual."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import NotInvertibleError, SignatureError
from ...codegen.trace import result_kinds
from ...common.parallel import interruptible
from ...common.validation import as_bool, as_choice
from ...dispatch.coefficients import embed, normalize_exponents
from ...dispatch.formulas import FormulaResult, evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, propagate_invalid, raise_first
from ...dispatch.product_tables import product_table
from ...status import Status
from .. import kind_constraints, linear_maps
from ..operators import Operators, P

#: Methods of the general inverse (thesis 1.2.5); "auto" chooses for each item.
METHODS = ("auto", "shirokov", "hitzer", "matrix")
#: An inverse y has the digits that x allows if x y - 1 is at most this many rounding units of |x| |y|: linear solvers
#: leave 0.5 to 13, a step of refinement about 1.
ROUNDED = 8
#: In small algebras the recursion is kept up to this, and is refined only: it leaves less for 998 of 1000 random
#: multivectors.
SMALL, ROUNDED_SMALL = 5, 1024
#: Steps of refinement before another method is tried; each squares the residual.
STEPS = 3
#: Matrices of more rows than this are not made unasked: a gigabyte and minutes for each item.
MOST_ROWS = 4096
#: Powers of multivectors on more vectors than this have more coefficients than anybody waits for.
MOST_VECTORS = 12
#: Matrices are solved of so many items at a time that an interrupt is seen after some 0.1 s.
MATRIX_WORK = 2**27
#: Matrices of more rows take longer each.
SLOW_ROWS = 256


def inverse(x: P, method: str = "auto", strict: bool = False) -> P:
    """The y with x y = 1.

    Versors and blades of constrained kinds need no method: their inverse is the reverse, up to sign.

    Parameters
    ----------
    x : Multivector
    method : {"auto", "shirokov", "hitzer", "matrix"}
        "auto" takes Shirokov's recursion where the residual x y - 1 proves that it kept the digits that x allows,
        refines y by Newton's steps where it did not, and solves by the matrix where these do not converge. To five
        dimensions it is nearly always the recursion alone, and never the matrix.
    strict : bool
        Raise instead of returning statuses.

    Returns
    -------
    Multivector
        `SINGULAR` and NaN where there is no inverse, `INVALID` where x is not finite.

    Raises
    ------
    NotInvertibleError
        With ``strict``, for the first item that has none; else that item is `SINGULAR` and NaN.
    SignatureError
        If the blades of x name more than `MOST_VECTORS` vectors, unless its kind says that x is a versor.
    """
    as_choice(method, "method", METHODS)
    refuses = as_bool(strict, "strict")
    value = propagate_invalid(_inverse(x, method), x)
    if refuses:
        raise_first(value._status, "inverse", NotInvertibleError)
    return value


def _inverse(x: P, method: str) -> P:
    sign = x._type.memoize("unit", lambda: _unit_square(x))
    if sign:
        reverse = linear_maps.apply_linear_map(x, "reverse")
        return reverse if sign > 0 else -reverse
    check_size(x, "inverse")
    level, exponent = normalize_exponents(x)
    outcome = _by_bound(level) if method == "auto" else by_matrix(level) if method == "matrix" else None
    outcome = outcome or _by_adjugate(level, method)
    value: P = outcome.value
    if exponent is not None:
        with np.errstate(all="ignore"):
            data = np.ldexp(value._data, -exponent[..., None])
        value = invalidate_nonfinite(value._make(value._type.unconstrained, data, value._lead, value._status))
    return value


def check_size(x: Operators, what: str) -> None:
    """Check that the powers of x, which hold all products of its vectors, are not too large.

    Raises
    ------
    SignatureError
        If its blades name more than `MOST_VECTORS` vectors.
    """
    named = 0
    for blade in x._type.blades:
        named |= blade
    if named.bit_count() > MOST_VECTORS:
        raise SignatureError(
            f"{what} of a multivector whose blades name {named.bit_count()} vectors: it goes to {MOST_VECTORS}.",
            remedy="Multiply by what is known of it: a vector v has the inverse v / (v | v)",
        )


def _by_adjugate(x: Operators, method: str) -> FormulaResult:
    """Shirokov's or Hitzer's inverse: a stock kernel where there is one, else the formula on these very products."""
    formula = f"inverses.{method}"
    if x.algebra.stock is not None and formula in x.algebra.stock.entries:
        return evaluate(x.algebra, formula, x)
    y = _over_determinant(x, method)
    return _with_status(x, y, _residual(x, y))


def _over_determinant(x: P, method: str) -> P:
    from ...codegen.formulas.products import inverses

    adjugate: Any = {"shirokov": inverses.shirokov_adjugate, "hitzer": inverses.hitzer_adjugate}[method](x)  # type: ignore[arg-type]
    with np.errstate(all="ignore"):
        return adjugate / x.scalar_product(adjugate)["1"]  # type: ignore[no-any-return]


def _residual(x: P, y: P) -> P:
    with np.errstate(all="ignore"):
        return x * y - 1


def _with_status(x: Operators, y: Operators, residual: Operators) -> FormulaResult:
    """y with its statuses: there is no inverse where the residual is no small number."""
    from ...codegen.formulas.products import inverses

    with np.errstate(all="ignore"):
        finite = np.isfinite(x._data).all(-1)
        regular = finite & (np.abs(residual._data).sum(-1) <= float(inverses.RESIDUAL))
    status = np.where(regular, Status.OK, np.where(finite, Status.SINGULAR, Status.INVALID)).astype(np.uint8)
    data = np.where(regular[..., None], y._data, np.nan).astype(x.dtype)
    return FormulaResult((x._make(y._type, data, x.shape, status),), status)


def _by_bound(x: Operators) -> FormulaResult:
    """Shirokov's inverse, refined, or that by the matrix: the first that keeps the digits that x allows."""
    if x.algebra.stock is not None and "inverses.shirokov" in x.algebra.stock.entries:
        return _by_adjugate(x, "shirokov")
    y = _over_determinant(x, "shirokov")
    residual = _residual(x, y)
    rough = _is_rough(x, y, residual)
    if not rough.any():
        status = np.zeros(x.shape, np.uint8)
        return FormulaResult((x._make(y._type, y._data, x.shape, status),), status)
    flat, y, residual = (m.reshape(-1) for m in (x, y, residual))
    y, residual = _refine(flat, y, residual, rough.reshape(-1))
    found: Operators = _with_status(flat, y, residual).value
    if x.algebra.dimension > SMALL:
        lost = _is_rough(flat, y, residual) & np.isfinite(_length(flat)) & (_length(flat) > 0)
        found = _with_matrices(flat, found, np.flatnonzero(lost))
    found = found.reshape(x.shape)
    return FormulaResult((found,), found._status)


def _refine(x: P, y: P, residual: P, rough: NDArray[np.bool_]) -> tuple[P, P]:
    """Newton's steps for some of the items (n,), as long as they gain."""
    for _ in range(STEPS):
        indices = np.flatnonzero(rough & (_length(residual) < 1))
        if not len(indices):
            break
        better = y[indices] - y[indices] * residual[indices]
        left = _residual(x[indices], better)
        gain = _length(left) < _length(residual[indices])
        y, residual = (_replace_items(a, indices[gain], b[gain]) for a, b in ((y, better), (residual, left)))
        rough = _is_rough(x, y, residual) if gain.any() else np.zeros_like(rough)
    return y, residual


def _is_rough(x: Operators, y: Operators, residual: Operators) -> NDArray[np.bool_]:
    """Mark where the residual is more than what rounding leaves of the product, or no small number."""
    from ...codegen.formulas.products.inverses import RESIDUAL

    units = ROUNDED_SMALL if x.algebra.dimension <= SMALL else ROUNDED
    with np.errstate(all="ignore"):
        bound = (units * float(np.finfo(x.dtype).eps)) ** 2 * _squared_length(x) * _squared_length(y)
        return np.asarray(~(_squared_length(residual) <= np.minimum(bound, float(RESIDUAL) ** 2 / residual._type.size)))


def _squared_length(x: Operators) -> NDArray[Any]:
    return np.einsum("...i,...i->...", x._data, x._data)  # type: ignore[no-any-return]


def _length(x: Operators) -> NDArray[Any]:
    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(_squared_length(x)))


def _replace_items(x: P, indices: NDArray[Any], by: P) -> P:
    """x with other items at some indices, on the blades of both."""
    kind = x.algebra.layout_of({*x._type.blades, *by._type.blades})
    data = np.array(embed(x, kind))
    data[indices] = embed(by, kind)
    status = None if x._status is None else x._status.copy()
    if status is not None and by._status is not None:
        status[indices] = by._status
    return x._make(x.algebra.type_of(kind, x.dtype), data, x.shape, status)


def _with_matrices(x: P, y: P, indices: NDArray[Any]) -> P:
    """y with these items solved by matrices, where they are not too large."""
    if not len(indices):
        return y
    if _row_count(x) > MOST_ROWS:
        return y
    solved = by_matrix(x[indices])
    regular = solved.status == Status.OK  # the residual has proved some that the matrix's condition only suspects
    result: P = _replace_items(y, indices[regular], solved.value[regular])
    return result


def by_matrix(x: P) -> FormulaResult:
    """Inverse through the matrix of y -> x y on the blades that products of x reach (thesis 1.2.5)."""
    rows, items = _row_count(x), x.reshape(-1)
    count = max(1, MATRIX_WORK // rows**3)
    solve = _solve_matrices if rows <= SLOW_ROWS else lambda part: interruptible(lambda: _solve_matrices(part))
    parts = [solve(items[i : i + count]) for i in range(0, max(items.size, 1), count)]
    data, status = (np.concatenate(part) for part in zip(*parts, strict=True))
    blades = x._type.memoize("left matrix", lambda: _matrix_entries(x))[0]
    out = x.algebra.type_of(x.algebra.layout_of(blades), x.dtype)
    data, status = data.reshape((*x.shape, out.size)), status.reshape(x.shape)
    return FormulaResult((x._make(out, data, x.shape, status),), status)


def _solve_matrices(x: Operators) -> tuple[NDArray[Any], NDArray[np.uint8]]:
    """Coefficients of inverses and their statuses."""
    from ...codegen.formulas.products.inverses import RESIDUAL

    matrix, blades = _left_matrix(x)
    unit = np.zeros((*x.shape, len(blades), 1), x.dtype)
    unit[..., blades.index(0), :] = 1
    finite = np.isfinite(x._data).all(-1)
    safe = np.where(finite[..., None, None], matrix, 0)
    with np.errstate(all="ignore"):
        row_scale = np.abs(safe).max(-1, keepdims=True)
        scaled = safe / np.where(row_scale > 0, row_scale, 1)
        condition = np.linalg.cond(scaled, 1) if x.size else np.zeros(x.shape)
        possible = finite & (condition < 1 / np.finfo(x.dtype).eps)
        matrix = np.where(possible[..., None, None], safe, np.eye(len(blades), dtype=x.dtype))
        data = np.linalg.solve(matrix, unit)
        # the bound by the condition is far from sharp: beyond the tolerance the residual decides
        proved = np.abs(matrix @ data - unit).sum((-2, -1)) <= float(RESIDUAL)
        regular = possible & (proved | (condition < 1 / kind_constraints.tolerance(x.dtype)))
        data = data[..., 0]
    status = np.where(regular, Status.OK, np.where(finite, Status.SINGULAR, Status.INVALID)).astype(np.uint8)
    return np.where(regular[..., None], data, np.nan).astype(x.dtype), status


def _row_count(x: Operators) -> int:
    return len(x._type.memoize("left matrix", lambda: _matrix_entries(x))[0])


def _left_matrix(x: Operators) -> tuple[NDArray[Any], tuple[int, ...]]:
    """The matrix of y -> x y, and its blades: those that the powers of x can have."""
    blades, entries = x._type.memoize("left matrix", lambda: _matrix_entries(x))
    rows, columns, sources, weights = entries
    matrix = np.zeros((*x.shape, len(blades), len(blades)), x.dtype)
    flat = matrix.reshape(*x.shape, len(blades) ** 2)
    for place, source, weight in zip(rows * len(blades) + columns, sources, weights, strict=True):
        flat[..., place] += x._data[..., source] * x.dtype.type(weight)
    return matrix, blades


def _matrix_entries(x: Operators) -> tuple[tuple[int, ...], tuple[NDArray[Any], ...]]:
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


def _unit_square(x: Operators) -> int:
    """+1 or -1 where x ~x is that for every member of the kind, else 0."""
    if not x.kind.constraints:
        return 0
    member = result_kinds.member(x.kind, 0)
    square = member * ~member
    return next((sign for sign in (1, -1) if not (square - sign).terms), 0)


__all__ = ["by_matrix", "inverse"]
