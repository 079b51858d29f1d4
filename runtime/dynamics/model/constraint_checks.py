"""Checks of pinned objects, paths, targets and wrenches, and of the values of their functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ...common.callbacks import GuardedCallback, check_arity
from ...common.validation import as_instance, finite_array, short_repr
from ...core.multivector import Multivector
from ...mechanics.arguments import LARGEST_COEFFICIENT, check_coefficients
from ...mechanics.motion_closed_kinds import is_movable


def check_object(x: Any, what: str) -> None:
    remedy = None
    if (x.shape == (3,)) if isinstance(x, np.ndarray) else (isinstance(x, (list, tuple)) and len(x) == 3):
        remedy = f"Make it a point: cga.point({short_repr(x)})"
    check_coefficients(as_instance(x, what, Multivector, "a multivector", remedy=remedy), what)
    if not np.any(x.values):
        raise InputError(f"{what} is zero, and pins nothing.")


def check_moving(x: Any, what: str) -> None:
    """Check that motions move an object, unlike scalars and the point at infinity."""
    check_object(x, what)
    if not is_movable(x):
        raise InputError(f"{what} is a {x.kind.name} that no motion moves: it pins nothing.")
    largest = float(np.abs(x.values).max())
    if largest > LARGEST_COEFFICIENT:
        raise InputError(
            f"{what} has a coefficient of size {largest:.3g}; the largest is {LARGEST_COEFFICIENT:g}.",
            remedy="Divide the object by a number, or take a larger unit of length",
        )


def check_alike(body: Multivector, world: Multivector) -> None:
    """Check that two objects have a grade in common; other differences are errors of the constraint."""
    if body.algebra is not world.algebra:
        raise AlgebraMismatchError(
            f"the body's object belongs to {body.algebra.name}, the world's to {world.algebra.name}."
        )
    used = [{b.bit_count() for b, v in zip(x.kind.blades, np.moveaxis(x.values, -1, 0), strict=True) if np.any(v)}
            for x in (body, world)]  # fmt: skip
    if not used[0] & used[1]:
        raise GradeError(
            f"the body's object is a {body.kind.name}, the world's a {world.kind.name}: no motion makes them one."
        )


def check_moving_or_path(x: Any, what: str) -> None:
    if callable(x):
        check_arity(x, (1,), what, "an object or a function of time")
    else:
        check_moving(x, what)


def check_point(x: Multivector) -> None:
    blades = x.algebra.kind("point").blades if "point" in x.algebra.kinds else ()
    if any(np.any(x.values[..., i]) for i, b in enumerate(x.kind.blades) if b not in blades):
        raise GradeError(f"the body's point is a {x.kind.name}; a point is needed.")


# -- values of functions ---------------------------------------------------------------------------------------


def guarded_path(x: Any, what: str) -> Any:
    return GuardedCallback(x, what, _check_path) if callable(x) else x


def _check_path(value: Any, what: str) -> None:
    parts = _with_derivatives(value, 3, what)
    for part in parts:
        if not isinstance(part, Multivector):
            raise InputError(f"{what} is {short_repr(part)} where its function should give a multivector.")


def check_target(value: Any, what: str) -> None:
    for part in _with_derivatives(value, 3, what):
        check_value(part, what)


def check_wrenches(value: Any, what: str) -> None:
    for part in _with_derivatives(value, 2, what):
        if not isinstance(part, Multivector):
            raise InputError(
                f"{what} are {short_repr(part)} where their function should give a multivector.",
                remedy="Several are one multivector of shape (n,), as wrench(forces, points) gives them",
            )


def _with_derivatives(value: Any, count: int, what: str) -> tuple[Any, ...]:
    """Value of a function and its derivatives, if there are any."""
    parts = value if isinstance(value, tuple) else (value,)
    if len(parts) not in (1, count) or (isinstance(value, tuple) and len(parts) == 1):
        raise InputError(
            f"the function of {what} gives a tuple of {len(parts)}; a value alone, or a tuple of {count} with its "
            "derivatives, is needed."
        )
    return parts


def check_value(value: Any, what: str) -> None:
    """Check a target: a multivector or a number."""
    if not isinstance(value, Multivector):
        number = finite_array(value, what)
        if number.ndim:
            raise ShapeError(f"{what} has shape {number.shape}; a multivector or one number is needed.")
    else:
        check_coefficients(value, what)
