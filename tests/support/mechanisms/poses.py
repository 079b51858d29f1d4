"""A four-bar and a Delta robot at known poses, bodies on a joint, and where points of bodies are."""

from functools import cache

import numpy as np

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin

from ..kinematics import ALGEBRAS, AXIS, Delta, FourBar, four_bar

THETA = np.array([0.3, 0.5, 0.1])
MOTORS = ["motor_0", "motor_1", "motor_2"]
BAR = FourBar()
START = 0.8
NAN = float("nan")


@cache
def bar(algebra="cga"):
    return four_bar(BAR.places(START), ALGEBRAS[algebra])


@cache
def delta(scale=1.0, centre=0.0, algebra="cga"):
    robot = Delta(scale, np.full(3, centre))
    return robot, robot.mechanism(THETA, ALGEBRAS[algebra])


def moved(poses, body, place):
    """Where a point of a body is."""
    return (poses[body] >> poses.mechanism.algebra.point(place)).parameters().xyz


@cache
def held_by(kind):
    place = np.array([1.0, 2, 3])
    joints = {
        "spherical": kin.Spherical("g", "x", cga.point(place)),
        "planar": kin.Planar("g", "x", cga.plane(AXIS, 3.0)),
        "cylindrical": kin.Cylindrical("g", "x", cga.line(place, AXIS)),
        "universal": kin.Universal("g", "x", cga.circle(place, [1, 0, 0], 1), cga.circle(place, [0, 1, 0], 1)),
        "on a plane": kin.Bilinear("g", "x", cga.plane(AXIS, 3.0), cga.point(place)),
        "on a plane, the other way": kin.Bilinear("g", "x", cga.point(place), cga.plane(AXIS, 3.0)),
    }
    m = kin.Mechanism(["g", "x"], "g")
    m.add(joints[kind], "j")
    return m
