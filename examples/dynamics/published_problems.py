"""Problems of the IFToMM library of multibody benchmarks (M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado: A
benchmarking system for MBS simulation software, Multibody System Dynamics 16, 2006): what they ask, and what comes out.

    python examples/dynamics/published_problems.py --out dynamics

A01 a pendulum, A02 parallelograms, singular where they lie flat, A03 Andrews' squeezing mechanism (with the digits of
Hairer and Wanner), A04 Bricard's mechanism, which has more constraints than it should be able to move with, A05 a stiff
flyball governor.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from bladesmith import cga3d, dynamics, kinematics
from bladesmith.dynamics import Gravity, RigidBody, Simulation, Spring, System, Trajectory, WorldWrench

Array = NDArray[Any]
EAST, NORTH, UP = np.eye(3)
#: Pendulum and Bricard's mechanism; their second axis is upright.
DOWN = (0.0, -9.81, 0.0)
#: The governor's turning at the start, and its steel.
SPEED, DENSITY = 2 * np.pi, 3000.0
#: Its parts, and how far below level the rods are at the start.
SHAFT, SLIDER, ROD, TILT = (0.01, 0.01, 1.0), (0.1, 0.1, 0.1), (1.0, 0.01, 0.01), np.pi / 6
#: Andrews' mechanism: angles at the start, at rest.
ANDREWS_START = np.array([
    -0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
    -0.222668390165885885, 1.23054744454982119,
])  # fmt: skip
#: Angles at 0.03 s, as published.
ANDREWS_END = np.array([
    15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
    0.5347301163226948, 1.048080741042263,
])  # fmt: skip


def hinge(a: str, b: str, point: Array, axis: Array = UP) -> kinematics.Revolute:
    """A revolute joint at a point of the world."""
    return kinematics.Revolute(a, b, cga3d.line(point, axis), cga3d.point(point))


def brick(size: Any, density: float) -> tuple[float, Array]:
    """Mass, and principal moments about the center."""
    mass = density * float(np.prod(size))
    squares = np.square(size)
    return mass, mass / 12 * (squares.sum() - squares)


# -- A01 -----------------------------------------------------------------------------------------------------


def pendulum() -> Simulation:
    """A point of 1 kg, 1 m from a hinge at the origin; at the start it is level with it."""
    point = RigidBody(1.0, np.full(3, 1e-12), position=-EAST)
    return Simulation(System({"point": point}, [hinge("base", "point", np.zeros(3))]), [Gravity(DOWN)])


# -- A02 -----------------------------------------------------------------------------------------------------


def parallelograms(count: int = 2, **options: Any) -> Simulation:
    """Cranks side by side, upright at the start, and rods from tip to tip, each of 1 kg and 1 m; tips begin at 1 m/s.

    When all rods lie on a line, each of the parallelograms could go on crossed.
    """
    bodies, joints = {}, []
    moments = np.array([1.0, 1.0, 1.0]) / 12
    for i in range(count + 1):
        bodies[f"crank {i}"] = RigidBody(
            1.0, moments, position=i * EAST + NORTH / 2, velocity=EAST / 2, angular_velocity=-UP
        )
        joints.append(hinge("base", f"crank {i}", i * EAST))
    for i in range(count):
        bodies[f"rod {i}"] = RigidBody(1.0, moments, position=(i + 0.5) * EAST + NORTH, velocity=EAST)
        joints.append(hinge(f"crank {i}", f"rod {i}", i * EAST + NORTH))
        joints.append(hinge(f"rod {i}", f"crank {i + 1}", (i + 1) * EAST + NORTH))
    return Simulation(System(bodies, joints), [Gravity(DOWN)], **options)


# -- A03 -----------------------------------------------------------------------------------------------------


def andrews() -> Simulation:
    """Seven bodies in a plane, three loops, a spring and a motor of constant torque; lengths of some centimeters."""
    beta, theta, gamma, phi, delta, omega, epsilon = ANDREWS_START
    a, b, c = np.array([[-0.06934, -0.00227, 0.0], [-0.03635, 0.03273, 0.0], [0.014, 0.072, 0.0]])

    def along(angle: float) -> Array:
        return np.array([np.cos(angle), np.sin(angle), 0.0])

    def across(angle: float) -> Array:
        return np.array([np.sin(angle), -np.cos(angle), 0.0])

    crank = 0.007 * along(beta)
    middle = crank - 0.028 * along(beta + theta)
    upper, lower = a + 0.04 * along(delta), a + 0.04 * across(epsilon)
    hook = b + 0.02 * along(gamma) + 0.018 * across(gamma)
    centers = [
        0.00092 * along(beta), crank - 0.0115 * along(beta + theta),
        b + 0.01874 * across(gamma) + 0.01043 * along(gamma),
        upper + (0.02 - 0.01421) * across(phi + delta), a + 0.02308 * along(delta) - 0.00916 * across(delta),
        lower + (0.02 - 0.01421) * along(omega + epsilon), a + 0.01228 * across(epsilon) - 0.00449 * along(epsilon),
    ]  # fmt: skip
    masses = [0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498]
    moments = [2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5]
    bodies = {
        f"k{i}": RigidBody(mass, (moment / 2, moment / 2, moment), position=center)  # flat: the others do not count
        for i, (mass, moment, center) in enumerate(zip(masses, moments, centers, strict=True), 1)
    }
    joints = [
        hinge("base", "k1", np.zeros(3)), hinge("k1", "k2", crank), hinge("k2", "k3", middle),
        hinge("k2", "k4", middle), hinge("k2", "k6", middle), hinge("base", "k3", b), hinge("base", "k5", a),
        hinge("k5", "k4", upper), hinge("base", "k7", a), hinge("k7", "k6", lower),
    ]  # fmt: skip
    spring = Spring(hook - centers[2], c, 4530.0, 0.07785, body="k3")
    return Simulation(System(bodies, joints), [spring, WorldWrench(dynamics.couple(0.033 * UP), "k1")])


def andrews_angles(trajectory: Trajectory) -> Array:
    """The seven angles of the literature, some of them between bodies, (7, n)."""
    turns = [trajectory[f"k{i}"].orientation for i in range(1, 8)]
    k1, k2, k3, k4, k5, k6, k7 = (np.unwrap(np.arctan2(turn[:, 1, 0], turn[:, 0, 0])) for turn in turns)
    return ANDREWS_START[:, None] + np.array([k1, k2 - k1, k3, k4 - k5, k5, k6 - k7, k7])


# -- A04 -----------------------------------------------------------------------------------------------------


def bricard() -> Simulation:
    """Five rods of 1 kg and 1 m along edges of a cube, six hinges: a freedom that counting does not see."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], float)
    edges = np.roll(corners, -1, axis=0) - corners
    names = ["base", *(f"rod {i}" for i in range(1, 6)), "base"]
    bodies = {}
    for name, corner, edge in zip(names[1:], corners, edges[:5], strict=False):
        moments = (1 + 0.1**2 - np.abs(edge) * (1 - 0.1**2)) / 12  # a square of 0.1 m across
        bodies[name] = RigidBody(1.0, moments, position=corner + edge / 2)
    joints = [
        hinge(a, b, corner, np.cross(before, edge))
        for a, b, corner, before, edge in zip(names, names[1:], corners, np.roll(edges, 1, axis=0), edges, strict=False)
    ]
    return Simulation(System(bodies, joints), [Gravity(DOWN)])


# -- A05 -----------------------------------------------------------------------------------------------------


def governor() -> Simulation:
    """A turning shaft; two rods with balls, hinged to its top; a slider that stiff springs with dampers hold there."""
    shaft, slider = brick(SHAFT, DENSITY), brick(SLIDER, DENSITY)
    rod, ball = brick(ROD, DENSITY), 5.0
    mass = rod[0] + ball
    center = (rod[0] * 0.5 + ball) / mass  # along the rod
    moments = rod[1] + np.array([0, 1, 1]) * (rod[0] * (center - 0.5) ** 2 + ball * (1 - center) ** 2)
    bodies = {
        "shaft": RigidBody(*shaft, position=UP / 2, angular_velocity=SPEED * UP),
        "slider": RigidBody(*slider, position=UP / 2, angular_velocity=SPEED * UP),
    }
    joints = [
        hinge("base", "shaft", np.zeros(3)),
        kinematics.Prismatic("shaft", "slider", cga3d.line(UP / 2, UP), cga3d.direction(EAST)),
    ]
    loads: list[Any] = [Gravity((0, 0, -9.81))]
    for name, side in (("right", 1.0), ("left", -1.0)):
        out = np.array([side * np.cos(TILT), 0, -np.sin(TILT)])
        turn = np.stack([out, np.cross(NORTH, out), NORTH], axis=1)
        top = np.array([side * 0.05, 0, 1.0])
        place = top + center * out
        bodies[name] = RigidBody(
            mass, moments, place, turn, velocity=SPEED * np.cross(UP, place), angular_velocity=SPEED * turn.T @ UP
        )
        joints.append(hinge("shaft", name, top, NORTH))
        loads.append(Spring((0.5 - center) * EAST, side * 0.05 * EAST, 8e5, 0.5, 4e4, body=name, other="slider"))
    return Simulation(System(bodies, joints), loads)


def governor_by_scipy(times: Array) -> Array:
    """The slider's height from the equations of Lagrange in its two coordinates, by SciPy's Radau; the shaft's speed
    follows from its angular momentum, which nothing changes."""
    shaft, slider, rod, ball = brick(SHAFT, DENSITY), brick(SLIDER, DENSITY), brick(ROD, DENSITY), 5.0
    mass = rod[0] + ball
    center = (rod[0] * 0.5 + ball) / mass
    along, *_, across = rod[1] + np.array([0, 1, 1]) * (rod[0] * (center - 0.5) ** 2 + ball * (1 - center) ** 2)

    def about_shaft(tilt: float) -> float:
        reach = 0.05 + center * np.cos(tilt)
        one = mass * reach**2 + along * np.sin(tilt) ** 2 + across * np.cos(tilt) ** 2
        return float(shaft[1][2] + slider[1][2] + 2 * one)

    momentum = SPEED * about_shaft(TILT)

    def rates(_: float, state: Array) -> Array:
        tilt, height, tilt_rate, rate = state
        c, s = np.cos(tilt), np.sin(tilt)
        up = 1 - 0.5 * s - height
        length = np.hypot(0.5 * c, up)
        by_tilt, by_height = (-0.25 * c * s - 0.5 * c * up) / length, -up / length
        force = 8e5 * (length - 0.5) + 4e4 * (by_tilt * tilt_rate + by_height * rate)
        widening = -2 * s * (mass * (0.05 + center * c) * center + (across - along) * c)
        speed = momentum / about_shaft(tilt)
        turning = speed**2 * widening / 2 + mass * 9.81 * center * c - force * by_tilt
        falling = -9.81 - 2 * force * by_height / slider[0]
        return np.array([tilt_rate, rate, turning / (mass * center**2 + across), falling])

    found = solve_ivp(
        rates, (0, times[-1]), [TILT, 0.5, 0, 0], method="Radau", t_eval=times, rtol=1e-10, atol=1e-12
    )  # fmt: skip
    return found.y[1]


# -- all of them ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Problem:
    """A problem, and how far what it asks about is off.

    Attributes
    ----------
    name : str
    simulation : function
    duration : float
        In seconds.
    what : str
        What is measured.
    error : function
        Of a trajectory.
    allowed : float
        What the library allows, or the last published digit.
    """

    name: str
    simulation: Callable[[], Simulation]
    duration: float
    what: str
    error: Callable[[Trajectory], float]
    allowed: float

    def run(self, steps: int = 1000) -> Trajectory:
        """Its motion, at equal distances of time."""
        return self.simulation().run(self.duration, times=np.linspace(0, self.duration, steps + 1), strict=True)


def energy_error(trajectory: Trajectory) -> float:
    """Largest change of energy, in J."""
    return float(np.abs(trajectory.energy - trajectory.energy[0]).max())


def angle_error(trajectory: Trajectory) -> float:
    """Largest difference of Andrews' angles at the end, in radians."""
    return float(np.abs(andrews_angles(trajectory)[:, -1] - ANDREWS_END).max())


def height_error(trajectory: Trajectory) -> float:
    """Largest difference of the governor's slider from SciPy's, in m."""
    return float(np.abs(trajectory["slider"].position[:, 2] - governor_by_scipy(trajectory.time)).max())


PROBLEMS = (
    Problem("A01 pendulum", pendulum, 10.0, "energy", energy_error, 5e-5),
    Problem("A02 two parallelograms", parallelograms, 10.0, "energy", energy_error, 0.1),
    Problem("A03 Andrews' mechanism", andrews, 0.03, "angles at the end", angle_error, 1e-6),
    Problem("A04 Bricard's mechanism", bricard, 10.0, "energy", energy_error, 1e-3),
    Problem("A05 stiff flyball governor", governor, 10.0, "the slider's height", height_error, 1e-6),
)


def picture(motions: dict[str, Trajectory], path: Path) -> None:
    """What moves in each problem, over time."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(3, 2, figsize=(13, 8), layout="constrained")
    axes[2, 1].remove()
    for axis, (name, motion) in zip(axes.flat, motions.items(), strict=False):
        if name.startswith("A01"):
            axis.plot(motion.time, motion["point"].position[:, :2], label=["x of the point", "y"])
        elif name.startswith("A02"):
            axis.plot(motion.time, 2 * motion["crank 0"].position[:, :2], label=["x of the first tip", "y"])
        elif name.startswith("A03"):
            axis.plot(motion.time, andrews_angles(motion)[2:].T, label=["gamma", "Phi", "delta", "Omega", "epsilon"])
        elif name.startswith("A04"):
            rod = motion["rod 3"]
            axis.plot(motion.time, rod.position + rod.orientation[:, :, 2] / 2, label=["x of corner 3", "y", "z"])
        else:
            axis.plot(motion.time, motion["slider"].position[:, 2], label="height of the slider")
        axis.set_title(name)
        axis.set_xlabel("time in s")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("dynamics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    motions = {}
    for problem in PROBLEMS:
        problem.run(1)  # compiles
        start = time.perf_counter()
        motions[problem.name] = motion = problem.run()
        seconds = time.perf_counter() - start
        print(f"{problem.name}: {problem.what} off by {problem.error(motion):.2g}", end="")
        print(f" ({problem.allowed:g} allowed), {seconds:.3g} s for {problem.duration:g} s")
    picture(motions, out / "published_problems.png")


if __name__ == "__main__":
    main()
