"""Surfaces evolved between circles, their definition on any ring, and rays that meet them."""

from __future__ import annotations

from collections import namedtuple
from math import comb

import numpy as np

from bladesmith import tracer
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.objects.blades import blade_projector
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.rings.protocol import NumericRing, PrecisionRing
from bladesmith.curves import Bezier
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.surface_tables import build_surface_tables


def random_surfaces(count, seed, degree=1):
    """Between any two circles; of higher degree along tubes, so that they stay real."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        axis = random.normal(size=3)
        spread = 0.4 if degree > 1 else 1.0
        controls = [
            (
                (degree > 1) * k * axis * 0.5 + spread * random.normal(size=3),
                (degree > 1) * axis + spread * random.normal(size=3),
                random.uniform(0.4, 1.2) if degree > 1 else random.uniform(0.2, 1.5),
            )
            for k in range(degree + 1)
        ]
        yield tracer.EvolvedCircles(Bezier(controls), align=True, gaps=degree > 1)


Circle = namedtuple("Circle", "center normal radius")


def controls_of(surface):
    """The circles that were given, flipped where the surface says so."""
    turns = np.where(surface.flipped, -1.0, 1.0)
    return [
        Circle(np.asarray(c, float), turn * np.asarray(n, float) / np.linalg.norm(n), float(r))
        for (c, n, r), turn in zip(surface.segments.source.original_controls, turns, strict=True)
    ]


class Geometry:
    """The surface as it is defined: C' = a C1 + b C2 projected to a circle, on any ring; nothing of the tracer's."""

    def __init__(self, surface, ring, number=float):
        self.ring = ring
        self.like = from_values(cga3d(), ring, (0,), [number(1)])
        self.circles = [self._circle(c, number) for c in controls_of(surface)]

    def scalar(self, x):
        return from_values(cga3d(), self.ring, (0,), [x])

    def vector(self, x):
        return from_values(cga3d(), self.ring, (1, 2, 4), list(x))

    def up(self, x):
        square = self.scalar(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        return self.vector(x) + square / 2 * self.like.basis("ni") + self.like.basis("no")

    def _circle(self, circle, number):
        """C = A ^ B ^ C through three points, normalised."""
        c, n, r = ([number(v) for v in circle.center], [number(v) for v in circle.normal], number(circle.radius))
        length = (n[0] ** 2 + n[1] ** 2 + n[2] ** 2) ** (number(1) / 2)
        n = [x / length for x in n]
        least = min(range(3), key=lambda i: abs(n[i]))
        u = [number(i == least) for i in range(3)]
        u = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
        length = (u[0] ** 2 + u[1] ** 2 + u[2] ** 2) ** (number(1) / 2)
        u = [x / length for x in u]
        v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
        points = [
            self.up([c[i] + r * (cos * u[i] + sin * v[i]) for i in range(3)]) for cos, sin in ((1, 0), (0, 1), (-1, 0))
        ]
        blade = points[0] ^ points[1] ^ points[2]
        norm = (blade * blade).grade(0).scalar() ** (number(1) / 2)
        return blade * self.scalar(1 / norm)

    def circle(self, a):
        """The circle of weight a = 1 - t of the first end."""
        n = len(self.circles) - 1
        parts = (
            self.scalar(comb(n, k) * a ** (n - k) * (1 - a) ** k) * circle for k, circle in enumerate(self.circles)
        )
        mixed = self.scalar(0 * a).sum(parts)
        return (blade_projector(mixed) * mixed).grade(3)

    def parameters(self, a):
        """Centre, normal, which is not of unit length, and radius."""
        circle = self.circle(a)
        ni = circle.basis("ni")
        image = (circle * ni * circle).grade(1)
        weight = -image.scalar_product(ni).scalar()
        center = [image[n].scalar() / weight for n in ("e1", "e2", "e3")]
        plane = (circle ^ ni).dual()
        normal = [plane[n].scalar() for n in ("e1", "e2", "e3")]
        return center, normal, 1 / (normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) ** (a * 0 + 1 / 2)

    def meet(self, origin, direction, a):
        """(L v C), a vector, and its square."""
        line = self.up(origin) ^ self.vector(direction) ^ self.like.basis("ni")
        y = (line & self.circle(a)).grade(1)
        return y, y.scalar_product(y).scalar()


def reference_roots(surface, origin, direction):
    """(t, point) of every sign change of f on a fine grid, refined at 40 digits."""
    numeric = Geometry(surface, NumericRing())
    grid = np.linspace(0, 1, 4001)
    with np.errstate(all="ignore"):
        _, f = numeric.meet(origin, direction, grid)
    ring = PrecisionRing(40)
    number = ring.context.mpf
    precise = Geometry(surface, ring, lambda x: number(x))
    o, d = ([number(float(x)) for x in v] for v in (origin, direction))
    roots = []
    for i in np.nonzero((f[:-1] < 0) != (f[1:] < 0))[0]:
        bracket = (number(grid[i]), number(grid[i + 1]))
        a = ring.context.findroot(
            lambda a: precise.meet(o, d, a)[1], bracket, solver="anderson", tol=1e-60, verify=False, maxsteps=40
        )
        y, _ = precise.meet(o, d, a)
        weight = -y.scalar_product(y.basis("ni")).scalar()
        roots.append((float(1 - a), [float(y[name].scalar() / weight) for name in ("e1", "e2", "e3")]))
    return sorted(roots)


def circles_of(surface, alphas):
    """Centres, unit normals and radii of the surface's circles, from their own geometry."""
    center, normal, _ = Geometry(surface, NumericRing()).parameters(1 - alphas)
    center, normal = np.stack(center, -1), np.stack(normal, -1)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    return center, normal / size, 1 / size


def points_on(surface, alphas, angles):
    """Points of the surface's circles."""
    center, normal, radius = circles_of(surface, alphas)
    u = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.9, [1.0, 0, 0], [0, 1.0, 0]))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    v = np.cross(normal, u)
    return center + radius * (np.cos(angles)[:, None] * u + np.sin(angles)[:, None] * v)


def constants_of(surface):
    engine = engine_for(needs([surface.program_kind], pictures=False))
    (row,) = build_surface_tables(engine, [surface])[surface.program_kind].constants
    return row


def answers_of_both_precisions(ask, origins, directions):
    """What rays of single precision are answered, and the same rays written in double."""
    rays = origins.astype(np.float32), directions.astype(np.float32)
    return ask(*rays), ask(*(x.astype(np.float64) for x in rays))
