"""Jacobians of the Delta robot: direct differentiation against screws, Table 7.1 of the thesis in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runner import Measurement
from ..study import Case, Errors, Method, Study, swept
from . import delta_joints
from .delta_exact import ExactDelta, floats

if TYPE_CHECKING:
    from ...kinematics.delta import DeltaRobot

Array = NDArray[Any]
#: Poses of a case; base, platform, upper arm and forearm.
COUNT, LENGTHS = 40, (0.4, 0.1, 0.5, 1.0)
#: Random angles.
ANGLES = (-0.3, 1.0)
#: How often a pose is computed in a call, where one takes little and where it takes much.
COPIES, FEW_COPIES = 200, 50
#: A method that has the wrong sign, or the wrong posture, has no digit right.
LOST = 1.0
#: Steps of differences, radians or shares of the forearm.
STEPS = (1e-3, 1e-5, 1e-7)
UNITS, PLACES = (1e-6, 1.0, 1e3), (1.0, 1e2, 1e4, 1e6)
CONDITIONS = (1e2, 1e4, 1e6, 1e8)
#: For each pose near a singular one so many are tried, and that is taken whose condition number is as asked for.
TRIED = 12
#: Bisections until two numbers are neighbours; how far to go, in forearms, and angles that arms have at most.
HALVINGS, FAR, TURN = 80, 4.0, 3.0


@dataclass(frozen=True)
class Asked:
    """Poses, and which Jacobian is wanted there.

    Attributes
    ----------
    robot : DeltaRobot
    at : array (n, 3)
        Angles for J, positions for J*.
    back : bool
        J* is wanted.
    place : array (3,)
        Where the robot stands.
    swept : bool
        The case is one of a sweep: pose by pose is left out.
    """

    robot: DeltaRobot
    at: Array
    back: bool
    place: Array
    swept: bool = True

    def __len__(self) -> int:
        return len(self.at)

    @cached_property
    def exact(self) -> Array:
        """The Jacobians (n, 3, 3), from 50 digits."""
        return exact(self.robot, self.at, self.back)

    @cached_property
    def condition(self) -> Array:
        """Of the Jacobians."""
        found: Array = np.linalg.cond(self.exact)
        return found

    @cached_property
    def known(self) -> tuple[Array, Array]:
        """Angles and positions, both rounded from 50 digits."""
        digits = ExactDelta(self.robot)
        other = digits.inverse if self.back else digits.forward
        found = np.array([floats(other(digits.numbers(x)), (3,)) for x in self.at])
        return (found, self.at) if self.back else (self.at, found)

    @cached_property
    def points(self) -> Any:
        """All points of the robot, in the world."""
        from ...kinematics.delta_geometry import pose

        theta, y = self.known
        return pose(self.robot, y, theta)

    @cached_property
    def held(self) -> delta_joints.Held:
        """The same poses of a mechanism."""
        return delta_joints.held(self.robot, self.points, self.place)


def exact(robot: DeltaRobot, at: Array, back: bool) -> Array:
    """Jacobians (n, 3, 3); NaN where there is no pose."""
    digits = ExactDelta(robot)
    jacobian = digits.inverse_jacobian if back else digits.forward_jacobian
    return np.array([floats(jacobian(digits.numbers(x)), (3, 3)) for x in at])


# -- methods -----------------------------------------------------------------------------------------------


def own(asked: Asked, setting: Any, *, method: str, copies: int = 1) -> Array | None:
    """`DeltaRobot`'s Jacobians of all poses in a call, each so often. A robot stands at the origin."""
    if asked.place.any():
        return None
    jacobian = asked.robot.inverse_jacobian if asked.back else asked.robot.forward_jacobian
    found: Array = jacobian(np.tile(asked.at, (copies, 1)), method, threads=1)[: len(asked)]
    return found


def own_singly(asked: Asked, setting: Any, *, method: str) -> Array | None:
    """The same, pose by pose."""
    if asked.swept:
        return None
    jacobian = asked.robot.inverse_jacobian if asked.back else asked.robot.forward_jacobian
    return np.stack([jacobian(x, method) for x in asked.at])


def by_joints(asked: Asked, setting: Any, *, method: str, copies: int = 1) -> Array:
    """`Mechanism`'s, of poses that are known."""
    given = asked.held
    return given.jacobian(given.copied(copies), asked.back, method)[: len(asked)]


def by_joints_singly(asked: Asked, setting: Any, *, method: str) -> Array | None:
    """The same, pose by pose."""
    if asked.swept:
        return None
    given = asked.held
    one = [type(given.poses)(given.mechanism, x, np.zeros(()), np.zeros((), np.uint8)) for x in given.poses.own]
    return np.stack([given.jacobian(x, asked.back, method) for x in one])


def pseudo_inverse(asked: Asked, setting: Any) -> Array:
    """NumPy's of the constraint matrix, of poses that are known."""
    solve = delta_joints.inverse_jacobian if asked.back else delta_joints.forward_jacobian
    return solve(asked.points, asked.place)


def differences(asked: Asked, step: float) -> Array | None:
    """Central differences of the robot's own kinematics."""
    if asked.place.any():
        return None
    h = step * asked.robot.forearm if asked.back else step
    solve = asked.robot.inverse if asked.back else asked.robot.forward
    ends = asked.at[:, None] + h * np.concatenate([np.eye(3), -np.eye(3)])
    found = solve(ends, threads=1)
    made: Array = ((found[:, :3] - found[:, 3:]) / (2 * h)).swapaxes(-1, -2)
    return made


def error(answer: Array, truth: Array, asked: Asked) -> Errors:
    """Relative, in Frobenius's norm; infinite where no digit is right."""
    found = np.linalg.norm(answer - truth, axis=(-2, -1)) / np.linalg.norm(truth, axis=(-2, -1))
    return np.where(found < LOST, found, np.inf)


# -- cases -------------------------------------------------------------------------------------------------


def robot_of(unit: float = 1.0) -> DeltaRobot:
    """With lengths in some unit."""
    from ...kinematics.delta import DeltaRobot

    return DeltaRobot(*(unit * x for x in LENGTHS))


def usual(back: bool = False, unit: float = 1.0, away: float = 0.0, swept: bool = True) -> Any:
    """Maker of random poses."""

    def make(rng: np.random.Generator, count: int) -> Asked:
        robot = robot_of(unit)
        theta = rng.uniform(*ANGLES, (count, 3))
        place = away * np.array([0.6, -0.7, 0.4])
        return Asked(robot, robot.forward(theta) if back else theta, back, place, swept)

    return make


def singular(back: bool) -> Any:
    """Maker of makers of poses near where the forearms lie in one plane, or an arm is stretched."""

    def near(condition: float) -> Any:
        def make(rng: np.random.Generator, count: int) -> Asked:
            robot = robot_of()
            tried = [_near(robot, condition, back, usual(back)(rng, count).at, rng) for _ in range(TRIED)]
            found = np.array([np.linalg.cond(exact(robot, at, back)) for at in tried])
            off = np.abs(np.log(found / condition))
            best = np.where(np.isfinite(off), off, np.inf).argmin(0)
            return Asked(robot, np.array(tried)[best, range(count)], back, np.zeros(3))

        return make

    return near


def _near(robot: DeltaRobot, condition: float, back: bool, start: Array, rng: np.random.Generator) -> Array:
    """From poses (n, 3) so far in random directions that the condition number is reached, or the edge of all poses."""
    way = rng.normal(size=start.shape)
    way *= np.sign((way * (start if back else 1.0)).sum(-1, keepdims=True))  # outwards, where all ways end
    jacobian = robot.inverse_jacobian if back else robot.forward_jacobian
    low, high = np.zeros((len(start), 1)), np.full((len(start), 1), FAR)
    if not back:
        high[:] = ((TURN - np.abs(start)) / np.abs(way)).min(-1, keepdims=True)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        values, codes = jacobian(start + middle * way, status=True)
        good = np.asarray(codes, int) == 0
        size = np.full(len(start), np.inf)
        size[good] = np.linalg.cond(values[good]) if good.any() else 0.0
        within = (size < condition)[:, None]
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    found: Array = start + low * way
    return found


def describe(asked: Asked, i: int) -> str:
    """One pose."""
    what = "position" if asked.back else "angles"
    row = ", ".join(f"{x:.17g}" for x in asked.at[i])
    return f"{what} ({row}), condition number {asked.condition[i]:.3g}"


def prepare() -> None:
    """Compile what else would be timed."""
    many = np.tile(np.full(3, delta_joints.HOME), (20_000, 1))
    robot = robot_of()
    for jacobian, at in ((robot.forward_jacobian, many), (robot.inverse_jacobian, robot.forward(many))):
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
        How many poses have no answer, or none with a digit right.
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
    found = []
    for name in dict.fromkeys(r.method for r in rows if not r.method.endswith(SINGLY)):
        times = [{r.case: r.nanoseconds for r in rows if r.method == which} for which in (name, name + SINGLY)]
        batch, single = (x.get("forward Jacobian", np.nan) for x in times)
        errors, lost = {}, {}
        for case, label in COLUMNS.items():
            own = [r for r in rows if r.method == name and r.case == case]
            best = min(own, key=lambda r: (r.lost, r.max_error), default=None)
            errors[label], lost[label] = (np.nan, 0) if best is None else (best.max_error, best.lost)
        found.append(Line(name, batch, single, errors, lost))
    return found


SINGLY = ", pose by pose"
_DIRECT, _RODS, _ELIMINATION, _GENERAL = "direct", "screws of the rods", "screws, elimination", "screws, general"

STUDY = Study(
    name="delta",
    title="Jacobians of the Delta robot: direct differentiation and screws",
    methods=(
        Method(_DIRECT, partial(own, method="direct", copies=COPIES), copies=COPIES, repeats=1, prepare=prepare),
        Method(_DIRECT + SINGLY, partial(own_singly, method="direct"), repeats=1),
        Method(_RODS, partial(own, method="screw", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method(_RODS + SINGLY, partial(own_singly, method="screw"), repeats=1),
        Method(_ELIMINATION, partial(by_joints, method="elimination", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method(_ELIMINATION + SINGLY, partial(by_joints_singly, method="elimination"), repeats=1),
        Method(_GENERAL, partial(by_joints, method="general", copies=FEW_COPIES), copies=FEW_COPIES, repeats=1),
        Method("pseudo-inverse of 51 x 60, NumPy", pseudo_inverse, repeats=1, most=10),
        Method("differences", differences, "step", STEPS, repeats=1),
    ),
    cases=(
        Case("forward Jacobian", usual(swept=False), describe=describe),
        Case("inverse Jacobian", usual(back=True, swept=False), describe=describe),
        *swept("unit of length", UNITS, lambda unit: usual(unit=unit), describe),
        *swept("distance from the origin", PLACES, lambda away: usual(away=away), describe),
        *swept("condition number of J", CONDITIONS, singular(back=False), describe),
        *swept("condition number of J*", CONDITIONS, singular(back=True), describe),
    ),
    reference=lambda asked: asked.exact,
    error=error,
    unit="relative",
    count=COUNT,
    source="thesis 7.7.4 to 7.7.6, Table 7.1",
    notes="Direct differentiation and the rods' screws are given angles or positions, and find the pose first; the "
    "others are given the pose, rounded from 50 digits, and find the twists of all ten bodies. The direct way is made "
    "for this robot and stands at the origin. Near singular poses angles and positions are rounded to doubles: what is "
    "asked for is exact.",
)
