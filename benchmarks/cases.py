"""What `compare.py` times: a name, what it stands for, and a function that prepares a call; nothing but public names.

A case prepares its data when it is first asked for, so that one that a commit does not know fails alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Call = Callable[[], Any]


class Case(NamedTuple):
    """A call that is timed, of so many items."""

    says: str
    items: int
    prepare: Callable[[np.random.Generator], Call]


CASES: dict[str, Case] = {}


def case(says: str, items: int = 1) -> Callable[[Callable[[np.random.Generator], Call]], Callable[..., Call]]:
    """Register a case under the name of its function."""

    def register(prepare: Callable[[np.random.Generator], Call]) -> Callable[..., Call]:
        CASES[prepare.__name__] = Case(says, items, prepare)
        return prepare

    return register


@case("`R >> x`, one motor, one point of CGA")
def motor_on_point_once(random: np.random.Generator) -> Call:
    from bladesmith import cga3d as cga

    motor, x = cga.rotor((0, 0, 1), 0.3, point=(1, 0, 0)), cga.point(random.normal(size=3))
    return lambda: motor >> x


@case("`R >> x`, points of CGA in cache", 1000)
def motor_on_points(random: np.random.Generator) -> Call:
    from bladesmith import cga3d as cga

    motor, x = cga.rotor((0, 0, 1), 0.3, point=(1, 0, 0)), cga.point(random.normal(size=(1000, 3)))
    return lambda: motor >> x


@case("`R >> x`, points of PGA in memory", 1_000_000)
def motor_on_many_points(random: np.random.Generator) -> Call:
    from bladesmith import pga3d as pga

    motor, x = pga.rotor((0, 0, 1), 0.3, point=(1, 0, 0)), pga.point(random.normal(size=(1_000_000, 3)))
    return lambda: motor >> x


@case("dense product of CGA in cache", 1000)
def dense_product(random: np.random.Generator) -> Call:
    from bladesmith import cga3d as cga

    x, y = (cga.multivector(random.normal(size=(1000, 32))) for _ in range(2))
    return lambda: x * y


@case("exponential of twists of PGA", 10_000)
def exponential(random: np.random.Generator) -> Call:
    from bladesmith import poses

    twists = random.normal(size=(10_000, 6))
    return lambda: poses.exp(twists)


@case("logarithm of poses", 10_000)
def logarithm(random: np.random.Generator) -> Call:
    from bladesmith import poses

    moved = poses.exp(random.normal(size=(10_000, 6)))
    return lambda: poses.log(moved)


@case("rotor between two circles", 10_000)
def rotor_between(random: np.random.Generator) -> Call:
    from bladesmith import objects

    x, y = (_circles(random, 10_000) for _ in range(2))
    return lambda: objects.rotor_between(x, y)


@case("interpolation of two circles", 10_000)
def interpolation(random: np.random.Generator) -> Call:
    from bladesmith import objects

    x, y = (_circles(random, 10_000) for _ in range(2))
    return lambda: objects.interpolate(x, y, alpha=0.3)


@case("costs between lines, 300 by 300", 90_000)
def cost_matrix(random: np.random.Generator) -> Call:
    from bladesmith import cga3d as cga
    from bladesmith import objects

    x, y = (cga.line(random.normal(size=(300, 3)), random.normal(size=(300, 3))) for _ in range(2))
    return lambda: objects.cost_matrix(x, y, threads=1)


@case("first hits on a tube, 160 x 120 pixels", 19_200)
def first_hits(random: np.random.Generator) -> Call:
    scene, camera = _tube()
    origins, directions = camera.rays(160, 120)
    return lambda: scene.intersect(origins, directions, threads=1)


@case("picture of a tube with its shadow, 160 x 120", 19_200)
def picture(random: np.random.Generator) -> Call:
    scene, _ = _tube()
    return lambda: scene.render(160, 120, threads=1)


@case("registration of 20 lines")
def registration(random: np.random.Generator) -> Call:
    from bladesmith import poses, reform

    points, directions = random.uniform(-1, 1, (20, 3)), random.normal(size=(20, 3))
    pose = poses.exp(random.normal(size=6))
    moved = np.stack([poses.act(pose, points), poses.rotate(pose, directions)], axis=1)
    models = reform.Model(lines=np.stack([points, directions], axis=1)), reform.Model(lines=moved)
    return lambda: reform.register(*models, threads=1)


@case("a top on its tip, 0.2 s at 1e-9")
def simulation(random: np.random.Generator) -> Call:
    from bladesmith import cga3d as cga
    from bladesmith import dynamics

    top = dynamics.RigidBody(1.0, [0.1, 0.1, 0.02], (0, 0, 1), angular_velocity=(0.1, 0, 60.0), velocity=(0, -0.1, 0))
    held = dynamics.Simulation(top, dynamics.Gravity((0, 0, -9.81)), dynamics.Pin(cga.point((0, 0, -1.0))))
    return lambda: held.run(0.2, times=[0.1, 0.2])


@case("pose of an arm of six axes")
def arm_pose(random: np.random.Generator) -> Call:
    arm = _arm()
    q = random.normal(size=6)
    return lambda: arm.forward(q)


@case("inverse kinematics of an arm from near starts", 200)
def arm_inverse(random: np.random.Generator) -> Call:
    arm = _arm()
    q = random.uniform(-1, 1, size=(200, 6))
    wanted = arm.forward(q)
    return lambda: arm.inverse(wanted, start=q + 0.1, threads=1)


@case("torques of an arm", 1000)
def arm_torques(random: np.random.Generator) -> Call:
    arm = _arm()
    q, qd, qdd = random.normal(size=(3, 1000, 6))
    return lambda: arm.inverse_dynamics(q, qd, qdd, threads=1)


@case("poses of the Delta robot", 1000)
def delta(random: np.random.Generator) -> Call:
    from bladesmith import kinematics

    robot = kinematics.DeltaRobot(base_radius=0.4, effector_radius=0.15, upper_arm=0.6, forearm=1.2)
    angles = random.uniform(0.1, 0.6, size=(1000, 3))
    return lambda: robot.forward(angles)


def _circles(random: np.random.Generator, n: int) -> Any:
    from bladesmith import cga3d as cga

    return cga.circle(random.normal(size=(n, 3)), random.normal(size=(n, 3)), random.uniform(0.5, 2, n))


def _tube() -> Any:
    from bladesmith import tracer

    controls = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6)]
    camera = tracer.Camera.look_at((0, -8, 2), (0, 0, 1))
    floor = tracer.Plane((0, 0, 1), 0.0)
    return tracer.Scene(camera, [tracer.Light((4, -6, 8))], [tracer.EvolvedCircles(controls), floor]), camera


def _arm() -> Any:
    from bladesmith import kinematics

    return kinematics.load_urdf(kinematics.urdf_example("arm")).chain("flange")
