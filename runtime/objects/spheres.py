"""Spheres that belong to two objects: through both, or orthogonal to both (thesis 3.7 and 3.8)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..codegen.errors import GradeError
from ..common.deprecation import renamed_keywords
from ..common.validation import as_bool
from ..core.multivector import Multivector
from ..dispatch.coefficients import embed
from ..dispatch.formulas import ArrayOperand, FormulaResult, evaluate
from ..dispatch.item_statuses import raise_first
from .arguments import pair
from .interpolation.sums import assemble, to_common_layout
from .rotors import local_origin


@renamed_keywords(C1="X", C2="Y")
def common_sphere(X: Any, Y: Any, strict: bool = False) -> Multivector:
    """The sphere through two circles that lie on one, or through the end points of two point pairs.

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Circles and lines in any mixture, or two batches of point pairs.
    strict : bool
        Raise for the first item without one.

    Returns
    -------
    Multivector, shape (...)
        Outward unit spheres; planes, on the side of C1's normal, where the objects are coplanar. Items with

        - `SINGULAR` and NaN have none: circles on no common sphere (<X Y>_4 is not zero, to 1e-12 of its terms), or
          point pairs on one circle, through which many spheres go;
        - `NOT_UNIQUE` are one circle twice: the sphere of which it is a great circle is returned. One line twice is
          SINGULAR.

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
        If the objects are no circles, lines or point pairs of one grade.
    SingularError
        With ``strict``.

    Notes
    -----
    Point pairs: A ^ B (Theorem 2). Circles: the span of X and a vector of Y. The formula of Conjecture 1 for equal
    radii, (X + Y)((X + Y) ^ n_inf) I5, needs circles of like orientation; this one needs neither.
    """
    return _sphere("common_sphere", X, Y, (2, 3), strict)


@renamed_keywords(C1="X", C2="Y")
def orthogonal_sphere(X: Any, Y: Any, strict: bool = False) -> Multivector:
    """The sphere that two circles meet at right angles, <X Y>_4 (Theorem 5); all their interpolants do so too.

    Parameters
    ----------
    X, Y : Multivector or list, shapes broadcasting to (...)
        Circles and lines in any mixture.
    strict : bool
        Raise for the first item without one.

    Returns
    -------
    Multivector, shape (...)
        Outward unit spheres, or planes. `IMAGINARY` and NaN: it has no real points (linked circles, a line through a
        circle). `SINGULAR` and NaN: the circles are on a common sphere, or share one point; two lines.

    Raises
    ------
    GradeError, InputError, AlgebraMismatchError, ShapeError
        If the objects are no circles or lines.
    SingularError
        With ``strict``.
    """
    return _sphere("orthogonal_sphere", X, Y, (3,), strict)


def _sphere(name: str, x1: Any, x2: Any, grades: tuple[int, ...], strict: bool) -> Multivector:
    a, b = pair(x1, x2, grades)
    if a.algebra.dimension != 5:
        raise GradeError(f"{name} is about space; {a.algebra.name} has no spheres.")

    def compute(frame: local_origin.Frame | None) -> Multivector:
        x, y = (a, b) if frame is None else (frame.to_local(a), frame.to_local(b))
        x, y = to_common_layout(x, y)
        distance = 0.0 if frame is None else np.linalg.norm(frame.origin, axis=-1)
        outcome = evaluate(a.algebra, f"spheres.{name}", x, y, ArrayOperand(distance, 0, "distance"))
        kind = a.algebra.kind("plane" if x.kind.name == "line" else "sphere")
        value: Multivector = outcome.value
        sphere = value._make(a.algebra.type_of(kind, value.dtype), embed(value, kind), value.shape)
        return assemble(FormulaResult((sphere,), outcome.status), (a, b), frame)

    refuses = as_bool(strict, "strict")
    result = local_origin.for_each(compute, a, b)
    if refuses:
        raise_first(result._status, name)
    return result


__all__ = ["common_sphere", "orthogonal_sphere"]
