"""Workspace, motion, dynamics and pictures of Delta robots."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.errors import InputError, Interrupted, ShapeError, SingularError
from bladesmith.kinematics.delta import plots
from bladesmith.kinematics.delta.robot import DeltaRobot

from ...oracles.delta_robots import MP, USUAL, as_floats, inverse_exact

pytestmark = pytest.mark.filterwarnings("error")


def test_workers_sample_the_same_workspace(monkeypatch):
    monkeypatch.setattr("bladesmith.kinematics.delta.workspace.POSITIONS_PER_CALL", 100)
    here, reports = USUAL.workspace(points=(9, 8, 10)), []
    with ThreadPoolExecutor(2) as pool:
        there = USUAL.workspace(points=(9, 8, 10), executor=pool, progress=reports.append)
    for name in ("x", "reachable", "condition", "inverse", "forward", "arms"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert reports[-1].done == 720 and len(reports) == 7


def test_an_interrupt_keeps_the_samples_of_a_workspace(monkeypatch):
    def stop(progress):
        raise KeyboardInterrupt

    monkeypatch.setattr("bladesmith.kinematics.delta.workspace.CHUNK", 360)
    whole = USUAL.workspace(points=(9, 8, 10))
    with pytest.raises(Interrupted) as caught:
        USUAL.workspace(points=(9, 8, 10), progress=stop)
    part = caught.value.partial
    assert (part.arms.reshape(-1, 3)[360:] == bs.Status.INVALID).all() and not part.reachable.ravel()[360:].any()
    np.testing.assert_array_equal(part.condition.ravel()[:360], whole.condition.ravel()[:360])


@pytest.mark.slow
def test_workspace():
    space = USUAL.workspace(bounds=[(-1.2, 1.2), (-1.2, 1.2), (0.0, 1.5)], points=(9, 8, 10))
    assert space.reachable.shape == (9, 8, 10) and space.arms.shape == (9, 8, 10, 3)
    for place in np.ndindex(9, 8, 10):
        angles = inverse_exact(USUAL, space.positions[place])
        assert space.reachable[place] == all(a is not None for a in angles)
    known = space.reachable
    assert np.isnan(space.condition[~known]).all() and (space.condition[known] >= 1).all()
    place = tuple(np.argwhere(known)[len(np.argwhere(known)) // 2])
    jacobian = USUAL.inverse_jacobian(space.positions[place])
    assert space.condition[place] == pytest.approx(np.linalg.cond(jacobian))
    near = USUAL.singularity_at(space.positions[place])
    assert space.inverse[place] == np.abs(near.sines).min() and space.forward[place] == abs(near.volume)
    assert 0 < space.well(3.0).sum() < known.sum() and space.volume > 0
    with pytest.raises(InputError, match="box"):
        USUAL.workspace(bounds=[(1, 0), (0, 1), (0, 1)])
    with pytest.raises(InputError, match="points"):
        USUAL.workspace(points=0)


@pytest.mark.slow
def test_trajectory():
    """Angles, speeds and accelerations along a path, against derivatives at 50 digits."""

    def path(t):
        return np.array([0.2 * np.cos(3 * t), 0.3 * np.sin(2 * t), 0.9 + 0.1 * np.sin(t)])

    def rates(t):
        velocity = [-0.6 * np.sin(3 * t), 0.6 * np.cos(2 * t), 0.1 * np.cos(t)]
        return path(t), np.array(velocity), np.array([-1.8 * np.cos(3 * t), -1.2 * np.sin(2 * t), -0.1 * np.sin(t)])

    def precise(t):
        third, tenth = MP.mpf(0.2), MP.mpf(0.1)
        return [third * MP.cos(3 * t), MP.mpf(0.3) * MP.sin(2 * t), MP.mpf(0.9) + tenth * MP.sin(t)]

    times = np.linspace(0, 1, 301)
    exactly, derived = USUAL.trajectory(rates, times), USUAL.trajectory(path, times)
    sampled = USUAL.trajectory(np.array([path(t) for t in times]), times)
    assert exactly.is_possible
    h = MP.mpf(10) ** -12
    for i in (0, 100, 300):
        t = MP.mpf(float(times[i]))
        low, middle, high = (inverse_exact(USUAL, precise(t + k * h)) for k in (-1, 0, 1))
        speed = as_floats([(b - a) / (2 * h) for a, b in zip(low, high, strict=True)])
        acceleration = as_floats([(a - 2 * m + b) / h**2 for a, m, b in zip(low, middle, high, strict=True)])
        assert np.abs(exactly.theta[i] - as_floats(middle)).max() < 1e-14
        assert np.abs(exactly.speed[i] - speed).max() < 1e-13
        assert np.abs(exactly.angular_acceleration[i] - acceleration).max() < 1e-11
    assert np.abs(derived.speed - exactly.speed).max() < 1e-9
    assert np.abs(derived.angular_acceleration - exactly.angular_acceleration).max() < 1e-6
    assert np.abs(sampled.speed - exactly.speed).max() < 1e-7
    out = USUAL.trajectory(lambda t: (np.array([0, 0, 1.0 + t]), np.array([0, 0, 1.0]), np.zeros(3)), [0.0, 0.2, 3.0])
    assert list(out.status) == [0, 0, bs.Status.UNREACHABLE] and np.isnan(out.theta[2]).all() and not out.is_possible
    for bad in (np.zeros((3, 3)), lambda t: np.zeros(2), np.zeros((301, 2))):
        with pytest.raises((InputError, ShapeError)):
            USUAL.trajectory(bad, times)
    with pytest.raises(InputError, match="increasing"):
        USUAL.trajectory(path, [0.0, 0.0])


@pytest.mark.compiles
def test_the_robot_falls():
    """The system of bodies and joints at rest falls by its energy: straight along e3, where gravity points."""
    theta = np.full(3, 0.2)
    system = USUAL.system(theta, masses=(1.0, 0.3, 2.0))
    assert len(system.bodies) == 10 and len(system.joints) == 15
    found = dynamics.Simulation(system, [dynamics.Gravity((0, 0, 9.81))]).run(0.05, times=[0.0, 0.05])
    place, moved = found["platform"].position[-1], found["platform"].velocity[-1]
    assert np.abs(place[:2]).max() < 1e-9 and found.violation.max() < 1e-11
    angles = USUAL.inverse(place)
    assert np.ptp(angles) < 1e-9
    speeds = USUAL.inverse_jacobian(place) @ moved
    turn = found["upper_arm_1"].angular_velocity[-1]
    assert np.linalg.norm(turn) == pytest.approx(abs(speeds[0]), rel=1e-9)
    with pytest.raises(SingularError):
        DeltaRobot(3, 1, 2, 1.5).system(np.zeros(3))
    with pytest.raises(ShapeError, match="masses"):
        USUAL.system(theta, masses=(1.0, 2.0))


@pytest.mark.slow
def test_pictures(tmp_path):
    y = np.array([[0.1, 0.0, 0.9], [0.2, 0.1, 1.0], [9.0, 0.0, 0.0]])
    ax = USUAL.picture(y=y, path=tmp_path / "robot.png")
    low, high = ax.get_zlim3d()
    assert low > high and (tmp_path / "robot.png").stat().st_size > 10_000
    space = USUAL.workspace(points=15)
    figure = space.plot(tmp_path / "slices.png", across="z", at=[0.9])
    (mesh,) = figure.axes[0].collections
    shown = np.ma.filled(mesh.get_array(), np.nan).reshape(15, 15)
    number = int(np.abs(space.z - 0.9).argmin())
    expected = np.where(space.reachable, space.condition, np.nan)[:, :, number].T
    assert np.array_equal(shown, expected, equal_nan=True)
    motion = USUAL.trajectory(lambda t: np.array([0.1 * t, 0, 0.9]), np.linspace(0, 1, 20))
    assert len(motion.plot().axes) == 3 and repr(motion) == "<Motion: 20 times from 0 to 1, all possible>"
    with pytest.raises(InputError):
        plots.picture(USUAL)
    with pytest.raises(SingularError):
        plots.picture(USUAL, y=[0, 0, 50.0])
    with pytest.raises(InputError, match="show"):
        plots.slices(space, show="conditions")


def test_nothing_to_draw() -> None:
    with pytest.raises(SingularError, match="cannot take any of these poses"):
        USUAL.picture(np.empty((0, 3)))
    away = USUAL.trajectory(lambda t: np.array([9.0, 0, 0]), np.linspace(0, 1, 5))
    with pytest.raises(SingularError, match="at none of these times. Its status says why"):
        away.plot()
    there = USUAL.trajectory(lambda t: np.array([0, 0, 0.9]), np.linspace(0, 1, 5))
    for dpi in (0, np.nan, "x"):
        with pytest.raises(InputError, match="^dpi is"):
            there.plot(dpi=dpi)


@pytest.mark.slow
def test_a_delta_robot_is_a_mechanism_at_one_pose_that_it_has() -> None:
    robot = kinematics.DeltaRobot(0.4, 0.15, 0.6, 1.2)
    assert robot.mechanism([0.1, 0.2, 0.3]).mobility() == 9
    with pytest.raises(ShapeError, match="is needed"):
        robot.mechanism([[0.1, 0.2, 0.3]])
    with pytest.raises(SingularError, match="INVALID"):
        robot.mechanism([np.nan, 0.2, 0.3])
    with pytest.raises(SingularError, match="UNREACHABLE"):
        kinematics.DeltaRobot(0.4, 0.15, 1.2, 0.6).mechanism([1.5, -1.5, 3.0])
