"""Integrators of `bladesmith.dynamics` as methods of studies: what they are given, and how far off they end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..runner import Measurement
from ..study import Case, Errors, Method, Nature
from . import exact_motions

Array = NDArray[Any]
#: Orientations that are further off, in radians, or velocities, relatively, count as lost.
LOST = 0.1
#: The error that "auto" is asked for; what stands before its choice in a description.
ASKED, TAKES = 1e-9, "; auto takes "
GRAVITY, SPHERE = np.array([0.0, 0.0, -9.81]), 0.7
#: Integrators that take steps of one size, in how many steps, and those that choose their own, with which tolerances.
FEW, MANY = (60, 250, 1000), (250, 1000, 4000)
STEPS = {
    "rk4": MANY, "rkmk4": MANY, "cf4": MANY, "midpoint": MANY, "strang": MANY, "blanes-moan": FEW, "yoshida6": FEW,
}  # fmt: skip
TOLERANCES = (1e-5, 1e-8, 1e-11)
#: How often each motion is computed at once, so that the cost of the call is shared: where one takes little, and where
#: one takes much.
COPIES, FEW_COPIES = 60, 2


@dataclass(frozen=True)
class Motions:
    """Bodies that are free, or turn about a point, or about a line.

    Attributes
    ----------
    mass, moments : arrays (n,), (n, 3)
        Moments about the centre of mass, along the body's axes.
    spin, rotation : arrays (n, 3), (n, 3, 3)
        At the start, along the body's axes; body to world.
    duration : float
    arm : array (n, 3)
        From the point that stays to the centre of mass, in the body. Zero for a free body.
    held : {"", "point", "line", "points", "sphere"}
        What of the body stays: nothing, a point, the line along its second axis, or two points of it; or a point stays
        on a sphere about ``place`` (of radius `SPHERE`).
    gap : float
        Between those two points.
    place : array (3,)
        Of the point that stays, in the world.
    stabilization : str
        How what stays is kept.
    step : float, optional
        Of integrators that do not choose their own: they have no other settings then.
    chosen : set
        What "auto" took, put there by it.
    """

    mass: Array
    moments: Array
    spin: Array
    rotation: Array
    duration: float
    arm: Array
    held: str = ""
    gap: float = 0.0
    place: Array = field(default_factory=lambda: np.zeros(3))
    stabilization: str = "auto"
    step: float | None = None
    chosen: set[str] = field(default_factory=set)

    def __len__(self) -> int:
        return len(self.mass)

    def constraints(self, copies: int = 1) -> list[Any]:
        """What holds each of so many copies."""
        from ... import cga3d, dynamics

        point = np.tile(-self.arm, (copies, 1))
        if self.held == "line":
            return [dynamics.Pin(cga3d.line(point[0], (0.0, 1.0, 0.0)))]
        if self.held == "points":
            return [dynamics.Pin(cga3d.point(point[0] + side * self.gap * np.array([0, 0.5, 0]))) for side in (-1, 1)]
        if self.held == "sphere":
            return [dynamics.Incidence(cga3d.point(point[0]), cga3d.sphere(self.place, SPHERE))]
        return [dynamics.Pin(cga3d.point(point[0]))] if self.held else []

    def simulation(self, copies: int = 1, **options: Any) -> Any:
        """All of them, each as often."""
        from ... import dynamics

        mass, moments, spin, rotation, arm = (
            np.concatenate([x] * copies) for x in (self.mass, self.moments, self.spin, self.rotation, self.arm)
        )
        velocity = np.einsum("nij,nj->ni", rotation, np.cross(spin, arm))
        position = self.place + np.einsum("nij,nj->ni", rotation, arm)
        if self.held == "sphere":
            position = position + SPHERE * np.array([1.0, 0.0, 0.0])
        body = dynamics.RigidBody(mass, moments, position, rotation, velocity, spin)
        loads = [dynamics.Gravity(GRAVITY)] if self.held else []
        return dynamics.Simulation(
            body, loads, self.constraints(copies), **{"stabilization": self.stabilization, **options}
        )


@dataclass(frozen=True)
class States:
    """Where bodies are: orientations (n, 3, 3), angular velocities along their axes (n, 3), centres (n, 3)."""

    orientation: Array
    spin: Array
    position: Array


def states(trajectory: Any, count: int) -> States:
    """At the end; NaN of those that did not get there."""
    parts = (trajectory.orientation, trajectory.angular_velocity, trajectory.position)
    singles = (2, 1, 1)
    last = [p[None, -1] if p.ndim == s + 1 else p[:, -1] for p, s in zip(parts, singles, strict=True)]
    ok = np.atleast_1d(trajectory.status) == "ok"
    return States(*(np.where(ok[:count].reshape(-1, *[1] * s), p[:count], np.nan)
                    for p, s in zip(last, singles, strict=True)))  # fmt: skip


def integrate(inputs: Motions, setting: Any, *, copies: int = 1, **options: Any) -> States | None:
    """The states at the end.

    A setting of one and more is a number of steps, one below a tolerance. None stands for what users get who say
    nothing; on motions that have a step of their own it is that step, and there are no other settings. Options are
    those of simulations; of what they are not made for there are no states.
    """
    run: dict[str, Any] = {}
    integrator = options["integrator"]
    if inputs.step is None:
        if setting is None and integrator != "auto":
            return None
        if setting is not None:
            run = {"step": inputs.duration / setting} if setting >= 1 else {"rtol": setting}
    elif setting is not None:
        return None
    elif integrator in STEPS:
        run = {"step": inputs.step}
    trajectory = ran(inputs.simulation(copies, **options), inputs.duration, [inputs.duration], **run)
    if trajectory is None:
        return None
    if integrator == "auto":
        inputs.chosen.add(trajectory.integrator)
    return states(trajectory, len(inputs))


def ran(simulation: Any, duration: float, times: Any, **run: Any) -> Any:
    """Its trajectory; None where the integrator or the way to keep constraints is not made for it."""
    from ...errors import InputError

    try:
        return simulation.run(duration, times=times, threads=1, strict=False, **run)
    except InputError:
        if simulation.integrator == "auto" and simulation.stabilization == "auto":
            raise
        return None


def methods(most: int, copies: int = COPIES, few: int = FEW_COPIES) -> tuple[Method, ...]:
    """All integrators that there are, at several settings, and "auto", on so many bodies, each as often at once.

    "auto" is last: what it takes is compiled by then.
    """
    from ...dynamics.methods import INTEGRATORS

    found = []
    for name in INTEGRATORS:
        knob, settings, own = "tolerance", (None, *TOLERANCES), copies
        if name in STEPS:
            knob, settings, own = "steps", (None, *STEPS[name]), few
        run = partial(integrate, integrator=name, copies=own)
        found.append(Method(name, run, knob, settings, most=most, repeats=1, copies=own))
    run = partial(integrate, integrator="auto", copies=copies)
    return (*found, Method("auto", run, most=most, repeats=1, copies=copies))


# -- truth -------------------------------------------------------------------------------------------------


def truth(inputs: Motions) -> States:
    """With 30 digits: elliptic functions where there are any, power series otherwise. Remembered, for it takes long."""
    arrays = (inputs.mass, inputs.moments, inputs.spin, inputs.rotation, inputs.arm)
    key = (*(x.tobytes() for x in arrays), inputs.duration, inputs.held)
    if key not in _KNOWN:
        _KNOWN[key] = _turned(inputs)
    turn, spin = _KNOWN[key]
    return States(turn, spin, inputs.place + np.einsum("nij,nj->ni", turn, inputs.arm))


#: Orientations and velocities of motions that were asked for.
_KNOWN: dict[Any, tuple[Array, Array]] = {}


def _turned(inputs: Motions) -> tuple[Array, Array]:
    if inputs.held in ("line", "points"):
        return _about_line(inputs)
    if inputs.held:
        return exact_motions.turning(
            inputs.mass, inputs.moments, inputs.arm, GRAVITY, inputs.rotation, inputs.spin, inputs.duration
        )
    parts = [exact_motions.free_top(i, w, inputs.duration) for i, w in zip(inputs.moments, inputs.spin, strict=True)]
    return inputs.rotation @ np.stack([p[0] for p in parts]), np.stack([p[1] for p in parts])


def _about_line(inputs: Motions) -> tuple[Array, Array]:
    """Pendulums about the second axis, turned about it from where their axes are those of the world."""
    turn, spin = np.zeros((len(inputs), 3, 3)), np.zeros((len(inputs), 3))
    for k in range(len(inputs)):
        x, _, z = inputs.arm[k]
        length = np.hypot(x, z)
        strength = inputs.mass[k] * -GRAVITY[2] * length / (inputs.moments[k, 1] + inputs.mass[k] * length**2)
        hanging = np.arctan2(x, -z)  # a turn by so much lets the arm hang
        start = np.arctan2(inputs.rotation[k, 0, 2], inputs.rotation[k, 0, 0])
        angle, spin[k, 1] = exact_motions.pendulum(strength, start - hanging, inputs.spin[k, 1], inputs.duration)
        s, c = np.sin(angle + hanging), np.cos(angle + hanging)
        turn[k] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    return turn, spin


def error(answer: States, exact: States, inputs: Motions) -> Errors:
    """The largest of: angle between the orientations, difference of the velocities and of the places of the centres,
    relative to the velocity and to the arm. Infinite from `LOST` on.
    """
    apart = np.linalg.norm(answer.orientation - exact.orientation, axis=(1, 2)) / (2 * np.sqrt(2))
    angle = 2 * np.arcsin(np.minimum(apart, 1))
    speed = np.linalg.norm(answer.spin - exact.spin, axis=1) / np.linalg.norm(exact.spin, axis=1)
    found = np.maximum(angle, speed)
    if inputs.held:
        away = np.linalg.norm(answer.position - exact.position, axis=1) / np.linalg.norm(inputs.arm, axis=1)
        found = np.maximum(found, away)
    return np.where(found < LOST, found, np.inf)


# -- "auto" beside the others ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verdict:
    """What "auto" took on a case, and what would have been better.

    Attributes
    ----------
    case, chosen : str
    error, nanoseconds : float
        Of "auto"; an infinite error: it was lost.
    fastest, exactest : Measurement, optional
        Of all others the fastest that is as exact as is asked for, and the one with the least error.
    """

    case: str
    chosen: str
    error: float
    nanoseconds: float
    fastest: Measurement | None
    exactest: Measurement | None


def verdicts(rows: Sequence[Measurement], asked: float = ASKED) -> list[Verdict]:
    """For each case that is not of a sweep."""
    found = []
    for case in dict.fromkeys(r.case for r in rows if not r.sweep):
        own = [r for r in rows if r.case == case]
        (auto,) = (r for r in own if r.method == "auto")
        others = [r for r in own if r.method != "auto" and not r.lost]
        right = [r for r in others if r.max_error <= asked]
        error = np.inf if auto.lost else auto.max_error
        chosen = (auto.worst or auto.first_lost).rpartition(TAKES)[2]
        fastest = min(right, key=lambda r: r.nanoseconds, default=None)
        exactest = min(others, key=lambda r: r.max_error, default=None)
        found.append(Verdict(case, chosen, error, auto.nanoseconds, fastest, exactest))
    return found


# -- cases -------------------------------------------------------------------------------------------------


def describe(inputs: Motions, i: int) -> str:
    """One body, and what "auto" takes for it."""
    chosen = ", ".join(sorted(inputs.chosen))
    auto = TAKES + chosen if chosen else ""
    return f"moments {_told(inputs.moments[i])}, spin {_told(inputs.spin[i])}, arm {_told(inputs.arm[i])}{auto}"


def _told(values: Sequence[float]) -> str:
    return f"({', '.join(f'{x:.6g}' for x in values)})"


def rotations(rng: np.random.Generator, count: int) -> Array:
    """Random ones (count, 3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    q = q * np.sign(np.einsum("nii->ni", r))[:, None]
    found: Array = q * np.linalg.det(q)[:, None, None]
    return found


def case(name: str, make: Callable[[np.random.Generator, int], Motions], nature: Nature = "ordinary") -> Case:
    """A case of motions."""
    return Case(name, make, nature, describe)
