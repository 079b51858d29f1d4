"""Integrators of `bladesmith.dynamics` as methods of studies: what they are given, and how far they are from the truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Nature
from . import exact_motions

Array = NDArray[Any]
#: Orientations that are further off, in radians, or velocities, relatively, count as lost.
LOST = 0.1
GRAVITY = np.array([0.0, 0.0, -9.81])
#: Integrators that take steps of one size, in how many steps, and those that choose their own, with which tolerances.
FEW, MANY = (60, 250, 1000), (250, 1000, 4000)
STEPS = {
    "rk4": MANY, "rkmk4": MANY, "cf4": MANY, "midpoint": MANY, "strang": MANY, "blanes-moan": FEW, "yoshida6": FEW,
}  # fmt: skip
TOLERANCES = (1e-5, 1e-8, 1e-11)
#: How often each motion is computed at once, so that the cost of the call is shared: where one takes little, and much.
COPIES, FEW_COPIES = 25, 4


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
    held : {"", "point", "line", "points"}
        What of the body stays: nothing, a point, the line along its second axis, or two points of it.
    gap : float
        Between those two points.
    place : array (3,)
        Of the point that stays, in the world.
    step : float, optional
        Where it is not one that divides the duration: of sweeps, in which steps do not get finer.
    chosen : dict
        What "auto" took, put there by it: setting to integrator.
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
    step: float | None = None
    chosen: dict[str, str] = field(default_factory=dict)

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
        return [dynamics.Pin(cga3d.point(point[0]))] if self.held else []

    def simulation(self, copies: int = 1, **options: Any) -> Any:
        """All of them, each as often."""
        from ... import dynamics

        mass, moments, spin, rotation, arm = (
            np.concatenate([x] * copies) for x in (self.mass, self.moments, self.spin, self.rotation, self.arm)
        )
        velocity = np.einsum("nij,nj->ni", rotation, np.cross(spin, arm))
        position = self.place + np.einsum("nij,nj->ni", rotation, arm)
        body = dynamics.RigidBody(mass, moments, position, rotation, velocity, spin)
        loads = [dynamics.Gravity(GRAVITY)] if self.held else []
        return dynamics.Simulation(body, loads, self.constraints(copies), **options)


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


def integrate(
    inputs: Motions, setting: Any, *, integrator: str, copies: int = 1, stabilization: str = "auto", **options: Any
) -> States | None:
    """The states at the end: a setting of one and more is a number of steps, one below a tolerance; None is default."""
    from ...dynamics.methods import INTEGRATORS

    is_split = INTEGRATORS.get(integrator) == "composition"
    if is_split and inputs.held not in ("", "point"):
        return None
    if setting == "step":
        options["step"] = inputs.step
    elif setting is not None:
        options |= {"step": inputs.duration / setting} if setting >= 1 else {"rtol": setting}
    simulation = inputs.simulation(copies, integrator=integrator, stabilization=stabilization)
    trajectory = simulation.run(inputs.duration, times=[inputs.duration], threads=1, strict=False, **options)
    if integrator == "auto":
        inputs.chosen[str(setting or "default")] = trajectory.integrator
    return states(trajectory, len(inputs))


def methods(most: int) -> tuple[Method, ...]:
    """"auto" at its default, and all integrators that there are, at several settings, on so many bodies."""
    from ...dynamics.methods import INTEGRATORS

    found = []
    for name in ("auto", *INTEGRATORS):
        knob, settings, copies = "tolerance", TOLERANCES, COPIES
        if name in STEPS:
            knob, settings, copies = "steps", STEPS[name], FEW_COPIES
        elif name == "auto":
            knob, settings, copies = "", (None,), FEW_COPIES
        run = partial(integrate, integrator=name, copies=copies)
        found.append(Method(name, run, knob, settings, most=most, repeats=1, copies=copies))
    return tuple(found)


# -- truth -------------------------------------------------------------------------------------------------


def truth(inputs: Motions) -> States:
    """With 30 digits: elliptic functions where there are any, power series otherwise."""
    if inputs.held in ("line", "points"):
        turn, spin = _about_line(inputs)
    elif inputs.held:
        turn, spin = exact_motions.turning(
            inputs.mass, inputs.moments, inputs.arm, GRAVITY, inputs.rotation, inputs.spin, inputs.duration
        )
    else:
        parts = [exact_motions.free_top(i, w, inputs.duration) for i, w in zip(inputs.moments, inputs.spin, strict=True)]
        turn = inputs.rotation @ np.stack([p[0] for p in parts])
        spin = np.stack([p[1] for p in parts])
    return States(turn, spin, inputs.place + np.einsum("nij,nj->ni", turn, inputs.arm))


def _about_line(inputs: Motions) -> tuple[Array, Array]:
    """Pendulums about the second axis: at the start turned about it from the position in which the world's are theirs."""
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


# -- cases -------------------------------------------------------------------------------------------------


def describe(inputs: Motions, i: int) -> str:
    """One body, and what "auto" takes for it."""
    chosen = ", ".join(sorted(set(inputs.chosen.values())))
    auto = f"; auto takes {chosen}" if chosen else ""
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
