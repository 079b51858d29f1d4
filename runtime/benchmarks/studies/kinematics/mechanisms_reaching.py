"""Poses by Newton's method: error and success against how far away they are, and the steps that it takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study, swept
from . import chains, delta
from .delta_exact import ExactDelta, floats
from .delta_joints import HOME, held

Array = NDArray[Any]
COUNT = 80
#: How far the joints are from the start, radians: the largest of them.
DISTANCES = (0.01, 0.1, 0.3, 1.0, 2.0, 3.0)
#: Steps of a path to the target; budgets of Newton steps, and the drivers' own; restarts of plain Newton: none.
STEPS, BUDGETS = 10, (5, 10, 60)
#: Random directions that are tried for each pose; further off than this is another solution, or none.
TRIED, LOST = 60, 1e-3
#: The start of the arm, where it is not singular.
START = (0.3, -0.9, 1.4, 0.5, 0.8, -0.4)


@dataclass(frozen=True)
class Goal:
    """Poses to reach, from one start.

    Attributes
    ----------
    what : {"angles", "place", "arm"}
        A Delta robot's motors are driven to angles; its platform is brought to places; an arm's tool is brought to
        poses.
    q : array (m, n)
        Coordinates there.
    """

    what: str
    q: Array

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def held(self) -> Any:
        """The Delta robot at its home, as a mechanism."""
        robot = delta.robot_of()
        return held(robot, robot.pose(np.full((1, 3), HOME)), np.zeros(3))

    @cached_property
    def arm(self) -> chains.Arm:
        """The six-axis arm at the poses."""
        return chains.six_at(self.q, "pose")

    @cached_property
    def places(self) -> Array:
        """Of the platform, from 50 digits."""
        digits = ExactDelta(delta.robot_of())
        return np.array([floats(digits.forward(digits.numbers(x)), (3,)) for x in self.q])

    @cached_property
    def exact(self) -> Array:
        """Places of the platform (m, 3), its angles (m, 3), or the arm's poses (m, 3, 4)."""
        if self.what == "arm":
            return self.arm.exact
        if self.what == "angles":
            return self.places
        digits = ExactDelta(delta.robot_of())
        return np.array([floats(digits.inverse(digits.numbers(y)), (3,)) for y in self.places])


# -- methods -----------------------------------------------------------------------------------------------


def by_newton(goal: Goal, setting: Any, *, steps: int = 1) -> Array | None:
    """`Mechanism.solve_pose` from the start at once, or along a path of so many steps."""
    if goal.what == "arm":
        return None
    given = goal.held
    mechanism, path = given.mechanism, steps > 1
    share = np.linspace(1 / steps, 1, steps)[:, None]
    if goal.what == "angles":
        ways = (goal.q - HOME)[:, None] * share
        ways = ways if path else ways[:, 0]
        driven = dict(zip(given.motors, np.moveaxis(ways, -1, 0), strict=True))
        found = mechanism.solve_pose(driven, path=path, threads=1)
        answer = (found["platform"] >> mechanism.algebra.point(given.point)).parameters().xyz
    else:
        places = given.point + (goal.places - given.point)[:, None] * share
        aims = {"platform": (given.point, places if path else places[:, 0])}
        found = mechanism.solve_pose(targets=aims, path=path, threads=1)
        answer = HOME + np.concatenate([found.coordinates(j) for j in given.motors], -1)
    good = np.asarray(found.status, int) == 0
    answer = np.where(good[..., None], answer, np.nan)
    return np.asarray(answer[:, -1] if path else answer)


def by_chain(goal: Goal, budget: int, *, attempts: int) -> Array | None:
    """`Chain.inverse` from the start, and from elsewhere where that does not lead there; its coordinates."""
    if goal.what != "arm":
        return None
    targets = goal.arm.chain.forward(goal.q)
    chain, start = goal.arm.chain, np.array(START)
    found: Array = chain.inverse(targets, start, iterations=budget, attempts=attempts, nearest=True).q
    return found


def plain(goal: Goal, budget: int) -> Array | None:
    """Undamped Newton steps with NumPy, on the same Jacobians, all poses at once."""
    if goal.what != "arm":
        return None
    chain, wanted = goal.arm.chain, chains.matrices(goal.arm.chain.forward(goal.q))
    q = np.tile(np.array(START), (len(goal), 1))
    for _ in range(budget):
        pose = chains.matrices(chain.forward(q))
        left = wanted[:, :, :3] @ pose[:, :, :3].swapaxes(-1, -2)
        turn = np.stack([left[:, i, j] - left[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], -1) / 2
        off = np.concatenate([turn, wanted[:, :, 3] - pose[:, :, 3]], -1)
        q = q + (np.linalg.pinv(chain.jacobian(q, point=np.zeros(3))) @ off[..., None])[..., 0]
    return q


def error(answer: Array, truth: Array, goal: Goal) -> Errors:
    """Of places relative to the forearm, of angles in radians, of an arm's poses the larger of both; infinite where
    another solution was found, or none."""
    if goal.what == "arm":
        known = np.isfinite(answer).all(-1)
        poses = np.full_like(truth, np.inf)
        poses[known] = np.reshape([goal.arm.digits.matrix(x) for x in answer[known]], (-1, 3, 4))
        found = np.abs(poses - truth).max((1, 2))
    else:
        found = np.abs(answer - truth).max(-1)
    return np.where(found < LOST, found, np.inf)


# -- cases -------------------------------------------------------------------------------------------------


def delta_goals(what: str) -> Any:
    """Maker of makers of poses of the Delta robot so far from home, all of which the straight way there leads to."""

    def far(distance: float) -> Any:
        def make(rng: np.random.Generator, count: int) -> Goal:
            way = _ways(rng, TRIED * count, 3)
            robot, on_way = delta.robot_of(), np.linspace(0, distance, STEPS * 4)
            theta = HOME + way[:, None] * on_way[:, None]
            good = np.isfinite(robot.forward(theta)).all((1, 2))
            back = robot.inverse(robot.forward(theta[good, -1]))
            same = np.abs(back - theta[good, -1]).max(-1) < LOST  # outer elbows, angles within half a turn
            return Goal(what, theta[good, -1][same][:count])

        return make

    return far


def arm_goals(distance: float) -> Any:
    """Maker of poses of the arm so far from the start."""

    def make(rng: np.random.Generator, count: int) -> Goal:
        return Goal("arm", np.array(START) + distance * _ways(rng, count, 6))

    return make


def _ways(rng: np.random.Generator, count: int, joints: int) -> Array:
    """Directions, the largest component 1."""
    ways = rng.normal(size=(count, joints))
    found: Array = ways / np.abs(ways).max(-1, keepdims=True)
    return found


def describe(goal: Goal, i: int) -> str:
    """Where the joints are."""
    return f"joints at ({', '.join(f'{x:.6g}' for x in goal.q[i])})"


def prepare() -> None:
    """Compile the drivers."""
    rng = np.random.default_rng(0)
    for what in ("angles", "place"):
        goal = delta_goals(what)(0.01)(rng, 1)
        by_newton(goal, None), by_newton(goal, None, steps=2)
    by_chain(arm_goals(0.01)(rng, 1), 2, attempts=1)


STUDY = Study(
    name="reaching",
    title="Poses by Newton's method",
    methods=(
        Method("solve_pose", by_newton, repeats=1, prepare=prepare),
        Method(f"solve_pose, path of {STEPS}", partial(by_newton, steps=STEPS), repeats=1),
        Method("Chain.inverse, one attempt", partial(by_chain, attempts=1), "steps", BUDGETS, repeats=1),
        Method("Chain.inverse", partial(by_chain, attempts=32), "steps", BUDGETS[-1:], repeats=1),
        Method("plain Newton, NumPy", plain, "steps", BUDGETS, repeats=1),
    ),
    cases=(
        Case("Delta, motors driven by 0.5", delta_goals("angles")(0.5), describe=describe),
        Case("Delta, platform brought, 0.5", delta_goals("place")(0.5), describe=describe),
        Case("six-axis arm, 0.5", arm_goals(0.5), describe=describe),
        *swept("distance, motors of a Delta", DISTANCES[:-1], delta_goals("angles"), describe),
        *swept("distance, platform of a Delta", DISTANCES[:-1], delta_goals("place"), describe),
        *swept("distance, six-axis arm", DISTANCES, arm_goals, describe),
    ),
    reference=lambda goal: goal.exact,
    error=error,
    unit="radian, or of a length",
    count=COUNT,
    shares=True,
    source="thesis 7.6; Newton's method",
    notes="Distances are of joints from the start, in radians. A Delta's pose is right if it is the one that hangs "
    "together with the start; an arm's if the tool is there, by whichever solution.",
)
