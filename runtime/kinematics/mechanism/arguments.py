"""Arguments that name joints, bodies and points of a mechanism, checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import finite_array, short_repr
from ...core.multivector import Multivector
from ...mechanics.arguments import vectors
from ...mechanics.joints.base import Joint
from .structure import Assembly

Array = NDArray[Any]
#: Role of a joint whose speeds are requested.
OUTPUT = "an output"


def as_list(x: Any) -> list[Any]:
    """One item or several, as a list.

    Raises
    ------
    InputError
        If the items have no order.
    """
    if isinstance(x, Mapping):
        return list(x.items())
    if isinstance(x, Set):
        raise InputError(f"{short_repr(x)} has no order.", remedy="Give a list")
    if isinstance(x, str | tuple | Joint | Multivector | None) or not isinstance(x, Iterable):
        return [x]
    return [v.item() if isinstance(v, np.generic) else v for v in x]


def body_and_value(x: Any, what: str) -> tuple[Any, Any]:
    """A body, and the value that is paired with it, if any.

    Raises
    ------
    InputError
        If it is neither a body nor such a pair.
    """
    if not isinstance(x, tuple):
        return x, None
    if len(x) != 2 or isinstance(x[1], str | Joint):
        raise InputError(f"{x!r} is not a pair (body, {what}).", remedy="Give several bodies or joints as a list")
    return x


def point_coordinates(point: Multivector, what: str) -> Array:
    """Coordinates (..., 3) of points.

    Raises
    ------
    InputError
        If the objects are not points.
    """
    parameters = point.parameters()
    if not hasattr(parameters, "xyz"):
        raise InputError(f"{what} is a {type(parameters).__name__.lower()}; a point is needed.")
    return np.asarray(parameters.xyz)


def position_of(point: Any, what: str) -> Array:
    """Coordinates (3,) of a point, given as a multivector or by coordinates."""
    values = point_coordinates(point, what) if isinstance(point, Multivector) else vectors(point, what)
    return finite_array(values, what, (3,))


def check_coordinates(mechanism: Assembly, joint: int, role: str = "") -> None:
    """Raise `InputError` if the spanning tree has no coordinate of a joint: it closes a loop, or its freedoms vary.

    ``role``: what it was to be at many poses, if a Jacobian is asked; an output may close a loop.
    """
    name, own = mechanism.joint_names[joint], mechanism.joints[joint]
    body = own.a if own.b == mechanism.fixed else own.b
    cannot = f"cannot be {role} at many poses" if role else "cannot be driven"
    instead = f"the body {body!r}, or loop over mechanism.at(..)" if role else f"targets= of its body {body!r}"
    if joint not in mechanism.tree.child_of and role != OUTPUT:
        raise InputError(f"{name} closes a loop, and {cannot}.", remedy=f"Take another joint of it, or use {instead}")
    if any(c.product is not None for c in own.conditions()):
        raise InputError(f"{name} has freedoms that change with the pose, and {cannot}.", remedy=f"Use {instead}")
