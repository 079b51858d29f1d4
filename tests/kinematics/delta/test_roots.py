"""Which of the two positions of a Delta robot's angles: three spheres cut in 50 digits, heights compared there."""

import itertools

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.errors import InputError
from bladesmith.kinematics.delta.robot import ROOTS, DeltaRobot

MP = mpmath.mp.clone()
MP.dps = 50
#: The base larger than the platform, smaller, equal; long and short upper arms.
LENGTHS = [
    (0.4, 0.1, 0.5, 1.0),
    (0.1, 0.15, 0.25, 0.5),
    (0.1, 0.35, 0.6, 1.1),
    (0.2, 0.2, 0.4, 0.9),
    (0.05, 0.5, 0.3, 0.7),
    (0.4, 0.3, 1.5, 1.0),
    (0.2, 0.2, 1.0, 0.7),
    (0.02, 0.3, 1.2, 1.0),
]
#: Positions this close in height, as shares of the arms, are equally far for what the test compares.
TIE = 1e-13


def spheres(lengths, theta):
    """Centres of the three spheres on which the platform's centre is."""
    base, platform, upper, _ = (MP.mpf(x) for x in lengths)
    found = []
    for i, t in enumerate(theta):
        t, turn = MP.mpf(float(t)), 2 * MP.pi * i / 3
        out = base - platform + upper * MP.cos(t)
        found.append((out * MP.cos(turn), out * MP.sin(turn), upper * MP.sin(t)))
    return found


def meetings(lengths, theta):
    """Both points at a forearm from all centres: two planes of equal distances, cut, and a quadratic along the line."""
    a, b, c = spheres(lengths, theta)
    rows = [[2 * (q - p) for p, q in zip(a, other, strict=True)] for other in (b, c)]
    right = [sum(q * q for q in other) - sum(p * p for p in a) for other in (b, c)]
    m, n = rows
    way = [m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2], m[0] * n[1] - m[1] * n[0]]
    start = MP.lu_solve(MP.matrix([m, n, way]), MP.matrix([*right, 0]))
    offset = [start[k] - a[k] for k in range(3)]
    two = sum(w * w for w in way)
    one = sum(w * o for w, o in zip(way, offset, strict=True))
    left = one * one - two * (sum(o * o for o in offset) - MP.mpf(lengths[3]) ** 2)
    if left < 0:
        return None
    return [[start[k] + (-one + sign * MP.sqrt(left)) / two * way[k] for k in range(3)] for sign in (1, -1)]


def volume(lengths, theta, y):
    v = [[p - q for p, q in zip(y, a, strict=True)] for a in spheres(lengths, theta)]
    return MP.det(MP.matrix(v)) / MP.mpf(lengths[3]) ** 3


def angles(lengths, count, seed):
    """Angles of poses, in all quadrants."""
    robot, rng = DeltaRobot(*lengths), np.random.default_rng(seed)
    theta = rng.uniform(-np.pi, np.pi, (60 * count, 3))
    theta[::2] = rng.uniform(-np.pi, np.pi, (30 * count, 1)) + rng.uniform(-0.4, 0.4, (30 * count, 3))
    _, status = robot.forward(theta, status=True)
    held = np.abs(robot.singularity(theta).volume) > 1e-2
    return robot, theta[(status == bs.Status.OK) & held][:count]


@pytest.mark.parametrize("precise", [False, True])
@pytest.mark.parametrize("lengths", LENGTHS)
def test_far_is_farther_and_positive_is_positive(lengths, precise):
    robot, theta = angles(lengths, 40, seed=1)
    assert len(theta) == 40
    found = {root: robot.forward(theta, root, precise=precise) for root in ROOTS}
    swapped = 0
    for i, t in enumerate(theta):
        both = meetings(lengths, t)
        near, far = sorted(both, key=lambda y: y[2])
        negative, positive = sorted(both, key=lambda y: volume(lengths, t, y))
        truth = {"positive": positive, "negative": negative}
        if far[2] - near[2] > TIE * (lengths[2] + lengths[3]):
            truth |= {"far": far, "near": near}
        hold = float(abs(volume(lengths, t, positive)))
        for root, y in truth.items():
            assert np.abs(found[root][i] - [float(x) for x in y]).max() < 1e-13 / hold, (root, t)
        swapped += far is negative
    assert bool(swapped) == (abs(lengths[0] - lengths[1]) < lengths[2])  # else no elbow passes the axis
    for root, sign in (("positive", 1), ("negative", -1)):
        assert (np.sign(robot.singularity(theta, root).volume) == sign).all()


def test_the_robot_with_the_larger_platform():
    robot, y = DeltaRobot(0.1, 0.15, 0.25, 0.5), np.array([0, -0.29886962548467444, 0.6488696254846744])
    theta = robot.inverse(y)
    for precise in (False, True):
        assert np.abs(robot.forward(theta, precise=precise) - y).max() < 1e-14
    assert np.abs(robot.pose(theta).position - y).max() < 1e-14
    assert np.abs(robot.forward_jacobian(theta) @ robot.inverse_jacobian(y) - np.eye(3)).max() < 1e-10
    assert robot.forward(theta, "near")[2] < y[2]


@pytest.mark.parametrize("lengths", LENGTHS)
def test_there_and_back_on_the_e3_side(lengths):
    """Everywhere within reach: y is the far root of its angles if it is on the e3 side of the centres' plane."""
    robot, rng = DeltaRobot(*lengths), np.random.default_rng(2)
    arm = lengths[2] + lengths[3]
    y = rng.uniform([-arm, -arm, 0], [arm, arm, arm], (60000, 3))
    theta = robot.inverse(y)
    shape = robot.singularity_at(y)
    good = np.isfinite(theta).all(-1) & (np.abs(shape.volume) > 1e-3) & (np.abs(shape.sines).min(-1) > 1e-3)
    y, theta, volumes = y[good], theta[good], shape.volume[good]
    assert len(y) > 200
    backs = {root: robot.forward(theta, root) for root in ROOTS}
    error = {root: np.abs(back - y).max(-1) for root, back in backs.items()}
    assert np.where(volumes > 0, error["positive"], error["negative"]).max() < 1e-10
    far = backs["far"][:, 2] - backs["near"][:, 2]
    assert (far >= 0).all()
    on_e3_side = y[:, 2] > (backs["far"] + backs["near"])[:, 2] / 2
    clear = far > 1e-9
    assert np.where(on_e3_side, error["far"], error["near"])[clear].max() < 1e-10


@pytest.mark.parametrize("lengths", LENGTHS[:4])
def test_the_named_volume_goes_on_where_far_jumps(lengths):
    """Along paths of the angles: steps of "positive" are J dtheta; "far" is left by it where the heights pass."""
    robot, rng = DeltaRobot(*lengths), np.random.default_rng(3)
    jumps = 0
    for _ in range(40):
        begin, end = rng.uniform(-np.pi, np.pi, (2, 3))
        path = begin + (end - begin) * np.linspace(0, 1, 4001)[:, None]
        for root in ("positive", "negative"):
            y, status = robot.forward(path, root, status=True)
            jacobian = robot.forward_jacobian(path, root=root)
            ok = (status == bs.Status.OK) & (np.abs(robot.singularity(path, root).volume) > 0.05)
            both = ok[1:] & ok[:-1]
            middle = (jacobian[1:] + jacobian[:-1]) / 2
            steps = np.einsum("nij,nj->ni", middle, np.diff(path, axis=0))
            assert np.abs(np.diff(y, axis=0) - steps)[both].max(initial=0) < 1e-3 * sum(lengths)
        far = robot.forward(path)
        known = np.isfinite(far).all(-1)
        same = (far == robot.forward(path, "positive")).all(-1)
        assert (same | (far == robot.forward(path, "negative")).all(-1))[known].all()
        jumps += int(np.abs(np.diff(same[known].astype(int))).sum())
    assert jumps


@pytest.mark.parametrize("root", ROOTS)
def test_everything_takes_the_same_root(root):
    """Jacobians by both methods are those of the position; poses, mechanisms and systems have it."""
    for lengths in LENGTHS[:4]:
        robot, theta = angles(lengths, 6, seed=4)
        for t in theta:
            y = robot.forward(t, root)
            h = 1e-6
            slopes = [(robot.forward(t + d, root) - robot.forward(t - d, root)) / (2 * h) for d in h * np.eye(3)]
            direct = robot.forward_jacobian(t, root=root)
            assert np.allclose(direct, np.array(slopes).T, rtol=1e-4, atol=1e-6 * np.abs(direct).max())
            screw = robot.forward_jacobian(t, "screw", root)
            assert np.abs(screw - direct).max() < 1e-9 * np.abs(direct).max()
            assert np.abs(robot.pose(t, root).position - y).max() < 1e-12
            assert np.abs(robot.pose(t, root).corners.mean(0) - y).max() < 1e-12
            corners = robot.joint_objects(t, root).corners
            assert np.abs(robot.joint_objects(t, root).tops.values).max() > 0 and corners.shape == (3,)
        assert robot.mechanism(theta[0], root).mobility() == 9
        platform = robot.system(theta[0], root=root).bodies["platform"]
        assert np.abs(platform.position - robot.forward(theta[0], root)).max() < 1e-12


def test_where_both_are_equally_far():
    """Two arms straight down and equal radii: the plane of the centres is parallel to e3. Far is the positive one."""
    robot = DeltaRobot(0.2, 0.2, 0.4, 0.9)
    theta = np.array([np.pi / 2, np.pi / 2 - 1e-3, 0.2])
    for t in (theta, theta + [0, 2e-3, 0]):
        far, near = (robot.forward(t, root) for root in ("far", "near"))
        assert far[2] >= near[2]
    level = DeltaRobot(1.0, 1.0, 1.0, 3.0).forward([0.0, 0.0, 0.0], "far")
    assert level[2] > 0


def test_all_postures_come_back_by_their_volume():
    robot, y = DeltaRobot(*LENGTHS[0]), np.array([0.12, -0.07, 0.8])
    for words in itertools.product(("outer", "inner"), repeat=3):
        root = "positive" if robot.singularity_at(y, words).volume > 0 else "negative"
        assert np.abs(robot.forward(robot.inverse(y, words), root) - y).max() < 1e-13


def test_a_wrong_name_is_told_all_four():
    with pytest.raises(InputError, match="far, near, positive, negative"):
        DeltaRobot(*LENGTHS[0]).forward([0, 0, 0], "above")
