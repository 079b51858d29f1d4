"""Integrators of `bladesmith.dynamics` as methods of studies: their inputs, and their errors at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from .... import dynamics
from ....dynamics.integration.integrators import INTEGRATORS
from ....dynamics.integration.tableaus import FIXED_SCHEMES
from ....errors import InputError
from ...harness.algebras import cga3d
from ...harness.runner import Measurement
from ...harness.study import Array, Errors, Method, Study, lost_beyond
from ...harness.vectors import vector_text
from . import exact_motions

#: Orientations that are further off, in radians, or velocities, relatively, count as lost.
LOST = 0.1
#: The error that "auto" is to reach; the words before its choice in a description.
TOLERANCE, TAKES = 1e-9, "; auto takes "
GRAVITY, SPHERE = np.array([0.0, 0.0, -9.81]), 0.7
#: Integrators that take steps of one size, in how many steps, and those that choose their own, with which tolerances.
FEW, MANY = (60, 250, 1000), (250, 1000, 4000)
STEPS = {
    "rk4": MANY, **dict.fromkeys(FIXED_SCHEMES, MANY), "cf4": MANY, "midpoint": MANY, "strang": MANY,
    "blanes-moan": FEW, "yoshida6": FEW,
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
        Moments about the center of mass, along the body's axes.
    spin, rotation : arrays (n, 3), (n, 3, 3)
        At the start, along the body's axes; body to world.
    duration : float
    arm : array (n, 3)
        From the point that stays to the center of mass, in the body. Zero for a free body.
    held : {"", "point", "line", "points", "sphere"}
        What of the body stays: nothing, a point, the line along its second axis, or two points of it; or a point stays
        on a sphere about ``position`` (of radius `SPHERE`).
    gap : float
        Between those two points.
    position : array (3,)
        Position of the fixed point, in the world.
    stabilization : str
        Stabilization of the constraints.
    step : float, optional
        Of integrators that do not choose their own: they have no other settings then.
    chosen : set
        Integrators that "auto" selected; it adds them.
    """

    mass: Array
    moments: Array
    spin: Array
    rotation: Array
    duration: float
    arm: Array
    held: str = ""
    gap: float = 0.0
    position: Array = field(default_factory=lambda: np.zeros(3))
    stabilization: str = "auto"
    step: float | None = None
    chosen: set[str] = field(default_factory=set)

    def __len__(self) -> int:
        return len(self.mass)

    def constraints(self, copies: int = 1) -> list[Any]:
        """Constraints of each copy."""
        point = np.tile(-self.arm, (copies, 1))
        if self.held == "line":
            return [dynamics.Pin(cga3d.line(point[0], (0.0, 1.0, 0.0)))]
        if self.held == "points":
            return [dynamics.Pin(cga3d.point(point[0] + side * self.gap * np.array([0, 0.5, 0]))) for side in (-1, 1)]
        if self.held == "sphere":
            return [dynamics.Incidence(cga3d.point(point[0]), cga3d.sphere(self.position, SPHERE))]
        return [dynamics.Pin(cga3d.point(point[0]))] if self.held else []

    def simulation(self, copies: int = 1, **options: Any) -> Any:
        """All of them, each as often."""
        mass, moments, spin, rotation, arm = (
            np.concatenate([x] * copies) for x in (self.mass, self.moments, self.spin, self.rotation, self.arm)
        )
        velocity = np.einsum("nij,nj->ni", rotation, np.cross(spin, arm))
        center = self.position + np.einsum("nij,nj->ni", rotation, arm)
        if self.held == "sphere":
            center = center + SPHERE * np.array([1.0, 0.0, 0.0])
        body = dynamics.RigidBody(mass, moments, center, rotation, velocity, spin)
        loads = [dynamics.Gravity(GRAVITY)] if self.held else []
        return dynamics.Simulation(
            body, loads, self.constraints(copies), **{"stabilization": self.stabilization, **options}
        )


def motions(
    moments: Any, spin: Array, rotation: Array, duration: float, *, arm: Any = (0, 0, 0), mass: float = 1.0,
    **options: Any,
) -> Motions:  # fmt: skip
    """Motions of bodies of one mass, moments and arm."""
    n = len(spin)
    return Motions(
        np.full(n, mass), np.tile(moments, (n, 1)), spin, rotation, duration, np.tile(arm, (n, 1)), **options
    )


@dataclass(frozen=True)
class States:
    """States of bodies: orientations (n, 3, 3), angular velocities along their axes (n, 3), centers (n, 3)."""

    orientation: Array
    spin: Array
    position: Array


def states(trajectory: Any, count: int) -> States:
    """At the end; NaN of those that did not get there."""
    parts = (trajectory.orientation, trajectory.angular_velocity, trajectory.position)
    singles = (2, 1, 1)
    last = [p[None, -1] if p.ndim == s + 1 else p[:, -1] for p, s in zip(parts, singles, strict=True)]
    ok = np.atleast_1d(trajectory.ending) == "ok"
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
    trajectory = run_if_possible(inputs.simulation(copies, **options), inputs.duration, [inputs.duration], **run)
    if trajectory is None:
        return None
    if integrator == "auto":
        inputs.chosen.add(trajectory.integrator)
    return states(trajectory, len(inputs))


def run_if_possible(simulation: Any, duration: float, times: Any, **run: Any) -> Any:
    """Trajectory of a simulation; None where the integrator or the stabilization is not made for it."""
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

    def method(name: str, knob: str, settings: tuple[Any, ...], copies: int) -> Method:
        run = partial(integrate, integrator=name, copies=copies)
        return Method(name, run, knob, settings, most=most, repeats=1, copies=copies)

    return (
        *(
            method(name, "steps", (None, *STEPS[name]), few)
            if name in STEPS
            else method(name, "tolerance", (None, *TOLERANCES), copies)
            for name in INTEGRATORS
        ),
        method("auto", "", (None,), copies),
    )


# -- truth -------------------------------------------------------------------------------------------------


def truth(inputs: Motions) -> States:
    """Exact states to 30 digits, by elliptic functions where these exist, else by power series; cached."""
    arrays = (inputs.mass, inputs.moments, inputs.spin, inputs.rotation, inputs.arm)
    key = (*(x.tobytes() for x in arrays), inputs.duration, inputs.held)
    if key not in _EXACT:
        _EXACT[key] = _exact_pose(inputs)
    rotation, spin = _EXACT[key]
    return States(rotation, spin, inputs.position + np.einsum("nij,nj->ni", rotation, inputs.arm))


#: Exact orientations and velocities by the bytes of the inputs.
_EXACT: dict[Any, tuple[Array, Array]] = {}


def _exact_pose(inputs: Motions) -> tuple[Array, Array]:
    if inputs.held in ("line", "points"):
        return _about_line(inputs)
    if inputs.held:
        return exact_motions.turning(
            inputs.mass, inputs.moments, inputs.arm, GRAVITY, inputs.rotation, inputs.spin, inputs.duration
        )
    parts = [exact_motions.free_top(i, w, inputs.duration) for i, w in zip(inputs.moments, inputs.spin, strict=True)]
    return inputs.rotation @ np.stack([p[0] for p in parts]), np.stack([p[1] for p in parts])


def _about_line(inputs: Motions) -> tuple[Array, Array]:
    """Pendulums about the second axis, rotated about it from where their axes are those of the world."""
    rotation, spin = np.zeros((len(inputs), 3, 3)), np.zeros((len(inputs), 3))
    for k in range(len(inputs)):
        x, _, z = inputs.arm[k]
        length = np.hypot(x, z)
        strength = inputs.mass[k] * -GRAVITY[2] * length / (inputs.moments[k, 1] + inputs.mass[k] * length**2)
        hanging = np.arctan2(x, -z)  # a rotation by so much lets the arm hang
        start = np.arctan2(inputs.rotation[k, 0, 2], inputs.rotation[k, 0, 0])
        angle, spin[k, 1] = exact_motions.pendulum(strength, start - hanging, inputs.spin[k, 1], inputs.duration)
        s, c = np.sin(angle + hanging), np.cos(angle + hanging)
        rotation[k] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    return rotation, spin


def error(answer: States, exact: States, inputs: Motions) -> Errors:
    """The largest of: angle between the orientations, difference of the velocities and of the centers' positions,
    relative to the velocity and to the arm. Infinite from `LOST` on.
    """
    apart = np.linalg.norm(answer.orientation - exact.orientation, axis=(1, 2)) / (2 * np.sqrt(2))
    angle = 2 * np.arcsin(np.minimum(apart, 1))
    speed = np.linalg.norm(answer.spin - exact.spin, axis=1) / np.linalg.norm(exact.spin, axis=1)
    errors = np.maximum(angle, speed)
    if inputs.held:
        away = np.linalg.norm(answer.position - exact.position, axis=1) / np.linalg.norm(inputs.arm, axis=1)
        errors = np.maximum(errors, away)
    return lost_beyond(errors, LOST)


# -- "auto" beside the others ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verdict:
    """Selection of "auto" on a case, and the best alternatives.

    Attributes
    ----------
    case, chosen : str
    error, nanoseconds : float
        Of "auto"; an infinite error: it was lost.
    fastest, exactest : Measurement, optional
        Of all others the fastest that is as exact as the tolerance, and the one with the least error.
    """

    case: str
    chosen: str
    error: float
    nanoseconds: float
    fastest: Measurement | None
    exactest: Measurement | None


def verdicts(rows: Sequence[Measurement], tolerance: float = TOLERANCE) -> list[Verdict]:
    """For each case that is not of a sweep."""
    judged = []
    for case in dict.fromkeys(r.case for r in rows if not r.sweep):
        of_case = [r for r in rows if r.case == case]
        (auto,) = (r for r in of_case if r.method == "auto")
        others = [r for r in of_case if r.method != "auto" and not r.lost]
        right = [r for r in others if r.max_error <= tolerance]
        error = np.inf if auto.lost else auto.max_error
        chosen = (auto.worst or auto.first_lost).rpartition(TAKES)[2]
        fastest = min(right, key=lambda r: r.nanoseconds, default=None)
        exactest = min(others, key=lambda r: r.max_error, default=None)
        judged.append(Verdict(case, chosen, error, auto.nanoseconds, fastest, exactest))
    return judged


# -- cases -------------------------------------------------------------------------------------------------


def describe(inputs: Motions, i: int) -> str:
    """One body, and what "auto" takes for it."""
    chosen = ", ".join(sorted(inputs.chosen))
    auto = TAKES + chosen if chosen else ""
    moments, spin, arm = (vector_text(x[i]) for x in (inputs.moments, inputs.spin, inputs.arm))
    return f"moments {moments}, spin {spin}, arm {arm}{auto}"


def rotations(rng: np.random.Generator, count: int) -> Array:
    """Random rotations (count, 3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    q = q * np.sign(np.einsum("nii->ni", r))[:, None]
    return np.asarray(q * np.linalg.det(q)[:, None, None])


def study(**options: Any) -> Study:
    """A study of integrators, with what they have in common."""
    return Study(reference=truth, error=error, describe=describe, unit="radian, or relative", **options)
