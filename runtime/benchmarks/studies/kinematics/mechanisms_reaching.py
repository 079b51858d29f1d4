"""Poses by Newton's method: error and success against their distance, and the steps that it takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ...harness.study import Array, Case, Errors, Method, Study, lost_beyond, sweep_cases
from ...harness.vectors import vector_text
from . import chains, delta
from .delta_exact import ExactDelta, floats
from .delta_joints import HOME, jointed_robot

COUNT = 80
#: Largest distance of a joint from the start, in radians.
DISTANCES = (0.01, 0.1, 0.3, 1.0, 2.0, 3.0)
#: Steps of a path to the target; budgets of Newton steps, and the drivers' own; restarts of plain Newton: none.
STEPS, BUDGETS = 10, (5, 10, 60)
#: Random directions that are tried for each pose; further off than this is another solution, or none.
CANDIDATES, LOST = 60, 1e-3
#: The start of the arm, where it is not singular.
START = (0.3, -0.9, 1.4, 0.5, 0.8, -0.4)


@dataclass(frozen=True)
class Goal:
    """Poses to reach, from one start.

    Attributes
    ----------
    target : {"angles", "position", "arm"}
        A Delta robot's motors are driven to angles; its platform is brought to positions; an arm's tool is brought to
        poses.
    q : array (m, n)
        Coordinates there.
    """

    target: str
    q: Array

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def jointed_robot(self) -> Any:
        """The Delta robot at its home, as a mechanism."""
        robot = delta.robot_of()
        return jointed_robot(robot, robot.pose(np.full((1, 3), HOME)), np.zeros(3))

    @cached_property
    def arm(self) -> chains.Arm:
        """The six-axis arm at the poses."""
        return chains.six_at(self.q, "pose")

    @cached_property
    def positions(self) -> Array:
        """Positions of the platform, from 50 digits."""
        digits = ExactDelta(delta.robot_of())
        return np.array([floats(digits.forward(digits.numbers(x)), (3,)) for x in self.q])

    @cached_property
    def exact(self) -> Array:
        """Positions of the platform (m, 3), its angles (m, 3), or the arm's poses (m, 3, 4)."""
        if self.target == "arm":
            return self.arm.exact
        if self.target == "angles":
            return self.positions
        digits = ExactDelta(delta.robot_of())
        return np.array([floats(digits.inverse(digits.numbers(y)), (3,)) for y in self.positions])


# -- methods -----------------------------------------------------------------------------------------------


def by_newton(goal: Goal, setting: Any, *, steps: int = 1) -> Array | None:
    """`Mechanism.solve_pose` from the start at once, or along a path of so many steps."""
    if goal.target == "arm":
        return None
    jointed = goal.jointed_robot
    mechanism, path = jointed.mechanism, steps > 1
    fractions = np.linspace(1 / steps, 1, steps)[:, None]
    if goal.target == "angles":
        offsets = (goal.q - HOME)[:, None] * fractions
        offsets = offsets if path else offsets[:, 0]
        driven = dict(zip(jointed.motors, np.moveaxis(offsets, -1, 0), strict=True))
        poses = mechanism.solve_pose(driven, path=path, threads=1)
        answer = (poses["platform"] >> mechanism.algebra.point(jointed.point)).parameters().xyz
    else:
        positions = jointed.point + (goal.positions - jointed.point)[:, None] * fractions
        targets = {"platform": (jointed.point, positions if path else positions[:, 0])}
        poses = mechanism.solve_pose(targets=targets, path=path, threads=1)
        answer = HOME + np.concatenate([poses.coordinates(j) for j in jointed.motors], -1)
    good = np.asarray(poses.status, int) == 0
    answer = np.where(good[..., None], answer, np.nan)
    return np.asarray(answer[:, -1] if path else answer)


def by_chain(goal: Goal, budget: int, *, attempts: int) -> Array | None:
    """`Chain.inverse` from the start, and from elsewhere where that does not converge; its coordinates."""
    if goal.target != "arm":
        return None
    targets = goal.arm.chain.forward(goal.q)
    chain, start = goal.arm.chain, np.array(START)
    return np.asarray(chain.inverse(targets, start, iterations=budget, attempts=attempts, nearest=True).q)


def plain(goal: Goal, budget: int) -> Array | None:
    """Undamped Newton steps with NumPy, on the same Jacobians, all poses at once."""
    if goal.target != "arm":
        return None
    chain, target = goal.arm.chain, chains.matrices(goal.arm.chain.forward(goal.q))
    q = np.tile(np.array(START), (len(goal), 1))
    for _ in range(budget):
        pose = chains.matrices(chain.forward(q))
        difference = target[:, :, :3] @ pose[:, :, :3].swapaxes(-1, -2)
        pairs = ((2, 1), (0, 2), (1, 0))
        rotation = np.stack([difference[:, i, j] - difference[:, j, i] for i, j in pairs], -1) / 2
        off = np.concatenate([rotation, target[:, :, 3] - pose[:, :, 3]], -1)
        q = q + (np.linalg.pinv(chain.jacobian(q, point=np.zeros(3))) @ off[..., None])[..., 0]
    return q


def error(answer: Array, truth: Array, goal: Goal) -> Errors:
    """Error of positions relative to the forearm, of angles in radians, for an arm's poses the larger of both; infinite
    at another solution, or at none."""
    if goal.target == "arm":
        known = np.isfinite(answer).all(-1)
        poses = np.full_like(truth, np.inf)
        poses[known] = np.reshape([goal.arm.digits.matrix(x) for x in answer[known]], (-1, 3, 4))
        return lost_beyond(np.abs(poses - truth).max((1, 2)), LOST)
    return lost_beyond(np.abs(answer - truth).max(-1), LOST)


# -- cases -------------------------------------------------------------------------------------------------


def delta_goals(rng: np.random.Generator, count: int, distance: float, target: str) -> Goal:
    """Poses of the Delta robot so far from home, all of which the straight path leads to."""
    robot, along = delta.robot_of(), np.linspace(0, distance, STEPS * 4)
    theta = HOME + _directions(rng, CANDIDATES * count, 3)[:, None] * along[:, None]
    good = np.isfinite(robot.forward(theta)).all((1, 2))
    solution = robot.inverse(robot.forward(theta[good, -1]))
    same = np.abs(solution - theta[good, -1]).max(-1) < LOST  # outer elbows, angles within half a turn
    return Goal(target, theta[good, -1][same][:count])


def arm_goals(rng: np.random.Generator, count: int, distance: float) -> Goal:
    """Poses of the arm so far from the start."""
    return Goal("arm", np.array(START) + distance * _directions(rng, count, 6))


def _directions(rng: np.random.Generator, count: int, joints: int) -> Array:
    """Directions, the largest component 1."""
    vectors = rng.normal(size=(count, joints))
    return np.asarray(vectors / np.abs(vectors).max(-1, keepdims=True))


def prepare() -> None:
    """Compile the drivers."""
    rng = np.random.default_rng(0)
    for target in ("angles", "position"):
        goal = delta_goals(rng, 1, 0.01, target)
        by_newton(goal, None), by_newton(goal, None, steps=2)
    by_chain(arm_goals(rng, 1, 0.01), 2, attempts=1)


STUDY = Study(
    name="reaching",
    title="Poses by Newton's method",
    methods=(
        Method("solve_pose", by_newton, repeats=1, prepare=prepare),
        Method(f"solve_pose, path of {STEPS} steps", partial(by_newton, steps=STEPS), repeats=1),
        Method("Chain.inverse, one attempt", partial(by_chain, attempts=1), "iterations", BUDGETS, repeats=1),
        Method("Chain.inverse", partial(by_chain, attempts=256), "iterations", BUDGETS[-1:], repeats=1),
        Method("plain Newton, NumPy", plain, "iterations", BUDGETS, repeats=1),
    ),
    cases=(
        Case("Delta, motors driven by 0.5", partial(delta_goals, distance=0.5, target="angles")),
        Case("Delta, platform brought, 0.5", partial(delta_goals, distance=0.5, target="position")),
        Case("six-axis arm, 0.5", partial(arm_goals, distance=0.5)),
        *sweep_cases("distance, motors of a Delta", DISTANCES[:-1], partial(delta_goals, target="angles")),
        *sweep_cases("distance, platform of a Delta", DISTANCES[:-1], partial(delta_goals, target="position")),
        *sweep_cases("distance, six-axis arm", DISTANCES, arm_goals),
    ),
    reference=lambda goal: goal.exact,
    error=error,
    describe=lambda goal, i: f"joints at {vector_text(goal.q[i])}",
    unit="radian, or of a length",
    count=COUNT,
    draws_fractions=True,
    source="thesis 7.6; Newton's method",
    notes="Distances are of joints from the start, in radians. A Delta's pose is right if it is the one that hangs "
    "together with the start; an arm's if the tool is there, by whichever solution.",
)
