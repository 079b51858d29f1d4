"""The Delta robot against 50-digit geometry, the thesis's own formulas, all fifteen joints, and brute force."""

import itertools
from concurrent.futures import ThreadPoolExecutor

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith.codegen.algebra.algebra import numbers, scalar_argument
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.errors import InputError, Interrupted, ShapeError, SingularError
from bladesmith.codegen.formulas.delta import delta as formulas
from bladesmith.codegen.formulas.products.double_double import Steps
from bladesmith.codegen.rings.double_double import DoubledRing
from bladesmith.codegen.rings.protocol import NumericRing
from bladesmith.kinematics.delta import plots
from bladesmith.kinematics.delta.robot import DeltaRobot

from ...oracles.sequences import dot

pytestmark = pytest.mark.filterwarnings("error")

MP = mpmath.mp.clone()
MP.dps = 50
EPS = float(np.finfo(float).eps)
#: Lengths: usual, equal radii, a negative reach, a long upper arm, a short one, a needle.
LENGTHS = [
    (0.4, 0.1, 0.5, 1.0),
    (0.2, 0.2, 0.4, 0.9),
    (0.1, 0.35, 0.6, 1.1),
    (0.4, 0.3, 1.5, 1.0),
    (0.3, 0.25, 0.02, 1.0),
    (0.3, 0.3 - 1e-3, 1.0, 5e-3),
]
USUAL = DeltaRobot(*LENGTHS[0])


# -- 50 digits, from distances alone ---------------------------------------------------------------------------


def exact(values):
    return [MP.mpf(float(v)) for v in values]


def frame(i):
    """s, s x e3 and e3 of arm i."""
    turn = 2 * MP.pi * i / 3
    return (
        [MP.cos(turn), MP.sin(turn), MP.mpf(0)],
        [MP.sin(turn), -MP.cos(turn), MP.mpf(0)],
        [MP.mpf(c) for c in (0, 0, 1)],
    )


def along(*parts):
    """Sum of weighted vectors."""
    return [sum(w * v[k] for w, v in parts) for k in range(3)]


def robot_lengths(robot):
    return exact((robot.base_radius, robot.effector_radius, robot.upper_arm, robot.forearm))


def reach_angle(robot, y, i, side):
    """Angle of arm i by the law of cosines in its plane; None where the sides close no triangle."""
    base, platform, upper, forearm = robot_lengths(robot)
    s, a, e3 = frame(i)
    u = along((1, y), (platform - base, s))
    x, z, across = dot(u, s), dot(u, e3), dot(u, a)
    p = MP.sqrt(x * x + z * z)
    cosine = (upper**2 + p**2 - (forearm**2 - across**2)) / (2 * upper * p)
    if abs(cosine) > 1 or abs(across) > forearm:
        return None
    angle = MP.atan2(z, x) - side * MP.acos(cosine)
    return angle - 2 * MP.pi * MP.ceil((angle - MP.pi) / (2 * MP.pi))


def inverse_exact(robot, y, sides=(1, 1, 1)):
    place = [MP.mpf(c) for c in y]
    return [reach_angle(robot, place, i, sides[i]) for i in range(3)]


def centers(robot, theta):
    base, platform, upper, _ = robot_lengths(robot)
    return [
        along((base - platform + upper * MP.cos(t), frame(i)[0]), (upper * MP.sin(t), frame(i)[2]))
        for i, t in enumerate(theta)
    ]


def forward_exact(robot, theta, side=1):
    """Where three spheres meet, by elimination: two planes and a quadratic; the farther along e3, -1: the nearer."""
    a = centers(robot, theta)
    rows = MP.matrix([[2 * (p - q) for p, q in zip(a[k], a[0], strict=True)] for k in (1, 2)])
    right = [dot(a[k], a[k]) - dot(a[0], a[0]) for k in (1, 2)]
    b, c = ([p - q for p, q in zip(a[k], a[0], strict=True)] for k in (1, 2))
    normal = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]]
    system = MP.matrix([[rows[r, k] for k in range(3)] for r in range(2)] + [normal])
    place = MP.lu_solve(system, MP.matrix([*right, dot(normal, a[0])]))
    start = [place[k] - a[0][k] for k in range(3)]
    left = robot_lengths(robot)[3] ** 2 - dot(start, start)
    if left < 0:
        return None
    step = side * (1 if normal[2] >= 0 else -1) * MP.sqrt(left / dot(normal, normal))
    return [place[k] + step * normal[k] for k in range(3)]


def differences(function, x, h=None):
    """Central differences at 50 digits, (3, 3); good to 30 of them."""
    h = MP.mpf(10) ** -16 if h is None else h
    columns = []
    for j in range(3):
        up, down = ([v + (s * h if i == j else 0) for i, v in enumerate(x)] for s in (1, -1))
        columns.append([(p - q) / (2 * h) for p, q in zip(function(up), function(down), strict=True)])
    return np.array([[float(columns[j][i]) for j in range(3)] for i in range(3)])


def as_floats(values):
    return np.array([float(v) for v in values])


def poses(robot, count, seed=0, spread=0.9):
    """Angles at which the forearms meet, and the platform's positions."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-0.6, 1.4, (40 * count, 1))
    if robot.forearm < 0.1 * robot.upper_arm:  # short forearms meet where the elbows are near the axis
        middle = np.arccos((robot.effector_radius - robot.base_radius) / robot.upper_arm)
    share = min(1.0, 0.5 * robot.forearm / robot.upper_arm) if robot.forearm < robot.upper_arm else 1.0
    theta = middle + share * rng.uniform(-spread, spread, (40 * count, 3))
    y, code = robot.forward(theta, status=True)
    good = code == bs.Status.OK
    assert good.sum() >= count
    return theta[good][:count], y[good][:count]


@pytest.mark.parametrize("lengths", LENGTHS)
def test_both_ways_to_50_digits(lengths):
    """Inverse and forward kinematics within 1e-13, or the error that the arguments' own rounding makes."""
    robot = DeltaRobot(*lengths)
    theta, y = poses(robot, 25)
    bend = np.abs(robot.singularity(theta).sines).min(-1)
    hold = np.abs(robot.singularity(theta).volume)
    size = robot.upper_arm + robot.forearm
    for i in range(len(theta)):
        truth = as_floats(forward_exact(robot, exact(theta[i])))
        assert np.abs(y[i] - truth).max() < 2e-14 * size / hold[i]
        angles = as_floats(inverse_exact(robot, y[i], modes(robot, theta[i], y[i])))
        words = tuple("outer" if s > 0 else "inner" for s in modes(robot, theta[i], y[i]))
        found = robot.inverse(y[i], elbow=words)
        bound = 2e-14 * size / (bend[i] * min(robot.forearm, robot.upper_arm))
        assert np.abs(np.remainder(found - angles + np.pi, 2 * np.pi) - np.pi).max() < bound


def modes(robot, theta, y):
    """+1 where the elbow is the outer one: turned from the wrist's direction towards s."""
    sides = []
    for i, t in enumerate(theta):
        s, e3 = as_floats(frame(i)[0]), np.array([0, 0, 1.0])
        u = y - (robot.base_radius - robot.effector_radius) * s
        sides.append(1 if np.cos(t) * (u @ e3) - np.sin(t) * (u @ s) > 0 else -1)
    return sides


def test_outer_and_far_are_what_they_say():
    """On the e3 side, with the platform below the elbows' plane: further from the axis, and further along e3."""
    rng = np.random.default_rng(3)
    y = np.concatenate([rng.uniform(-0.3, 0.3, (500, 2)), rng.uniform(0.6, 1.2, (500, 1))], 1)
    outer, inner = (USUAL.inverse(y, elbow) for elbow in ("outer", "inner"))
    assert (np.cos(outer) > np.cos(inner)).all()
    theta = rng.uniform(-0.4, 1.0, (500, 3))
    far, near = (USUAL.forward(theta, root) for root in ("far", "near"))
    assert (far[:, 2] > near[:, 2]).all()
    assert np.allclose(USUAL.inverse(far), theta, atol=1e-13)


# -- the thesis's own formulas, corrected ----------------------------------------------------------------------


def end_of(pair):
    """-P (T . n_inf) with P = (1 + ~T/sqrt(T^2))/2: ~T where the text has T (MATHS); as a position."""
    square = np.sqrt((pair * pair)["1"])
    w = -(0.5 * (~(1 + ~pair / square))) * (pair | cga.ni)
    w = w.grade(1)
    weight = -(w | cga.ni)["1"]
    return np.array([w[e] for e in ("e1", "e2", "e3")]) / weight


def test_the_formulas_of_the_text():
    """Meets of circle and sphere, and of three spheres, in conformal geometry (7.7.2)."""
    base, platform, upper, forearm = LENGTHS[0]
    theta, y = poses(USUAL, 20, seed=5)
    for t, place in zip(theta, y, strict=True):
        duals = []
        for i in range(3):
            s = as_floats(frame(i)[0])
            x = cga.point(place + platform * s) - 0.5 * forearm**2 * cga.ni
            center = cga.point(base * s) - 0.5 * upper**2 * cga.ni
            sv = vector(s)
            circle = center ^ ((cga.e1 ^ cga.e2 ^ cga.e3) * (sv ^ cga.e3)).grade(1)
            pair = (circle ^ x).dual()
            ends = [end_of(p) for p in (pair, ~pair)]
            z = [e - base * s for e in ends]
            angles = [np.arctan2(v[2], v @ s) for v in z]
            assert np.abs(np.array(angles) - [USUAL.inverse(place, e)[i] for e in ("outer", "inner")]).max() < 1e-12
            a = (base - platform + upper * np.cos(t[i])) * s + upper * np.sin(t[i]) * np.array([0, 0, 1])
            duals.append(cga.point(a) - 0.5 * forearm**2 * cga.ni)
        pair = (duals[0] ^ duals[1] ^ duals[2]).dual()
        assert np.abs(end_of(pair) - USUAL.forward(t)).max() < 1e-12
        assert np.abs(end_of(~pair) - USUAL.forward(t, "near")).max() < 1e-12


def moved_end(pair, rate):
    """7.7.5: the end of a point pair and its rate, as positions; ~T for T, as everywhere (MATHS)."""
    t, dt = ~pair, ~rate
    square = (t * t)["1"]
    root = np.sqrt(square)
    p, dp = 0.5 * (1 + t / root), (root * dt - t * ((dt | t)["1"] / root)) / (2 * square)
    w = (-(~p) * (t | cga.ni)).grade(1)
    dw = (-(~dp) * (t | cga.ni) - ~p * (dt | cga.ni)).grade(1)
    weight, slope = (w | cga.ni)["1"], (dw | cga.ni)["1"]
    parts, rates = (np.array([x[e] for e in ("e1", "e2", "e3")]) for x in (w, dw))
    return -parts / weight, -rates / weight + parts * slope / weight**2


def test_the_derivatives_of_the_text():
    """Both Jacobians by the printed rules for point pairs and their projectors, in conformal geometry (7.7.5)."""
    base, platform, upper, forearm = LENGTHS[0]
    y = np.array([0.12, -0.07, 0.85])
    theta, e3 = USUAL.inverse(y), np.array([0, 0, 1.0])
    inverse, spheres, rates = np.zeros((3, 3)), [], []
    for i in range(3):
        s = as_floats(frame(i)[0])
        circle = (cga.point(base * s) - 0.5 * upper**2 * cga.ni) ^ (
            (cga.e1 ^ cga.e2 ^ cga.e3) * (vector(s) ^ cga.e3)
        ).grade(1)
        x = y + platform * s
        for j, way in enumerate(np.eye(3)):
            pair = ((cga.point(x) - 0.5 * forearm**2 * cga.ni) ^ circle).dual()
            w, dw = moved_end(pair, ((vector(way) + (way @ x) * cga.ni) ^ circle).dual())
            z = w - base * s
            inverse[i, j] = ((z @ s) * (dw @ e3) - (z @ e3) * (dw @ s)) / (z @ z)
        a = (base - platform + upper * np.cos(theta[i])) * s + upper * np.sin(theta[i]) * e3
        da = upper * (np.cos(theta[i]) * e3 - np.sin(theta[i]) * s)
        spheres.append(cga.point(a) - 0.5 * forearm**2 * cga.ni)
        rates.append(vector(da) + (da @ a) * cga.ni)
    assert np.abs(inverse - USUAL.inverse_jacobian(y)).max() < 1e-12
    pair = (spheres[0] ^ spheres[1] ^ spheres[2]).dual()
    for i in range(3):
        parts = [rates[k] if k == i else spheres[k] for k in range(3)]
        place, column = moved_end(pair, (parts[0] ^ parts[1] ^ parts[2]).dual())
        assert np.abs(place - y).max() < 1e-12
        assert np.abs(column - USUAL.forward_jacobian(theta)[:, i]).max() < 1e-12


def vector(v):
    return sum(c * e for c, e in zip(v, (cga.e1, cga.e2, cga.e3), strict=True))


def text_inverse_jacobian(robot, y, theta):
    """7.7.5 by arms, without the factor z.s/|z.s|: dW by differentiating |W - X| = forearm on the circle."""
    rows = []
    for i, t in enumerate(theta):
        s, e3 = as_floats(frame(i)[0]), np.array([0, 0, 1.0])
        z = robot.upper_arm * (np.cos(t) * s + np.sin(t) * e3)
        v = y + robot.effector_radius * s - robot.base_radius * s - z
        path = robot.upper_arm * (np.cos(t) * e3 - np.sin(t) * s)
        rows.append(v / (v @ path))
    return np.array(rows)


# -- Jacobians -------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("lengths", LENGTHS[:4])
def test_jacobians_to_50_digits(lengths):
    """Against differences at 50 digits, at 1e-14 times the square of what the pose is ill-conditioned by."""
    robot = DeltaRobot(*lengths)
    theta, y = poses(robot, 12, seed=1)
    near = robot.singularity(theta)
    for i in range(len(theta)):
        sides = modes(robot, theta[i], y[i])
        words = tuple("outer" if s > 0 else "inner" for s in sides)
        truth = differences(lambda x, s=sides: inverse_exact(robot, x, s), exact(y[i]))
        bound = 1e-13 * np.abs(truth).max()
        bend, hold = np.abs(near.sines[i]).min(), abs(near.volume[i])
        for method in ("direct", "screw"):
            assert np.abs(robot.inverse_jacobian(y[i], method, words) - truth).max() < bound / bend**2
        truth = differences(lambda x: forward_exact(robot, x), exact(theta[i]))
        bound = 1e-13 * np.abs(truth).max()
        for method in ("direct", "screw"):
            assert np.abs(robot.forward_jacobian(theta[i], method) - truth).max() < bound / hold**2


def test_jacobians_agree():
    """Both methods, both ways: J J* = 1 to 1e-11 at the conditions of a robot at work, and the text's own rows."""
    rng = np.random.default_rng(2)
    y = np.concatenate([rng.uniform(-0.4, 0.4, (2000, 2)), rng.uniform(0.7, 1.1, (2000, 1))], 1)
    theta = USUAL.inverse(y, strict=True)
    inverse, forward = USUAL.inverse_jacobian(y), USUAL.forward_jacobian(theta)
    assert np.abs(forward @ inverse - np.eye(3)).max() < 1e-11
    assert np.abs(inverse - USUAL.inverse_jacobian(y, "screw")).max() < 1e-11
    assert np.abs(forward - USUAL.forward_jacobian(theta, "screw")).max() < 1e-11
    assert (
        np.abs(inverse[:50] - [text_inverse_jacobian(USUAL, *x) for x in zip(y[:50], theta[:50], strict=True)]).max()
        < 1e-11
    )


def test_each_posture_has_its_jacobian():
    """All eight working modes, and both roots: the derivative of that posture."""
    y = np.array([0.12, -0.07, 0.8])
    for words in itertools.product(("outer", "inner"), repeat=3):
        sides = [1 if w == "outer" else -1 for w in words]
        theta = USUAL.inverse(y, words)
        assert np.allclose(theta, as_floats(inverse_exact(USUAL, y, sides)), atol=1e-14)
        truth = differences(lambda x, s=sides: inverse_exact(USUAL, x, s), exact(y))
        for method in ("direct", "screw"):
            assert np.allclose(USUAL.inverse_jacobian(y, method, words), truth, rtol=1e-12)
    theta = np.array([0.3, 0.1, 0.5])
    for root, side in (("far", 1), ("near", -1)):
        truth = differences(lambda x, s=side: forward_exact(USUAL, x, s), exact(theta))
        for method in ("direct", "screw"):
            assert np.allclose(USUAL.forward_jacobian(theta, method, root), truth, rtol=1e-11, atol=1e-13)


# -- units, precision, targets ---------------------------------------------------------------------------------


def test_units_do_not_matter():
    """The same bits in all units that are powers of two; the same digits from 1e-6 to 1e3, and 1e-60 to 1e60."""
    theta, y = poses(USUAL, 50, seed=7, spread=0.3)
    for scale in (2.0**-20, 2.0**10):
        robot = DeltaRobot(*(scale * x for x in LENGTHS[0]))
        assert (robot.inverse(scale * y) == USUAL.inverse(y)).all()
        assert (robot.forward(theta) == scale * USUAL.forward(theta)).all()
        assert (robot.forward_jacobian(theta) == scale * USUAL.forward_jacobian(theta)).all()
    for scale in (1e-60, 1e-6, 1e3, 1e60):
        robot = DeltaRobot(*(scale * x for x in LENGTHS[0]))
        assert np.abs(robot.inverse(scale * y) - USUAL.inverse(y)).max() < 1e-12
        assert np.abs(robot.forward(theta) / scale - y).max() < 1e-12
        assert np.abs(robot.inverse_jacobian(scale * y) * scale - USUAL.inverse_jacobian(y)).max() < 1e-10


@pytest.mark.compiles
def test_single_precision():
    theta, y = poses(USUAL, 50, seed=8, spread=0.4)
    found = USUAL.inverse(y.astype(np.float32))
    assert found.dtype == np.float32 and np.abs(found - USUAL.inverse(y)).max() < 1e-5
    good = np.abs(USUAL.singularity(theta).sines).min(-1) > 0.3
    exactly = USUAL.forward_jacobian(theta[good])
    assert np.abs(USUAL.forward_jacobian(theta[good].astype(np.float32)) - exactly).max() < 1e-5
    exactly = USUAL.inverse_jacobian(y[good])
    assert np.abs(USUAL.inverse_jacobian(y[good].astype(np.float32)) - exactly).max() < 1e-4
    small = DeltaRobot(*(1e-6 * x for x in LENGTHS[0])).forward(theta.astype(np.float32))
    assert small.dtype == np.float32 and np.abs(small * 1e6 - y).max() < 1e-5


@pytest.mark.compiles
@pytest.mark.parametrize("name", ["inverse", "forward"])
def test_targets_give_the_same_bits(name):
    """C on vectors, and the same text on NumPy columns."""
    theta, y = poses(USUAL, 101, seed=9)
    row = USUAL.parameters
    operands = {"inverse": [y, row, np.ones(3)], "forward": [theta, row, np.array([0.0, 1.0])]}[name]
    kinds = [numbers(cga, a.shape[-1]) if a.ndim else scalar_argument(cga) for a in operands]
    kernel = KernelFunction(getattr(formulas, name), kinds, None, name, cga)
    compiled, plain = (kernel.on(target)(*operands) for target in ("c", "numpy"))
    assert (compiled[0] == plain[0]).all() and (compiled[1] == plain[1]).all()
    found = getattr(USUAL, name)(operands[0])
    assert np.abs(found - compiled[0]).max() < 1e-13


def test_batches_of_any_shape_and_threads():
    theta, y = poses(USUAL, 60, seed=10)
    grid = y.reshape(3, 4, 5, 3)
    assert (USUAL.inverse(grid) == USUAL.inverse(y).reshape(grid.shape)).all()
    assert USUAL.forward_jacobian(theta.reshape(12, 5, 3)).shape == (12, 5, 3, 3)
    assert USUAL.inverse(np.zeros((0, 3))).shape == (0, 3)
    assert USUAL.inverse_jacobian(np.zeros((0, 3)), "screw").shape == (0, 3, 3)
    many = np.tile(y, (2000, 1))
    assert (USUAL.inverse(many, threads=2) == USUAL.inverse(many, threads=1)).all()
    assert (USUAL.inverse(many, threads=2)[-60:] == USUAL.inverse(y)).all()
    with pytest.raises(InputError, match="threads"):
        USUAL.inverse(y, threads=0)


# -- where there is no answer ----------------------------------------------------------------------------------


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


# -- properties ------------------------------------------------------------------------------------------------

length = st.floats(0.1, 2.0)
angle = st.floats(-np.pi, np.pi)


@settings(max_examples=60, deadline=None)
@given(st.tuples(length, length, length, length), st.tuples(angle, angle, angle))
def test_forward_positions_are_a_forearm_from_all_elbows(lengths, theta):
    """And the inverse, in the posture that it is, is back at the angles: any lengths, any angles, both roots."""
    base, platform, upper, forearm = lengths
    if abs(base - platform) > 0.99 * (upper + forearm):
        return
    robot = DeltaRobot(*lengths)
    theta = np.array(theta)
    for root in ("far", "near"):
        y, status = robot.forward(theta, root, status=True)
        if status != bs.Status.OK:
            continue
        near = robot.singularity(theta, root)
        away = [np.linalg.norm(y - as_floats(a)) for a in centers(robot, exact(theta))]
        assert np.abs(np.array(away) - forearm).max() < 1e-13 / max(abs(near.volume), 1e-6)
        if np.abs(near.sines).min() < 1e-3 or abs(near.volume) < 1e-3:
            continue
        words = tuple("outer" if s > 0 else "inner" for s in modes(robot, theta, y))
        back = robot.inverse(y, words)
        turn = np.remainder(back - theta + np.pi, 2 * np.pi) - np.pi
        assert np.abs(turn).max() < 1e-8


# -- the whole mechanism ---------------------------------------------------------------------------------------


def test_points_of_the_whole_robot():
    """7.7.1 and 7.7.3: lengths of all limbs, the platform a triangle about its centre, rods of an arm parallel."""
    theta, y = poses(USUAL, 30, seed=12)
    found = USUAL.pose(theta)
    lengths = np.linalg.norm(found.bottoms - found.tops, axis=-1)
    assert np.abs(lengths - USUAL.forearm).max() < 1e-12
    assert np.abs(np.linalg.norm(found.elbows - found.shoulders, axis=-1) - USUAL.upper_arm).max() < 1e-14
    assert np.abs((found.tops - found.bottoms)[:, ::2] - (found.tops - found.bottoms)[:, 1::2]).max() < 1e-14
    for rods in ((1, 2), (3, 4), (5, 0)):
        assert np.abs(found.bottoms[:, rods[0]] - found.bottoms[:, rods[1]]).max() < 1e-14
    assert np.abs(found.corners.mean(1) - y).max() < 1e-14
    sides = np.linalg.norm(found.corners - np.roll(found.corners, 1, 1), axis=-1)
    assert np.abs(sides - 2 * np.sqrt(3) * USUAL.effector_radius).max() < 1e-14
    outer = np.array([modes(USUAL, *each) == [1, 1, 1] for each in zip(theta, y, strict=True)])
    back = USUAL.pose_at(y[outer])
    assert outer.sum() > 10 and np.abs(back.elbows - found.elbows[outer]).max() < 1e-12
    lost = USUAL.pose_at([[0, 0, 9.0], [0, 0, 1.0]])
    assert np.isnan(lost.tops[0]).all() and np.isfinite(lost.tops[1]).all()


def test_the_fifteen_joints_have_nullity_nine():
    """51 independent rows of 60 columns: three motions and the spins of six rods; and they give the Jacobian."""
    theta = np.array([0.3, 0.1, 0.5])
    mechanism = USUAL.mechanism(theta)
    found = mechanism.jacobian(list(mechanism.joints)[:3], ("platform", USUAL.forward(theta)))
    assert mechanism.mobility() == 9 and np.abs(found - USUAL.forward_jacobian(theta)).max() < 1e-12
    shared = USUAL.joint_objects(theta).incidences()
    bodies = [*dict.fromkeys(name for a, b, _ in shared for name in (a, b) if name != "base")]
    twists = [dynamics.twist(w, v) for w, v in [(e, 0) for e in np.eye(3)] + [(0, e) for e in np.eye(3)]]
    rows = []
    for a, b, x in shared:
        block = np.stack([x.commutator(t).values for t in twists], 1)
        row = np.zeros((len(block), 6 * len(bodies)))
        for sign, name in ((1, a), (-1, b)):
            if name != "base":
                row[:, 6 * bodies.index(name) :][:, :6] = sign * block
        rows.append(row)
    matrix = np.concatenate(rows)
    assert len(shared) == 15 and matrix.shape[1] == 60
    values = np.linalg.svd(matrix)[1]
    assert (values > 1e-9).sum() == 51
    null = np.linalg.svd(matrix)[2][51:].T
    speeds = []
    for i in range(3):  # the speed of a motor is its twist's angular part along the axis
        at = 6 * bodies.index(f"upper_arm_{i + 1}")
        speeds.append(as_floats(frame(i)[1]) @ null[at : at + 3])
    at = 6 * bodies.index("platform")
    turning, moving = null[at : at + 3], null[at + 3 : at + 6]
    assert np.abs(turning).max() < 1e-12
    jacobian = moving @ np.linalg.pinv(np.array(speeds), rcond=1e-9)
    assert np.abs(jacobian - USUAL.forward_jacobian(theta)).max() < 1e-12


def test_motor_twists_turn_the_elbows():
    """dX = X x Omega is the elbow's rate per radian, in its arm's plane."""
    theta = np.array([0.3, 0.1, 0.5])
    rates = cga.point(USUAL.pose(theta).elbows).commutator(USUAL.motor_twists())
    for i in range(3):
        s = as_floats(frame(i)[0])
        path = USUAL.upper_arm * (np.cos(theta[i]) * np.array([0, 0, 1]) - np.sin(theta[i]) * s)
        assert np.abs([rates[i][e] for e in ("e1", "e2", "e3")] - path).max() < 1e-15


def test_batches_of_joint_objects():
    theta, _ = poses(USUAL, 7, seed=13)
    found = USUAL.joint_objects(theta)
    assert found.circles.shape == (7, 3) and found.tops.shape == (7, 6) and found.corners.shape == (7, 3)
    one = USUAL.joint_objects(theta[4])
    assert np.allclose(one.circles.values, found.circles[4].values, atol=1e-14)
    read = one.circles.parameters()
    assert np.allclose(read.radius, USUAL.upper_arm) and np.allclose(read.normal[0], [0, -1, 0])
    assert [type(j).__name__ for j in one.joints()] == ["Revolute"] * 3 + ["Spherical"] * 12
    assert {n for j in one.joints() for n in (j.a, j.b)} == {
        "base", "platform", *(f"upper_arm_{i}" for i in (1, 2, 3)), *(f"forearm_{i}" for i in range(1, 7))
    }  # fmt: skip


# -- workspace, motion, dynamics, pictures ---------------------------------------------------------------------


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
    ax = plots.picture(USUAL, y=y, path=tmp_path / "robot.png")
    low, high = ax.get_zlim3d()
    assert low > high and (tmp_path / "robot.png").stat().st_size > 10_000
    space = USUAL.workspace(points=15)
    figure = plots.slices(space, tmp_path / "slices.png", across="z", at=[0.9])
    (mesh,) = figure.axes[0].collections
    shown = np.ma.filled(mesh.get_array(), np.nan).reshape(15, 15)
    number = int(np.abs(space.z - 0.9).argmin())
    expected = np.where(space.reachable, space.condition, np.nan)[:, :, number].T
    assert np.array_equal(shown, expected, equal_nan=True)
    motion = USUAL.trajectory(lambda t: np.array([0.1 * t, 0, 0.9]), np.linspace(0, 1, 20))
    assert len(plots.curves(motion).axes) == 3
    with pytest.raises(InputError):
        plots.picture(USUAL)
    with pytest.raises(SingularError):
        plots.picture(USUAL, y=[0, 0, 50.0])
    with pytest.raises(InputError, match="show"):
        plots.slices(space, show="conditions")


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
