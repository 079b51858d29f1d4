"""The whole Delta robot: its points, the forces of its rods, how near it is to a singular pose (thesis 7.7.3, 7.7.4).

Operands as in `delta`; ``plates`` are the radii of base and platform in units of length.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, cos, sin
from ...trace.outputs import Result, row
from ..mechanics.mechanics import power, screw_of, wrench_at
from ..objects.euclidean import axes, coordinates, cross, vector
from ..products.outcome import as_computed
from .delta import SINE, Arms, Coordinates, Robot, arm_directions, down, sphere_centers


class Plates(NamedTuple):
    """The row ``plates``."""

    base: Multivector
    platform: Multivector


class Frame(NamedTuple):
    """Points of the whole robot, by arm: shoulder, elbow and wrist, and the ends of its two rods."""

    shoulders: list[Multivector]
    elbows: list[Multivector]
    wrists: list[Multivector]
    tops: list[Multivector]
    bottoms: list[Multivector]


def _frame(y: Coordinates, theta: Arms, robot: Robot, plates: Plates) -> Frame:
    """7.7.1 and 7.7.3: on each arm the first rod is on the side of a = s x e3, r_t = r_e/tan 30 degrees away."""
    like, (base, platform) = y[0], plates
    s, e3, position = arm_directions(like), down(like), vector(tuple(c * robot.unit for c in y))
    shoulders = [base * each for each in s]
    elbows = [b + robot.upper * (cos(t) * each + sin(t) * e3) for b, t, each in zip(shoulders, theta, s, strict=True)]
    wrists = [position + platform * each for each in s]
    half_side = 2 * as_computed(like.constant(SINE)) * platform  # r_e/tan 30 degrees
    offsets = [half_side * cross(each, e3) for each in s]
    tops = [w + sign * o for w, o in zip(elbows, offsets, strict=True) for sign in (1, -1)]
    bottoms = [x + sign * o for x, o in zip(wrists, offsets, strict=True) for sign in (1, -1)]
    return Frame(shoulders, elbows, wrists, tops, bottoms)


def points(y: Coordinates, theta: Arms, robot: Robot, plates: Plates) -> tuple[Result, ...]:
    """Shoulders B_i, elbows W_i and wrists X_i, and the upper and lower ends of the six rods: rows of coordinates.

    Rods 1 and 2 are of arm 1, and so on; the lower
    ends of rods 2 and 3, 4 and 5, 6 and 1 are one point: P_11, P_12, P_10.
    """
    frame = _frame(y, theta, robot, plates)
    return tuple(
        row([x * robot.length for v in vectors for x in coordinates(v)], name)
        for name, vectors in zip(Frame._fields, frame, strict=True)
    )


def rod_powers(y: Coordinates, theta: Arms, robot: Robot, plates: Plates) -> tuple[Result, Result]:
    """Powers of the forces along the six rods on the platform's twists, (6, 6), and on the arms' unit twists, (6,).

    A rod between two ball joints transmits one force, along its line L (in the dual form f I3 + (p x f) n): its power
    L ^ Omega is the same at both ends. Coordinates of the platform's twist are of w and v about its center, in units
    of length.
    """
    frame, like = _frame(y, theta, robot, plates), y[0]
    center = vector(tuple(c * robot.unit for c in y))
    turning = [cross(s, down(like)) for s in arm_directions(like)]
    twists = [screw_of(a, cross(b - center, a)) for a, b in zip(turning, frame.shoulders, strict=True)]
    still = like.new({})
    units = [screw_of(e, still) for e in axes(like)] + [screw_of(still, e) for e in axes(like)]
    platform, arms = [], []
    for i, (top, bottom) in enumerate(zip(frame.tops, frame.bottoms, strict=True)):
        line = wrench_at((bottom - top) / robot.forearm, bottom - center)
        platform += [power(unit, line) for unit in units]
        arms.append(power(twists[i // 2], line))
    return row(platform, "platform"), row(arms, "arms")


def singularities(y: Coordinates, theta: Arms, robot: Robot) -> tuple[Result, Result, Result]:
    """Distance of a pose from singular ones: sines of the arms, the forearms' volume, and the forearms' directions.

    A sine, of the angle between upper arm and forearm in the arm's plane times the forearm's share of it, is zero where
    an arm is stretched or folded: there the platform cannot move along this forearm (a lost direction). The volume
    of the three unit forearms is zero where they lie in one plane: the platform is free across it.
    """
    center = vector(tuple(c * robot.unit for c in y))
    forearms = [(center - a) / robot.forearm for a in sphere_centers(theta, robot)]
    paths = [cos(t) * down(y[0]) - sin(t) * s for t, s in zip(theta, arm_directions(y[0]), strict=True)]
    sines = [v | path for v, path in zip(forearms, paths, strict=True)]
    volume = (forearms[0] ^ forearms[1] ^ forearms[2])["e123"]
    return row(sines, "sines"), row([volume], "volume"), row([x for v in forearms for x in coordinates(v)], "forearms")
