"""Loops of joints and couplings: against constraints on poses, Lagrange's equations; through singular positions."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import InputError

CGA, PGA = bs.cga3d, bs.pga3d
DOWN = dynamics.Gravity((0.0, 0.0, -9.81))
ASKEW = dynamics.Gravity((0.7, 0.9, -9.81))


def hinge(a: str, b: str, point: Any, axis: Any = (0, 1, 0), algebra: Any = CGA) -> kinematics.Revolute:
    return kinematics.Revolute(a, b, algebra.line(point, axis), algebra.point(point))


def four_bars(n: int) -> dynamics.System:
    """The N four-bar mechanism of the IFToMM's benchmarks: rods of 1 m and 1 kg, whose heads begin at -1 m/s."""
    lying = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    moments = (1 / 12, 1 / 12, 1e-3)
    bodies = {
        f"rod{i}": dynamics.RigidBody(1.0, moments, (i, 0, 0.5), velocity=(-0.5, 0, 0), angular_velocity=(0, -1, 0))
        for i in range(n + 1)
    }
    bodies |= {
        f"bar{i}": dynamics.RigidBody(1.0, moments, (i + 0.5, 0, 1.0), lying, velocity=(-1, 0, 0)) for i in range(n)
    }
    joints = [hinge("base", f"rod{i}", (i, 0, 0)) for i in range(n + 1)]
    joints += [hinge(f"rod{i}", f"bar{i}", (i, 0, 1)) for i in range(n)]
    joints += [hinge(f"bar{i}", f"rod{i + 1}", (i + 1, 0, 1)) for i in range(n)]
    return dynamics.System(bodies, joints)


def closed_chain(last: str, algebra: Any) -> dynamics.System:
    """Bodies in a ring, from the world back to it: balls, a slide, and what closes it."""
    corners = np.array([(0, 0, 0), (1, 0.2, 0), (1.3, 1, 0.4), (0.4, 1.2, 1), (-0.3, 0.6, 0.7)])
    centers = (corners + np.roll(corners, -1, 0)) / 2
    bodies = {
        name: dynamics.RigidBody(1 + 0.2 * i, (0.1, 0.12, 0.15), x, algebra=algebra)
        for i, (name, x) in enumerate(zip("abcd", centers, strict=False))
    }
    k, point = kinematics, corners[4]
    normal = np.array([0.2, 1, 0.1]) / np.sqrt(1.05)
    line, plane = algebra.line(point, (0.3, 0.2, 1)), algebra.plane(normal, float(point @ normal))
    if last == "prismatic":
        closing: Any = k.Prismatic("d", "base", line, algebra.direction((1, 0, 0)))
    else:
        closing = {
            "revolute": lambda: hinge("base", "d", point, (0.3, 0.2, 1), algebra),
            "cylindrical": lambda: k.Cylindrical("d", "base", line),
            "planar": lambda: k.Planar("d", "base", plane),
            "spherical": lambda: k.Spherical("base", "d", algebra.point(point)),
        }[last]()
    joints = [
        k.Spherical("base", "a", algebra.point(corners[0])),
        hinge("b", "a", corners[1], (0, 0.3, 1), algebra),
        k.Spherical("b", "c", algebra.point(corners[2])),
        k.Cylindrical("c", "d", algebra.line(corners[3], (1, 0.3, 0.2))),
        closing,
    ]
    return dynamics.System(bodies, joints)


def difference(one: Any, other: Any) -> float:
    return float(np.abs(getattr(one, "values", one) - getattr(other, "values", other)).max(initial=0))


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", [CGA, PGA], ids=["cga", "pga"])
@pytest.mark.parametrize("last", ["revolute", "cylindrical", "planar", "spherical", "prismatic"])
def test_loops_beside_constraints(last: str, algebra: Any) -> None:
    system, times = closed_chain(last, algebra), np.linspace(0, 0.4, 3)
    found = dynamics.Simulation(system, [ASKEW]).run(0.4, times=times)
    other = dynamics.Simulation(system, [ASKEW], coordinates="maximal", integrator="adaptive").run(0.4, times=times)
    assert found.converged and other.converged and found.violation.max() < 1e-12
    for name in system.bodies:
        assert difference(found[name].position, other[name].position) < 1e-10
        assert difference(found[name].velocity, other[name].velocity) < 1e-9
        assert difference(found[name].reaction, other[name].reaction) < 1e-8
    for joint in range(5):
        assert difference(found.coordinates(joint), other.coordinates(joint)) < 1e-9
    assert np.ptp(found.energy) < 1e-10
    with pytest.raises(InputError, match="in a loop"):
        found.reactions(1)


@pytest.mark.parametrize("n", [1, 3])
def test_four_bars_pass_their_singular_positions(n: int) -> None:
    """Beside the one freedom that they have: rods stay parallel, energy is kept."""
    times = np.linspace(0, 4, 21)
    found = dynamics.Simulation(four_bars(n), [DOWN]).run(4.0, times=times)
    assert found.converged and found.violation.max() < 1e-11

    inertia, weight = (n + 1) / 3 + n, 9.81 * ((n + 1) / 2 + n)

    def rates(_: float, y: Any) -> Any:
        return [y[1], weight * np.sin(y[0]) / inertia]

    exact = solve_ivp(rates, (0, 4), [0.0, -1.0], method="DOP853", rtol=1e-13, atol=1e-13, t_eval=times).y[0]
    assert exact.min() < -np.pi / 2  # where all hinges are on one line
    for i in range(n + 1):
        assert difference(found.coordinates(i), exact) < 1e-5
    assert np.ptp(found.energy) < 1e-5
    flat = np.interp(found.singular_time, times, exact)
    assert abs(np.cos(flat)) < 0.1


@pytest.mark.slow
def test_forty_four_bars() -> None:
    """The benchmark: ten seconds, energy within 0.1 J."""
    simulation = dynamics.Simulation(four_bars(40), [DOWN])
    simulation.run(0.01)
    begin = time.perf_counter()
    found = simulation.run(10.0, times=np.linspace(0, 10, 101))
    assert found.converged and np.ptp(found.energy) < 1e-3 and time.perf_counter() - begin < 20.0
    rods = [found[f"rod{i}"].orientation for i in range(41)]
    assert max(difference(rod, rods[0]) for rod in rods) < 1e-6


def test_couplings() -> None:
    """Two pendulums, the second turning twice as far the other way: beside the equation of motion of both."""
    bodies = {n: dynamics.RigidBody(1.0, (0.3, 0.3, 0.3), (x, 0, -0.5)) for n, x in (("a", 0), ("b", 2))}
    joints = [hinge("base", "a", (0, 0, 0)), hinge("b", "base", (2, 0, 0))]
    system = dynamics.System(bodies, joints, couplings=[{(0, 0): 2.0, (1, 0): -1.0}])
    times = np.array([0.0, 1.0, 2.0])
    found = dynamics.Simulation(system, [dynamics.Gravity((4, 0, -9.81))]).run(2.0, times=times)

    def pull(x: float) -> float:
        return float(0.5 * (-4 * np.cos(x) - 9.81 * np.sin(x)))

    def rates(_: float, y: Any) -> Any:  # the angle of b is that of its own hinge, turned round
        return [y[1], (pull(y[0]) - 2 * pull(-2 * y[0])) / (0.55 * 5)]

    exact = solve_ivp(rates, (0, 2), [0, 0], method="DOP853", rtol=1e-13, atol=1e-14, t_eval=times).y
    assert difference(found.coordinates(0), exact[0]) < 1e-11
    assert difference(found.coordinates(1), 2 * exact[0]) < 1e-11 and found.violation.max() < 1e-13
    assert difference(found.rates(1), 2 * exact[1]) < 1e-10


def test_a_screw() -> None:
    """A cylindrical joint whose translation is coupled to its rotation falls as m + I/p^2 does."""
    pitch, moment = 0.2, 0.3
    nut = dynamics.RigidBody(2.0, (0.4, 0.4, moment))
    joint = kinematics.Cylindrical("base", "nut", CGA.line((0, 0, 0), (0, 0, 1)))
    system = dynamics.System({"nut": nut}, [joint], couplings=[{(0, 0): pitch, (0, 1): -1.0}])
    found = dynamics.Simulation(system, [DOWN]).run(1.0, times=[0.5, 1.0])
    fall = -9.81 * 2.0 / (2.0 + moment / pitch**2) * found.time**2 / 2
    assert difference(found.coordinates(0)[:, 0], fall) < 1e-11
    assert difference(found.coordinates(0)[:, 1], fall / pitch) < 1e-10


def test_what_loops_refuse() -> None:
    system = four_bars(1)
    load = dynamics.JointDamper(3, 0.1)
    with pytest.raises(InputError, match="closes a loop, which is cut there"):
        dynamics.Simulation(system, [load])
    still = {n: dynamics.RigidBody(b.mass, b.moments, orientation=b.motor) for n, b in system.bodies.items()}
    still["rod0"] = system.bodies["rod0"]
    apart = dynamics.System(still, system.joints)
    with pytest.raises(InputError, match="velocities at the start"):
        dynamics.Simulation(apart, [DOWN], coordinates="joint")
    circles = [CGA.circle((1, 0, 1), axis, 0.2) for axis in ((1, 0, 0), (0, 1, 0))]
    cross = kinematics.Universal("bar0", "rod1", *circles)
    with pytest.raises(InputError, match=r"Universal\('bar0', 'rod1'\) closes a loop"):
        dynamics.Simulation(dynamics.System(system.bodies, [*system.joints[:3], cross]), coordinates="joint")
    with pytest.raises(InputError, match="more than two joints"):
        triple = {(0, 0): 1.0, (1, 0): 1.0, (2, 0): 1.0}
        dynamics.Simulation(dynamics.System(system.bodies, system.joints, couplings=[triple]))
