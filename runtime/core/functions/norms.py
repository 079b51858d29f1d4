"""Norms, nearest members of kinds, and reflections of runtime multivectors: formulas of the code generator by name.

Each gives statuses per item, and raises with ``strict=True``. What has no formula for the blades at hand is done
by products alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.errors import AlgebraMismatchError, GradeError, KindError
from ...common.dtypes import F64
from ...common.validation import as_bool, as_float
from ...dispatch.coefficients import embed, normalize_exponents
from ...dispatch.formulas import evaluate, item_value, resolve_kernel
from ...dispatch.item_statuses import invalidate_nonfinite, merge_statuses, propagate_invalid, raise_first
from ...dispatch.multivector_data import check_multivector
from ...dispatch.types import Type
from ...status import Status
from .. import kind_constraints, linear_maps
from ..operators import Operators, P
from .nearest_members import distance, nearest_member, spread

#: The nearest motor, line, plane or sphere.
NEAREST = "versors.normalise_flat"
#: Items over their norms.
NORMALISE = "versors.normalise"
#: Deviations whose ratio is less than this say as much as each other.
ALIKE = 4


def norm(x: Operators) -> NDArray[Any]:
    """sqrt |<x ~x>_0| of each item."""
    x, exponent = normalize_exponents(x)
    square = x.scalar_product(linear_maps.apply_linear_map(x, "reverse"))
    root = np.sqrt(np.abs(square._data[..., 0]))
    return (root if exponent is None else np.ldexp(root, exponent))[()]  # type: ignore[no-any-return]


def normalized(x: P, kind: str | Kind | None = None, strict: bool = False, tolerance: float | None = None) -> P:
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
    tolerance : float, optional
        Take the nearest member of the kind, for objects with more rounding than products of this package leave: up to
        this far, and ``.deviation`` of the result says how far it was. Coefficients that the kind does not have count
        as well. Without a kind the smallest is taken that holds all items within the tolerance.

    Returns
    -------
    Multivector
        `SINGULAR` and NaN where the norm is zero, `IMAGINARY` where the square has the wrong sign for the kind;
        `INVALID` where the item is not finite or no member, or with ``tolerance`` none is near.

    Raises
    ------
    KindError
        If all items have a coefficient that the kind does not have; with ``tolerance`` and no kind, if none is near.

    Notes
    -----
    The deviation is the largest change of a coefficient relative to the largest coefficient, in the unit of length in
    which the object is one away from the origin (or nearer). For a circle of radius r at a distance d it is about
    r/d times the change of its shape: rounding of the coefficients at d looks small, and may be large beside r.
    """
    if kind is None and tolerance is None and strict is False and not x._lead and not x.kind.constraints:
        usual = _normalized_item(x)
        if usual is not None:
            return usual
    if isinstance(kind, str):
        kind = x.algebra.kind(kind)
    if tolerance is not None:
        result = nearest(x, kind, tolerance)
    elif kind is not None and kind != x.kind:
        result = _scale_to_kind(normalize_exponents(kind_constraints.convert_to_kind(x, kind.layout))[0], kind)
    elif x.kind.constraints:
        result = x
    else:
        result = _scale_to_first_kind(normalize_exponents(x)[0])
    if not np.isfinite(result._data).all():  # as it is where x is not, or no number holds what is far from its kind
        result = invalidate_nonfinite(propagate_invalid(result, x))
    if as_bool(strict, "strict"):
        raise_first(result._status, "normalized")
    return result


def _normalized_item(x: P) -> P | None:
    """A single item at the scale of the first kind on its blades, if it clearly is a member then."""
    found = x._type.memoize("normalized", lambda: _item_scaling(x))
    if found is None:
        return None
    scale, made, is_member = found
    result: P | None = _over_weight(x, *scale) if isinstance(scale, tuple) else item_value(x.algebra, scale, (x,))
    if result is None or (result._type is not made and not is_member(*result._data.tolist())):
        return None
    result._type = made
    return result


def _item_scaling(x: Operators) -> tuple[str | tuple[NDArray[Any], ...], Type, Callable[..., bool]] | None:
    """How single items are scaled: by a formula, or over the linear form that has these weights."""
    kind = next(iter(kind_constraints.candidate_kinds(x)), None)
    if kind is None or x.dtype != F64 or kind.blades != x._type.blades:
        return None
    weights, scale = kind_constraints.linear_scale(kind), NEAREST if _is_repaired(x, kind) else NORMALISE
    row = np.array(weights or (), F64)
    made, is_member = x.algebra.type_of(kind, F64), kind_constraints.clear_member(x.algebra, kind)
    return (row, np.abs(row)) if weights else scale, made, is_member


def _over_weight(x: P, row: NDArray[Any], sizes: NDArray[Any]) -> P | None:
    """A single item over its weight; None where that is not clearly more than noise, or anything is not finite."""
    with np.errstate(all="ignore"):
        weight = x._data @ row
        if not abs(weight) > kind_constraints.tolerance(F64) * (np.abs(x._data) @ sizes):
            return None
        data = x._data / weight
    return x._make(x._type, data, ()) if np.isfinite(data).all() else None


def nearest(x: P, kind: str | Kind | None, tolerance: Any, noise: float = 0.0) -> P:
    """The nearest members of a kind, or of the smallest that has some within the tolerance for all items.

    ``noise`` is the error of each coefficient relative to the largest of its item, where that is known.
    """
    tolerance = as_float(tolerance, "the tolerance, relative to the coefficients,", 0, below=1)
    flat = normalize_exponents(x.reshape(-1))[0]
    if isinstance(kind, str):
        kind = x.algebra.kind(kind)
    if kind is not None:
        if kind.algebra is not x.algebra:
            raise AlgebraMismatchError(f"{kind!r} is not a kind of {x.algebra.name}; convert the multivector first.")
        made, deviation = _members(flat, kind, noise)
    else:
        usable = np.isfinite(flat._data).all(-1) & (flat._data != 0).any(-1)
        if not usable.any():
            raise KindError("no item is finite and not zero: none tells a kind.", remedy="Say which with kind=")
        fitting = sorted((k for k in x.algebra.kinds.values() if k.constraints), key=lambda k: k.size)
        tries = (_members(flat, k, noise) for k in fitting)
        found = next(((m, d) for m, d in tries if (d[usable] <= tolerance).all()), None)
        if found is None:
            raise KindError(
                f"no kind of {x.algebra.name} has members within {float(tolerance):g} of all items.",
                remedy="Say which with kind=, allow a larger tolerance, or convert to an algebra that has such kinds",
            )
        made, deviation = found
        kind = made.kind
    data = made._data.astype(x.dtype)
    with np.errstate(all="ignore"):
        bad = ~np.isnan(data).all(-1) & ~((deviation <= tolerance) & kind_constraints.satisfies_constraints(kind, data))
    status = merge_statuses(made._status, np.where(bad, np.uint8(Status.INVALID), np.uint8(Status.OK)))
    data[bad] = np.nan
    result = x._make(x.algebra.type_of(kind, x.dtype), data.reshape((*x.shape, kind.size)), x.shape)
    result._status = None if status is None else status.reshape(x.shape)
    result._deviation = deviation.reshape(x.shape)
    return result


def _members(x: P, kind: Kind, noise: float) -> tuple[P, NDArray[Any]]:
    """Members of a kind near items (n,), and how far they are.

    Far from the origin rounding hides the norm of a small object, but not that it was one: items that are as near to a
    member as they stand, or within the noise of their coefficients, are not scaled before.
    """
    layout, unit = x.algebra.type_of(kind.layout, x.dtype), x.algebra.type_of(kind, F64)
    own = x._make(layout, embed(x, kind), x.shape)
    with np.errstate(all="ignore"):
        scaled = _scale_for_kind(own, kind)
        rows, plain = (nearest_member(start, kind) for start in (scaled, own))
        far, also = (distance(x, x._make(unit, data, x.shape)) for data in (rows, plain))
        stays = (also <= np.fmax(ALIKE * far, noise * spread(own, kind))) | (np.isnan(far) & np.isfinite(also))
    status = None if scaled._status is None else np.where(stays, np.uint8(Status.OK), scaled._status)
    found = x._make(unit, np.where(stays[:, None], plain, rows), x.shape, status)
    return found, np.where(stays, also, far)


def _scale_to_first_kind(x: P) -> P:
    """x at unit scale, of the first kind that holds its blades and whose members all items are."""
    for kind in kind_constraints.candidate_kinds(x):
        scaled = _scale_for_kind(kind_constraints.convert_to_kind(x, kind.layout), kind)
        answered = ~np.isnan(scaled._data).all(-1)
        proved = scaled.kind == kind
        if answered.any() and (proved or kind_constraints.satisfies_constraints(kind, scaled._data[answered]).all()):
            return x._make(x.algebra.type_of(kind, x.dtype), scaled._data, x._lead, scaled._status)
    return _divide_by_norm(x)


def _scale_for_kind(x: P, kind: Kind) -> P:
    """x, on the kind's blades, scaled in its way: by its weight, to its nearest member, or else by its norm."""
    weights = kind_constraints.linear_scale(kind)
    if weights:
        return _divide_by_weight(x, weights)
    if x._type.memoize(("repairs", kind), lambda: _is_repaired(x, kind)):
        return evaluate(x.algebra, NEAREST, x).value  # type: ignore[no-any-return]
    return _divide_by_norm(x)


def _scale_to_kind(x: P, kind: Kind) -> P:
    """x scaled to a kind; items that are no members are invalid."""
    scaled = _scale_for_kind(x, kind)
    answered = ~np.isnan(scaled._data).all(-1)
    bad = answered & ~kind_constraints.satisfies_constraints(kind, scaled._data)
    status = merge_statuses(scaled._status, np.where(bad, np.uint8(Status.INVALID), np.uint8(Status.OK)))
    data = np.where(bad[..., None], np.nan, scaled._data).astype(x.dtype)
    return x._make(x.algebra.type_of(kind, x.dtype), data, x._lead, status)


def _divide_by_weight(x: P, weights: tuple[float, ...]) -> P:
    """x over the linear form that is 1 for members."""
    row = np.array(weights, x.dtype)
    with np.errstate(all="ignore"):
        weight = x._data @ row
        noise = kind_constraints.tolerance(x.dtype) * (np.abs(x._data) @ np.abs(row))
        regular = np.abs(weight) > noise
        data = x._data / np.where(regular, weight, np.nan)[..., None]
    status = np.where(regular, np.uint8(Status.OK), np.uint8(Status.SINGULAR))
    return x._make(x._type, data.astype(x.dtype), x._lead, np.asarray(status, np.uint8))


def _is_repaired(x: Operators, kind: Kind) -> bool:
    try:
        return resolve_kernel(x.algebra, NEAREST, (x.kind,)).outputs[0].kind == kind
    except GradeError:
        return False


def _divide_by_norm(x: P) -> P:
    return evaluate(x.algebra, NORMALISE, x).value  # type: ignore[no-any-return]


def reflect(x: P, mirror: P, strict: bool = False) -> P:
    """x reflected, or inverted, in the blade ``mirror`` (thesis 1.3.4).

    Raises
    ------
    GradeError
        If the mirror is not of one grade.
    """
    check_multivector(mirror, "the mirror")
    if len(mirror.grades) != 1:
        raise GradeError(f"the mirror has the grades {mirror.grades}; a blade has one.", remedy="Use .grade(k)")
    outcome = evaluate(x.algebra, "versors.reflect", x, normalize_exponents(mirror)[0])
    if as_bool(strict, "strict"):
        raise_first(outcome.status, "reflect")
    return outcome.value  # type: ignore[no-any-return]
