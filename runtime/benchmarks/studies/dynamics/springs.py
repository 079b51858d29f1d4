"""Stiff springs and dampers between points: implicit and adaptive steps beside SciPy's methods for stiff equations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from .... import dynamics
from ...harness.study import Array, Case, Errors, Method, Study, lost_beyond, sweep_cases
from . import integrators

GRAVITY = np.array([0.0, 0.0, -9.81])
TOLERANCES, SWEPT = (1e-4, 1e-6, 1e-8, 1e-10), 1e-6
#: Tolerances of the reference, by SciPy with exact derivatives.
EXACT = {"method": "Radau", "rtol": 1e-12, "atol": 1e-13}
#: Explicit steps follow the fastest damper: where more than so many are expected they are left out.
MOST_STEPS = 3e5
#: Positions that are further off, in meters, count as lost.
LOST = 0.1
#: The world, as the other end of a spring.
WORLD = -1


@dataclass(frozen=True)
class Network:
    """Points of mass with springs, from rest; one motion.

    Attributes
    ----------
    masses, starts : arrays (n,), (n, 3)
    ends : tuple of (int, int)
        Points of each spring; `WORLD` is the origin.
    stiffness, damping, length : float
        Of all springs: N/m, N s/m, m.
    duration : float
        s
    rtol : float, optional
        The only tolerance of all methods, which have no other settings then.
    """

    masses: Array
    starts: Array
    ends: tuple[tuple[int, int], ...]
    stiffness: float
    damping: float
    length: float
    duration: float
    rtol: float | None = None

    def __len__(self) -> int:
        return 1

    def tolerance(self, setting: float | None) -> float | None:
        """The tolerance of a setting; None where it is not for this motion."""
        return setting if self.rtol is None else self.rtol if setting is None else None

    @property
    def explicit_steps(self) -> float:
        """Steps that a method without implicit stages needs, about."""
        lightest = float(self.masses.min())
        return self.duration * (self.damping / lightest + math.sqrt(self.stiffness / lightest)) / 2

    def simulation(self, **options: Any) -> Any:
        """Bodies that do not turn."""
        bodies = {
            str(i): dynamics.RigidBody(m, np.full(3, 0.1 * m), x)
            for i, (m, x) in enumerate(zip(self.masses, self.starts, strict=True))
        }
        springs = [
            dynamics.Spring(
                (0, 0, 0), (0, 0, 0), self.stiffness, self.length, self.damping, str(a), None if b == WORLD else str(b)
            )
            for a, b in self.ends
        ]
        return dynamics.Simulation(dynamics.System(bodies), [dynamics.Gravity(GRAVITY), *springs], **options)

    def rates(self, _: float, state: Array) -> Array:
        """Newton's equations of positions and velocities, (6 n,)."""
        position, velocity = state.reshape(2, -1, 3)
        force = self.masses[:, None] * GRAVITY
        for a, b in self.ends:
            along, rate = self._between(position, a, b), self._between(velocity, a, b)
            length = np.linalg.norm(along)
            unit = along / length
            pull = (self.stiffness * (length - self.length) + self.damping * (unit @ rate)) * unit
            force[a] -= pull
            if b != WORLD:
                force[b] += pull
        return np.concatenate([velocity.ravel(), (force / self.masses[:, None]).ravel()])

    def derivatives(self, _: float, state: Array) -> Array:
        """Of `rates` by the state, (6 n, 6 n)."""
        position, velocity = state.reshape(2, -1, 3)
        n = len(position)
        found = np.zeros((2, n, 3, 2, n, 3))
        found[0, range(n), :, 1, range(n), :] = np.eye(3)
        for a, b in self.ends:
            along, rate = self._between(position, a, b), self._between(velocity, a, b)
            length = np.linalg.norm(along)
            unit = along / length
            ray, speed = np.outer(unit, unit), unit @ rate
            tension = self.stiffness * (length - self.length) + self.damping * speed
            by_position = self.stiffness * ray + tension / length * (np.eye(3) - ray)
            by_position += self.damping * np.outer(unit, rate - speed * unit) / length
            for point, sign in ((a, -1.0), (b, 1.0)):
                for other, sense in ((a, sign), (b, -sign)):
                    if WORLD not in (point, other):
                        found[1, point, :, 0, other] += sense * by_position / self.masses[point]
                        found[1, point, :, 1, other] += sense * self.damping * ray / self.masses[point]
        jacobian: Array = found.reshape(6 * n, 6 * n)
        return jacobian

    @staticmethod
    def _between(rows: Array, a: int, b: int) -> Array:
        apart: Array = rows[a] - (rows[b] if b != WORLD else 0.0)
        return apart


def pendulum(_: np.random.Generator, __: int, stiffness: float, rtol: float | None = SWEPT) -> Network:
    """A mass of 1 kg on a spring of 1 m, level at the start; ten times critically damped."""
    return Network(np.ones(1), np.eye(1, 3), ((0, WORLD),), stiffness, 20 * np.sqrt(stiffness), 1.0, 1.0, rtol)


def chain(_: np.random.Generator, __: int) -> Network:
    """Four masses in a row, level at the start, on springs with a hundred times the critical damping."""
    starts = np.arange(1, 5)[:, None] * np.array([0.5, 0.0, 0.0])
    ends = tuple((i, i - 1) for i in range(4))
    return Network(np.full(4, 0.25), starts, ends, 1e4, 1e4, 0.5, 1.0)


def landing(_: np.random.Generator, __: int) -> Network:
    """A mass that falls by 1 cm onto a hard spring, with little damping: it rings at 160 Hz."""
    return Network(np.ones(1), np.array([[0.0, 0.0, 1.01]]), ((0, WORLD),), 1e6, 100.0, 1.0, 0.2)


def ours(inputs: Network, setting: float | None, *, integrator: str) -> Array | None:
    """Positions at the end, (1, n, 3)."""
    rtol = inputs.tolerance(setting)
    if rtol is None or (integrator == "adaptive" and inputs.explicit_steps > MOST_STEPS):
        return None
    simulation = inputs.simulation(integrator=integrator)
    trajectory = integrators.run_if_possible(simulation, inputs.duration, [inputs.duration], rtol=rtol)
    if trajectory is None:
        return None
    return np.array([[trajectory[str(i)].position[-1] for i in range(len(inputs.masses))]])


def by_scipy(inputs: Network, setting: float | None, *, method: str) -> Array | None:
    """The same by SciPy, with exact derivatives."""
    rtol = inputs.tolerance(setting)
    return None if rtol is None else _solved(inputs, method=method, rtol=rtol, atol=1e-2 * rtol)


def by_heyoka(inputs: Network, setting: float | None) -> Array | None:
    """The same by explicit Taylor series, compiled by LLVM; making them is timed, as that of ours is."""
    import heyoka

    rtol, n = inputs.tolerance(setting), inputs.starts.size
    if rtol is None or inputs.explicit_steps > MOST_STEPS:
        return None
    names = heyoka.make_vars(*(f"{name}{i}" for name in "xv" for i in range(n)))
    position, velocity = (np.array(x, object).reshape(-1, 3) for x in (names[:n], names[n:]))
    force = (inputs.masses[:, None] * GRAVITY).astype(object)
    for a, b in inputs.ends:
        along, rate = (x[a] - (x[b] if b != WORLD else 0.0) for x in (position, velocity))
        length = heyoka.sqrt(along @ along)
        pull = (inputs.stiffness * (length - inputs.length) + inputs.damping * (along @ rate) / length) / length * along
        force[a] -= pull
        if b != WORLD:
            force[b] += pull
    rates = [*velocity.ravel(), *(force / inputs.masses[:, None]).ravel()]
    start = [*inputs.starts.ravel(), *np.zeros(n)]
    integrator = heyoka.taylor_adaptive(list(zip(names, rates, strict=True)), start, tol=rtol)
    integrator.propagate_until(inputs.duration)
    return np.array(integrator.state[:n]).reshape(1, -1, 3)


def by_mujoco(inputs: Network, setting: float | None) -> Array | None:
    """The same by MuJoCo's steps of one size, implicit in the dampers and explicit in the springs."""
    import mujoco

    if inputs.rtol is not None:  # it has no tolerance to be swept at
        return None
    step = setting or 1e-3
    slides = "".join(f"<joint type='slide' axis='{axis}'/>" for axis in ("1 0 0", "0 1 0", "0 0 1"))
    offsets = np.diff(inputs.starts, axis=0, prepend=0.0).tolist()
    bodies = "".join(  # each in the one before, or implicit steps leave out what couples them
        f"<body pos='{x} {y} {z}'><inertial pos='0 0 0' mass='{m!r}' diaginertia='{m!r} {m!r} {m!r}'/>"
        f"{slides}<site name='s{i}'/>"
        for i, (m, (x, y, z)) in enumerate(zip(inputs.masses.tolist(), offsets, strict=True))
    )
    bodies += "</body>" * len(inputs.masses)
    law = f"stiffness='{inputs.stiffness!r}' damping='{float(inputs.damping)!r}' springlength='{inputs.length!r}'"
    springs = "".join(
        f"<spatial {law}><site site='s{a}'/><site site='{'world' if b == WORLD else f's{b}'}'/></spatial>"
        for a, b in inputs.ends
    )
    gravity = " ".join(map(str, GRAVITY))
    text = (
        f"<mujoco><option timestep='{step!r}' integrator='implicit' gravity='{gravity}'/>"
        f"<worldbody><site name='world'/>{bodies}</worldbody><tendon>{springs}</tendon></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(inputs.duration / step))
    return np.array(data.xpos[1:]).reshape(1, -1, 3)


def truth(inputs: Network) -> Array:
    """By SciPy's Radau, to 1e-12."""
    found = _solved(inputs, **EXACT)
    assert found is not None
    return found


def _solved(inputs: Network, **options: Any) -> Array | None:
    start = np.concatenate([inputs.starts.ravel(), np.zeros(inputs.starts.size)])
    found = solve_ivp(inputs.rates, (0, inputs.duration), start, jac=inputs.derivatives, **options)
    if not found.success:
        return None
    position: Array = found.y[: inputs.starts.size, -1].reshape(1, -1, 3)
    return position


def error(answer: Array, exact: Array, inputs: Network) -> Errors:
    """Largest error of a position, in m."""
    return lost_beyond(np.abs(answer - exact).max(axis=(1, 2)), LOST)


STUDY = Study(
    name="springs",
    title="Stiff springs",
    methods=(
        *(
            Method(name, partial(ours, integrator=name), "rtol", (None, *TOLERANCES), repeats=3)
            for name in ("implicit", "adaptive")
        ),
        *(
            Method(f"SciPy {name}", partial(by_scipy, method=name), "rtol", (None, *TOLERANCES[:-1]), repeats=1)
            for name in ("Radau", "BDF")
        ),
        Method("heyoka", by_heyoka, "rtol", (None, *TOLERANCES), repeats=1, requires="heyoka"),
        Method("MuJoCo", by_mujoco, "step", (None, 1e-3, 1e-4, 1e-5), repeats=1, requires="mujoco"),
    ),
    cases=(
        Case("pendulum on 1e6 N/m, damping ratio 10", partial(pendulum, stiffness=1e6, rtol=None), "stiff"),
        Case("four overdamped springs in a row", chain, "stiff"),
        Case("landing on 1e6 N/m", landing, "stiff"),
        *sweep_cases("N/m, damping ratio 10", (1e2, 1e4, 1e6, 1e8), pendulum),
    ),
    reference=truth,
    error=error,
    unit="m",
    count=1,
    source="Hairer and Wanner, Solving Ordinary Differential Equations II",
    notes="A point is a whole motion; in the second picture all have one tolerance, 1e-6. SciPy's methods have the "
    "exact derivatives of the forces. Adaptive steps and heyoka's are explicit, and left out where they would be very "
    "many; MuJoCo's have one size, implicit in dampers alone.",
)  # fmt: skip
