"""Validation of the arguments of functions on objects: objects of one grade, of known kinds, item by item.

A kind known by construction is trusted; coefficients on plain blades are checked against the kind of their grade, and
items that are no unit blades become NaN with `Status.INVALID`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError
from ..common.validation import broadcast_shapes, short_repr
from ..core.kind_constraints import satisfies_constraints
from ..core.multivector import Multivector
from ..dispatch.item_statuses import invalidate, invalidate_nonfinite

#: Kinds of direct objects by grade, narrowest first: flats, then all of the grade.
OBJECTS = {1: ("point",), 2: ("point_pair",), 3: ("line", "circle"), 4: ("plane", "sphere")}


def as_objects(x: Any, what: str = "the objects", grades: Sequence[int] = (1, 2, 3, 4)) -> Multivector:
    """x as a multivector of a kind of objects; items that do not belong to it are NaN and INVALID.

    Raises
    ------
    InputError, GradeError
        If x is no multivector of conformal geometry, or has not one of these grades.
    """
    if isinstance(x, (list, tuple)):
        return concatenate_objects(x, what, grades)
    if not isinstance(x, Multivector):
        remedy = "Make objects with bladesmith.cga3d"
        raise InputError(f"{what}: {short_repr(x)}; a multivector is needed.", remedy=remedy)
    if "ni" not in x.algebra.vectors:
        raise InputError(f"{what} belong to {x.algebra.name}; objects are those of conformal geometry.")
    kind = x._type.memoize(("object", *grades), lambda: object_kind(x, what, grades))
    if kind == x.kind:
        whole = math.isfinite(x._largest_coefficient()) and (x._status is None or not x._status.any())
        return x if whole else invalidate_nonfinite(x)
    data = _embed(x, kind)
    typed = x._make(x.algebra.type_of(kind, x.dtype), data, x.shape, x._status)
    return invalidate(typed, ~satisfies_constraints(kind, data))


def object_kind(x: Multivector, what: str, grades: Sequence[int]) -> Kind:
    """The kind that x is, or is to be checked for: the flat one only where x has no other blades.

    Raises
    ------
    GradeError
        If x has several grades, or none of ``grades``.
    """
    own = tuple(x.grades)
    if len(own) != 1 or own[0] not in grades or own[0] not in OBJECTS:
        wanted = ", ".join(str(g) for g in grades)
        raise GradeError(f"{what} are a {x.kind.name} of grades {own}; one of the grades {wanted} is needed.")
    names = [name for name in OBJECTS[own[0]] if name in x.algebra.kinds]
    if x.kind.name in names and x.kind == x.algebra.kind(x.kind.name):
        return x.kind
    fitting = (x.algebra.kind(name) for name in names)
    found = next((k for k in fitting if set(x.blades) <= set(k.blades)), None)
    if found is None:
        raise GradeError(f"{what} are a {x.kind.name}, which is not an object of {x.algebra.name}.")
    return found


def pair(x1: Any, x2: Any, grades: Sequence[int] = (1, 2, 3, 4)) -> tuple[Multivector, Multivector]:
    """Two batches of objects of one grade and one algebra, whose shapes broadcast.

    Raises
    ------
    AlgebraMismatchError, GradeError, ShapeError
    """
    a, b = as_objects(x1, "the first objects", grades), as_objects(x2, "the second objects", grades)
    same_sort(a, b)
    if a.shape != b.shape:
        broadcast_shapes({"the first objects": a.shape, "the second objects": b.shape})
    return a, b


def same_sort(a: Multivector, b: Multivector) -> None:
    """Raise unless both are objects of one grade of one algebra."""
    if a.algebra is not b.algebra:
        raise AlgebraMismatchError(f"objects of {a.algebra.name} and of {b.algebra.name} do not mix; convert one.")
    if a.grades != b.grades:
        raise GradeError(
            f"a {a.kind.name} has grade {a.grades[0]} and a {b.kind.name} grade {b.grades[0]}; "
            "both objects must have the same grade."
        )


def concatenate_objects(
    objects: Sequence[Any], what: str = "the objects", grades: Sequence[int] = (1, 2, 3, 4)
) -> Multivector:
    """Objects of a list as one batch (n,): flats and rounds of one grade may be mixed; batches are joined.

    Raises
    ------
    InputError, GradeError, AlgebraMismatchError
    """
    if not objects:
        raise InputError(f"{what} are an empty list.")
    parts = [as_objects(x, f"{what}: entry {i}", grades) for i, x in enumerate(objects)]
    for x in parts[1:]:
        same_sort(parts[0], x)
    wide = max((x.kind for x in parts), key=lambda k: k.size)
    dtype = np.result_type(*(x.dtype for x in parts))
    data = np.concatenate([_embed(x, wide).reshape(-1, wide.size) for x in parts]).astype(dtype)
    first = parts[0]
    known = [np.zeros(x.shape, np.uint8) if x._status is None else x._status for x in parts]
    status = np.concatenate([np.ravel(s) for s in known])
    return first._make(first.algebra.type_of(wide, dtype), data, data.shape[:-1], status if status.any() else None)


def _embed(x: Multivector, kind: Kind) -> Any:
    from ..dispatch.coefficients import embed

    return embed(x, kind)
