"""Joints with springs and dampers: a double pendulum in coordinates of joints, beside SciPy and MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from .... import dynamics, kinematics
from ...harness.algebras import cga3d
from ...harness.study import Array, Case, Errors, Method, Study, lost_beyond
from . import integrators

#: Sideways too, or rods without springs would hang at rest.
GRAVITY = np.array([6.0, 0.0, -9.81])
#: Of both rods, of length 1 m, about their middles: kg, kg m^2.
MASS, MOMENT = np.array([1.0, 0.5]), np.array([0.1, 0.05])
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
#: Explicit steps follow the fastest damper: where more than so many are expected they are left out.
MOST_STEPS = 1e5
#: Positions that are further off, in meters, count as lost.
LOST = 0.1


@dataclass(frozen=True)
class Rods:
    """Two rods below each other, at rest at the start; one motion, of which the lower one's middle is asked.

    Attributes
    ----------
    stiffness, rest, damping : arrays (2,)
        Of the springs at the shoulder and at the elbow: N m/rad, rad, N m s/rad.
    duration : float
        s
    """

    stiffness: Array
    rest: Array
    damping: Array
    duration: float = 1.0

    def __len__(self) -> int:
        return 1

    @property
    def explicit_steps(self) -> float:
        """Steps that a method without implicit stages needs, about."""
        return self.duration * float((self.damping + np.sqrt(self.stiffness)).max()) / float(MOMENT.min())

    def simulation(self, integrator: str) -> Any:
        bodies = {
            name: dynamics.RigidBody(m, np.full(3, i), (0, 0, -0.5 - k))
            for k, (name, m, i) in enumerate(zip(("upper", "lower"), MASS, MOMENT, strict=True))
        }
        hinges = [(cga3d.line((0, 0, -k), (0, 1, 0)), cga3d.point((0, 0, -k))) for k in range(2)]
        joints = [
            kinematics.Revolute("base", "upper", *hinges[0]),
            kinematics.Revolute("upper", "lower", *hinges[1]),
        ]
        springs = [
            dynamics.JointSpring(i, float(self.stiffness[i]), float(self.rest[i]), float(self.damping[i]))
            for i in range(2)
        ]
        loads = [dynamics.Gravity(GRAVITY), *springs]
        return dynamics.Simulation(dynamics.System(bodies, joints), loads, integrator=integrator, coordinates="joint")

    def rates(self, _: float, state: Array) -> Array:
        """Lagrange's equations of both rods' angles with the vertical, and their rates (4,)."""
        (a, b), (u, v) = state[:2], state[2:]
        torque = -self.stiffness * (np.array([a, b - a]) - self.rest) - self.damping * np.array([u, v - u])
        (m, n), (i, j) = MASS, MOMENT
        turning = [np.array([-np.cos(x), 0.0, np.sin(x)]) @ GRAVITY for x in (a, b)]
        coupling, centrifugal = n / 2 * np.cos(a - b), n / 2 * np.sin(a - b)
        inertia = np.array([[m / 4 + n + i, coupling], [coupling, n / 4 + j]])
        force = np.array(
            [
                -centrifugal * v * v + (m / 2 + n) * turning[0] + torque[0] - torque[1],
                centrifugal * u * u + n / 2 * turning[1] + torque[1],
            ]
        )
        return np.concatenate([state[2:], np.linalg.solve(inertia, force)])

    def derivatives(self, time: float, state: Array) -> Array:
        """Of `rates` by the state (4, 4), by complex steps."""
        steps = state + 1e-30j * np.eye(4)
        return np.stack([self.rates(time, each).imag / 1e-30 for each in steps], axis=1)

    def solved(self, **options: Any) -> Array | None:
        """The lower rod's middle at the end, by SciPy, (1, 3)."""
        found = solve_ivp(self.rates, (0, self.duration), np.zeros(4), **options)
        if not found.success:
            return None
        a, b = found.y[:2, -1]
        return np.array([[-np.sin(a) - np.sin(b) / 2, 0.0, -np.cos(a) - np.cos(b) / 2]])


def ours(inputs: Rods, setting: float, *, integrator: str) -> Array | None:
    explicit = integrator in ("adaptive", "rk4")
    if explicit and inputs.explicit_steps > (MOST_STEPS if integrator == "adaptive" else 2 * setting):
        return None
    run = {"step": inputs.duration / setting} if integrator == "rk4" else {"rtol": setting}
    found = integrators.run_if_possible(inputs.simulation(integrator), inputs.duration, [inputs.duration], **run)
    return None if found is None else found["lower"].position[-1:]


def by_scipy(inputs: Rods, setting: float, *, method: str) -> Array | None:
    return inputs.solved(method=method, jac=inputs.derivatives, rtol=setting, atol=1e-2 * setting)


def by_mujoco(inputs: Rods, setting: float) -> Array:
    """By steps of one size, implicit in the dampers and explicit in the springs."""
    import mujoco

    inner = ""
    numbers = np.stack([inputs.stiffness, inputs.rest, inputs.damping, MASS, MOMENT], axis=1).tolist()
    for k in (1, 0):
        stiffness, rest, damping, mass, moment = numbers[k]
        law = f"stiffness='{stiffness!r}' springref='{rest!r}' damping='{damping!r}'"
        inertia = f"mass='{mass!r}' diaginertia='{moment!r} {moment!r} {moment!r}'"
        inner = (
            f"<body pos='0 0 {-k}'><joint type='hinge' axis='0 1 0' {law}/>"
            f"<inertial pos='0 0 -0.5' {inertia}/>{inner}</body>"
        )
    text = (
        f"<mujoco><compiler angle='radian'/><option timestep='{setting!r}' integrator='implicit' "
        f"gravity='{' '.join(map(str, GRAVITY))}'/><worldbody>{inner}</worldbody></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(inputs.duration / setting))
    mujoco.mj_kinematics(model, data)  # positions of the last state, not of the one before
    return np.array(data.xipos[-1:])


def truth(inputs: Rods) -> Array:
    """By SciPy, to 1e-12."""
    stiff = inputs.explicit_steps > 1e4
    method: dict[str, Any] = {"method": "Radau", "jac": inputs.derivatives} if stiff else {"method": "DOP853"}
    found = inputs.solved(rtol=1e-12, atol=1e-12, **method)
    assert found is not None
    return found


def error(answer: Array, exact: Array, inputs: Rods) -> Errors:
    """Largest error of a coordinate, in m."""
    return lost_beyond(np.abs(answer - exact).max(axis=1), LOST)


def rods(_: np.random.Generator, __: int, stiffness: float, damping: float, duration: float = 1.0) -> Rods:
    """The same spring at both joints, bent at the start by half a radian."""
    return Rods(np.full(2, stiffness), np.full(2, 0.5), np.full(2, damping), duration)


STUDY = Study(
    name="joints",
    title="Joints with springs and dampers",
    methods=(
        *(
            Method(name, partial(ours, integrator=name), "rtol", TOLERANCES, repeats=3)
            for name in ("implicit", "adaptive", "auto")
        ),
        Method("rk4", partial(ours, integrator="rk4"), "steps", (100, 1000, 10000), repeats=3),
        Method("SciPy Radau", partial(by_scipy, method="Radau"), "rtol", TOLERANCES[:-1], repeats=1),
        Method("MuJoCo", by_mujoco, "step", (1e-3, 1e-4, 1e-5), repeats=1, requires="mujoco"),
    ),
    cases=(
        Case("springs of 10 N m/rad, dampers of 0.1 N m s", partial(rods, stiffness=10.0, damping=0.1)),
        Case("springs of 1e5 N m/rad, damping ratio about 10", partial(rods, stiffness=1e5, damping=2e3), "stiff"),
        Case("dampers of 1e3 N m s alone", partial(rods, stiffness=0.0, damping=1e3), "stiff"),
        Case(
            "springs of 1e4 N m/rad that ring, t = 0.2",
            partial(rods, stiffness=1e4, damping=0.1, duration=0.2),
            "stiff",
        ),
    ),
    reference=truth,
    error=error,
    unit="m",
    count=1,
    source="Featherstone, Rigid Body Dynamics Algorithms",
    notes="A point is a whole motion, of 1 s, in the coordinates of joints. SciPy has Lagrange's equations in Python, "
    "with exact derivatives. Explicit steps are left out where they would be very many; MuJoCo's have one size, "
    "implicit in dampers alone.",
)
