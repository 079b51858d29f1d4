"""The surfaces and rays of the reference files, made again from their seeds on every machine.

Raw bits of PCG64 and elementwise operations that IEEE 754 rounds correctly: nothing here depends on the version of
NumPy, on the processor, or on an order of summation. What is no dyadic fraction is what its rounded value says.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SEED = 20261121
#: Places after the binary point of coarse numbers.
COARSE, FINE = 8, 20
#: Steps of the stored logarithms of condition numbers, per decade.
PER_DECADE = 8
#: The code of a margin of one.
MARGIN_ZERO = 160
#: How far rays start from where they aim, in lengths of their direction.
AWAY = 4.0


class Stream:
    """Numbers from the raw bits of one seed."""

    def __init__(self, *seed: int) -> None:
        self._bits = np.random.PCG64([SEED, *seed])

    def fraction(self, shape: Any = ()) -> Array:
        """Numbers in [0, 1), multiples of 2^-53."""
        count = int(np.prod(shape))
        return ((self._bits.random_raw(count) >> np.uint64(11)).astype(float) * 2.0**-53).reshape(shape)

    def whole(self, low: int, high: int, shape: Any = ()) -> Array:
        """Whole numbers from low to high, both included."""
        return np.floor(low + self.fraction(shape) * (high + 1 - low))

    def dyadic(self, low: float, high: float, shape: Any = (), places: int = COARSE) -> Array:
        """Multiples of 2^-places."""
        scale = 2.0**places
        return self.whole(int(low * scale), int(high * scale), shape) / scale

    def small(self, shape: Any = ()) -> Array:
        """Positive numbers from 2^-50 to 2^-10, their logarithms spread evenly."""
        return np.ldexp(1 + self.fraction(shape), -self.whole(11, 50, shape).astype(int))


@dataclass(frozen=True)
class Family:
    """Surfaces of one sort, each with the same number of rays.

    Attributes
    ----------
    kind : "circles" or "pairs"
    curve : "bezier" or "spline" (Kochanek-Bartels)
    controls : int
        Objects of each curve.
    nature : "random", "tangent", "cospherical", "far" or "grazing" (tangent to about the rounding error)
    surfaces, rays : int
    number : int
        Of its seeds.
    """

    name: str
    kind: str
    curve: str
    controls: int
    nature: str
    surfaces: int
    rays: int
    number: int


def _families() -> dict[str, Family]:
    found: dict[str, Family] = {}
    for kind in ("circles", "pairs"):
        for nature, surfaces, rays in (
            ("random", 200, 500), ("tangent", 100, 100), ("cospherical", 100, 100), ("far", 100, 100),
            ("grazing", 50, 40),
        ):  # fmt: skip
            name = f"{kind}_{nature}"
            found[name] = Family(name, kind, "bezier", 2, nature, surfaces, rays, len(found))
        for word, curve, controls in (("quadratic", "bezier", 3), ("cubic", "bezier", 4), ("spline", "spline", 4)):
            name = f"{kind}_{word}"
            found[name] = Family(name, kind, curve, controls, "random", 100, 100, len(found))
    return found


FAMILIES = _families()


@dataclass(frozen=True)
class Controls:
    """Parameters of a surface's objects, near the origin, and where the scene stands.

    Attributes
    ----------
    center, quaternion, radius : (n, 3), (n, 4), (n,)
        Of circles: the columns of the quaternion's matrix are u, v and the normal, all of the length of its square.
    a, b : (n, 3)
        End points of pairs.
    shape : (3, n)
        Tension, bias and continuity of splines.
    shift : (3,)
        Whole numbers: what is added to all positions in the world.
    """

    shift: Array
    shape: Array
    center: Array | None = None
    quaternion: Array | None = None
    radius: Array | None = None
    a: Array | None = None
    b: Array | None = None

    @property
    def middles(self) -> Array:
        """Centres of the objects."""
        if self.center is not None:
            return self.center
        assert self.a is not None and self.b is not None
        return np.asarray((self.a + self.b) / 2)

    def given(self) -> list[tuple[Any, ...]]:
        """Parameters in the world: (center, normal, radius), or (a, b)."""
        if self.center is not None:
            assert self.quaternion is not None and self.radius is not None
            normal = axes(self.quaternion)[2]
            return [(c + self.shift, n, float(r)) for c, n, r in zip(self.center, normal, self.radius, strict=True)]
        assert self.a is not None and self.b is not None
        return [(a + self.shift, b + self.shift) for a, b in zip(self.a, self.b, strict=True)]


def axes(q: Array) -> tuple[Array, Array, Array]:
    """Columns (..., 3) of the matrix of quaternions (..., 4), times their squares: whole numbers from whole numbers."""
    w, x, y, z = (q[..., i] for i in range(4))
    u = [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)]
    v = [2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)]
    n = [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z]
    return np.stack(u, -1), np.stack(v, -1), np.stack(n, -1)


def square(q: Array) -> Array:
    """Squares of quaternions: the length of their axes."""
    return np.asarray(q[..., 0] * q[..., 0] + q[..., 1] * q[..., 1] + q[..., 2] * q[..., 2] + q[..., 3] * q[..., 3])


def controls(family: Family, surface: int, attempt: int) -> Controls:
    """The objects of one surface; attempts that were not real all the way are skipped by the file of references."""
    s = Stream(family.number, surface, attempt)
    n = family.controls
    shift = np.zeros(3)
    if family.nature == "far":
        shift = s.whole(-1_000_000, 1_000_000, 3)
        shift[surface % 3] = 1_000_000.0
    shape = s.dyadic(-0.5, 0.5, (3, n)) * (surface % 2) if family.curve == "spline" else np.zeros((3, n))
    if family.nature == "cospherical":
        make = _near_sphere if family.kind == "circles" else _near_circle
        return make(s, surface, shift, shape)
    places = FINE if family.nature == "far" else COARSE
    # along a path that every second surface follows closely
    is_tube = surface % 2 == 1 or n > 2
    path = np.cumsum(s.dyadic(-0.5, 0.5, (n, 3), places) + s.dyadic(-0.75, 0.75, (1, 3), places), axis=0)
    middle = path - path[n // 2] if is_tube else s.dyadic(-1.5, 1.5, (n, 3), places)
    if family.kind == "circles":
        q = s.whole(-7, 7, (n, 4))
        if is_tube:
            q = q + 4 * s.whole(-7, 7, (1, 4))
        return Controls(shift, shape, center=middle, quaternion=q, radius=s.dyadic(0.25, 1.5, n, places))
    half = s.dyadic(-1, 1, (n, 3), places)
    if is_tube:
        half = half / 2 + s.dyadic(-1, 1, (1, 3), places)
    return Controls(shift, shape, a=middle - half, b=middle + half)


def _near_sphere(s: Stream, surface: int, shift: Array, shape: Array) -> Controls:
    """Two circles that miss lying on the unit sphere; each eighth pair is coaxial, on one sphere exactly."""
    q = s.whole(-7, 7, (2, 4))
    if surface % 8 == 0:
        axis = surface // 8 % 3
        middle = np.zeros((2, 3))
        middle[:, axis] = s.dyadic(-1, 1, 2)
        along = np.array([[1.0, 0, 1, 0], [1.0, -1, 0, 0], [1.0, 0, 0, 0]])[axis]
        return Controls(shift, shape, center=middle, quaternion=np.stack([along, along]), radius=s.dyadic(0.25, 1, 2))
    normal = axes(q)[2] / square(q)[:, None]
    h = s.dyadic(-0.75, 0.75, 2)
    off = s.small() * s.dyadic(-1, 1, (2, 3))
    if surface % 8 == 1:  # through one point: M4 is null, and not small
        u = axes(q)[0] / square(q)[:, None]
        radius = s.dyadic(0.25, 1, 2)
        return Controls(shift, shape, center=off - radius[:, None] * u, quaternion=q, radius=radius)
    return Controls(shift, shape, center=h[:, None] * normal + off, quaternion=q, radius=np.sqrt(1 - h * h))


def _near_circle(s: Stream, surface: int, shift: Array, shape: Array) -> Controls:
    """Two point pairs that miss lying on one circle; each eighth two share a point, and lie on one exactly."""
    q = s.whole(-7, 7, 4)
    u, v, _ = (axis / square(q) for axis in axes(q))
    w = s.dyadic(-2, 2, 4)
    ends = ((1 - w * w) / (1 + w * w))[:, None] * u + (2 * w / (1 + w * w))[:, None] * v
    ends = ends + s.small() * s.dyadic(-1, 1, (4, 3))
    if surface % 8 == 0:
        ends = s.dyadic(-1, 1, (4, 3))
        ends[2] = ends[0]
    return Controls(shift, shape, a=ends[[0, 2]], b=ends[[1, 3]])


def ray_stream(family: Family, surface: int) -> Stream:
    """What the rays of a surface are drawn from."""
    return Stream(family.number, surface, 1 << 20)


def rays(family: Family, surface: int, objects: Controls) -> tuple[Array, Array]:
    """Origins and directions (rays, 3) near the origin, aimed where the surface is."""
    s = ray_stream(family, surface)
    if family.nature in ("tangent", "grazing"):
        from .tangents import tangent_rays

        return tangent_rays(family, objects, s)[:2]
    count = family.rays
    places = FINE if family.nature == "far" else COARSE
    which = s.whole(0, len(objects.middles) - 2, count).astype(int)
    share = s.fraction((2, count, 1))
    if objects.a is None or objects.b is None:
        middle, around = objects.middles[which], 1.0
    else:  # on the bilinear patch of two neighbours
        first, second = ((1 - share[0]) * objects.a[i] + share[0] * objects.b[i] for i in (which, which + 1))
        middle, around = (1 - share[1]) * first + share[1] * second, 0.125
    target = np.round(middle * 2.0**COARSE) / 2.0**COARSE + s.dyadic(-around, around, (count, 3), places)
    direction = s.dyadic(-1, 1, (count, 3), places)
    direction[:, 0] = np.where(direction[:, 0] == 0, 1.0, direction[:, 0])
    return target - AWAY * direction, direction


def input_bytes(given: list[tuple[Any, ...]], origins: Array, directions: Array) -> bytes:
    """What a surface and its rays are made from."""
    flat = [np.ravel(x) for control in given for x in control]
    return np.concatenate([*flat, origins.ravel(), directions.ravel()]).astype("<f8").tobytes()
