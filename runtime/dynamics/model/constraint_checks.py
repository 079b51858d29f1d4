"""What users pin, checked: objects, paths, targets and wrenches, and what their functions give."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ..multivector import Multivector
from .functions import Asked, takes
from .given import LARGEST_COEFFICIENT, check_coefficients, finite, shown
from .layouts import moves


def check_object(x: Any, what: str) -> None:
    if not isinstance(x, Multivector):
        raise InputError(f"{what} is {shown(x)}; a multivector is needed.")
    check_coefficients(x, what)
    if not np.any(x.values):
        raise InputError(f"{what} is zero, and pins nothing.")


def check_moving(x: Any, what: str) -> None:
    """An object that motions move: not a scalar, nor the point at infinity."""
    check_object(x, what)
    if not moves(x):
        raise InputError(f"{what} is a {x.kind.name} that no motion moves: it pins nothing.")
    largest = float(np.abs(x.values).max())
    if largest > LARGEST_COEFFICIENT:
        raise InputError(
            f"{what} has a coefficient of size {largest:.3g}; the largest is {LARGEST_COEFFICIENT:g}.",
            remedy="Divide the object by a number, or take a larger unit of length",
        )


def check_alike(own: Multivector, world: Multivector) -> None:
    """Objects of other grades never meet; those of other sizes are told by how far they are off."""
    if own.algebra is not world.algebra:
        raise AlgebraMismatchError(
            f"the body's object belongs to {own.algebra.name}, the world's to {world.algebra.name}."
        )
    used = [{b.bit_count() for b, v in zip(x.kind.blades, np.moveaxis(x.values, -1, 0), strict=True) if np.any(v)}
            for x in (own, world)]  # fmt: skip
    if not used[0] & used[1]:
        raise GradeError(
            f"the body's object is a {own.kind.name}, the world's a {world.kind.name}: no motion makes them one."
        )


def check_moving_or_path(x: Any, what: str) -> None:
    if callable(x):
        takes(x, (1,), what, "an object or a function of time")
    else:
        check_moving(x, what)


def check_point(x: Multivector) -> None:
    blades = x.algebra.kind("point").blades if "point" in x.algebra.kinds else ()
    if any(np.any(x.values[..., i]) for i, b in enumerate(x.kind.blades) if b not in blades):
        raise GradeError(f"the body's point is a {x.kind.name}; a point is needed.")


# -- what functions give ---------------------------------------------------------------------------------------


def asked_path(x: Any, what: str) -> Any:
    return Asked(x, what, _check_path) if callable(x) else x


def _check_path(value: Any, what: str) -> None:
    parts = _with_derivatives(value, 3, what)
    for part in parts:
        if not isinstance(part, Multivector):
            raise InputError(f"{what} is {shown(part)} where its function should give a multivector.")


def check_target(value: Any, what: str) -> None:
    for part in _with_derivatives(value, 3, what):
        check_value(part, what)


def check_wrenches(value: Any, what: str) -> None:
    for part in _with_derivatives(value, 2, what):
        if not isinstance(part, Multivector):
            raise InputError(
                f"{what} are {shown(part)} where their function should give a multivector.",
                remedy="Several are one multivector of shape (n,), as wrench(forces, points) gives them",
            )


def _with_derivatives(value: Any, count: int, what: str) -> tuple[Any, ...]:
    """What a function gave: a value, or a tuple of it and its derivatives."""
    parts = value if isinstance(value, tuple) else (value,)
    if len(parts) not in (1, count) or (isinstance(value, tuple) and len(parts) == 1):
        raise InputError(
            f"the function of {what} gives a tuple of {len(parts)}; a value alone, or a tuple of {count} with its "
            "derivatives, is needed."
        )
    return parts


def check_value(value: Any, what: str) -> None:
    """A multivector or a number."""
    if not isinstance(value, Multivector):
        found = finite(value, what)
        if found.ndim:
            raise ShapeError(f"{what} is an array of shape {found.shape}; a multivector or one number is needed.")
    else:
        check_coefficients(value, what)
