"""Steps of control loops: a state and torques in, the next state out, with nothing made in between."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, SimulationError
from ...common.validation import as_float, as_instance, broadcast_to, finite_array, real_array
from ...mechanics.system import System
from ..integration.runs import NOT_FINITE
from .balls import BallStates
from .problem import TreeProblem

Array = NDArray[Any]
#: Relative error of implicit steps.
RTOL = 1e-8
#: Steps of the integrator between two looks for an interrupt.
MOST_STEPS = 8192


class JointState:
    """Coordinates and speeds of all joints at a time.

    Attributes
    ----------
    q, qd : array (n,)
        In the order of the joints, and of their freedoms, as `Trajectory.coordinates` and `rates` have them: of what
        turns about a point, the rotation vector since the start and the angular velocity along the second body's axes.
        A root that floats comes first: path and velocity of its center of mass along the world's axes, then the same.
    time : float
    """

    __slots__ = ("_balls", "q", "qd", "time")

    def __init__(self, q: Array, qd: Array, time: float = 0.0, _balls: tuple[Array, Array] | None = None) -> None:
        self.q, self.qd, self.time, self._balls = q, qd, time, _balls

    def __repr__(self) -> str:
        return f"<JointState at t = {self.time:.6g}: q = {self.q}, qd = {self.qd}>"


class Stepper:
    """Steps of a tree of joints; made by `Simulation.stepper`. Not for several threads at once.

    Attributes
    ----------
    start : JointState
        The simulation's own.
    dt : float
    names : tuple of str
        Of the joints, one for each coordinate; of a root that floats, that of its body.
    """

    def __init__(self, problem: TreeProblem, system: System, dt: float, substeps: int) -> None:
        tree = problem.tree
        for joint in tree.joints:
            if joint.is_reversed and joint.freedoms.is_ball:
                raise InputError(
                    f"a stepper is for joints that turn about a point from the nearer body to the further one, and "
                    f"{system.joints[joint.index].label} names them the other way round.",
                    remedy="Give the joint its bodies in the order from the root",
                )
        if problem.assembly.batched:
            raise InputError("a stepper is of one simulation, not of a batch.")
        driver = problem.with_fixed_steps().driver((dt, dt / substeps, RTOL if problem.is_implicit else None, None))
        self.dt, n = dt, tree.count
        joints = sorted(tree.joints, key=lambda joint: joint.index)
        ranges = [range(j.first, j.first + len(j.freedoms.axes)) for j in joints]
        order = [k for j, each in zip(joints, ranges, strict=True) for k in (each[::-1] if j.is_reversed else each)]
        names = [*(system.joint_names or [f"joint_{i}" for i in range(len(system.joints))])]
        bodies = list(system.bodies)
        own_names = [bodies[j.body] if j.index < 0 else names[j.index] for j in joints]
        self.names = tuple(name for name, each in zip(own_names, ranges, strict=True) for _ in each)
        self._order = None if order == list(range(n)) else np.array(order)
        starts = [0.0 if j.index < 0 else system.joint_coordinates[j.index] for j in joints]
        self._zero = np.repeat(starts, [len(each) for each in ranges])
        memory, own = driver.own_memory(), driver.parameters.each
        self._constant = own["torques"][0].copy() if own["torques"].any() else None
        self._shape, self._state, self._torques = (n,), memory["state"][0], np.zeros(n)
        self._balls = BallStates(tree, memory["references"][0]) if (tree.balls >= 0).any() else None
        start = self._state.copy()
        arguments = {**driver.shared(), "h": dt / substeps}
        arguments |= {name: x[0] for name, x in {**own, **memory}.items()}
        arguments |= {"state": self._state, "torques": self._torques}
        loop = driver.loops["intervals" if problem.is_implicit else "steps"]
        whole, rest = divmod(substeps - 1, MOST_STEPS)
        counts = [*[MOST_STEPS] * bool(whole), rest + 1]
        self._bounds = [loop.over(1, {}, {**arguments, "count": count}) for count in counts]
        self._before, self._kept = range(whole), arguments
        self._run, self._status = self._bounds[-1].run, self._bounds[-1].returned[0]
        self.start = self._read(start, 0.0)

    def state(self, q: ArrayLike, qd: ArrayLike = 0.0, time: float = 0.0) -> JointState:
        """A state from arrays (n,), or a number for all.

        Raises
        ------
        InputError, ShapeError
            If a number is not finite, or an array has another shape.
        """
        given = ((finite_array(x, name), name) for x, name in ((q, "q"), (qd, "qd")))
        own = [np.array(broadcast_to(x, self._shape, name), np.float64) for x, name in given]
        return JointState(own[0], own[1], as_float(time, "time"))

    def __call__(self, state: JointState, torques: ArrayLike) -> JointState:
        """The state a step later, under torques (n,) that stay as they are for its time.

        Raises
        ------
        InputError, ShapeError
            If an array has another shape.
        SimulationError
            If the next state is not finite, or implicit steps come to no end.
        """
        n, own, order, shape = self._shape[0], self._state, self._order, self._shape
        if type(state) is not JointState:
            as_instance(state, "state", JointState)
        q, qd = state.q, state.qd
        if not (
            type(torques) is type(q) is type(qd) is np.ndarray
            and torques.shape == shape == q.shape == qd.shape
            and torques.dtype == q.dtype == qd.dtype == np.float64
        ):
            torques, q, qd = (real_array(x, name, shape) for x, name in ((torques, "torques"), (q, "q"), (qd, "qd")))
        if order is None:
            np.subtract(q, self._zero, own[:n])
            own[n:], self._torques[...] = qd, torques
        else:
            own[order], own[n + order], self._torques[order] = q - self._zero, qd, torques
        if self._balls is not None:
            self._balls.write(own, state._balls)
        if self._constant is not None:
            self._torques += self._constant
        status = self._status
        for _ in self._before:  # interrupts are heard between
            part = self._bounds[0]
            part.run(0, 1)
            if part.returned[0][0]:
                status = part.returned[0]
                break
        else:
            self._run(0, 1)
        if status[0]:
            is_lost = status[0] == NOT_FINITE
            what = "the state is no longer finite" if is_lost else "steps became too small to go on"
            raise SimulationError(
                f"{what}, at time {state.time + self.dt:.6g}.",
                remedy="Look at the torques; or take a smaller dt, or more substeps; or, where loads are stiff, "
                "integrator='implicit'",
            )
        return self._read(own, state.time + self.dt)

    def _read(self, own: Array, time: float) -> JointState:
        n, order = self._shape[0], self._order
        balls = self._balls.read(own) if self._balls is not None else None
        if order is None:
            return JointState(own[:n] + self._zero, own[n:].copy(), time, balls)
        return JointState(own[order] + self._zero, own[n + order], time, balls)
