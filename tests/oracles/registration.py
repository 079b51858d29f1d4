"""Objects of registration, motors and differences at 50 digits: objects are built from points and products, motors are
moved by.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement

import numpy as np

from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.multivector import Multivector, from_values
from bladesmith.codegen.programs.registration.registration import DIRECTED
from bladesmith.codegen.rings.protocol import PrecisionRing

from ..support.formulas import series_exp, stock
from ..support.registration import KINDS

RING = PrecisionRing(50)
MP = RING.context
ALGEBRA = stock("cga3d")
TINY = MP.mpf(10) ** -40
PAIRS = list(combinations_with_replacement(KINDS, 2))


def vector(values) -> Multivector:
    return from_values(ALGEBRA, RING, [1, 2, 4], [MP.mpf(v) for v in values])


def up(p) -> Multivector:
    """The point at some coordinates."""
    square = sum((MP.mpf(v) ** 2 for v in p), MP.mpf(0))
    ni, no = (vector((0, 0, 0)).basis(n) for n in ("ni", "no"))
    return vector(p) + no + ni * from_values(ALGEBRA, RING, [0], [square / 2])


def number(value) -> Multivector:
    return from_values(ALGEBRA, RING, [0], [MP.mpf(value)])


def scalar(x: Multivector):
    return x.terms.get(0, MP.mpf(0))


def largest(x: Multivector):
    return max((abs(c) for c in x.terms.values()), default=MP.mpf(0))


def plus(p, *scaled):
    return [MP.mpf(a) + sum(MP.mpf(s) * MP.mpf(v[i]) for s, v in scaled) for i, a in enumerate(p)]


class Thing:
    """An object at 50 digits: place, unit direction and radius, and what it is as a multivector of points."""

    def __init__(self, kind: str, seed: int) -> None:
        random = np.random.default_rng([seed, KINDS.index(kind)])
        self.kind = kind
        self.place = [MP.mpf(v) for v in random.uniform(-1, 1, 3)]
        along = [MP.mpf(v) for v in random.normal(size=3)]
        size = MP.sqrt(sum(v * v for v in along))
        self.along = [v / size for v in along]
        self.radius = MP.mpf(random.uniform(0.2, 0.6))
        one = self._across(random.normal(size=3))
        n = self.along
        other = [n[1] * one[2] - n[2] * one[1], n[2] * one[0] - n[0] * one[2], n[0] * one[1] - n[1] * one[0]]
        p, r, ni = self.place, self.radius, up((0, 0, 0)).basis("ni")
        a, b = plus(p, (r, one)), plus(p, (r, other))
        x = {
            "point": lambda: up(p),
            "point_pair": lambda: up(plus(p, (-r, n))) ^ up(plus(p, (r, n))),
            "line": lambda: up(p) ^ up(plus(p, (1, n))) ^ ni,
            "circle": lambda: up(a) ^ up(b) ^ up(plus(p, (-r, one))),
            "plane": lambda: up(p) ^ up(plus(p, (1, one))) ^ up(plus(p, (1, other))) ^ ni,
            "sphere": lambda: up(a) ^ up(b) ^ up(plus(p, (-r, one))) ^ up(plus(p, (r, n))),
        }[kind]()
        if kind != "point":
            x = x * number(1 / MP.sqrt(abs(scalar(x * x))))
        self.x = -x if self._agreement(x) < 0 else x
        self.element = self._expected()

    def _across(self, v):
        v = [MP.mpf(a) for a in v]
        dot = sum(a * b for a, b in zip(v, self.along, strict=True))
        v = plus(v, (-dot, self.along))
        size = MP.sqrt(sum(a * a for a in v))
        return [a / size for a in v]

    def _agreement(self, x: Multivector) -> float:
        """Whether it is turned as the constructor of its kind turns it."""
        p, n, r = (np.array(v, float) for v in (self.place, self.along, self.radius))
        made = {
            "point": lambda: cga.point(p),
            "point_pair": lambda: cga.point_pair(p - r * n, p + r * n),
            "line": lambda: cga.line(p, n),
            "circle": lambda: cga.circle(p, n, r),
            "plane": lambda: cga.plane(n, p @ n),
            "sphere": lambda: cga.sphere(p, r),
        }[self.kind]()
        row = np.array([float(x.terms.get(b, 0)) for b in ALGEBRA.kind(self.kind).blades])
        sign = float(np.sign(row @ made._data))
        np.testing.assert_allclose(sign * row, made._data, atol=1e-13)
        return sign

    def _expected(self):
        dot = sum(a * b for a, b in zip(self.place, self.along, strict=True))
        place = {
            "line": lambda: plus(self.place, (-dot, self.along)),
            "plane": lambda: [dot * v for v in self.along],
        }.get(self.kind, lambda: self.place)()
        along = self.along if self.kind in DIRECTED else [MP.mpf(0)] * 3
        return [*place, *along, self.radius if self.kind in ("point_pair", "circle", "sphere") else MP.mpf(0)]

    def row(self) -> np.ndarray:
        return np.array([float(self.x.terms.get(b, 0)) for b in ALGEBRA.kind(self.kind).blades])


@cache
def thing(kind: str, seed: int) -> Thing:
    return Thing(kind, seed)


@cache
def motor(seed: int) -> Multivector:
    """A rotation about an axis through the origin, then a translation."""
    random = np.random.default_rng(seed)
    axis, angle, shift = random.normal(size=3), random.uniform(0.3, 3), random.uniform(-1, 1, 3)
    plane = vector(axis) * (vector((1, 0, 0)) * vector((0, 1, 0)) * vector((0, 0, 1)))
    plane = plane * number(1 / MP.sqrt(abs(scalar(plane * plane))))
    ni = plane.basis("ni")
    turn = number(MP.cos(angle / 2)) - number(MP.sin(angle / 2)) * plane
    return ((number(1) - vector(shift) * ni / 2) * turn).grade(0, 2, 4)


def moved(r: Multivector, x: Multivector) -> Multivector:
    return (r * x * ~r).grade(*x.grades)


def values(result) -> list:
    """A row of a formula's result."""
    return [scalar(v) for v in result.values]


def twists() -> list[Multivector]:
    return [from_values(ALGEBRA, RING, [b], [MP.mpf(1)]) for b in ALGEBRA.kind("twist").blades]


def near(r: Multivector, b: Multivector, h) -> Multivector:
    """exp(h b) r."""
    return series_exp(b * number(h)) * r


@cache
def orthonormal() -> tuple[Multivector, ...]:
    """All 32 products of e1 e2 e3 e+ e-."""
    ni, no = (number(1).basis(n) for n in ("ni", "no"))
    axes = [vector(v) for v in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    axes += [ni / 2 - no, ni / 2 + no]
    found = [number(1)]
    for e in axes:
        found += [b * e for b in found]
    return tuple(found)


def coefficients(x: Multivector) -> list:
    """On the orthonormal basis: a blade's inverse picks its own."""
    return [scalar(x * ~b) * scalar(b * ~b) for b in orthonormal()]


def magnitude(x: Multivector):
    return sum(c * c for c in coefficients(x))


def stabiliser(*things: Multivector) -> np.ndarray:
    """Twists, as columns, that leave objects as they are."""
    columns = []
    for b in twists():
        rates = [x * b - b * x for x in things]
        columns.append([float(c) for d in rates for c in coefficients(d)])
    _, sizes, rows = np.linalg.svd(np.array(columns).T)
    return rows[(sizes > 1e-9).sum() :].T
