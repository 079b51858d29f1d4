"""Rotors and mirrors between two objects of one grade, and similarities between rounds (thesis chapter 2 and 4.10).

The direct formula runs on the whole batch; items where it loses digits, or where it has no unique answer, are
gathered and done again by formulas of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.deprecation import renamed_keywords
from ...common.validation import as_bool
from ...core.arrays.multivector import ArrayMultivector
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed, no_items
from ...dispatch.formulas import ArrayOperand, evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, merge_statuses, raise_first
from ...status import Status
from ..arguments import OBJECTS, as_objects, object_kind, pair, same_sort
from ..masked_items import at, codes, masked_indices, merge_items, select
from . import local_origin

#: Below this margin (see `formulas.motions.rotors.margin`) the direct formula loses more than a digit and a half, so a
#: second rotor, from where the first one leads, goes on top. Some per cent of random pairs.
REFINED_BELOW = 1 / 32
#: Above this product of the objects' sizes (sums of absolute coefficients) they are brought to a local origin: rounding
#: errors of rotors grow with it.
FAR = 1024.0
#: By how much larger the margin after a quarter turn must be for it to be taken instead of half a turn.
HALF_TURN_PREFERRED = 4

#: Kinds whose product tells an angle from half a turn by its sine alone.
FLATS = ("line", "plane")

Between = Callable[[Multivector, Multivector], Multivector]
#: Kind of unit rotors of every sort.
CONFORMAL = "rotor_conformal"
ROTOR, MIRROR, SIMILARITY = "rotor_between", "mirror_between", "trs_rotor"


@renamed_keywords(X1="X", X2="Y", x1="X", x2="Y")
def rotor_between(X: Any, Y: Any, strict: bool = False) -> Multivector:
    """Rotor R with R X ~R = Y, for two objects of one grade.

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Point pairs, lines and circles, planes and spheres in any mixture of one grade; or points.
    strict : bool
        Raise for the first item that has no rotor, instead of giving it a status.

    Returns
    -------
    Multivector, shape (...)
        Unit rotors with <R>_0 >= 0; rotor_between(x, x) is 1. Of points the translator. Items with

        - `NOT_UNIQUE` have a documented choice. Spheres with K0 <= 0 (apart from each other and of like orientation,
          tangent from outside, Y = -X; or such a sphere and a plane) go to -Y, the same sphere. Everything else
          is singular where the eigenvalues of K touch zero or the negative axis: Y = -X, opposite lines and planes
          (coincident or apart), point pairs and coaxial circles of opposite orientation, a circle and its own axis.
          There X is turned by half a turn first, about an axis through its center and perpendicular to its own
          (of flats: through their point nearest the origin, far away a local one); or by a quarter turn, if -X is
          as singular. R X ~R is Y.
        - `SINGULAR` have none, and NaN; with finite unit objects no such pair is known.
        - `INVALID` come from a bad operand.

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
        If the grades differ, or the operands are no objects of one conformal algebra.
    SingularError
        With ``strict``.

    Notes
    -----
    Objects on JAX arrays or PyTorch tensors go through the direct formula alone, without checks and statuses: it loses
    digits next to the singular cases.

    Thesis 2.4 with S = 1/(2 beta) - beta K4 (the printed sign gives -R), in the form that splits on the sign of K0,
    so that nothing cancels as K4 goes to 0. An angle of e from a singular case costs no digits of R X ~R: the rotor
    is refined by the one from there to Y. Below e of about 1.2e-7 rounding takes the case for singular; lines and
    planes down to 3e-14, or where their rotor's axis is more than about 1e6 away. R itself is known to 1/e rounding
    units. Objects far from the origin are compared from a local one.

    Examples
    --------
    >>> R = objects.rotor_between(cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.line((1, 0, 0), (0, 1, 0)))
    """
    if isinstance(X, ArrayMultivector) or isinstance(Y, ArrayMultivector):
        return _on_arrays(X, Y)  # type: ignore[no-any-return]
    a, b = pair(X, Y)
    if a.grades == (1,):
        return _with_operand_statuses(invalidate_nonfinite(_formula("translation_between")(a, b)), a, b, ROTOR, strict)
    return _with_operand_statuses(_rotors(a, b), a, b, ROTOR, strict)


@renamed_keywords(X1="X", X2="Y", x1="X", x2="Y")
def mirror_between(X: Any, Y: Any, strict: bool = False) -> Multivector:
    """The object M in which X is reflected, or inverted, to Y: M X M = gamma Y with gamma = X^2.

    M = S (X + Y)/sqrt(mu) (thesis 2.4), the object half way between; gamma is +1 for point pairs, lines and
    circles, -1 for planes and spheres.

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Objects of one grade, 2 to 4, rounds and flats in any mixture.
    strict : bool
        Raise for the first item that has none.

    Returns
    -------
    Multivector, shape (...)
        Unit objects. `IMAGINARY` and NaN where M is imaginary (spheres with K0 < 0, coaxial circles of opposite
        orientation); `SINGULAR` where it vanishes or is null (Y = -X, opposite lines or planes, tangent spheres,
        a circle and its own axis).

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
    SingularError
        With ``strict``.
    """
    a, b = pair(X, Y, (2, 3, 4))
    return _with_operand_statuses(
        invalidate_nonfinite(_in_local_frame(_formula("mirror_between"), a, b)), a, b, MIRROR, strict
    )


@renamed_keywords(X1="X", X2="Y", x1="X", x2="Y")
def trs_rotor(X: Any, Y: Any, strict: bool = False) -> Multivector:
    """The similarity Z = T(c2) D R ~T(c1) that takes X to Y: translation, rotation and scaling, no transversion.

    R turns the axis of X (normal of a circle, direction of a point pair) to that of Y by the smallest angle, D
    scales by r2/r1; parts of the objects keep their proportions (thesis 4.10).

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Two rounds of one grade; or two flats, whose points nearest the origin are matched, without scaling; or points.
    strict : bool
        Raise for the first item that has none.

    Returns
    -------
    Multivector, shape (...)
        Unit rotors with <Z>_0 >= 0. `NOT_UNIQUE`: opposite axes, which are turned by half a turn about the
        perpendicular nearest a basis vector (Z X ~Z is still Y); or spheres of opposite orientation, where
        Z X ~Z = -Y. `SINGULAR` and NaN: a round and a flat.

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
    SingularError
        With ``strict``.

    Notes
    -----
    A curvature below 64 rounding units (a radius above 7e13) counts as noise of a flat unless the coefficients have the
    proportions of a round. They have them if its center's distance from the origin differs from its radius by 0.5 % or
    more; nearer to that it is taken for a flat: use a larger unit of length. Beyond 1e150 squares overflow: `INVALID`.
    """
    a, b = pair(X, Y)
    if a.grades == (1,):
        return _with_operand_statuses(
            invalidate_nonfinite(_formula("translation_between")(a, b)), a, b, SIMILARITY, strict
        )
    found = _with_sign(evaluate(a.algebra, "placement.similarity", *_placement(a), *_placement(b)).value)
    if CONFORMAL in a.algebra.kinds:
        found = found.as_kind(CONFORMAL, check=False)  # unit, proved on paper only
    # computed from parameters, it is accurate at any distance
    return _with_operand_statuses(invalidate_nonfinite(found), a, b, SIMILARITY, strict)


def _on_arrays(x: Any, y: Any) -> Any:
    """Rotors of objects on other packages' arrays: the direct formula, which is NaN where there is no unique answer."""
    both: list[Any] = []
    for each, what in ((x, "the first objects"), (y, "the second objects")):
        if isinstance(each, ArrayMultivector):
            kind = object_kind(each, what, tuple(OBJECTS))  # type: ignore[arg-type]
            each = each.as_kind(kind, check=False)
        both.append(each if isinstance(each, ArrayMultivector) else as_objects(each, what))
    same_sort(*both)
    kind = rotor_between(*map(no_items, both)).kind
    name = "translation_between" if both[0].grades == (1,) else "rotor_between"
    return evaluate(kind.algebra, f"rotors.{name}", *both).value.as_kind(kind, check=False)  # type: ignore[arg-type]


def _with_operand_statuses(r: Multivector, a: Multivector, b: Multivector, name: str, strict: bool) -> Multivector:
    """Statuses of the operands first."""
    if a._status is None and b._status is None and strict is False:
        return r
    known = [np.broadcast_to(x._status, r.shape) for x in (a, b) if x._status is not None and x._status.any()]
    result = r._make(r._type, r._data, r.shape, merge_statuses(*known, r._status))
    if as_bool(strict, "strict"):
        raise_first(result._status, name)
    return result


def _formula(name: str) -> Between:
    """A formula of two objects, by its name in `codegen.formulas.motions.rotors`."""
    return lambda x, y: evaluate(x.algebra, f"rotors.{name}", x, y).value


def _direct(a: Multivector, b: Multivector) -> tuple[Multivector, NDArray[Any], NDArray[Any]]:
    """Rotors by the direct formula, their margins, and the products of the objects' sizes."""
    found = evaluate(a.algebra, "rotors.rotor_between", a, b)
    return found.value, found.values[1][..., 0], found.values[1][..., 1]


def _rotors(a: Multivector, b: Multivector) -> Multivector:
    """The direct rotors, and in their place better ones where they lose digits."""
    r, margin, written = _direct(a, b)
    good = (margin > REFINED_BELOW) & (written < FAR)  # a singular margin is small too
    if good.all():
        return r
    poor = ~np.asarray(good)
    # the others are finite: NaN is below no bound
    found = invalidate_nonfinite(_in_local_frame(_compose_correction, at(a, poor), at(b, poor)))
    status, where = codes(r), masked_indices(poor)
    r._data[where] = embed(found, r.kind)  # a new array, which nobody has seen yet
    status[where] = codes(found)
    return r._make(r._type, r._data, r.shape, status)


def _compose_correction(a: Multivector, b: Multivector) -> Multivector:
    """Rotors composed with a second one if the margin is small, or after a rotation of a if it is zero."""
    r, margin, _ = _direct(a, b)
    data, status = r._data, codes(r)
    singular = status == Status.SINGULAR
    if singular.any() and a.kind.name == b.kind.name and a.kind.name in FLATS:
        found = evaluate(a.algebra, "rotors.flat_rotor", at(a, singular), at(b, singular)).value
        data[singular], status[singular] = embed(found, r.kind), codes(found)
        singular = status == Status.SINGULAR
    weak = ~(margin > REFINED_BELOW) & ~singular
    a, b = _as_round(a), _as_round(b)
    if weak.any():
        flipped = (status == Status.NOT_UNIQUE)[:, None]
        target = b._make(b._type, np.where(flipped, -b._data, b._data), b.shape)
        first = evaluate(a.algebra, "rotors.unit_rotor", at(_even(r), weak)).value
        second, _, _ = _direct(_apply(first, at(a, weak)), at(target, weak))
        data[weak] = embed(_compose(second, first), r.kind)
    if singular.any():
        turned = _prerotate(at(a, singular), at(b, singular))
        data[singular], status[singular] = embed(turned, r.kind), codes(turned)
    return r._make(r._type, data, r.shape, status)


def _prerotate(a: Multivector, b: Multivector) -> Multivector:
    """Rotors from objects that are first rotated by half a turn or, if that is as singular, by a quarter.

    The half turn, about an axis perpendicular to that of a and through its center, leads to -a; from there is a rotor
    to b unless every object near is as singular (a circle and its own axis). The quarter takes the axis of a into its
    plane.
    """
    center, axis, _ = _placement(a)
    half, quarter = (_even(x) for x in evaluate(a.algebra, "placement.half_rotations", center, axis).values)
    by_half, margin, _ = _direct(_apply(half, a), b)
    by_quarter, other, _ = _direct(_apply(quarter, a), b)
    take_other = HALF_TURN_PREFERRED * margin < other
    second, first = select(take_other, by_quarter, by_half), select(take_other, quarter, half)
    r = _compose(second, first)
    lost = codes(second) == Status.SINGULAR
    return r._make(r._type, r._data, r.shape, np.where(lost, Status.SINGULAR, Status.NOT_UNIQUE).astype(np.uint8))


def _placement(x: Multivector) -> tuple[Multivector, Multivector, ArrayOperand]:
    """Centers, axes and 1/radii of objects, as operands."""
    center, axis, curvature = evaluate(x.algebra, "placement.center_axis_curvature", _as_round(x)).values
    return center, axis, ArrayOperand(curvature._data[..., 0], 0, "curvature")


def _apply(r: Multivector, x: Multivector) -> Multivector:
    """Apply rotors to objects; the kind stays, unchecked."""
    return evaluate(x.algebra, "rotors.transform_object", r, x).value.as_kind(x.kind, check=False)  # type: ignore[no-any-return]


def _compose(second: Multivector, first: Multivector) -> Multivector:
    """A rotor after another."""
    return _with_sign(evaluate(first.algebra, "products.geometric", _even(second), _even(first)).value)


def _with_sign(r: Multivector) -> Multivector:
    """Rotors with the documented one of their two signs, on all even blades."""
    found = evaluate(r.algebra, "rotors.canonicalize_sign", _even(r)).value
    return r._make(found._type, found._data, r.shape, r._status)


def _as_round(x: Multivector) -> Multivector:
    """Objects as rounds, of which flats are special: what is rare shares its kernels."""
    return x.as_kind(next(name for name in reversed(OBJECTS[x.grades[0]]) if name in x.algebra.kinds), check=False)


def _even(x: Multivector) -> Multivector:
    """x on all even blades."""
    return x.as_kind("even", check=False)


def _in_local_frame(function: Between, a: Multivector, b: Multivector) -> Multivector:
    """The function of two objects; items far from the origin are brought to a local one, and their results back."""
    far = np.asarray(~(_coefficient_magnitude(a, b) < FAR))
    if not far.any():
        return function(a, b)
    x, y = at(a, far), at(b, far)
    frame = _frame(x, y)
    found = frame.to_world(function(frame.to_local(x), frame.to_local(y)))
    if far.all():
        return found.reshape(far.shape)
    return merge_items(far, found, function(at(a, ~far), at(b, ~far)))


def _frame(a: Multivector, b: Multivector) -> local_origin.Frame:
    """Local frame with the smallest coefficients: at the world's origin, on a near b, or on b near a."""
    algebra, best = a.algebra, _coefficient_magnitude(a, b)
    origin = np.zeros((*a.shape, algebra.space), a.dtype)
    for first, second in ((a, b), (b, a)):
        start = _position(evaluate(algebra, "local.anchor", first).value)
        position = _position(evaluate(algebra, "local.nearest", second, algebra.spatial(start, "origin")).value)
        frame = local_origin.Frame(position, algebra.translator(position))
        written = _coefficient_magnitude(frame.to_local(a), frame.to_local(b))
        better = written < best
        best, origin = np.where(better, written, best), np.where(better[:, None], position, origin)
    return local_origin.Frame(origin, algebra.translator(origin))


def _position(position: Multivector) -> NDArray[Any]:
    """Coordinates; zero if they are not finite."""
    return np.where(np.isfinite(position._data).all(-1, keepdims=True), position._data, position.dtype.type(0))


def _coefficient_magnitude(a: Multivector, b: Multivector) -> NDArray[Any]:
    """Magnitude of a pair: the product of the sums of the absolute values of their coefficients."""
    with np.errstate(over="ignore", invalid="ignore"):  # infinity is as good: larger than any bound; NaN is no better
        return np.asarray(np.abs(a._data).sum(-1) * np.abs(b._data).sum(-1))


__all__ = ["mirror_between", "rotor_between", "trs_rotor"]
