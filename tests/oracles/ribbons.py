"""The oracle for ribbons: at 50 digits, all roots of the printed polynomial, told true from false on two branches.

Nothing of the tracer's: the polynomial comes from values of the projector's parts along the curve, its roots from
mpmath, points from the end points of the projected pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.objects.blades import blade_projector
from bladesmith.codegen.formulas.objects.conformal import infinity, point
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.rings.protocol import PrecisionRing

from .sequences import dot

RING = PrecisionRing(50)
MP = RING.context
ALGEBRA = cga3d()
BLADES = ALGEBRA.kind("point_pair").blades
#: Imaginary parts and sizes below this are rounding of 50 digits, also of double roots.
NOTHING = MP.mpf(10) ** -18


def number(x):
    return from_values(ALGEBRA, RING, (0,), [MP.mpf(x)])


def vector(x):
    return from_values(ALGEBRA, RING, (1, 2, 4), [MP.mpf(v) for v in x])


def coordinates(x):
    return [x[name].scalar() for name in ("e1", "e2", "e3")]


def unit_pair(a, b):
    """A ^ B, normalised."""
    pair = point(vector(a)) ^ point(vector(b))
    return pair / number(MP.sqrt((pair * pair).grade(0).scalar()))


@dataclass(frozen=True)
class Root:
    """A carrier that the ray meets: curve parameter, parameter of the ray, place (-1 to 1 on the segment)."""

    alpha: float
    t: float
    place: float


class Oracle:
    """A curve of point pairs; ``flipped`` controls are of reversed orientation."""

    def __init__(self, pairs, flipped=None):
        pairs = [[[float(x) for x in p] for p in pair] for pair in pairs]
        flipped = np.zeros(len(pairs), bool) if flipped is None else flipped
        self.degree = len(pairs) - 1
        self.controls = [number(-1 if turn else 1) * unit_pair(*p) for p, turn in zip(pairs, flipped, strict=True)]
        self._nodes = None

    def raw(self, t):
        n = self.degree
        parts = (number(comb(n, k) * t**k * (1 - t) ** (n - k)) * c for k, c in enumerate(self.controls))
        return self.controls[0].sum(parts)

    def pair(self, t):
        raw = self.raw(t)
        return (blade_projector(raw) * raw).grade(2)

    def shape(self, t):
        """Middle, unit direction and half length of the segment of a parameter."""
        pair = self.pair(MP.mpf(t))
        n = infinity(pair)
        image, carrier = (pair * n * pair).grade(1), pair ^ n
        weight = -(image | n).scalar()
        along = coordinates(-(carrier | (pair.basis("no") ^ n)))
        length = MP.sqrt(dot(along, along))
        half = MP.sqrt((pair * pair).grade(0).scalar() / (carrier * carrier).grade(0).scalar())
        return [x / weight for x in coordinates(image)], [x / length for x in along], half

    def place(self, t, place):
        """A point of the surface: -1 and 1 are the ends of the segment."""
        middle, along, half = self.shape(t)
        return [m + MP.mpf(place) * half * d for m, d in zip(middle, along, strict=True)]

    def _parts(self, t):
        raw = self.raw(t)
        square = raw * raw
        s0, s4 = square.grade(0).scalar(), square.grade(4)
        return raw, s0, (s4 * raw).grade(2), s0 * s0 - (s4 * s4).grade(0).scalar()

    def _prepare(self):
        size = 6 * self.degree + 1
        places = [MP.cos(MP.pi * (2 * k + 1) / (2 * size)) for k in range(size)]
        inverse = MP.matrix([[x**j for j in range(size)] for x in places]) ** -1
        self._nodes = [self._parts((1 + x) / 2) for x in places], inverse

    def roots(self, origin, direction):
        """All carriers that the line of a ray meets, by their parameters, rising."""
        if self._nodes is None:
            self._prepare()
        nodes, inverse = self._nodes
        line = point(vector(origin)) ^ vector(direction) ^ infinity(self.controls[0])
        one = {b: line & self.controls[0].new({b: MP.mpf(1)}) for b in BLADES}
        meets = {b: x.grade(0).scalar() for b, x in one.items()}

        def meet(x):
            return sum(c * x.terms.get(b, 0) for b, c in meets.items())

        squared = [(s0 * meet(raw) - meet(other)) ** 2 - s2 * meet(raw) ** 2 for raw, s0, other, s2 in nodes]
        powers = list(inverse * MP.matrix(squared))
        while len(powers) > 1 and abs(powers[-1]) < max(map(abs, powers)) * MP.mpf(10) ** -44:
            powers.pop()
        found = [] if len(powers) == 1 else MP.polyroots(powers[::-1], maxsteps=500, extraprec=400)
        rising = sorted((1 + MP.re(z)) / 2 for z in found if abs(MP.im(z)) < NOTHING)
        return [t for t in rising if 0 <= t <= 1 and self._is_true(t, meet)]

    def _is_true(self, t, meet):
        raw, s0, other, s2 = self._parts(t)
        if s2 < 0:
            return False
        sum_, root = s0 * meet(raw) - meet(other), MP.sqrt(s2) * meet(raw)
        return abs(sum_ + root) <= abs(sum_ - root)

    def hits(self, origin, direction):
        """Roots with the points where ray and carrier are nearest."""
        found = []
        origin, direction = ([MP.mpf(float(x)) for x in v] for v in (origin, direction))
        for alpha in self.roots(origin, direction):
            middle, along, half = self.shape(alpha)
            apart = [x - y for x, y in zip(origin, middle, strict=True)]
            square, slope = dot(direction, direction), dot(direction, along)
            t = (slope * dot(apart, along) - dot(apart, direction)) / (square - slope * slope)
            position = [x + t * d for x, d in zip(apart, direction, strict=True)]
            found.append(Root(float(alpha), float(t), float(dot(position, along) / half)))
        return found


def compare(oracle, found, origins, directions, tolerance):
    """(hits, lost, false, worst alpha) of the tracer's points against the oracle's; on an edge they may be either."""
    total = lost = false = 0
    worst = 0.0
    for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        roots = oracle.hits(origin, direction)
        wanted = [r for r in roots if abs(r.place) <= 1]
        got = found.alpha[i, : found.count[i]].tolist()
        total += len(wanted)
        for root in wanted:
            near = min(got, key=lambda a, r=root: abs(a - r.alpha), default=np.inf)
            if abs(near - root.alpha) <= tolerance:
                got.remove(near)
                worst = max(worst, abs(near - root.alpha))
            elif min(abs(1 - abs(root.place)), root.alpha, 1 - root.alpha) > tolerance:
                lost += 1
        edges = [r.alpha for r in roots if abs(abs(r.place) - 1) <= tolerance]
        false += sum(all(abs(a - e) > tolerance for e in edges) for a in got)
    return total, lost, false, worst
