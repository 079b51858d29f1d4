"""Circles, point pairs and their sums at 50 digits, from points and inner products alone: no formula of the package.

Vectors of the conformal space are (x1, x2, x3, n0, n_inf) with n0 . n_inf = -1; trivectors and bivectors are wedges of
them, sums of which are judged by the eigenvalues of x -> B . x.
"""

from __future__ import annotations

from itertools import permutations

import mpmath
from mpmath import mpf

from bladesmith import cga3d as cga

from .sequences import cross

#: Bits of the blades of the stored algebra belong to e1, e2, e3, n0, n_inf.
AXES = 5
#: What 50 digits leave of zero, for objects of ordinary size.
NOTHING = 1e-30


def exact(values):
    return [mpf(float(v)) for v in values]


def dot(a, b):
    return mpmath.fsum(x * y for x, y in zip(a, b, strict=True))


def inner(x, y):
    return dot(x[:3], y[:3]) - x[3] * y[4] - x[4] * y[3]


def up(x):
    return [*x, mpf(1), dot(x, x) / 2]


def unit(v):
    size = mpmath.sqrt(dot(v, v))
    return [x / size for x in v]


def across(n):
    """Two unit vectors that make a right-handed frame with n."""
    other = [mpf(1), mpf(0), mpf(0)] if abs(n[0]) < 0.7 else [mpf(0), mpf(1), mpf(0)]
    u = unit(cross(n, other))
    return u, cross(n, u)


def points_of(circle):
    """Three points of a circle, counter-clockwise."""
    center, normal, radius = circle
    u, v = across(unit(normal))
    steps = [(mpf(1), mpf(0)), (mpf(-1) / 2, mpmath.sqrt(3) / 2), (mpf(-1) / 2, -mpmath.sqrt(3) / 2)]
    return [[c + radius * (x * a + y * b) for c, a, b in zip(center, u, v, strict=True)] for x, y in steps]


def wedge(vectors, blades):
    """Coefficients of a wedge of vectors on blades, by determinants."""
    return [_minor(vectors, [i for i in range(AXES) if blade >> i & 1]) for blade in blades]


def _minor(vectors, axes):
    terms = (_sign(p) * mpmath.fprod(v[a] for v, a in zip(vectors, p, strict=True)) for p in permutations(axes))
    return mpmath.fsum(terms)


def _sign(p):
    return (-1) ** sum(p[i] > p[j] for i in range(len(p)) for j in range(i + 1, len(p)))


def circle_row(circle, center, size):
    """Unit coefficients of a circle seen from a frame: those on e_ij n0 are the normal over the radius."""
    moved = [(c - o) / size for c, o in zip(circle[0], center, strict=True)], circle[1], circle[2] / size
    blades = cga.kind("circle").blades
    row = wedge([up(p) for p in points_of(moved)], blades)
    weight = mpmath.sqrt(mpmath.fsum(x * x for x, b in zip(row, blades, strict=True) if b >> 3 & 1 and not b >> 4 & 1))
    return [x / (weight * moved[2]) for x in row]


def pair_row(pair, center, size):
    """Unit coefficients of a point pair seen from a frame: |A ^ B| is half the squared distance."""
    a, b = ([(x - o) / size for x, o in zip(p, center, strict=True)] for p in pair)
    row = wedge([up(a), up(b)], cga.kind("point_pair").blades)
    weight = dot([x - y for x, y in zip(a, b, strict=True)], [x - y for x, y in zip(a, b, strict=True)]) / 2
    return [x / weight for x in row]


def agreement(first, second, kind):
    """<X Y>_0 of two objects, up to a positive factor: from distances between their points."""
    if kind == "circle":
        p, q = points_of(first), points_of(second)
    else:
        p, q = first, second
    squares = mpmath.matrix([[inner(up(a), up(b)) for b in q] for a in p])
    return -mpmath.det(squares)


# -- is a sum real? ------------------------------------------------------------------------------------------


def bivector(obj, kind):
    """Two vectors whose wedge is a unit point pair, or the dual of a unit circle."""
    if kind == "point_pair":
        a, b = obj
        gap = [x - y for x, y in zip(a, b, strict=True)]
        return up(a), [x * 2 / dot(gap, gap) for x in up(b)]
    center, normal, radius = obj
    sphere = up(center)
    sphere[4] -= radius * radius / 2
    n = unit(normal)
    return [x / radius for x in sphere], [*n, mpf(0), dot(n, center)]


def squares_of_sum(weights, objects, kind):
    """Squares a >= b of the two commuting blades that a weighted sum is made of (real numbers, or a pair)."""
    metric = mpmath.eye(AXES)
    metric[3, 3] = metric[4, 4] = 0
    metric[3, 4] = metric[4, 3] = -1
    total = mpmath.zeros(AXES)
    for w, obj in zip(weights, objects, strict=True):
        x, y = (mpmath.matrix(v) for v in bivector(obj, kind))
        total += w * (x * y.T - y * x.T)
    step = total * metric
    two, four = step * step, step * step * step * step
    trace = lambda m: mpmath.fsum(m[i, i] for i in range(AXES))  # noqa: E731
    s = trace(two) / 2
    product = (s * s - trace(four) / 2) / 2
    sign = 1 if kind == "point_pair" else -1
    return sign * s, (product if abs(product) > NOTHING else mpf(0))  # a + b, a b


def is_real(weights, objects, kind):
    """Whether a sum has a projection to a real object: one square positive, and larger than the other."""
    s, product = squares_of_sum(weights, objects, kind)
    return product < 0 or (s > 0 and s * s - 4 * product > 0)


def bernstein(n, t):
    return [mpmath.binomial(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)]
