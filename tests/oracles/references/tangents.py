"""Rays that miss being tangent by 1e-9, on either side, of linear surfaces: plain geometry, one operation at a time.

Nothing here is exact or needs to be: the references are of the rays that come out. But the same rays must come out
everywhere, so that no operation may be left to a library that orders sums as it likes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..sequences import cross
from .families import Controls, Family, Stream, axes, square

Array = NDArray[np.float64]
Vector = list[Array]
Skew = list[list[float]]
#: How far off, relative to the size of the surface, which is about one.
OFF = 1e-9
#: Half the step in t of differences.
STEP = 2.0**-17
#: How far before the point rays start.
BEFORE = 3.0
METRIC = (1.0, 1.0, 1.0, 1.0, -1.0)


def tangent_rays(family: Family, objects: Controls, s: Stream) -> tuple[Array, Array, Array]:
    """Origins and directions: through a point of the surface, along a tangent, moved off by its normal; and its t."""
    n = family.rays
    t = 0.0625 + 0.875 * s.fraction(n)
    across = s.dyadic(-1, 1, n, 20) * (2.0 if family.kind == "circles" else 0.9375)
    turn = s.dyadic(-1, 1, n, 20) * 2
    side = np.where(np.arange(n) % 2 == 0, OFF, -OFF)
    if family.nature == "grazing":
        side = np.sign(side) * np.ldexp(s.small(n), -10)
    controls = [_bivector(objects, i) for i in range(2)]
    find = _on_circle if family.kind == "circles" else _on_pair
    here, sideways, axis = find(controls, t, across, None)
    after, before = (find(controls, t + step, across, axis)[0] for step in (STEP, -STEP))
    along = _unit([p - q for p, q in zip(after, before, strict=True)])
    sideways = _unit(sideways)
    normal = _unit(cross(along, sideways))
    cosine, sine = _turned(turn)
    direction = _unit([cosine * p + sine * q for p, q in zip(along, sideways, strict=True)])
    origin = [p + side * m - BEFORE * d for p, m, d in zip(here, normal, direction, strict=True)]
    return np.stack(origin, -1), np.stack(direction, -1), t


def _bivector(objects: Controls, i: int) -> Skew:
    """The unit object number i as a skew matrix: of a pair, and of a circle's dual (plane ^ sphere)."""
    if objects.center is not None:
        assert objects.quaternion is not None and objects.radius is not None
        q, c, r = objects.quaternion[i], objects.center[i], objects.radius[i]
        normal = list(axes(q)[2] / square(q))
        d = _dot(normal, list(c))
        e = (_dot(list(c), list(c)) - r * r) / 2
        first = [*normal, d, d]
        second = [x / r for x in (*c, e - 0.5, e + 0.5)]
    else:
        assert objects.a is not None and objects.b is not None
        a, b = list(objects.a[i]), list(objects.b[i])
        apart = [p - q for p, q in zip(a, b, strict=True)]
        size = _dot(apart, apart) / 2
        first, second = ([*x, _dot(x, x) / 2 - 0.5, _dot(x, x) / 2 + 0.5] for x in (a, b))
        second = [x / size for x in second]
    return [[first[j] * second[k] - second[j] * first[k] for k in range(5)] for j in range(5)]


def _projected(controls: list[Skew], t: Array, sign: float) -> tuple[list[Vector], Vector, Vector]:
    """The object at t, and what it makes of infinity, once and twice: its plane and sphere, or direction and centre."""
    mixed = [[(1 - t) * controls[0][j][k] + t * controls[1][j][k] for k in range(5)] for j in range(5)]
    map_ = [[METRIC[k] * mixed[j][k] for k in range(5)] for j in range(5)]
    square_ = [[_dot(map_[j], [row[k] for row in map_]) for k in range(5)] for j in range(5)]
    p = sign * sum(square_[j][j] for j in range(5)) / 2
    fourth = sum(square_[j][k] * square_[k][j] for j in range(5) for k in range(5))
    small = (p - np.sqrt(np.maximum(fourth - p * p, 0.0))) / 2
    blade = [
        [_dot(square_[j], [row[k] for row in mixed]) - sign * small * mixed[j][k] for k in range(5)] for j in range(5)
    ]
    infinity = [0.0, 0.0, 0.0, 1.0, 1.0]
    once = [_dot(row, [METRIC[k] * infinity[k] for k in range(5)]) for row in blade]
    return blade, once, [_dot(row, [METRIC[k] * once[k] for k in range(5)]) for row in blade]


def _on_circle(controls: list[Skew], t: Array, turn: Array, axis: Array | None) -> tuple[Vector, Vector, Array]:
    """A point of the circle at t, the direction along it, and the coordinate axis from which angles count."""
    _, plane, sphere = _projected(controls, t, -1.0)
    weight = sphere[4] - sphere[3]
    center = [x / weight for x in sphere[:3]]
    radius = np.sqrt(_dot(center, center) - (sphere[3] + sphere[4]) / weight)
    normal = _unit(plane[:3])
    size = np.abs(np.stack(normal))
    if axis is None:
        axis = np.where((size[0] <= size[1]) & (size[0] <= size[2]), 0, np.where(size[1] <= size[2], 1, 2))
    u = _unit(cross(normal, [np.where(axis == i, 1.0, 0.0) for i in range(3)]))
    v = cross(normal, u)
    cosine, sine = _turned(turn)
    point = [c + radius * (cosine * p + sine * q) for c, p, q in zip(center, u, v, strict=True)]
    return point, [cosine * q - sine * p for p, q in zip(u, v, strict=True)], axis


def _on_pair(controls: list[Skew], t: Array, place: Array, axis: Array | None) -> tuple[Vector, Vector, Array]:
    """A point of the segment at t, at a place from -1 to 1, and the direction of the segment."""
    _, direction, middle = _projected(controls, t, 1.0)
    weight = middle[4] - middle[3]
    center = [x / weight for x in middle[:3]]
    half = np.sqrt((middle[3] + middle[4]) / weight - _dot(center, center))
    along = _unit(direction[:3])
    return [c + place * half * d for c, d in zip(center, along, strict=True)], along, np.zeros(0)


def _turned(q: Array) -> tuple[Array, Array]:
    """Cosine and sine of an angle of which q is the tangent of the half."""
    return (1 - q * q) / (1 + q * q), 2 * q / (1 + q * q)


def _dot(x: list, y: list) -> Array:  # type: ignore[type-arg]
    total = x[0] * y[0]
    for p, q in zip(x[1:], y[1:], strict=True):
        total = total + p * q
    return total


def _unit(x: Vector) -> Vector:
    length = np.sqrt(_dot(x, x))
    return [p / length for p in x]
