"""Delta robots in 50 digits, from distances alone; robots and poses that several modules test."""

import mpmath
import numpy as np

import bladesmith as bs
from bladesmith.kinematics.delta.robot import DeltaRobot

from .sequences import dot

MP = mpmath.mp.clone()
MP.dps = 50

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


def modes(robot, theta, y):
    """+1 where the elbow is the outer one: turned from the wrist's direction towards s."""
    sides = []
    for i, t in enumerate(theta):
        s, e3 = as_floats(frame(i)[0]), np.array([0, 0, 1.0])
        u = y - (robot.base_radius - robot.effector_radius) * s
        sides.append(1 if np.cos(t) * (u @ e3) - np.sin(t) * (u @ s) > 0 else -1)
    return sides
