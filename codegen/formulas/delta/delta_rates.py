"""Jacobians of the Delta robot by direct differentiation, and motions (thesis 7.7.5); operands as in `delta`.

The derivatives are generated: the solution is run on dual numbers. Its roots are known with all their digits, so that
a Jacobian is as good next to a singular pose as elsewhere.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, select
from ...status import Status
from ...trace.derivatives import tangent_formula
from ...trace.outputs import Result, as_outputs, row
from ..objects.euclidean import coordinates
from ..products.outcome import not_a_number, outcome
from .delta import (
    Arms,
    Branch,
    Coordinates,
    Robot,
    Row,
    all_of,
    angles_of,
    are_finite,
    exact_height,
    exact_roots,
    meeting_of,
    moving,
    side_of,
    solve_arms,
)


def inverse_angles(y: Coordinates, robot: Robot, sides: Arms) -> Result:
    """The angles alone, whatever becomes of them."""
    return angles_of(solve_arms(y, robot, sides))


def inverse_angles_at(y: Coordinates, robot: Robot, sides: Arms, roots: Arms) -> Result:
    """The same where the roots are known with all their digits: what is differentiated."""
    return angles_of(solve_arms(y, robot, sides, [moving(root) for root in roots]))


def forward_position_at(theta: Arms, robot: Robot, side: Multivector, height: Multivector) -> Result:
    """The position alone, its height over the centers' plane known with all its digits: what is differentiated."""
    return row([x * robot.length for x in coordinates(meeting_of(theta, robot, side, moving(height)).position)], "y")


_inverse_tangent = tangent_formula(inverse_angles, __name__, constant=["robot", "sides"])
_inverse_tangent_at = tangent_formula(inverse_angles_at, __name__, constant=["robot", "sides", "roots"])
_forward_tangent_at = tangent_formula(forward_position_at, __name__, constant=["robot", "side", "height"])


def _columns(tangent: object, x: Row, *constant: object) -> list[Row]:
    """The tangents along the three coordinates."""
    one, zero = x[0].constant(1), x[0].constant(0)
    directions = [tuple(one if i == j else zero for i in range(3)) for j in range(3)]
    return [as_outputs(tangent(x, *constant, d))[1].values for d in directions]  # type: ignore[operator]


def _matrix(columns: list[Row], good: Mask) -> Result:
    """Row-major; NaN where there is no answer."""
    nan = not_a_number(columns[0][0])
    return row([select(good, columns[j][i], nan) for i in range(3) for j in range(3)], "jacobian")


def inverse_jacobian(y: Coordinates, robot: Robot, sides: Arms) -> tuple[Result, Result]:
    """d theta_i/d y_j, row-major (7.7.5). SINGULAR: an arm is stretched or folded, or a wrist is on a motor's axis."""
    arms, finite = solve_arms(y, robot, sides), are_finite(y)
    reachable, roots = all_of([r.is_reachable for r in arms]), exact_roots(y, robot)
    free = all_of([(root > 0) & ~r.is_aligned for r, root in zip(arms, roots, strict=True)])
    status = outcome(y[0], (~finite, Status.INVALID), (~reachable, Status.UNREACHABLE), (~free, Status.SINGULAR))
    return _matrix(_columns(_inverse_tangent_at, y, robot, sides, roots), reachable & free & finite), status


def forward_jacobian(theta: Arms, robot: Robot, root: Branch) -> tuple[Result, Result]:
    """d y_i/d theta_j, row-major (7.7.5). SINGULAR: the forearms lie in one plane, or two start at one point."""
    side = side_of(theta, robot, root)
    found, finite = meeting_of(theta, robot, side), are_finite(theta)
    height = exact_height(theta, robot)
    free = ~found.coincide & (height > 0)
    status = outcome(
        theta[0],
        (~finite, Status.INVALID),
        (found.coincide, Status.SINGULAR),
        (~found.meet, Status.UNREACHABLE),
        (~free, Status.SINGULAR),
    )
    return _matrix(_columns(_forward_tangent_at, theta, robot, side, height), found.meet & free & finite), status


# -- motions -----------------------------------------------------------------------------------------------------


def inverse_rates(y: Coordinates, dy: Coordinates, robot: Robot, sides: Arms) -> tuple[Result, Result]:
    """Angles and their speeds for a position and its velocity."""
    return tuple(as_outputs(_inverse_tangent(y, robot, sides, dy)))  # type: ignore[return-value]


_second_tangent = tangent_formula(inverse_rates, __name__, constant=["robot", "sides"])


def inverse_motion(
    y: Coordinates, dy: Coordinates, ddy: Coordinates, robot: Robot, sides: Arms
) -> tuple[Result, Result, Result, Result]:
    """Angles, speeds and accelerations of the arms for a motion of the platform.

    Statuses as of `inverse_jacobian`, and INVALID where numbers overflow: in single precision a robot of millimeters.
    """
    arms, finite = solve_arms(y, robot, sides), are_finite((*y, *dy, *ddy))
    reachable = all_of([r.is_reachable for r in arms])
    free = all_of([(r.root > 0) & ~r.is_aligned for r in arms])
    found = as_outputs(_second_tangent(y, dy, robot, sides, dy, ddy))
    values = [(name, found[i].values) for name, i in (("theta", 0), ("speed", 1), ("acceleration", 3))]
    held = are_finite(tuple(x for _, each in values for x in each))
    good, nan = reachable & free & finite & held, not_a_number(y[0])
    theta, speed, acceleration = (row([select(good, x, nan) for x in each], name) for name, each in values)
    status = outcome(
        y[0],
        (~finite, Status.INVALID),
        (~reachable, Status.UNREACHABLE),
        (~free, Status.SINGULAR),
        (~held, Status.INVALID),
    )
    return theta, speed, acceleration, status
