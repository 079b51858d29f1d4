"""Delta robots where there is no answer, or none that is unique: stretched arms, flat forearms, bad lengths."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.codegen.errors import InputError, ShapeError, SingularError
from bladesmith.codegen.formulas.delta import delta as formulas
from bladesmith.codegen.formulas.products.double_double import Steps
from bladesmith.codegen.rings.double_double import DoubledRing
from bladesmith.codegen.rings.protocol import NumericRing
from bladesmith.kinematics.delta.robot import DeltaRobot

from ...oracles.delta_robots import MP, USUAL, as_floats, differences, exact, forward_exact, inverse_exact

pytestmark = pytest.mark.filterwarnings("error")

EPS = float(np.finfo(float).eps)


def test_unreachable_poses_name_their_arm():
    y = [[0.1, 0.0, 0.9], [0.3, 1.3, 0.4], [0, 0, 5.0], [np.nan, 0, 1], [0.0, 0.0, 0.1]]
    theta, status = USUAL.inverse(y, status=True)
    codes = bs.Status
    assert list(status) == [codes.OK, codes.UNREACHABLE, codes.UNREACHABLE, codes.INVALID, codes.UNREACHABLE]
    assert np.isnan(theta[1:]).all() and np.isfinite(theta[0]).all()
    arms = USUAL.arm_status(y)
    for i, place in enumerate(y[:3]):
        expected = [angle is None for angle in inverse_exact(USUAL, place)]
        assert list(arms[i] == codes.UNREACHABLE) == expected
    assert (arms[3] == codes.INVALID).all()
    with pytest.raises(SingularError, match=r"item 1 is UNREACHABLE, arms? [123]"):
        USUAL.inverse(y, strict=True)
    with pytest.raises(SingularError, match=r"forward: item 1 is UNREACHABLE"):
        DeltaRobot(3, 1, 2, 1.5).forward([[2.0, 2.0, 2.0], [0.0, 0.0, 0.0]], strict=True)
    with pytest.raises(SingularError, match="it is INVALID"):
        USUAL.inverse([np.inf, 0, 0], strict=True)


def test_what_is_reached_is_what_triangles_say():
    """Random positions about the boundary: reached exactly where 50 digits find all three triangles."""
    rng = np.random.default_rng(11)
    y = rng.uniform([-1.6, -1.6, -1.6], [1.6, 1.6, 1.6], (400, 3))
    arms = USUAL.arm_status(y) == bs.Status.OK
    truth = np.array([[angle is not None for angle in inverse_exact(USUAL, place)] for place in y])
    assert (arms == truth).all() and 0.1 < truth.mean() < 0.9
    assert (np.isfinite(USUAL.inverse(y)).all(-1) == truth.all(-1)).all()


def stretched(robot, gap):
    """A position at which arm 1 is a relative ``gap`` short of being stretched, the others at ease."""
    reach = robot.base_radius - robot.effector_radius
    arm = (robot.upper_arm + robot.forearm) * (1 - gap)
    return np.array([reach - arm * np.sin(0.5), 0.0, arm * np.cos(0.5)])


def test_stretched_arms():
    """Within rounding of the boundary there is an angle; the Jacobian is singular, and the forearm's way is lost."""
    y = stretched(USUAL, 0.0)
    for step in (-2e-15, 0.0, 1e-15):
        theta, status = USUAL.inverse(y * (1 + step), status=True)
        assert status == bs.Status.OK and abs(theta[0] - (np.pi / 2 + 0.5)) < 2e-7
    assert USUAL.inverse(y * (1 + 1e-12), status=True)[1] == bs.Status.UNREACHABLE
    jacobian, status = USUAL.inverse_jacobian(y * (1 + 1e-15), status=True)
    assert status == bs.Status.SINGULAR and np.isnan(jacobian).all()
    with pytest.raises(SingularError, match=r"arm 1 is stretched or folded, .* along \(-0.479, 0, 0.878\)"):
        USUAL.inverse_jacobian(y * (1 + 1e-15), strict=True)
    near = USUAL.singularity_at(stretched(USUAL, 1e-10))
    assert abs(near.sines[0]) < 1e-4 and np.abs(near.sines[1:]).min() > 0.1
    direction = np.array([-np.sin(0.5), 0, np.cos(0.5)])
    assert np.allclose(near.lost_direction, direction, atol=1e-4)
    assert USUAL.arm_status(y + 1e-6 * near.lost_direction)[0] == bs.Status.UNREACHABLE
    assert (USUAL.arm_status(y - 1e-6 * near.lost_direction) == bs.Status.OK).all()


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_inverse_jacobians_near_stretched_arms(gap):
    """The root that nearly vanishes has all its digits: 1e-14 at any condition; without them it would be 1e-16/gap."""
    y = stretched(USUAL, gap)
    truth = differences(lambda x: inverse_exact(USUAL, x), exact(y), MP.mpf(10) ** -18)
    assert np.linalg.cond(truth) > 0.4 / np.sqrt(gap)
    found = {method: USUAL.inverse_jacobian(y, method) for method in ("direct", "screw")}
    assert np.abs(found["direct"] - truth).max() < 1e-14 * np.abs(truth).max()
    assert np.abs(found["screw"] - truth).max() < 20 * EPS / np.sqrt(gap) * np.abs(truth).max()
    angles = as_floats(inverse_exact(USUAL, exact(y)))
    assert np.abs(USUAL.inverse(y, precise=True) - angles).max() < 1e-15
    assert np.abs(USUAL.inverse(y) - angles).max() < 20 * EPS / np.sqrt(gap)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_forward_jacobians_near_flat_forearms(gap):
    """The same where the forearms come to lie in one plane."""
    robot, tilt = DeltaRobot(0.65, 0.1, 0.5, 1.0), np.array([0.02, -0.03, 0.01])
    low, high = 0.0, 1.5  # with all motors turned by less the forearms do not meet
    for _ in range(60):
        middle = (low + high) / 2
        reached = forward_exact(robot, exact(tilt + middle)) is not None
        low, high = (low, middle) if reached else (middle, high)
    theta = tilt + high + gap
    truth = differences(lambda x: forward_exact(robot, x), exact(theta), MP.mpf(10) ** -18)
    assert np.linalg.cond(truth) > 0.4 / np.sqrt(gap)
    found = {method: robot.forward_jacobian(theta, method) for method in ("direct", "screw")}
    assert np.abs(found["direct"] - truth).max() < 2e-14 * np.abs(truth).max()
    assert np.abs(found["screw"] - truth).max() < 20 * EPS / np.sqrt(gap) * np.abs(truth).max()
    place = as_floats(forward_exact(robot, exact(theta)))
    assert np.abs(robot.forward(theta, precise=True) - place).max() < 1e-15
    assert np.abs(robot.forward(theta) - place).max() < 20 * EPS / np.sqrt(gap)


def test_twice_the_digits():
    """Sums, products, sines of the ring that roots are made on: 30 digits of sums and products, 18 of sines."""
    base = NumericRing(np.dtype(np.float64))
    ring = DoubledRing(base, Steps(base, cga))
    rng = np.random.default_rng(21)
    a, b, c, angle = (rng.uniform(-3.2, 3.2, 50) for _ in range(4))
    doubles = [(x, None) for x in (a, b, c)]
    found = ring.multiply(ring.multiply(doubles[0], doubles[1]), ring.constant(formulas.SINE))
    found = ring.combine([(found, 1), (ring.multiply(doubles[2], doubles[2]), -2)])
    sines = {name: ring.apply(name, (angle, None)) for name in ("sin", "cos")}
    for i in range(50):
        x, y, z, t = (MP.mpf(float(v[i])) for v in (a, b, c, angle))
        truth = x * y * MP.sqrt(3) / 2 - 2 * z * z
        assert abs(sum(MP.mpf(float(part[i])) for part in found) - truth) < 1e-30
        for name, value in sines.items():
            assert abs(sum(MP.mpf(float(part[i])) for part in value) - getattr(MP, name)(t)) < 4e-19
    far = ring.apply("sin", (np.array([100.0]), None))
    assert far[0] == np.sin(100.0) and far[1] == 0
    with pytest.raises(NotImplementedError):
        ring.apply("log", (a, None))


def test_flat_forearms_leave_the_platform_free():
    """Centres of the spheres as far from their middle as the forearm: the platform is in their plane."""
    robot = DeltaRobot(0.6, 0.1, 0.5, 1.0)  # at angle 0 the elbows are 1 from the axis
    y, status = robot.forward(np.zeros(3), status=True)
    assert status == bs.Status.OK and np.abs(y).max() < 1e-7
    near = robot.singularity(np.full(3, 1e-9))
    assert abs(near.volume) < 1e-3 and near.hold < 1e-3 and abs(abs(near.free[2]) - 1) < 1e-9
    _, status = robot.forward_jacobian(np.zeros(3), status=True)
    assert status in (bs.Status.SINGULAR, bs.Status.OK)
    assert robot.forward(np.full(3, -0.1), status=True)[1] == bs.Status.OK
    beyond = DeltaRobot(0.7, 0.1, 0.5, 1.0)
    assert beyond.forward(np.zeros(3), status=True)[1] == bs.Status.UNREACHABLE


def test_coinciding_elbows_are_singular():
    """Equal radii, arms straight down: all three spheres are one."""
    robot = DeltaRobot(0.2, 0.2, 0.5, 1.0)
    for theta in ([np.pi / 2] * 3, [np.pi / 2, np.pi / 2, 0.3]):
        y, status = robot.forward(theta, status=True)
        assert status == bs.Status.SINGULAR and np.isnan(y).all()
        assert robot.forward_jacobian(theta, status=True)[1] == bs.Status.SINGULAR
        assert robot.forward_jacobian(theta, "screw", status=True)[1] == bs.Status.SINGULAR
        with pytest.raises(SingularError, match="forearms start at one point"):
            robot.forward_jacobian(theta, strict=True)


def test_a_wrist_on_its_motors_axis_is_singular():
    robot = DeltaRobot(0.3, 0.3, 0.8, 1.0)
    y = np.array([0.0, 0.6, 0.0])  # the first wrist is on its axis, 0.6 along it: 0.8^2 + 0.6^2 = 1
    assert robot.arm_status(y)[0] == bs.Status.SINGULAR
    with pytest.raises(SingularError, match="SINGULAR"):
        DeltaRobot(0.3, 0.3, 1.0, 1.0).inverse([0.0, 0.0, 0.0], strict=True)


@pytest.mark.parametrize(
    ("lengths", "words"),
    [
        ((0, 0.1, 0.5, 1), "base_radius"),
        ((0.4, -0.1, 0.5, 1), "effector_radius"),
        ((0.4, 0.1, np.nan, 1), "upper_arm"),
        ((0.4, 0.1, 0.5, np.inf), "forearm"),
        ((0.4, 0.1, "long", 1), "upper_arm"),
        ((3.0, 0.1, 0.5, 1), "apart everywhere"),
    ],
)
def test_bad_lengths(lengths, words):
    with pytest.raises(InputError, match=words):
        DeltaRobot(*lengths)


def test_bad_arguments():
    with pytest.raises(ShapeError, match="length|3. is needed"):
        USUAL.inverse([1.0, 2.0])
    with pytest.raises(ShapeError):
        USUAL.forward(1.0)
    with pytest.raises(InputError, match="outer"):
        USUAL.inverse([0, 0, 1], elbow="outre")
    with pytest.raises(InputError, match="three of them"):
        USUAL.inverse([0, 0, 1], elbow=("outer", "inner"))
    with pytest.raises(InputError, match="far"):
        USUAL.forward([0, 0, 0], root="fare")
    with pytest.raises(InputError, match="direct"):
        USUAL.forward_jacobian([0, 0, 0], method="directly")
    with pytest.raises(InputError, match="strict"):
        USUAL.inverse([0, 0, 1], strict="yes")
    with pytest.raises(InputError):
        USUAL.inverse(["a", "b", "c"])
