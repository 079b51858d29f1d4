"""Directional derivatives of the functions of poses. Poses move by twists of the world: dx = -phi x/2.

Each takes the arguments of the formula that it is named after, then a direction for each: a row (w, v) for a pose, else
what the argument is. Results that are poses have twists for derivatives.
"""

from __future__ import annotations

import inspect
from typing import Any

from ...algebra.multivector import Multivector
from ...trace.derivatives import tangent_formula
from ...trace.kernel import Formula
from ...trace.outputs import Result
from ..mechanics.mechanics import screw_of
from ..motions.screws import direction_part
from ..motions.twists import ScrewRow, screw_of_row, screw_row
from ..objects.euclidean import cross, euclidean_part, space
from ..products.exponentials import log_motor
from . import poses
from .pose_jacobians import inverse_jacobian_on, jacobian_on
from .poses import shortest


def rate_of(x: Multivector, twist: ScrewRow) -> Multivector:
    """dx of a pose that moves with a twist of the world."""
    return (screw_of_row(twist) * x).grade(0, 2, 4) / -2


def twist_of_rate(x: Multivector, rate: Multivector) -> Multivector:
    """-2 dx ~x."""
    return (-2 * (rate * ~x)).grade(2)


def along(formula: Formula, *names_of_poses: str) -> Formula:
    """The derivative of a formula by dual numbers."""
    tangent = tangent_formula(formula, __name__)
    names = [p for p in inspect.signature(tangent).parameters if not p.startswith("d_")]

    def derivative(*arguments: Any) -> Any:
        operands, directions = arguments[: len(names)], list(arguments[len(names) :])
        for i, (each, x) in enumerate(zip(names, operands, strict=True)):
            if each in names_of_poses:
                directions[i] = rate_of(x, ScrewRow(*directions[i]))
        results = tangent(*operands, *directions)
        value, rate = results[0], results[len(results) // 2]
        if not value.is_row and 0 in value.value.grades:
            return screw_row(twist_of_rate(value.value, rate.value), "twist")
        return rate if rate.is_row else rate.value

    derivative.__name__ = derivative.__qualname__ = formula.__name__
    derivative.__module__ = __name__
    derivative.__doc__ = f"Derivative of `{formula.__name__}`."
    annotations = dict(tangent.__annotations__)
    annotations.update({f"d_{each}": ScrewRow for each in names_of_poses})
    derivative.__annotations__ = annotations
    derivative.__signature__ = inspect.signature(tangent)  # type: ignore[attr-defined]
    return derivative


def composed(x: Multivector, y: Multivector, d_x: ScrewRow, d_y: ScrewRow) -> Result:
    """The twist of x y."""
    return screw_row(screw_of_row(d_x) + (x >> screw_of_row(d_y)).grade(2), "twist")


def inverse(x: Multivector, d_x: ScrewRow) -> Result:
    """The twist of ~x."""
    return screw_row(-(~x >> screw_of_row(d_x)).grade(2), "twist")


quaternion = along(poses.quaternion, "x")
dual_quaternion = along(poses.dual_quaternion, "x")
matrix = along(poses.matrix, "x")
position = along(poses.position, "x")
moved = along(poses.moved, "x")
rotated = along(poses.rotated, "x")
pose_of_quaternion = along(poses.pose_of_any_quaternion)
pose_of_dual_quaternion = along(poses.pose_of_any_dual_quaternion)


# -- through the exponential: by its Jacobians, which need no root that is zero at the identity -------------


def exp_pose(twist: ScrewRow, d_twist: ScrewRow) -> Result:
    """The twist of exp(-phi/2)."""
    return screw_row(jacobian_on(screw_of_row(twist), screw_of_row(d_twist), 1), "twist")


def log_pose(x: Multivector, d_x: ScrewRow) -> tuple[Result, Result]:
    """The derivative of the logarithm. SINGULAR: a full turn."""
    b, _ = log_motor(x)
    twist, status = inverse_jacobian_on(-2 * b, screw_of_row(d_x), 1)
    return screw_row(twist, "twist"), status


def pose_of_rotation_vector(r: Multivector, position: Multivector, d_r: Multivector, d_position: Multivector) -> Result:
    """The twist of a pose: (w, dp - w x p) with w = J dr."""
    w = direction_part(jacobian_on(r * space(r), d_r * space(r), 1))
    return screw_row(screw_of(w, d_position - cross(w, position)), "twist")


def rotation_vector(x: Multivector, d_x: ScrewRow) -> tuple[Multivector, Result]:
    """The derivative of the rotation vector. SINGULAR: a full turn."""
    b, _ = log_motor(euclidean_part(x))
    twist, status = inverse_jacobian_on(-2 * b, direction_part(screw_of_row(d_x)) * space(x), 1)
    return direction_part(twist), status


def screw_path(
    x: Multivector, y: Multivector, t: Multivector, d_x: ScrewRow, d_y: ScrewRow, d_t: Multivector
) -> tuple[Result, Result]:
    """The twist of x exp(t xi), xi = log(~x y). SINGULAR: xi is a full turn."""
    b, _ = log_motor(shortest((~x * y).grade(0, 2, 4)))
    xi, moving = -2 * b, screw_of_row(d_x)
    rate, status = inverse_jacobian_on(xi, (~x >> (screw_of_row(d_y) - moving)).grade(2), 1)
    own = jacobian_on(t * xi, d_t * xi + t * rate, 1)
    return screw_row(moving + (x >> own).grade(2), "twist"), status
