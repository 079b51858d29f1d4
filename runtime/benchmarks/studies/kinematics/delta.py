"""Jacobians of the Delta robot: direct differentiation against screws, Table 7.1 of the thesis in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ....kinematics.delta.geometry import pose
from ....kinematics.delta.robot import DeltaRobot
from ...harness.runner import Measurement
from ...harness.study import Array, Case, Errors, Method, Study, lost_beyond, sweep_cases
from ...harness.vectors import vector_text
from . import delta_joints
from .chains import AWAY
from .delta_exact import ExactDelta, floats

#: Poses of a case; base, platform, upper arm and forearm.
COUNT, LENGTHS = 40, (0.4, 0.1, 0.5, 1.0)
#: Random angles.
ANGLES = (-0.3, 1.0)
#: Number of computations of a pose in a call, for fast methods and for slow ones.
COPIES, FEW_COPIES = 200, 50
#: A method that has the wrong sign, or the wrong posture, has no digit right.
LOST = 1.0
#: Steps of differences, radians or fractions of the forearm.
STEPS = (1e-3, 1e-5, 1e-7)
UNITS, DISTANCES = (1e-6, 1.0, 1e3), (1.0, 1e2, 1e4, 1e6)
CONDITIONS = (1e2, 1e4, 1e6, 1e8)
#: Number of candidates for each pose near a singular one, of which the one nearest to the condition number is taken.
CANDIDATES = 12
#: Bisections until two numbers are neighbors; the range, in forearms; the largest angle of an arm.
HALVINGS, FAR, LARGEST_ANGLE = 80, 4.0, 3.0


@dataclass(frozen=True)
class JacobianQuery:
    """Poses, and the requested Jacobian.

    Attributes
    ----------
    robot : DeltaRobot
    at : array (n, 3)
        Angles for J, positions for J*.
    is_inverse : bool
        J* is requested.
    position : array (3,)
        Position of the robot.
    is_swept : bool
        The case is one of a sweep: pose by pose is left out.
    """

    robot: DeltaRobot
    at: Array
    is_inverse: bool
    position: Array
    is_swept: bool = True

    def __len__(self) -> int:
        return len(self.at)

    @property
    def jacobian(self) -> Any:
        """The robot's function."""
        return self.robot.inverse_jacobian if self.is_inverse else self.robot.forward_jacobian

    @cached_property
    def exact(self) -> Array:
        """The Jacobians (n, 3, 3), from 50 digits; NaN where there is no pose."""
        digits = ExactDelta(self.robot)
        jacobian = digits.inverse_jacobian if self.is_inverse else digits.forward_jacobian
        return np.array([floats(jacobian(digits.numbers(x)), (3, 3)) for x in self.at])

    @cached_property
    def condition(self) -> Array:
        """Condition numbers of the Jacobians."""
        return np.asarray(np.linalg.cond(self.exact))

    @cached_property
    def known_pose(self) -> tuple[Array, Array]:
        """Angles and positions, both rounded from 50 digits."""
        digits = ExactDelta(self.robot)
        solve = digits.inverse if self.is_inverse else digits.forward
        others = np.array([floats(solve(digits.numbers(x)), (3,)) for x in self.at])
        return (others, self.at) if self.is_inverse else (self.at, others)

    @cached_property
    def points(self) -> Any:
        """All points of the robot, in the world."""
        theta, y = self.known_pose
        return pose(self.robot, y, theta)

    @cached_property
    def jointed_robot(self) -> delta_joints.JointedRobot:
        """Mechanism at the same poses."""
        return delta_joints.jointed_robot(self.robot, self.points, self.position)


# -- methods -----------------------------------------------------------------------------------------------


def by_robot(query: JacobianQuery, setting: Any, *, method: str, copies: int = 1) -> Array | None:
    """`DeltaRobot`'s Jacobians of all poses in a call, each so often. A robot stands at the origin."""
    if query.position.any():
        return None
    return np.asarray(query.jacobian(np.tile(query.at, (copies, 1)), method, threads=1)[: len(query)])


def by_robot_singly(query: JacobianQuery, setting: Any, *, method: str) -> Array | None:
    """The same, pose by pose."""
    return None if query.is_swept else np.stack([query.jacobian(x, method) for x in query.at])


def by_joints(query: JacobianQuery, setting: Any, *, method: str, copies: int = 1) -> Array:
    """`Mechanism`'s, of poses that are known."""
    jointed = query.jointed_robot
    return jointed.jacobian(jointed.repeated_poses(copies), query.is_inverse, method)[: len(query)]


def by_joints_singly(query: JacobianQuery, setting: Any, *, method: str) -> Array | None:
    """The same, pose by pose."""
    if query.is_swept:
        return None
    jointed, none = query.jointed_robot, (np.zeros(()), np.zeros((), np.uint8))
    poses = [type(jointed.poses)(jointed.mechanism, x, *none) for x in jointed.poses.own]
    return np.stack([jointed.jacobian(x, query.is_inverse, method) for x in poses])


def pseudo_inverse(query: JacobianQuery, setting: Any) -> Array:
    """NumPy's of the constraint matrix, of poses that are known."""
    solve = delta_joints.inverse_jacobian if query.is_inverse else delta_joints.forward_jacobian
    return solve(query.points, query.position)


def differences(query: JacobianQuery, step: float) -> Array | None:
    """Central differences of the robot's own kinematics."""
    if query.position.any():
        return None
    h = step * query.robot.forearm if query.is_inverse else step
    solve = query.robot.inverse if query.is_inverse else query.robot.forward
    ends = query.at[:, None] + h * np.concatenate([np.eye(3), -np.eye(3)])
    solutions = solve(ends, threads=1)
    return np.asarray(((solutions[:, :3] - solutions[:, 3:]) / (2 * h)).swapaxes(-1, -2))


def error(answer: Array, truth: Array, _: JacobianQuery) -> Errors:
    """Relative, in Frobenius's norm; infinite where no digit is right."""
    return lost_beyond(np.linalg.norm(answer - truth, axis=(-2, -1)) / np.linalg.norm(truth, axis=(-2, -1)), LOST)


# -- cases -------------------------------------------------------------------------------------------------


def robot_of(unit: float = 1.0) -> DeltaRobot:
    """Robot with lengths in some unit."""
    return DeltaRobot(*(unit * x for x in LENGTHS))


def usual(
    rng: np.random.Generator, count: int, unit: float = 1.0, away: float = 0.0, is_inverse: bool = False,
    is_swept: bool = True,
) -> JacobianQuery:  # fmt: skip
    """Random poses."""
    robot = robot_of(unit)
    theta = rng.uniform(*ANGLES, (count, 3))
    at = robot.forward(theta) if is_inverse else theta
    return JacobianQuery(robot, at, is_inverse, away * np.array(AWAY), is_swept)


def singular(rng: np.random.Generator, count: int, condition: float, is_inverse: bool) -> JacobianQuery:
    """Poses near where the forearms lie in one plane, or an arm is stretched."""
    queries = []
    for _ in range(CANDIDATES):
        query = usual(rng, count, is_inverse=is_inverse)
        queries.append(replace(query, at=_near(query, condition, rng)))
    off = np.abs(np.log(np.array([query.condition for query in queries]) / condition))
    best = np.where(np.isfinite(off), off, np.inf).argmin(0)
    return replace(queries[0], at=np.array([query.at for query in queries])[best, range(count)])


def _near(query: JacobianQuery, condition: float, rng: np.random.Generator) -> Array:
    """From poses (n, 3) so far in random directions that the condition number is reached, or the edge of all poses."""
    start = query.at
    direction = rng.normal(size=start.shape)
    outwards = direction * (start if query.is_inverse else 1.0)  # where all paths end
    direction *= np.sign(outwards.sum(-1, keepdims=True))
    low, high = np.zeros((len(start), 1)), np.full((len(start), 1), FAR)
    if not query.is_inverse:
        high[:] = ((LARGEST_ANGLE - np.abs(start)) / np.abs(direction)).min(-1, keepdims=True)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        values, codes = query.jacobian(start + middle * direction, status=True)
        good = np.asarray(codes, int) == 0
        size = np.full(len(start), np.inf)
        size[good] = np.linalg.cond(values[good]) if good.any() else 0.0
        within = (size < condition)[:, None]
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return np.asarray(start + low * direction)


def describe(query: JacobianQuery, i: int) -> str:
    """One pose."""
    quantity = "position" if query.is_inverse else "angles"
    return f"{quantity} {vector_text(query.at[i], 17)}, condition number {query.condition[i]:.3g}"


def prepare() -> None:
    """Compile what else would be timed."""
    angles = np.tile(np.full(3, delta_joints.HOME), (20_000, 1))
    robot = robot_of()
    for jacobian, at in ((robot.forward_jacobian, angles), (robot.inverse_jacobian, robot.forward(angles))):
        for method in ("direct", "screw"):
            jacobian(at, method)


# -- Table 7.1 ---------------------------------------------------------------------------------------------


class Line(NamedTuple):
    """A method in numbers; NaN where it is not made for that.

    Attributes
    ----------
    method : str
    batch, single : float
        Nanoseconds for a pose, of many in a call and of one.
    errors : dict of str to float
        The largest, by case, of answers that there are.
    lost : dict of str to int
        Number of poses without an answer, or without a correct digit.
    """

    method: str
    batch: float
    single: float
    errors: dict[str, float]
    lost: dict[str, int]


#: Cases of the table, and what they are called in it.
COLUMNS = {
    "forward Jacobian": "J", "inverse Jacobian": "J*", "unit of length 1e-06": "lengths 1e-6",
    "unit of length 1e+03": "lengths 1e3", "distance from the origin 1e+04": "at 1e4",
    "condition number of J 1e+04": "J, 1e4", "condition number of J 1e+08": "J, 1e8",
    "condition number of J* 1e+04": "J*, 1e4", "condition number of J* 1e+08": "J*, 1e8",
}  # fmt: skip


def table(rows: Sequence[Measurement]) -> list[Line]:
    """Table 7.1 in numbers."""
    lines = []
    for name in dict.fromkeys(r.method for r in rows if not r.method.endswith(SINGLY)):
        times = [{r.case: r.nanoseconds for r in rows if r.method == which} for which in (name, name + SINGLY)]
        batch, single = (x.get("forward Jacobian", np.nan) for x in times)
        errors, lost = {}, {}
        for case, label in COLUMNS.items():
            of_case = [r for r in rows if r.method == name and r.case == case]
            best = min(of_case, key=lambda r: (r.lost, r.max_error), default=None)
            errors[label], lost[label] = (np.nan, 0) if best is None else (best.max_error, best.lost)
        lines.append(Line(name, batch, single, errors, lost))
    return lines


SINGLY = ", pose by pose"
_DIRECT, _RODS, _ELIMINATION, _GENERAL = "direct", "screws of the rods", "screws, elimination", "screws, general"

STUDY = Study(
    name="delta",
    title="Jacobians of the Delta robot: direct differentiation and screws",
    methods=(
        Method(_DIRECT, partial(by_robot, method="direct", copies=COPIES), copies=COPIES, repeats=1, prepare=prepare),
        Method(_DIRECT + SINGLY, partial(by_robot_singly, method="direct"), repeats=1),
        Method(_RODS, partial(by_robot, method="screw", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method(_RODS + SINGLY, partial(by_robot_singly, method="screw"), repeats=1),
        Method(_ELIMINATION, partial(by_joints, method="elimination", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method(_ELIMINATION + SINGLY, partial(by_joints_singly, method="elimination"), repeats=1),
        Method(_GENERAL, partial(by_joints, method="general", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method("pseudo-inverse of 51 x 60, NumPy", pseudo_inverse, repeats=1, most=10),
        Method("differences", differences, "step", STEPS, repeats=1),
    ),
    cases=(
        Case("forward Jacobian", partial(usual, is_swept=False)),
        Case("inverse Jacobian", partial(usual, is_inverse=True, is_swept=False)),
        *sweep_cases("unit of length", UNITS, usual),
        *sweep_cases("distance from the origin", DISTANCES, lambda rng, count, away: usual(rng, count, away=away)),
        *sweep_cases("condition number of J", CONDITIONS, partial(singular, is_inverse=False)),
        *sweep_cases("condition number of J*", CONDITIONS, partial(singular, is_inverse=True)),
    ),
    reference=lambda query: query.exact,
    error=error,
    describe=describe,
    unit="relative",
    count=COUNT,
    source="thesis 7.7.4 to 7.7.6, Table 7.1",
    notes="Direct differentiation and the rods' screws are given angles or positions, and find the pose first; the "
    "others are given the pose, rounded from 50 digits, and find the twists of all ten bodies. XX",
)
