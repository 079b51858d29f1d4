"""Rotors and mirrors between two objects of one grade, and similarities between rounds (thesis chapter 2 and 4.10).

The direct formula runs on the whole batch; items where it loses digits, or where it has no unique answer, are
gathered and done again by formulas of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..calls import Numbers, call, finite, merged, raise_first
from ..multivector import Multivector
from ..rows import embedded
from ..status import Status
from . import local
from .inputs import OBJECTS, pair
from .items import at, codes, joined, one_of, places

#: Below this margin (see `codegen.formulas.rotors.margin`) the direct formula loses more than a digit and a half, so a
#: second rotor, from where the first one leads, goes on top. Some per cent of random pairs.
REFINED_BELOW = 1 / 32
#: Above this product of the objects' sizes (sums of absolute coefficients) they are brought to a local origin: rounding
#: errors of rotors grow with it.
FAR = 1024.0
#: By how much larger the margin after a quarter turn must be for it to be taken instead of half a turn.
HALF_TURN_PREFERRED = 4

Between = Callable[[Multivector, Multivector], Multivector]
#: Kind of unit rotors of every sort.
CONFORMAL = "rotor_conformal"
ROTOR, MIRROR, SIMILARITY = "rotor_between", "mirror_between", "trs_rotor"


def rotor_between(x1: Any, x2: Any, strict: bool = False) -> Multivector:
    """Rotor R with R x1 ~R = x2, for two objects of one grade.

    Parameters
    ----------
    x1, x2 : Multivector or list, shapes broadcasting to (...)
        Point pairs, lines and circles, planes and spheres in any mixture of one grade; or points.
    strict : bool
        Raise for the first item that has no rotor, instead of giving it a status.

    Returns
    -------
    Multivector, shape (...)
        Unit rotors with <R>_0 >= 0; rotor_between(x, x) is 1. Of points the translator. Items with

        - `NOT_UNIQUE` have a documented choice. Spheres with K0 <= 0 (apart from each other and of like orientation,
          tangent from outside, x2 = -x1; or such a sphere and a plane) go to -x2, the same sphere. Everything else
          is singular where the eigenvalues of K touch zero or the negative axis: x2 = -x1, opposite lines and planes
          (coincident or apart), point pairs and coaxial circles of opposite orientation, a circle and its own axis.
          There x1 is turned by half a turn first, about an axis through its centre and perpendicular to its own
          (of flats: through their point nearest the origin, far away a local one); or by a quarter turn, if -x1 is
          as singular. R x1 ~R is x2.
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
    Thesis 2.4 with S = 1/(2 beta) - beta K4 (the printed sign gives -R), in the form that splits on the sign of K0,
    so that nothing cancels as K4 goes to 0. An angle of e from a singular case costs no digits: the rotor is
    refined by the one from R x1 ~R to x2. Objects far from the origin are compared from a local one.

    Examples
    --------
    >>> R = objects.rotor_between(cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.line((1, 0, 0), (0, 1, 0)))
    """
    a, b = pair(x1, x2)
    if a.grades == (1,):
        return _finished(finite(_formula("translation_between")(a, b)), a, b, ROTOR, strict)
    return _finished(_rotors(a, b), a, b, ROTOR, strict)


def mirror_between(x1: Any, x2: Any, strict: bool = False) -> Multivector:
    """The object M in which x1 is reflected, or inverted, to x2: M x1 M = gamma x2 with gamma = x1^2.

    M = S (x1 + x2)/sqrt(mu) (thesis 2.4), the object half way between; gamma is +1 for point pairs, lines and
    circles, -1 for planes and spheres.

    Parameters
    ----------
    x1, x2 : Multivector or list, shapes broadcasting to (...)
        Objects of one grade, 2 to 4, rounds and flats in any mixture.
    strict : bool
        Raise for the first item that has none.

    Returns
    -------
    Multivector, shape (...)
        Unit objects. `IMAGINARY` and NaN where M is imaginary (spheres with K0 < 0, coaxial circles of opposite
        orientation); `SINGULAR` where it vanishes or is null (x2 = -x1, opposite lines or planes, tangent spheres,
        a circle and its own axis).

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
    SingularError
        With ``strict``.
    """
    a, b = pair(x1, x2, (2, 3, 4))
    return _finished(finite(_seen_locally(_formula("mirror_between"), a, b)), a, b, MIRROR, strict)


def trs_rotor(x1: Any, x2: Any, strict: bool = False) -> Multivector:
    """The similarity Z = T(c2) D R ~T(c1) that takes x1 to x2: translation, rotation and scaling, no transversion.

    R turns the axis of x1 (normal of a circle, direction of a point pair) to that of x2 by the smallest angle, D
    scales by r2/r1; parts of the objects keep their proportions (thesis 4.10).

    Parameters
    ----------
    x1, x2 : Multivector or list, shapes broadcasting to (...)
        Two rounds of one grade; or two flats, whose points nearest the origin are matched, without scaling; or points.
    strict : bool
        Raise for the first item that has none.

    Returns
    -------
    Multivector, shape (...)
        Unit rotors with <Z>_0 >= 0. `NOT_UNIQUE`: opposite axes, which are turned by half a turn about the
        perpendicular nearest a basis vector (Z x1 ~Z is still x2); or spheres of opposite orientation, where
        Z x1 ~Z = -x2. `SINGULAR` and NaN: a round and a flat.

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
    SingularError
        With ``strict``.
    """
    a, b = pair(x1, x2)
    if a.grades == (1,):
        return _finished(finite(_formula("translation_between")(a, b)), a, b, SIMILARITY, strict)
    found = _signed(call(a.algebra, "placement.similarity", *_located(a), *_located(b)).value)
    if CONFORMAL in a.algebra.kinds:
        found = found.as_kind(CONFORMAL, check=False)  # unit, proved on paper only
    return _finished(finite(found), a, b, SIMILARITY, strict)  # from parameters: good at any distance


def _finished(r: Multivector, a: Multivector, b: Multivector, name: str, strict: bool) -> Multivector:
    """Statuses of the operands first."""
    known = [np.broadcast_to(x._status, r.shape) for x in (a, b) if x._status is not None and x._status.any()]
    result = r._make(r._type, r._data, r.shape, merged(*known, r._status))
    if truth(strict, "strict"):
        raise_first(result._status, name)
    return result


def _formula(name: str) -> Between:
    """A formula of two objects, by its name in `codegen.formulas.rotors`."""
    return lambda x, y: call(x.algebra, f"rotors.{name}", x, y).value


def _direct(a: Multivector, b: Multivector) -> tuple[Multivector, NDArray[Any], NDArray[Any]]:
    """Rotors by the direct formula, their margins, and the products of the objects' sizes."""
    found = call(a.algebra, "rotors.rotor_between", a, b)
    return found.value, found.values[1][..., 0], found.values[1][..., 1]


def _rotors(a: Multivector, b: Multivector) -> Multivector:
    """The direct rotors, and in their place better ones where they lose digits."""
    r, margin, written = _direct(a, b)
    poor = ~np.asarray((margin > REFINED_BELOW) & (written < FAR))  # a singular margin is small too
    if not poor.any():
        return r
    found = finite(_seen_locally(_refined, at(a, poor), at(b, poor)))  # the others are finite: NaN is below no bound
    status, where = codes(r), places(poor)
    r._data[where] = embedded(found, r.kind)  # a new array, which nobody has seen yet
    status[where] = codes(found)
    return r._make(r._type, r._data, r.shape, status)


def _refined(a: Multivector, b: Multivector) -> Multivector:
    """Rotors with a second one on top where the margin is small, or a turn before where it is none."""
    r, margin, _ = _direct(a, b)
    data, status = r._data, codes(r)
    singular = status == Status.SINGULAR
    weak = ~(margin > REFINED_BELOW) & ~singular
    a, b = _widened(a), _widened(b)
    if weak.any():
        flipped = (status == Status.NOT_UNIQUE)[:, None]
        target = b._make(b._type, np.where(flipped, -b._data, b._data), b.shape)
        first = call(a.algebra, "rotors.unit_rotor", at(_even(r), weak)).value
        second, _, _ = _direct(_led(first, at(a, weak)), at(target, weak))
        data[weak] = embedded(_composed(second, first), r.kind)
    if singular.any():
        turned = _turned(at(a, singular), at(b, singular))
        data[singular], status[singular] = embedded(turned, r.kind), codes(turned)
    return r._make(r._type, data, r.shape, status)


def _turned(a: Multivector, b: Multivector) -> Multivector:
    """Rotors from objects that are turned first, by half a turn or, where that is as singular, by a quarter.

    The half turn, about an axis perpendicular to that of a and through its centre, leads to -a; from there is a rotor
    to b unless every object near is as singular (a circle and its own axis). The quarter takes the axis of a into its
    plane.
    """
    center, axis, _ = _located(a)
    half, quarter = (_even(x) for x in call(a.algebra, "placement.turns", center, axis).values)
    by_half, margin, _ = _direct(_led(half, a), b)
    by_quarter, other, _ = _direct(_led(quarter, a), b)
    take_other = HALF_TURN_PREFERRED * margin < other
    second, first = one_of(take_other, by_quarter, by_half), one_of(take_other, quarter, half)
    r = _composed(second, first)
    lost = codes(second) == Status.SINGULAR
    return r._make(r._type, r._data, r.shape, np.where(lost, Status.SINGULAR, Status.NOT_UNIQUE).astype(np.uint8))


def _located(x: Multivector) -> tuple[Multivector, Multivector, Numbers]:
    """Centres, axes and 1/radii of objects, as operands."""
    center, axis, curvature = call(x.algebra, "placement.located", _widened(x)).values
    return center, axis, Numbers(curvature._data[..., 0], 0, "curvature")


def _led(r: Multivector, x: Multivector) -> Multivector:
    """Objects where rotors lead them, trusted to be of their kind."""
    return call(x.algebra, "rotors.led", r, x).value.as_kind(x.kind, check=False)  # type: ignore[no-any-return]


def _composed(second: Multivector, first: Multivector) -> Multivector:
    """A rotor after another."""
    return _signed(call(first.algebra, "products.geometric", _even(second), _even(first)).value)


def _signed(r: Multivector) -> Multivector:
    """Rotors with the documented one of their two signs, on all even blades."""
    found = call(r.algebra, "rotors.signed", _even(r)).value
    return r._make(found._type, found._data, r.shape, r._status)


def _widened(x: Multivector) -> Multivector:
    """Objects as rounds, of which flats are special: what is rare shares its kernels."""
    return x.as_kind(next(name for name in reversed(OBJECTS[x.grades[0]]) if name in x.algebra.kinds), check=False)


def _even(x: Multivector) -> Multivector:
    """x on all even blades."""
    return x.as_kind("even", check=False)


def _seen_locally(function: Between, a: Multivector, b: Multivector) -> Multivector:
    """The function of two objects; items far from the origin are brought to a local one, and their results back."""
    far = np.asarray(~(_written(a, b) < FAR))
    if not far.any():
        return function(a, b)
    x, y = at(a, far), at(b, far)
    frame = _frame(x, y)
    found = frame.outward(function(frame.inward(x), frame.inward(y)))
    if far.all():
        return found.reshape(far.shape)
    return joined(far, found, function(at(a, ~far), at(b, ~far)))


def _frame(a: Multivector, b: Multivector) -> local.Frame:
    """Of the world's origin, one on a near b and one on b near a, that from which both are written smallest."""
    algebra, best = a.algebra, _written(a, b)
    origin = np.zeros((*a.shape, algebra.space), a.dtype)
    for first, second in ((a, b), (b, a)):
        start = _position(call(algebra, "local.anchor", first).value)
        place = _position(call(algebra, "local.nearest", second, algebra.vector(start, "origin")).value)
        frame = local.Frame(place, algebra.translator(place))
        written = _written(frame.inward(a), frame.inward(b))
        better = written < best
        best, origin = np.where(better, written, best), np.where(better[:, None], place, origin)
    return local.Frame(origin, algebra.translator(origin))


def _position(place: Multivector) -> NDArray[Any]:
    """Coordinates; the origin's where there are none."""
    return np.where(np.isfinite(place._data).all(-1, keepdims=True), place._data, place.dtype.type(0))


def _written(a: Multivector, b: Multivector) -> NDArray[Any]:
    """How large a pair is written: the product of the sums of the absolute values of their coefficients."""
    with np.errstate(over="ignore"):  # infinity is as good: larger than any bound
        return np.asarray(np.abs(a._data).sum(-1) * np.abs(b._data).sum(-1))


__all__ = ["mirror_between", "rotor_between", "trs_rotor"]
