"""What can hold a body, twice: as constraints of the package, and as rows of plain three-vectors (`newton_euler`).

A `Case` draws a body's objects from a generator; then come states that obey it, the rows and the constraints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladesmith import dynamics

from ...oracles import newton_euler as ne
from ...oracles.newton_euler import REST, times
from ..vectors import unit

# -- objects that never move -----------------------------------------------------------------------------------


@dataclass
class Case:
    """Objects that are fixed in the body, and what holding them means.

    Attributes
    ----------
    objects : callable
        Of the algebra: the objects of the body that are pinned.
    rows : callable
        Of the state: independent rows.
    free : int
        Degrees of freedom left.
    """

    objects: object
    rows: object
    free: int


def axis(s, p, q):
    """Two points of the body held: of the second only what is across their line is new."""
    return ne.point_held(s, p) + ne.point_along(s, q, ne.across(times(s.turn, q - p)))


def line_held(s, p, m):
    here = (s.x + s.arm(p), REST, REST)
    return ne.direction_held(s, m) + ne.on_line(s, p, (times(s.turn, m), REST, REST), here)


def plane_held(s, p, n):
    return ne.direction_held(s, n) + level(s, p, n)


def level(s, p, n):
    """A point of the body stays in the plane of the world that has its normal there."""
    return ne.on_plane(s, p, (times(s.turn, n), REST, REST), (s.x + s.arm(p), REST, REST))


def no_turn(s):
    """All three components of w are zero."""
    return ne._stacked([(REST, np.broadcast_to(e, s.x.shape), 0.0, 0.0) for e in np.eye(3)])


def pins(rng):
    """Everything that can be pinned, by name: in both algebras, and in CGA alone; at random places."""
    p, q, m, n = rng.normal(size=(4, 3))
    return pins_at(p, q, unit(m), unit(n), *rng.uniform(0.3, 1.5, 2))


def pins_at(p, q, m, n, radius, off):
    """The same of two points, two unit vectors and two lengths."""
    across = unit(np.cross(m, n))
    both = {
        "point": Case(lambda a: [a.point(p)], lambda s: ne.point_held(s, p), 3),
        "direction": Case(lambda a: [a.direction(m)], lambda s: ne.direction_held(s, m), 4),
        "line": Case(lambda a: [a.line(p, m)], lambda s: line_held(s, p, m), 2),
        "plane": Case(lambda a: [a.plane(n, off)], lambda s: plane_held(s, off * n, n), 3),
        "two points": Case(lambda a: [a.point(p), a.point(q)], lambda s: axis(s, p, q), 1),
        "three points": Case(
            lambda a: [a.point(p), a.point(q), a.point(p + across)], lambda s: ne.point_held(s, p) + no_turn(s), 0
        ),
        "a point twice": Case(lambda a: [a.point(p), a.point(p)], lambda s: ne.point_held(s, p), 3),
        "point and a line through it": Case(
            lambda a: [a.point(p), a.line(p, m)], lambda s: ne.point_held(s, p) + ne.direction_held(s, m), 1
        ),
        "point and a plane through it": Case(
            lambda a: [a.plane(n, n @ p), a.point(p)], lambda s: ne.point_held(s, p) + ne.direction_held(s, n), 1
        ),
        "two planes": Case(
            lambda a: [a.plane(n, off), a.plane(m, radius)],
            lambda s: no_turn(s) + level(s, off * n, n) + level(s, radius * m, m), 1,
        ),
        "two directions": Case(lambda a: [a.direction(m), a.direction(n)], no_turn, 3),
        "line and a plane across it": Case(
            lambda a: [a.line(p, m), a.plane(m, m @ p)], lambda s: line_held(s, p, m) + level(s, p, m), 1
        ),
        "line and a plane with it": Case(
            lambda a: [a.line(p, m), a.plane(across, across @ p)],
            lambda s: no_turn(s) + ne.on_line(s, p, (times(s.turn, m), REST, REST), (s.x + s.arm(p), REST, REST)), 1,
        ),
        "parallel lines": Case(
            lambda a: [a.line(p, m), a.line(q, m)],
            lambda s: no_turn(s) + ne.on_line(s, p, (times(s.turn, m), REST, REST), (s.x + s.arm(p), REST, REST)), 1,
        ),
    }  # fmt: skip
    rounds = {
        "point pair": Case(lambda a: [a.point_pair(p, q)], lambda s: axis(s, p, q), 1),
        "flat point": Case(lambda a: [a.flat_point(p)], lambda s: ne.point_held(s, p), 3),
        "circle": Case(
            lambda a: [a.circle(p, n, radius)], lambda s: ne.point_held(s, p) + ne.direction_held(s, n), 1
        ),
        "sphere": Case(lambda a: [a.sphere(p, radius)], lambda s: ne.point_held(s, p), 3),
        "sphere and a plane": Case(
            lambda a: [a.sphere(p, radius), a.plane(n, off)],
            lambda s: ne.point_held(s, p) + ne.direction_held(s, n), 1,
        ),
    }  # fmt: skip
    return both, rounds


def surfaces(rng):
    """Objects of the world that a point of the body stays on: points of each (n -> (n, 3)), the rows, freedom left."""
    c, p = rng.normal(size=(2, 3))
    m = unit(rng.normal(size=3))
    e1, e2 = ne.across(m)
    radius = rng.uniform(0.5, 2.0)

    def flat(n):
        u = rng.normal(size=(2, n, 1))
        return c + u[0] * e1 + u[1] * e2

    def straight(n):
        return c + rng.normal(size=(n, 1)) * m

    def round_(n):
        u = rng.normal(size=(n, 3))
        return c + radius * u / np.linalg.norm(u, axis=1, keepdims=True)

    def ring(n):
        angle = rng.uniform(0, 2 * np.pi, (n, 1))
        return c + radius * (np.cos(angle) * e1 + np.sin(angle) * e2)

    here, way = (c, REST, REST), (m, REST, REST)
    both = {
        "on a plane": (p, flat, lambda a: a.plane(m, m @ c), lambda s: ne.on_plane(s, p, way, here), 5),
        "on a line": (p, straight, lambda a: a.line(c, m), lambda s: ne.on_line(s, p, way, here), 4),
    }
    rounds = {
        "on a sphere": (p, round_, lambda a: a.sphere(c, radius), lambda s: ne.at_distance(s, p, here), 5),
        "on a circle": (
            p, ring, lambda a: a.circle(c, m, radius),
            lambda s: ne.at_distance(s, p, here) + ne.on_plane(s, p, way, here), 4,
        ),
    }  # fmt: skip
    return both, rounds


# -- objects that move -----------------------------------------------------------------------------------------
#
# Places and directions with two derivatives, (x, dx, ddx), become objects with two derivatives.


def path_of(make, *moving):
    """(V, dV, ddV) at 0 of what `make` gives for x + dx t + ddx t^2/2: a polynomial of degree four at most."""
    values = [make(*(x[0] + t * x[1] + t * t / 2 * x[2] for x in moving)) for t in (-2.0, -1.0, 0.0, 1.0, 2.0)]
    first = (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / 12
    second = (16 * (values[1] + values[3]) - 30 * values[2] - values[0] - values[4]) / 12
    return values[2], first, second


def product(x, y):
    """Derivatives of an outer product."""
    return x[0] ^ y[0], (x[1] ^ y[0]) + (x[0] ^ y[1]), (x[2] ^ y[0]) + 2 * (x[1] ^ y[1]) + (x[0] ^ y[2])


def line_of(a, c, m):
    """Bilinear in a point and a direction."""
    return a.point(c) & a.direction(m) if a.is_degenerate else a.point(c) ^ a.direction(m)


def plane_of(a, n, c):
    """Linear in the normal and in n . c."""
    flat = [a.plane(e, 0.0) for e in np.eye(3)]
    away = a.plane(np.eye(3)[0], 1.0) - flat[0]
    x, y, z = np.moveaxis(n, -1, 0)
    return x * flat[0] + y * flat[1] + z * flat[2] + (n * c).sum(-1) * away


def sphere_of(a, c, square):
    """The dual sphere with the square of a radius."""
    infinity = a.multivector({"ni": 1.0})
    return a.point(c) - square / 2 * infinity


def turning(rng, m):
    """Derivatives of unit vectors (n, 3) that turn."""
    w, dw = rng.normal(size=(2, *m.shape))
    first = np.cross(w, m)
    return m, first, np.cross(dw, m) + np.cross(w, first)


def moving(rng, x):
    """Derivatives of places."""
    first, second = rng.normal(size=(2, *x.shape))
    return x, first, second


def wrench(a, force, moment):
    """With the moment about the origin."""
    return dynamics.wrench(force, np.zeros(3), algebra=a) + dynamics.couple(moment, algebra=a)
