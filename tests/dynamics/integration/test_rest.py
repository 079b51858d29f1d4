"""Systems that begin at rest, of which some parts stay there: the adaptive integrator with its default tolerances."""

from __future__ import annotations

from importlib import util
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith.errors import SimulationError

G = 9.81
GRAVITY = dynamics.Gravity((0, 0, -G))
LENGTH, MASS = 1.0, 1.0
#: Turns of a robot's joints beside Pinocchio's and SciPy's.
BAR = 1e-9


def rod(start, end, mass=MASS):
    """A thin rod between two points."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    way = (end - start) / np.linalg.norm(end - start)
    across = np.cross(way, [0.0, 1.0, 0.0]) if abs(way[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    axes = np.stack([across, np.cross(way, across), way], 1)
    moment = mass * np.dot(end - start, end - start) / 12
    return dynamics.RigidBody(mass, [moment, moment, moment / 100], (start + end) / 2, axes)


def hinge(a, b, place, axis):
    return kinematics.Revolute(a, b, cga.circle(place, axis, 0.3))


def two_rods(start=0.0):
    """The first turns about the vertical, where nothing moves it; the second falls below its end."""
    end = np.array([1 + np.cos(start), 0, -np.sin(start)])
    bodies = {"first": rod((0, 0, 0), (1, 0, 0)), "second": rod((1, 0, 0), end)}
    joints = [hinge("base", "first", (0, 0, 0), (0, 0, 1)), hinge("first", "second", (1, 0, 0), (0, 1, 0))]
    return dynamics.System(bodies, joints)


def pendulum(time, start=0.0):
    """Angle below the horizon of a rod about its end."""

    def rates(t, y):
        return [y[1], 1.5 * G / LENGTH * np.cos(y[0])]

    return solve_ivp(rates, (0, time), [start, 0], method="DOP853", rtol=1e-13, atol=1e-13).y[0, -1]


@pytest.mark.parametrize("integrator", ["adaptive", "auto"])
@pytest.mark.parametrize("start", [0.0, 0.3])
def test_two_rods(start, integrator) -> None:
    found = dynamics.Simulation(two_rods(start), [GRAVITY], integrator=integrator).run(1.5, times=[0.5, 1.5])
    for i, time in ((1, 0.5), (2, 1.5)):
        angle = pendulum(time, start)
        expected = [1 + np.cos(angle) / 2, 0, -np.sin(angle) / 2]
        assert np.abs(found.bodies["second"].position[i] - expected).max() < 1e-10
        assert np.abs(found.bodies["first"].position[i] - [0.5, 0, 0]).max() < 1e-12
    assert found._run.steps[0] < 200


def test_what_hangs_still() -> None:
    """A body on two oblique springs: its weight is balanced but for rounding."""
    mass, stiffness = 3.0, 137.0
    length = np.sqrt(2) - mass * G / (np.sqrt(2) * stiffness)
    springs = [dynamics.Spring((0, 0, 0), (x, 0, 1), stiffness, length) for x in (-1, 1)]
    body = dynamics.RigidBody(mass, (0.1, 0.2, 0.25))
    found = dynamics.Simulation(body, [*springs, GRAVITY], integrator="adaptive").run(2.0, times=[2.0])
    assert np.abs(found.position).max() < 1e-12 and found._run.steps[0] < 1000


ROBOT = """<robot name="stacked">
  <link name="base"/>
  <joint name="turret" type="continuous">
    <parent link="base"/> <child link="post"/> <origin xyz="0 0 0.2"/> <axis xyz="0 0 1"/>
  </joint>
  <link name="post">
    <inertial> <origin xyz="0 0 0.15"/> <mass value="4.0"/>
      <inertia ixx="0.05" iyy="0.05" izz="0.02" ixy="0" ixz="0" iyz="0"/> </inertial>
  </link>
  <joint name="shoulder" type="continuous">
    <parent link="post"/> <child link="upper"/> <origin xyz="0 0 0.3"/> <axis xyz="0 1 0"/>
  </joint>
  <link name="upper">
    <inertial> <origin xyz="0.25 0 0"/> <mass value="2.0"/>
      <inertia ixx="0.002" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/> </inertial>
  </link>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="lower"/> <origin xyz="0.5 0 0"/> <axis xyz="0 1 0"/>
  </joint>
  <link name="lower">
    <inertial> <origin xyz="0.2 0 0"/> <mass value="1.0"/>
      <inertia ixx="0.001" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/> </inertial>
  </link>
  <joint name="wrist" type="continuous">
    <parent link="lower"/> <child link="hand"/> <origin xyz="0.4 0 0"/> <axis xyz="1 0 0"/>
  </joint>
  <link name="hand">
    <inertial> <origin xyz="0.05 0 0"/> <mass value="0.02"/>
      <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/> </inertial>
  </link>
</robot>
"""


def arm(time):
    """Angles below the horizon of the upper and the lower arm, by Lagrange's equations of two links in a plane."""
    hand, lower, far = 0.02, 1.0, 0.45
    mass, inertia = np.array([2.0, lower + hand]), np.array([0.05, 0.0])
    place = np.array([0.25, (lower * 0.2 + hand * far) / (lower + hand)])
    inertia[1] = 0.02 + 1e-6 + lower * (0.2 - place[1]) ** 2 + hand * (far - place[1]) ** 2
    length = 0.5

    def rates(t, y):
        a, b, u, v = y
        couple = mass[1] * length * place[1]
        matrix = [[inertia[0] + mass[0] * place[0] ** 2 + mass[1] * length**2, couple * np.cos(a - b)],
                  [couple * np.cos(a - b), inertia[1] + mass[1] * place[1] ** 2]]  # fmt: skip
        forces = [G * (mass[0] * place[0] + mass[1] * length) * np.cos(a) - couple * np.sin(a - b) * v * v,
                  G * mass[1] * place[1] * np.cos(b) + couple * np.sin(a - b) * u * u]  # fmt: skip
        return [u, v, *np.linalg.solve(matrix, forces)]

    return solve_ivp(rates, (0, time), np.zeros(4), method="DOP853", rtol=1e-13, atol=1e-13).y[:2, -1], place[1]


def test_a_robot_from_rest(tmp_path) -> None:
    """Its turret and its wrist stay where they are, at rest but for rounding."""
    (tmp_path / "robot.urdf").write_text(ROBOT)
    system = kinematics.load_urdf(tmp_path / "robot.urdf").system()
    found = dynamics.Simulation(system, [GRAVITY], integrator="adaptive").run(1.0, times=[1.0])
    (a, b), _ = arm(1.0)
    upper = np.array([0.25 * np.cos(a), 0, 0.5 - 0.25 * np.sin(a)])
    lower = np.array([0.5 * np.cos(a) + 0.2 * np.cos(b), 0, 0.5 - 0.5 * np.sin(a) - 0.2 * np.sin(b)])
    for name, expected in (("upper", upper), ("lower", lower), ("post", [0, 0, 0.35])):
        assert np.abs(found.bodies[name].position[-1] - expected).max() < BAR
    assert found._run.steps[0] < 300


ROBOTS = {
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "a1": "a1_description/urdf/a1.urdf",
}


def robot_folder() -> Path | None:
    """Where example-robot-data puts its files; None where it or Pinocchio is not installed."""
    found = util.find_spec("pinocchio")
    if found is None or found.origin is None:
        return None
    folder = Path(found.origin).parents[4] / "share" / "example-robot-data" / "robots"
    return folder if folder.is_dir() else None


#: Packages of the `benchmark` extra are tested with where they are installed.
FOLDER = robot_folder()


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_robots_of_their_makers_from_rest(name) -> None:
    """Half a second of falling from rest, with the settings that a newcomer has, beside Pinocchio with DOP853."""
    assert FOLDER is not None
    path = FOLDER / ROBOTS[name]
    import pinocchio as pin

    robot = kinematics.load_urdf(path)
    found = dynamics.Simulation(robot.system(), [GRAVITY]).run(0.5, times=[0.25, 0.5])
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear[:] = (0, 0, -G)
    data, none = model.createData(), np.zeros(model.nv)

    def placed(angles):
        return pin.integrate(model, pin.neutral(model), angles)  # all joints have one coordinate

    def rates(t, y):
        q, v = y[: model.nv], y[model.nv :]
        return np.concatenate([v, pin.aba(model, data, placed(q), v, none)])

    truth = solve_ivp(rates, (0, 0.5), np.zeros(2 * model.nv), "DOP853", [0.25, 0.5], rtol=1e-13, atol=1e-15)
    for i in range(2):
        pin.framesForwardKinematics(model, data, placed(truth.y[: model.nv, i]))
        for link, body in found.bodies.items():
            frame = data.oMf[model.getFrameId(link)].homogeneous @ robot.lumps[link].inertia.origin
            assert np.abs(body.position[i + 1] - frame[:3, 3]).max() < BAR
    assert found._run.steps[0] < 1000


test_robots_of_their_makers_from_rest.__test__ = FOLDER is not None  # type: ignore[attr-defined]


@pytest.mark.slow
def test_a_run_without_end_says_so() -> None:
    """A push that jumps a thousand million times a second: each step ends at a jump."""
    rng = np.random.default_rng(0)
    noise = rng.normal(size=4096)

    def push(t):
        return dynamics.wrench([noise[int(t * 1e9) % 4096], 0, 0])

    body = dynamics.RigidBody(1.0, (0.1, 0.2, 0.25))
    simulation = dynamics.Simulation(body, [dynamics.WorldWrench(push)], integrator="adaptive")
    with pytest.raises(SimulationError, match="so small that the run would not end") as caught:
        simulation.run(1.0, times=[1.0], atol=1e-13, strict=True)
    assert "at time" in str(caught.value) and caught.value.trajectory.time[0] == 0
    assert caught.value.trajectory.ending == "stalled"
