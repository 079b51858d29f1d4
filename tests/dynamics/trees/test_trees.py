"""Trees of joints in coordinates of the joints: against Lagrange, poses under constraints, Pinocchio."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.dynamics.integration.program import tree_loops
from bladesmith.errors import InputError

from ...oracles.motions.double_pendulum import HALF, MASS, MOMENT, double_pendulum
from ...support import cuda
from ...support.build.numba_code import numba_text_as_python
from ...support.effort import FULL
from ...support.mechanisms.robots import needs_robots, real_robots

CGA, PGA = bs.cga3d, bs.pga3d
DOWN = dynamics.Gravity((0.0, 0.0, -9.81))
ASKEW = dynamics.Gravity((1.0, -0.5, -9.81))
#: Angular velocity with which all bodies turn about the world's origin at the start.
SPIN = np.array([0.5, -0.7, 0.9])


def chain(n: int, algebra: Any = CGA) -> dynamics.System:
    """Hinged rods that hang below each other, axes in turn along x and y."""
    bodies, joints = {}, []
    for i in range(n):
        bodies[f"b{i}"] = dynamics.RigidBody(1.0, (0.1, 0.11, 0.02), (0, 0, -(i + 0.5)), algebra=algebra)
        axis, top = ((1, 0, 0) if i % 2 else (0, 1, 0)), (0, 0, -i)
        hinge = algebra.line(top, axis), algebra.point(top)
        joints.append(kinematics.Revolute(f"b{i - 1}" if i else "base", f"b{i}", *hinge))
    return dynamics.System(bodies, joints, joint_names=[f"j{i}" for i in range(n)])


def mixed(algebra: Any = CGA, spin: Any = SPIN, holds: bool = True) -> dynamics.System:
    """A tree with every kind of joint, bodies on either side; without ``holds`` nothing holds it to the world."""
    k, rng = kinematics, np.random.default_rng(3)
    positions = {
        "a": (0, 0, -0.5), "b": (0.3, 0, -1.5), "c": (0, 0.2, -2.5), "d": (1, 0, -0.5), "e": (1.5, 0.3, -1),
        "f": (2, 0.2, -1.2), "g": (0, 1, -1), "h": (0.4, 1.2, -1),
    }  # fmt: skip
    bodies = {
        name: dynamics.RigidBody(
            1 + rng.random(), (0.1, 0.12, 0.05), x, velocity=np.cross(spin, x), angular_velocity=spin, algebra=algebra
        )
        for name, x in positions.items()
    }
    joints = {
        "ball": k.Spherical("base", "a", algebra.point((0, 0, 0))),
        "hinge": k.Revolute("b", "a", algebra.line((0, 0, -1), (0, 1, 0.2)), algebra.point((0, 0, -1))),
        "cylinder": k.Cylindrical("a", "d", algebra.line((0.5, 0, -0.5), (1, 1, 0))),
        "plane": k.Planar("e", "d", algebra.plane((0, 0.6, 0.8), -0.8)),
        "weld": k.Rigid("e", "f", (1.8, 0.2, -1.1), algebra),
        "other ball": k.Spherical("g", "a", algebra.point((0, 0.5, -0.7))),
        "slide": k.Prismatic("g", "h", algebra.line((0.2, 1, -1), (0.3, 1, 0)), algebra.direction((0, 0, 1))),
    }
    if algebra is CGA:
        circles = [algebra.circle((0.1, 0, -2), axis, 0.2) for axis in ((1, 0, 0), (0, 1, 0))]
        joints["cross"] = k.Universal("b", "c", *circles)
    else:
        joints["cross"] = k.Spherical("b", "c", algebra.point((0.1, 0, -2)))
    if not holds:
        del joints["ball"]
    return dynamics.System(bodies, list(joints.values()), joint_names=list(joints))


def loads(algebra: Any = CGA) -> list[dynamics.Load]:
    """All loads that are constant or laws."""
    wrench = dynamics.wrench((0.3, 0.2, 0.5), (0.1, 0, 0.2), algebra=algebra)
    return [
        ASKEW, dynamics.WorldWrench(wrench, "c"), dynamics.BodyWrench(wrench, "e"), dynamics.Damper(0.1, 0.2, "b"),
        dynamics.QuadraticDrag(0.1, 0.1, "d"), dynamics.Spring((0, 0, 0.1), (3, 0, 0), 20.0, 0.5, 0.3, "f"),
        dynamics.Spring((0, 0, 0.1), (0.1, 0, 0), 20.0, 0.5, 0.3, "f", "c"),
    ]  # fmt: skip


def difference(one: Any, other: Any) -> float:
    return float(np.abs(getattr(one, "values", one) - getattr(other, "values", other)).max(initial=0))


def test_double_pendulum() -> None:
    """Two rods in a plane: angles, speeds and the force of the upper hinge by Lagrange's equations."""
    bodies = {
        name: dynamics.RigidBody(m, (0.3, i, 0.3), (0, 0, -0.5 - k))
        for k, (name, m, i) in enumerate(zip("ab", MASS, MOMENT, strict=True))
    }
    hinges = [(CGA.line((0, 0, -k), (0, 1, 0)), CGA.point((0, 0, -k))) for k in range(2)]
    joints = [kinematics.Revolute("base", "a", *hinges[0]), kinematics.Revolute("b", "a", *hinges[1])]
    gravity = np.array([6.0, 0.0, -9.81])
    times = np.linspace(0, 1.5, 16)
    found = dynamics.Simulation(dynamics.System(bodies, joints), [dynamics.Gravity(gravity)]).run(1.5, times=times)
    rates = double_pendulum(gravity)
    exact = solve_ivp(rates, (0, 1.5), np.zeros(4), method="DOP853", rtol=3e-14, atol=1e-14, t_eval=times).y
    assert difference(found.coordinates(0), exact[0]) < 1e-11
    assert difference(found.coordinates(joints[1]), exact[0] - exact[1]) < 1e-11  # of the first body against the second
    assert difference(found.rates(1), exact[2] - exact[3]) < 1e-10
    assert found.violation.max() == 0.0 and np.ptp(found.energy) < 1e-11
    accelerations = np.array([rates(0.0, y)[2:] for y in exact.T]).T
    force = np.zeros((len(times), 3))
    for k in range(2):  # of the hinge on both: masses times accelerations, less their weights
        for j in range(k + 1):
            reach = HALF if j == k else 1.0
            p, w, a = exact[j], exact[2 + j], accelerations[j]
            force[:, 0] += MASS[k] * reach * (-np.cos(p) * a + np.sin(p) * w**2)
            force[:, 2] += MASS[k] * reach * (np.sin(p) * a + np.cos(p) * w**2)
        force -= MASS[k] * gravity
    own = dynamics.wrench_parts(found.reactions(0))[0]
    assert difference(own, force) < 1e-9 * np.abs(force).max()


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", [CGA, PGA], ids=["cga", "pga"])
@pytest.mark.parametrize("holds", [True, False])
def test_every_joint_and_load_beside_constraints(algebra: Any, holds: bool) -> None:
    system, acting, times = mixed(algebra, holds=holds), loads(algebra), np.linspace(0, 1, 6)
    found = dynamics.Simulation(system, acting, coordinates="joint").run(1.0, times=times)
    other = dynamics.Simulation(system, acting, coordinates="maximal", integrator="adaptive").run(1.0, times=times)
    assert found.converged and other.converged
    for name in system.bodies:
        one, two = found[name], other[name]
        assert difference(one.position, two.position) < 1e-10
        assert difference(one.orientation, two.orientation) < 1e-10
        assert difference(one.velocity, two.velocity) < 1e-9
        assert difference(one.momentum, two.momentum) < 1e-9
        assert difference(one.reaction, two.reaction) < 1e-8
    for name in system.joint_names:
        assert found.coordinates(name).shape == other.coordinates(name).shape
        assert difference(found.coordinates(name), other.coordinates(name)) < 1e-10
        assert difference(found.rates(name), other.rates(name)) < 1e-9
        assert difference(found.reactions(name), other.reactions(name)) < 1e-8
    assert difference(found.energy, other.energy) < 1e-9


def test_nothing_holds_it() -> None:
    """Joined bodies in free fall: momentum, and their center of mass."""
    found = dynamics.Simulation(mixed(spin=8 * SPIN, holds=False), [ASKEW]).run(1.0, times=np.linspace(0, 1, 6))
    bodies = found.bodies.values()
    mass = sum(float(b._rigid_body.mass) for b in bodies)
    center = sum(b._rigid_body.mass * b.position for b in bodies) / mass
    fall = np.outer(found.time**2 / 2, ASKEW.acceleration)
    drift = np.outer(found.time, np.cross(8 * SPIN, center[0]))
    assert difference(center, center[0] + drift + fall) < 1e-12
    parts = [dynamics.wrench_parts(b.momentum) for b in bodies]
    linear, angular = (sum(part[i] for part in parts) for i in (0, 1))
    t = found.time[:, None]
    path = center[0] * t + np.cross(8 * SPIN, center[0]) * t**2 / 2 + ASKEW.acceleration * t**3 / 6
    assert difference(linear, linear[0] + mass * ASKEW.acceleration * t) < 1e-10
    assert difference(angular, angular[0] + np.cross(path, mass * ASKEW.acceleration)) < 1e-9
    assert np.ptp(found.energy) < 1e-10 * np.abs(found.energy).max()


@pytest.mark.parametrize("speed", [0.5, 300.0])
def test_balls_turn_all_the_way(speed: float) -> None:
    """A top whose tip is a ball of one hundred turns: beside the same body with a pin."""
    spin = np.array([0.3, 0.0, speed])
    center = np.array([0.0, 0.6, 0.8])
    body = dynamics.RigidBody(1.0, (0.2, 0.2, 0.1), center, velocity=np.cross(spin, center), angular_velocity=spin)
    tip = kinematics.Spherical("base", "top", CGA.point((0, 0, 0)))
    found = dynamics.Simulation(dynamics.System({"top": body}, [tip]), [DOWN]).run(0.5, times=[0.1, 0.5])
    pinned = dynamics.Simulation(body, [DOWN], [dynamics.Pin(CGA.point(-center), CGA.point((0, 0, 0)))])
    exact = pinned.run(0.5, times=[0.1, 0.5])
    assert found.integrator == "adaptive" and difference(found["top"].position, exact.position) < 1e-10
    assert difference(found["top"].orientation, exact.orientation) < 1e-9
    assert difference(found.rates(tip), found["top"].angular_velocity) < 1e-12 * speed + 1e-12


def test_steps_of_order_four() -> None:
    """Halving the step of rk4 divides the error by 16, also where a ball is."""
    system = mixed()
    exact = dynamics.Simulation(system, [ASKEW]).run(0.3, times=[0.3])
    errors = []
    for step in (4e-3, 2e-3):
        found = dynamics.Simulation(system, [ASKEW], integrator="rk4", coordinates="joint").run(0.3, step, [0.3])
        errors.append(max(difference(found[n].position, exact[n].position) for n in system.bodies))
    assert found.steps == 150 and 14 < errors[0] / errors[1] < 18


def test_batches_have_the_bits_of_single_ones() -> None:
    masses = np.array([1.0, 2.0, 3.5])
    top, axis = CGA.point((0, 0, 0)), CGA.line((0, 0, 0), (0, 1, 0))

    def run(mass: Any, threads: int = 1, **options: Any) -> Any:
        body = dynamics.RigidBody(mass, (0.1, 0.2, 0.3), (0.5, 0, 0), velocity=(0, 0, -1), angular_velocity=(0, 2, 0))
        system = dynamics.System({"arm": body}, [kinematics.Revolute("base", "arm", axis, top)])
        return dynamics.Simulation(system, [DOWN]).run(0.5, times=[0.2, 0.5], threads=threads, **options)

    together = run(masses, threads=2)
    assert together["arm"].motor.shape == (3, 3) and together.coordinates(0).shape == (3, 3)
    for i, mass in enumerate(masses):
        single = run(mass)
        assert np.array_equal(together["arm"].motor[i].values, single["arm"].motor.values)
        assert np.array_equal(together["arm"].reaction[i].values, single["arm"].reaction.values)
    with ThreadPoolExecutor(2) as executor:
        elsewhere = run(masses, executor=executor)
    assert elsewhere.integrator == "adaptive" and elsewhere.message == ""
    for name in ("motors", "reactions", "coordinates", "steps", "reached", "violations"):
        assert np.array_equal(getattr(elsewhere._run, name), getattr(together._run, name))


@pytest.mark.slow
def test_the_time_of_a_step_grows_with_the_bodies() -> None:
    """Chains of 300 and of 3000 rods run; ten times the bodies take no more than twenty times as long."""
    seconds = []
    for n in (300, 3000):
        simulation = dynamics.Simulation(chain(n), [ASKEW], integrator="rk4", coordinates="joint")
        simulation.run(2e-3, times=[2e-3])
        begin = time.perf_counter()
        found = simulation.run(0.03, times=[0.03])
        seconds.append(time.perf_counter() - begin)
        assert found.converged and np.ptp(found.energy) < 1e-9 * n
    assert seconds[1] < 20 * seconds[0]


def test_what_is_no_tree() -> None:
    bodies = {n: dynamics.RigidBody(1.0, (0.1, 0.1, 0.1), x) for n, x in zip("abc", np.eye(3), strict=True)}
    joints = [kinematics.Bilinear("a", "b", CGA.point((0, 0, 0)), CGA.plane((1, 0, 0), 0.0), "inner")]
    with pytest.raises(InputError, match=r"Bilinear\('a', 'b'\) is no sequence of motions.*coordinates='auto'"):
        dynamics.Simulation(dynamics.System(bodies, joints), [DOWN], coordinates="joint")
    for options, reason in (
        ({"integrator": "midpoint"}, "'midpoint' moves bodies"),
        ({"map": "cayley"}, "map is of motions with constraints"),
        ({"constraints": [dynamics.Pin(CGA.point((0, 0, 0)), body="b1")]}, "constraints besides the joints"),
        ({"loads": [dynamics.WorldWrench(lambda t: dynamics.wrench((t, 0, 0), 0))]}, "a WorldWrench is a function"),
    ):
        with pytest.raises(InputError, match=reason):
            dynamics.Simulation(chain(2), coordinates="joint", **options)
    with pytest.raises(InputError, match="coordinates"):
        dynamics.Simulation(chain(2), coordinates="minimal")
    simulation = dynamics.Simulation(chain(2), [DOWN], coordinates="joint")
    with pytest.raises(InputError, match="sensitivities: these need poses"):
        simulation.run(0.1, sensitivities=["gravity"])
    found = simulation.run(0.01)
    for joint in ("j7", 2, joints[0], None):
        with pytest.raises(InputError):
            found.coordinates(joint)
    fast = dynamics.RigidBody(1.0, (1, 1, 1), velocity=(1, 0, 0))
    hinge = kinematics.Revolute("base", "a", CGA.line((0, 0, 0), (0, 1, 0)), CGA.point((0, 0, 0)))
    moved = dynamics.System({"a": fast}, [hinge])
    with pytest.raises(InputError, match="velocities at the start"):
        dynamics.Simulation(moved, coordinates="joint")


@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.parametrize("integrator", ["auto", "implicit"])
def test_text_for_numba_has_the_bits_of_c(integrator: str) -> None:
    tree_loops.cache_clear()
    with numba_text_as_python():
        assert_same_bits("numba", integrator, 0.02)
    tree_loops.cache_clear()


@pytest.mark.peers
@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.skipif(not FULL, reason="no full bars: half a minute for text that runs as Python above")
def test_numba_has_the_bits_of_c() -> None:
    pytest.importorskip("numba")
    assert_same_bits("numba", "auto")  # implicit steps have these bits too, after minutes of compilation


@pytest.mark.gpu
@pytest.mark.slow
@pytest.mark.compiles
@cuda.each_device
@pytest.mark.parametrize("integrator", ["auto", "implicit"])
def test_text_for_gpus_has_the_bits_of_c(where: str, integrator: str) -> None:
    with cuda.devices(where):
        tree_loops.cache_clear()
        assert_same_bits("cuda", integrator)
    tree_loops.cache_clear()


def assert_same_bits(target: str, integrator: str, end: float = 0.2) -> None:
    """Of every joint and load, a loop and a coupling."""
    ends, tree = [], mixed()
    joints = [*tree.joints, kinematics.Spherical("c", "h", CGA.point((0.3, 1, -2)))]
    system = dynamics.System(tree.bodies, joints, couplings=[{(1, 0): 1.0, (6, 0): -0.5}])
    for each in ("c", target):
        options = {"integrator": integrator, "coordinates": "joint", "target": each}
        run: Any = dynamics.Simulation(system, loads(), **options).run(end, times=[end / 2, end])._run
        assert run.violations.max() < 1e-10
        ends.append([run.motors, run.twists, run.reactions, run.coordinates, run.violations, run.steps, run.reached])
    assert all(x.tobytes() == y.tobytes() for x, y in zip(*ends, strict=True))


ROBOTS = real_robots()
SOME = ("ur/ur5_robot", "xarm/xarm7", "kinova/kinova", "solo/solo12", "a1/a1", "g1/g1_29dof_rev_1_0")


@pytest.mark.peers
@pytest.mark.slow
@needs_robots
@pytest.mark.parametrize("name", SOME)
def test_robots_fall_as_pinocchio_has_it(name: str) -> None:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromUrdf(str(ROBOTS[name]))
    memory, n, zero = model.createData(), model.nv, pin.neutral(model)

    def rates(_: float, y: Any) -> Any:
        q = pin.integrate(model, zero, y[:n])
        return np.concatenate([y[n:], pin.aba(model, memory, q, y[n:], np.zeros(n))])

    exact = solve_ivp(rates, (0, 0.2), np.zeros(2 * n), method="DOP853", rtol=3e-14, atol=1e-14).y[:, -1]
    robot = kinematics.load_urdf(ROBOTS[name])
    found = dynamics.Simulation(robot.system(), [DOWN]).run(0.2)
    assert found.integrator == "adaptive" and len(robot.joint_names) == n
    for joint in range(1, model.njoints):
        own, at = model.names[joint], model.idx_vs[joint]
        assert abs(found.coordinates(own)[-1] - exact[at]) < 1e-11
        assert abs(found.rates(own)[-1] - exact[n + at]) < 1e-9
