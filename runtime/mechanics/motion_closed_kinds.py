"""Layouts of pinned objects: the narrowest kind of the algebra that holds an object in all its poses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.closed_kinds import closed_kinds, commutator
from ..codegen.errors import GradeError
from ..common.validation import as_instance, check_shape
from ..core.multivector import Multivector
from .arguments import multivector_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..core.multivector import Algebra

Array = NDArray[Any]


def is_movable(x: Multivector) -> bool:
    """True if a motion changes it; none changes scalars, the point at infinity and the whole space."""
    algebra = x.algebra
    if "twist" not in algebra.kinds:
        return True  # of another geometry: reported where objects meet bodies
    twists = algebra.kind("twist").blades
    used = (b for b, v in zip(x.kind.blades, np.moveaxis(x.values, -1, 0), strict=True) if np.any(v))
    return any(commutator(algebra, b, e) for b in used for e in twists)


def layout_of(objects: list[Multivector], what: str) -> str:
    """Narrowest closed kind that holds all objects.

    Raises
    ------
    GradeError
        If no closed kind has their blades.
    """
    algebra = objects[0].algebra
    blades = {b for x in objects for b, v in zip(x.kind.blades, np.moveaxis(x.values, -1, 0), strict=True) if np.any(v)}
    for name in closed_kinds(algebra):
        if blades <= set(algebra.kind(name).blades):
            return name
    raise GradeError(f"{what} has blades of no kind of {algebra.name} that motions keep.")


def basis(algebra: Algebra, layout: str) -> Multivector:
    """Basis blades of a layout as a batch."""
    kind = algebra.kind(layout)
    return algebra.wrap(kind.layout, np.eye(kind.size))


def on_layout(x: Multivector, layout: str) -> Array:
    """Coefficients (..., k) on a layout; others are dropped, and must be rounding."""
    kind = x.algebra.kind(layout)
    values = np.zeros((*x.shape, kind.size))
    for i, b in enumerate(x.kind.blades):
        if b in kind.blades:
            values[..., kind.blades.index(b)] = x.values[..., i]
    return values


def sandwich_matrix(frame: Multivector, layout: str) -> Array:
    """Matrices (..., k, k) of X -> F X ~F on coefficients, for motors F."""
    images = (frame[..., None] if frame.shape else frame) >> basis(frame.algebra, layout)
    return np.swapaxes(on_layout(images, layout), -1, -2)


def matrix_of(function: Callable[[Multivector], Any], algebra: Algebra, layout: str, what: str) -> Array:
    """Matrix (rows, k) of a linear function of objects of a layout, without its zero rows.

    Raises
    ------
    GradeError
        If it is not linear, is zero, or its value is not a multivector.
    """
    kind = algebra.kind(layout)

    def evaluate(row: Array) -> Array:
        x = algebra.wrap(kind.layout, np.ascontiguousarray(row))
        y = function(x)
        check_shape(as_instance(y, f"a value of {what}", Multivector, "a multivector", GradeError), what, ())
        multivector_of(y, algebra, what)
        values = np.zeros(1 << len(algebra.vectors))
        values[list(y.kind.blades)] = y.values
        return values

    columns = np.stack([evaluate(row) for row in np.eye(kind.size)], 1)
    test = np.linspace(1, 2, kind.size) ** 2
    whole = evaluate(test)
    if not np.allclose(columns @ test, whole, rtol=1e-9, atol=1e-9 * np.abs(columns).max(initial=0)):
        raise GradeError(f"{what} is not linear: of a sum it is not the sum.")
    rows: Array = columns[np.abs(columns).max(1) > 0]
    if not len(rows):
        raise GradeError(f"{what} is zero for every {layout}: it holds nothing.")
    return rows
