"""Sums of objects, projected to objects: interpolation, its rate, averages, consistent orientation (chapter 3).

Statuses say where a sum is imaginary or vanishes. What is far from the origin is added about a local one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import GradeError, InputError
from ...common.deprecation import renamed_keywords
from ...common.validation import as_bool, as_choice, broadcast_shapes, real_array
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed, normalize_exponents
from ...dispatch.formulas import ArrayOperand, FormulaResult, evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, merge_statuses, raise_first
from ...status import Status
from ..arguments import as_objects, pair
from ..rotors import local_origin
from .sums import (
    assemble,
    block_sum,
    checked_axis,
    first_along,
    is_opposite,
    negate_where,
    normalized_weights,
    to_common_layout,
    to_layout,
)

#: How `interpolate` goes from one object to the other.
METHODS = ("direct", "rotor")


def project_to_blade(X: Multivector, strict: bool = False) -> Multivector:
    """The unit object that a sum of objects stands for: S X with the projector S of thesis 3.5.

    Parameters
    ----------
    X : Multivector, shape (...)
        Multivectors of one grade, 1 to 4; of any scale. A vector is taken as a sum of points, which becomes the point
        at their weighted mean (3.1).
    strict : bool
        Raise for the first item without an answer, instead of giving it a status.

    Returns
    -------
    Multivector, shape (...)
        Point pairs, lines, circles, planes, spheres or points. Items with NaN and

        - `IMAGINARY` stand for no real object: Sigma = -X ~X has no real square root;
        - `SINGULAR` have no length but rounding noise (a line added to its opposite), or a radius of zero;
        - `INVALID` are not finite.

    Raises
    ------
    InputError, GradeError
        If X is not a multivector of conformal geometry, or not of one grade from 1 to 4.
    SingularError
        With ``strict``.

    Notes
    -----
    Where -<X ~X>_0 < 0 the root is taken by its other split, so nothing cancels. Far from the origin the sum is
    projected about a local one; but it holds a radius r at a distance c to (c/r)^2 rounding units only. `interpolate`,
    `average` and the curves do better: they add about a local origin.
    """
    if not isinstance(X, Multivector) or "ni" not in X.algebra.vectors:
        raise InputError("X is not a multivector of conformal geometry.", remedy="Make objects with bladesmith.cga3d")
    if len(X.grades) != 1 or not 1 <= X.grades[0] <= X.algebra.dimension - 1:
        raise GradeError(f"X has the grades {tuple(X.grades)}; a sum of objects has one grade, 1 to 4.")
    refuses = as_bool(strict, "strict")
    x = normalize_exponents(to_layout(X, X.kind))[0]  # squares overflow before numbers do

    def compute(frame: local_origin.Frame | None) -> Multivector:
        if frame is None:
            return assemble(evaluate(X.algebra, "blades.project_sum", x, x), (X,))
        written = x._make(x._type, np.abs(x._data), x.shape)
        outcome = evaluate(X.algebra, "blades.project_sum", to_layout(~frame.translator >> x, X.kind), written)
        return assemble(outcome, (X,), frame)

    return _checked(local_origin.for_each(compute, x), "project_to_blade", refuses)


@renamed_keywords(X1="X", X2="Y")
def interpolate(
    X: Any, Y: Any, *, alpha: Any, method: str = "direct", align: bool = False, strict: bool = False
) -> Multivector:
    """Objects between two objects: alpha = 1 is X, alpha = 0 is Y.

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Objects of one grade; rounds and flats may be mixed.
    alpha : float or array
        Broadcasts with the batch. Any real number: outside [0, 1] the sum is extrapolated.
    method : str
        "direct": alpha X + (1 - alpha) Y, projected (thesis 3.5). "rotor": X moved by exp((1 - alpha) log R) with R
        from `rotor_between` (2.5), which goes to -Y where R does. Points go along the straight line with both (3.1).
    align : bool
        Turn Y round first where gamma <X Y>_0 < 0; see `align`. With it alpha = 0 is -Y there.
    strict : bool
        Raise for the first item without an answer, instead of giving it a status.

    Returns
    -------
    Multivector, shape (...)
        Unit objects; statuses as of `project_to_blade`. IMAGINARY happens: of two spheres apart from each other, of
        like orientation, some interpolants are imaginary. SINGULAR: half way between L and -L.

    Raises
    ------
    InputError, GradeError, AlgebraMismatchError, ShapeError
        If the operands are no objects of one grade, or the shapes do not broadcast; for an unknown method.
    SingularError
        With ``strict``.

    Notes
    -----
    Circles on a common sphere stay on it (Theorem 4), point pairs on theirs (Theorem 2). Lines take the axis of the
    screw that the sum is; the normals of planes and the duals' offsets interpolate linearly; two outward spheres take
    their center at the fraction (alpha/r1)/(alpha/r1 + (1 - alpha)/r2), and concentric circles meet half way at the
    geometric mean of their radii.

    The ends are the objects to the last bit. In between, what is at a distance d from the other end and has a radius r
    is accurate to about (d/r)^2 rounding units.

    Examples
    --------
    >>> half_way = objects.interpolate(c1, c2, alpha=0.5)
    >>> path = objects.interpolate(c1, c2, alpha=np.linspace(1, 0, 100))
    """
    as_choice(method, "method", METHODS)
    a, b, weight = _operands(X, Y, alpha)
    aligns, refuses = as_bool(align, "align"), as_bool(strict, "strict")

    def compute(frame: local_origin.Frame | None) -> Multivector:
        x, y = (a, b) if frame is None else (frame.to_local(a), frame.to_local(b))
        end = b
        if aligns:
            opposite = is_opposite(x, y)
            y, end = negate_where(y, opposite), negate_where(b, opposite)
        if method == "rotor" and a.grades != (1,):
            outcome = _along_rotor(x, y, np.asarray(weight))
        else:
            formula = "interpolation.interpolate" if frame is None else "interpolation.interpolate_far"
            outcome = evaluate(
                a.algebra, formula, *to_common_layout(x, y), ArrayOperand(weight, 0, "alpha"), *_distance(frame)
            )
        return _with_ends(assemble(outcome, (a, b), frame), a, end, weight, method)

    return _checked(local_origin.for_each(compute, a, b), "interpolate", refuses)


@renamed_keywords(X1="X", X2="Y")
def interpolate_derivative(X: Any, Y: Any, *, alpha: Any, align: bool = False, strict: bool = False) -> Multivector:
    """Derivative of `interpolate` (direct) with respect to alpha.

    Parameters
    ----------
    X, Y, alpha, align, strict
        As of `interpolate`.

    Returns
    -------
    Multivector, shape (...)
        Multivectors of the objects' grade (no objects); NaN, with the status of the interpolant, where that has none.

    Raises
    ------
    InputError, GradeError, AlgebraMismatchError, ShapeError, SingularError
        As of `interpolate`.

    Notes
    -----
    Thesis (4.26) to (4.30), generated from the formula of the interpolant, so it holds where -<X ~X>_0 < 0 too.
    """
    a, b, weight = _operands(X, Y, alpha)
    aligns, refuses = as_bool(align, "align"), as_bool(strict, "strict")

    def compute(frame: local_origin.Frame | None) -> Multivector:
        x, y = (a, b) if frame is None else (frame.to_local(a), frame.to_local(b))
        if aligns:
            y = negate_where(y, is_opposite(x, y))
        operands = to_common_layout(x, y)
        formula = "interpolation.interpolate_rate" if frame is None else "interpolation.interpolate_far_rate"
        outcome = evaluate(a.algebra, formula, *operands, ArrayOperand(weight, 0, "alpha"), *_distance(frame))
        outcome = FormulaResult((to_layout(outcome.value, operands[0].kind),), outcome.status)
        return assemble(outcome, (a, b), frame)

    return _checked(local_origin.for_each(compute, a, b), "interpolate_derivative", refuses)


def average(X: Any, weights: Any = None, axis: int = 0, align: bool = False, strict: bool = False) -> Multivector:
    """Mean of objects: their weighted sum, projected (thesis 3.5). Points give the weighted mean of their positions.

    Parameters
    ----------
    X : Multivector or list, shape (..., n, ...)
        Objects of one grade; rounds and flats may be mixed.
    weights : array, optional
        Shape (n,), or the shape of X. Only their proportions count; negative ones are allowed.
    axis : int
        Axis of the batch that is averaged over.
    align : bool
        Turn objects round first that are opposed to the first one along the axis; see `align`. Without it an object
        and its opposite cancel.
    strict : bool
        Raise for the first mean without an answer, instead of giving it a status.

    Returns
    -------
    Multivector, shape of X without the axis
        Unit objects; statuses as of `project_to_blade`: SINGULAR where the objects cancel, IMAGINARY where the sum
        stands for no real object, INVALID where an object has no value.

    Raises
    ------
    InputError
        If there are no objects along the axis, or weights are not finite or sum to zero.
    ShapeError
        If the weights have another shape.
    GradeError, SingularError
        As of `interpolate`.
    """
    x = as_objects(X)
    place = checked_axis(x, axis)
    share = normalized_weights(weights, x.shape, place)
    if share is None and x.shape[0] == 2 and place == 0:  # one pass over both, nothing copied
        return interpolate(_part(x, 0), _part(x, 1), alpha=0.5, align=align, strict=strict)
    aligns, refuses = as_bool(align, "align"), as_bool(strict, "strict")

    def compute(frame: local_origin.Frame | None) -> Multivector:
        y = x if frame is None else frame.to_local(x)
        if aligns:
            y = negate_where(y, is_opposite(first_along(y, place), y))
        parts = y._data if share is None else y._data * share[..., None].astype(y.dtype)  # any scale will do
        total, written = (block_sum(p, place) for p in (parts, np.abs(parts)))
        layout = x.algebra.type_of(y.kind.layout, y.dtype)
        if frame is not None:
            frame = local_origin.Frame(np.squeeze(frame.origin, place), frame.translator.reshape(total.shape[:-1]))
        operands = (x._make(layout, data, data.shape[:-1]) for data in (total, written))
        formula = "blades.project_sum" if frame is None else "blades.project_far_sum"
        outcome = evaluate(x.algebra, formula, *operands, *_distance(frame))
        return assemble(outcome, (), frame)

    return _checked(local_origin.for_each(compute, x, axis=place), "average", refuses)


def align(X: Any, reference: Any = None) -> tuple[Multivector, Any]:
    """Objects turned round where they are opposed to a reference: where gamma <reference X>_0 < 0, gamma = reference^2.

    Parameters
    ----------
    X : Multivector or list, shape (...)
        Objects of one grade.
    reference : Multivector, optional
        An object of this grade, or a batch that broadcasts with X. Default: the first of X.

    Returns
    -------
    aligned : Multivector, shape (...)
        X, or -X where ``flipped``: the same object in the other orientation.
    flipped : bool or array (...)
        A product of zero (within rounding) keeps the sign. Points have no orientation: never.

    Raises
    ------
    GradeError, AlgebraMismatchError, ShapeError
        If the grades differ, or the shapes do not broadcast.

    Notes
    -----
    For lines and planes that is a positive product of directions or normals; for spheres it is also a matter of
    distance: outward spheres whose distance is larger than sqrt(r1^2 + r2^2) are opposed.
    """
    if reference is None:
        x = as_objects(X)
        if not x.size:
            return x, np.zeros(x.shape, bool)
        first = x.reshape(-1)[0]
    else:
        first, x = pair(reference, X)

    def compute(frame: local_origin.Frame | None) -> NDArray[np.bool_]:
        return is_opposite(first, x) if frame is None else is_opposite(frame.to_local(first), frame.to_local(x))

    flipped = local_origin.for_each(compute, first, x)
    return negate_where(x, flipped), flipped[()]


def _checked(result: Multivector, name: str, refuses: bool) -> Multivector:
    if refuses:
        raise_first(result._status, name)
    return result


def _distance(frame: local_origin.Frame | None) -> tuple[ArrayOperand, ...]:
    """Distance of a frame's origin from the world's."""
    if frame is None:
        return ()
    with np.errstate(over="ignore"):  # farther than numbers are: infinite
        return (ArrayOperand(np.linalg.norm(frame.origin, axis=-1), 0, "distance"),)


def _part(x: Multivector, i: int) -> Multivector:
    """Items i of the first axis, without a copy; what is known of all is known of them."""
    status = None if x._status is None else x._status[i]
    part = x._make(x._type, x._data[i], x.shape[1:], status)
    part._largest = x._largest_coefficient()
    return part


def _operands(x1: Any, x2: Any, alpha: Any) -> tuple[Multivector, Multivector, Any]:
    for x in (x1, x2):
        if isinstance(x, Multivector) and 0 in x.grades:
            raise GradeError(
                f"a {x.kind.name.replace('_', ' ')} of {x.algebra.name} is no object.",
                remedy="Between poses use poses.interpolate(x, y, t)",
            )
    a, b = pair(x1, x2)
    weight = alpha if isinstance(alpha, float | int) else real_array(alpha, "alpha")
    broadcast_shapes({"X": a.shape, "Y": b.shape, "alpha": np.shape(weight)})
    return a, b, weight


def _with_ends(x: Multivector, first: Multivector, second: Multivector, alpha: Any, method: str) -> Multivector:
    """The objects themselves at the ends: of the nearer one a sum keeps few digits, or none, beside a far one."""
    for value, end in ((1, first), (0, second)):
        here = np.asarray(alpha == value)
        if not here.any():
            continue
        rows = np.broadcast_to(embed(end, x.kind), x._data.shape)
        mask = np.broadcast_to(here, x.shape) & np.isfinite((x if method == "rotor" else end)._data[..., 0])
        there = rows[mask]
        if method == "rotor" and value == 0:  # where it may lead to the negative
            there = np.where((np.sign(there) * x._data[mask]).sum(-1, keepdims=True) < 0, -there, there)
        x._data[mask] = there  # an array that nobody else has seen yet
        if method == "direct" and x._status is not None:
            x._status[mask] = Status.OK
    return x


def _along_rotor(a: Multivector, b: Multivector, alpha: NDArray[Any]) -> FormulaResult:
    """exp((1 - alpha) log R) >> a."""
    from ..rotors.between import rotor_between

    wide = max(a.kind, b.kind, key=lambda kind: kind.size)
    rotor = rotor_between(a, b)
    logarithm = rotor.log()
    with np.errstate(all="ignore"):
        moved = (logarithm * (1 - alpha)).exp() >> to_layout(a, wide)
    lead = np.broadcast_shapes(moved.shape, rotor.shape)
    known = [None if s is None else np.broadcast_to(s, lead) for s in (rotor._status, logarithm._status)]
    typed = moved._make(moved.algebra.type_of(wide, moved.dtype), embed(moved, wide), lead, merge_statuses(*known))
    typed = invalidate_nonfinite(typed)
    return FormulaResult((typed,), typed._status)


__all__ = ["align", "average", "interpolate", "interpolate_derivative", "project_to_blade"]
