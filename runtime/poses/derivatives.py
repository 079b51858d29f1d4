"""Directional derivatives of functions of poses, by generated formulas."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..codegen.errors import InputError
from ..core.geometry.euclidean import is_origin, plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result, merge_statuses
from .angles import from_rotation_vector, to_rotation_vector
from .arguments import Array, as_pose, as_twist, call, vector
from .matrices import to_matrix
from .motions import act, compose, exp, inverse, log, position, rotate
from .paths import interpolate
from .quaternions import from_dual_quaternion, from_quaternion, to_dual_quaternion, to_quaternion


class Rule(NamedTuple):
    """The formula of a derivative, and what its arguments are: a pose, a vector, a twist, or so many numbers."""

    formula: str
    arguments: tuple[str | int, ...]
    shape: tuple[int, ...] = ()


RULES: dict[Callable[..., Any], Rule] = {
    exp: Rule("exp_pose", ("twist",)),
    log: Rule("log_pose", ("pose",)),
    compose: Rule("composed", ("pose", "pose")),
    inverse: Rule("inverse", ("pose",)),
    act: Rule("moved", ("pose", "vector")),
    rotate: Rule("rotated", ("pose", "vector")),
    position: Rule("position", ("pose",)),
    interpolate: Rule("screw_path", ("pose", "pose", 0)),
    to_quaternion: Rule("quaternion", ("pose",)),
    from_quaternion: Rule("pose_of_quaternion", (4, "vector")),
    to_dual_quaternion: Rule("dual_quaternion", ("pose",)),
    from_dual_quaternion: Rule("pose_of_dual_quaternion", (8,)),
    to_matrix: Rule("matrix", ("pose",), (4, 4)),
    to_rotation_vector: Rule("rotation_vector", ("pose",)),
    from_rotation_vector: Rule("pose_of_rotation_vector", ("vector", "vector")),
}


def derivative(function: Callable[..., Any], *arguments: Any, along: Any, strict: bool = False) -> Array:
    """Derivative of a function of this module along a direction of its arguments.

    Parameters
    ----------
    function : callable
        `exp`, `log`, `compose` (of two), `inverse`, `act`, `rotate`, `position`, `interpolate` (the screw motion),
        `to_quaternion`, `from_quaternion`, `to_dual_quaternion`, `from_dual_quaternion`, `to_matrix`,
        `to_rotation_vector` or `from_rotation_vector`, with the defaults of their options.
    *arguments
        Its arguments, without options; shapes broadcast to (...).
    along : array, or tuple of arrays
        A direction for each argument, None for one that does not vary. Of a pose it is the twist (..., 6) of the world
        that it moves with, x to exp(d) x.
    strict : bool
        Raise `SingularError` for the first item that is not finite.

    Returns
    -------
    array
        As the result of the function; where that is a pose, its twist (..., 6) of the world. Finite at the identity and
        at half turns; NaN at full turns where the logarithm is in it.

    Examples
    --------
    >>> x = poses.exp([0.1, 0.2, 0.3, 1, 2, 3])
    >>> velocity = poses.derivative(poses.act, x, (1, 0, 0), along=([0, 0, 1, 0, 0, 0], None))
    """
    rule = RULES.get(function) if callable(function) else None
    if rule is None:
        known = ", ".join(each.__name__ for each in RULES)
        raise InputError(f"{getattr(function, '__name__', function)!r} has no derivative here; {known} have.")
    name, kinds = function.__name__, list(rule.arguments)
    values, directions = list(arguments), list(along) if isinstance(along, tuple) else [along]
    if kinds[-1] == "vector" and len(values) == len(kinds) - 1 and len(kinds) > 1:
        values.append(0)  # the position
    if len(values) != len(kinds):
        raise InputError(f"{name} has {len(kinds)} arguments that may vary; here are {len(values)}.")
    directions += [None] * (len(values) - len(directions))
    if len(directions) != len(values):
        raise InputError(f"along has {len(directions)} directions for the {len(values)} arguments of {name}.")
    operands = [_operand(v, kind, f"argument {i + 1}") for i, (v, kind) in enumerate(zip(values, kinds, strict=True))]
    for i, (d, kind) in enumerate(zip(directions, kinds, strict=True)):
        operands.append(_direction(d, kind, f"along[{i}]"))
    result = call(f"pose_tangents.{rule.formula}", *operands)
    rows: Array = plain(result.value)
    rows = rows.reshape(*rows.shape[:-1], *rule.shape) if rule.shape else rows
    status = merge_statuses(*(x._status for x in operands if isinstance(x, Multivector)), result.status)
    found = array_result(rows, status, f"derivative of {name}", False, strict, len(rule.shape) or 1)
    assert not isinstance(found, tuple)
    return found


def _operand(value: Any, kind: str | int, name: str) -> Multivector | ArrayOperand:
    if kind == "pose":
        return as_pose(value, name)
    if kind == "twist":
        return as_twist(value, name)
    return vector(value, name, np.float64) if kind == "vector" else ArrayOperand(value, int(kind), name)


def _direction(value: Any, kind: str | int, name: str) -> ArrayOperand:
    count = {"pose": 6, "twist": 6, "vector": 3}.get(str(kind), kind)
    if value is None or is_origin(value):
        value = np.zeros(int(count)) if count else 0.0
    if kind == "vector":
        return vector(value, name, np.float64)
    return as_twist(value, name) if count == 6 else ArrayOperand(value, int(count), name)
