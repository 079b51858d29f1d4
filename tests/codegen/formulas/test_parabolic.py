"""Logarithm, root and exponential of rotors next to parabolic ones: objects that touch, nearly touch, or nearly do not.

The oracle is a series at 50 digits; a bound says what rounding of the coefficients may do. |x| are absolute values and
their product that of the multiplication table with absolute signs. If B = log(R) has relative errors e in its
coefficients, exp(B) is off by e times the integral of |R^s| |B| |R^(1-s)| over s in [0, 1]; R itself is off the group
by R ~R - 1, which no logarithm sees. Coefficients of one weight (n0 alone, neither or both, n_inf alone) share a bound,
as everywhere: a turned object has its noise in other places.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, objects
from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.multivector import Multivector, sqrt
from bladesmith.codegen.rings.protocol import PrecisionRing

from ...support.formulas import precise, series_exp, stock
from ...support.vectors import unit

Array = np.ndarray
ALGEBRA = stock("cga3d")
EVEN, BIVECTOR = ALGEBRA.kind("even"), ALGEBRA.kind("bivector")
BLADES = list(EVEN.blades)
NAMES = [ALGEBRA.blade_name(b) for b in BLADES]
WEIGHTS = np.array([("ni" in name) - ("no" in name) for name in NAMES])
TABLE = [
    (i, j, BLADES.index(b), np.longdouble(c))
    for i, x in enumerate(BLADES)
    for j, y in enumerate(BLADES)
    for b, c in ALGEBRA.product(x, y)
]
REVERSE = np.array([-1.0 if b.bit_count() == 2 else 1.0 for b in BLADES])[:, None]
PRECISE = PrecisionRing(50)
#: R must be known, and be a rotor, to this many of its digits: else its own rounding is more than first order. Bars by
#: that, in units of the bound.
BARS = {1e-6: 1e-12, 1e-9: 1e-13}
GAPS = (0.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
COUNT = 60


# -- long doubles on the even blades, as (16, n) -----------------------------------------------------------------


def product(a: Array, b: Array, signs: bool = True) -> Array:
    out = np.zeros(np.broadcast_shapes(a.shape, b.shape), np.longdouble)
    for i, j, k, c in TABLE:
        out[k] += (c if signs else abs(c)) * a[i] * b[j]
    return out


def absolute_product(*factors: Array) -> Array:
    out = np.abs(factors[0])
    for x in factors[1:]:
        out = product(out, np.abs(x), signs=False)
    return out


def long_exp(b: Array) -> Array:
    """exp(b) by 2^14 squarings of exp(b/2^14) - 1: eps of long doubles times what rounding of b does."""
    x, e = b / 2.0**14, b / 2.0**14 / 12
    for k in range(11, 0, -1):
        e = (product(x, e) + x) / k
    for _ in range(14):
        e = 2 * e + product(e, e)
    e[0] += 1
    return e


def shared(bound: Array) -> Array:
    """The largest of each weight."""
    out = np.empty_like(bound)
    for w in (-1, 0, 1):
        alike = w == WEIGHTS
        out[alike] = bound[alike].max(0)
    return out


def columns(x: Any) -> Array:
    """(16, n) long doubles of runtime multivectors."""
    return np.moveaxis(x.as_kind("even", check=False).values.astype(np.longdouble), -1, 0)


def bound(r: Array, b: Array) -> Array:
    """|R| and the integral of |R^s| |B| |R^(1-s)| by five nodes."""
    powers = {k: long_exp(b * k / 4) for k in range(5)}
    weights = {0: 7 / 90, 1: 32 / 90, 2: 12 / 90, 3: 32 / 90, 4: 7 / 90}
    return shared(np.abs(r) + sum(w * absolute_product(powers[k], b, powers[4 - k]) for k, w in weights.items()))


def worst(r: Any, told: float = np.inf) -> tuple[float, int]:
    """Errors of exp(log R), sqrt(R)^2 and of the library's exp, over bound and bar; and how many rotors are known.

    Those that are off the group by more than ``told`` may be told, by a status.
    """
    regular = np.asarray(r.status) == Status.OK
    r = r[regular]
    log, root = r.log(), r.sqrt()
    one, b, half, own = columns(r), columns(log), columns(root), columns(log.exp())
    off = product(one, one * REVERSE)
    off[0] -= 1
    size = np.finfo(float).eps * absolute_product(one, one)[0]
    largest = np.maximum(np.maximum(size, np.abs(off).max(0) / np.abs(one).max(0)), np.abs(off[0]))
    known = largest < max(BARS)
    known &= (np.asarray(log.status) == Status.OK) | ~(np.abs(off).max(0) > told)
    one, b, half, own, off = (x[:, known] for x in (one, b, half, own, off))
    bars = np.where(largest[known] < min(BARS), BARS[min(BARS)], BARS[max(BARS)])
    assert (np.asarray(log.status)[known] == Status.OK).all() and (np.asarray(root.status)[known] == Status.OK).all()
    scale, again = bound(one, b), long_exp(b)
    allowed = 2 * shared(absolute_product(shared(np.abs(off)), one))
    errors = [
        np.maximum(np.abs(x) - y, 0) / np.maximum(scale, 1e-300)
        for x, y in ((again - one, allowed), (product(half, half) - one, allowed), (own - again, 0))
    ]
    assert all(np.isfinite(e).all() for e in errors)
    return max(float((e / bars).max(initial=0)) for e in errors), int(known.sum())


# -- families ----------------------------------------------------------------------------------------------------


def integer_circles(rng: np.random.Generator, count: int) -> tuple[Any, Any]:
    """Coplanar circles that touch, with small integer centres, normals and radii, oriented alike where they do."""
    steps = np.array([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 2, 2, 3], [2, 3, 6, 7], [3, 4, 0, 5]])
    step = steps[rng.integers(0, len(steps), 4 * count)]
    normal = np.cross(step[:, :3], rng.integers(-3, 4, (4 * count, 3)))
    times = rng.integers(1, 4, 4 * count) * rng.choice([-1, 1], 4 * count)
    distance, first = np.abs(times) * step[:, 3], rng.integers(1, 8, 4 * count)
    second, sense = np.abs(first - distance), np.where(first < distance, -1, 1)
    center = rng.integers(-3, 4, (4 * count, 3))
    good = np.flatnonzero((np.abs(normal).sum(1) > 0) & (second > 0))[:count]
    other = center + times[:, None] * step[:, :3]
    pick = [np.asarray(x, float)[good] for x in (center, normal, first, other, normal * sense[:, None], second)]
    return cga.circle(*pick[:3]), cga.circle(*pick[3:])


def touching(name: str, gap: Any, far: Any, decades: Any, count: int, seed: int) -> tuple[Any, Any]:
    """Two objects with a common tangent at one point, but for a gap, of sizes 10^-decades to 10^decades."""
    rng = np.random.default_rng(seed)
    gap, far, decades = (np.broadcast_to(x, (count,)) for x in (gap, far, decades))
    sizes = 10 ** (decades * rng.uniform(-1, 1, (3, count)))
    place = rng.normal(size=(count, 3)) * sizes[2][:, None] + far[:, None] * unit(rng.normal(size=(count, 3)))
    tangent = unit(rng.normal(size=(count, 3)))
    to1, to2 = (unit(np.cross(tangent, rng.normal(size=(count, 3)))) for _ in range(2))
    r1, r2 = sizes[0], sizes[1]
    other = place + (gap * r1)[:, None] * unit(rng.normal(size=(count, 3)))
    sense = rng.choice([-1.0, 1.0], count)
    first = cga.circle(place + to1 * r1[:, None], np.cross(tangent, to1), r1)
    if name == "coplanar circles":
        normal = np.cross(tangent, to1)
        return first, cga.circle(place + to1 * (sense * r2 + gap * r1)[:, None], normal * sense[:, None], r2)
    if name == "circles":
        return first, cga.circle(other + to2 * r2[:, None], np.cross(tangent, to2), r2)
    if name == "circles that nearly share a tangent":
        turned = unit(tangent + gap[:, None] * rng.normal(size=(count, 3)))
        to2 = unit(np.cross(turned, rng.normal(size=(count, 3))))
        return first, cga.circle(place + to2 * r2[:, None], np.cross(turned, to2), r2)
    if name == "circle and tangent":
        return first, cga.line(other, tangent)
    if name == "point pairs":
        ends = (place + unit(rng.normal(size=(count, 3))) * r[:, None] for r in (r1, r2))
        return cga.point_pair(place, next(ends)), cga.point_pair(other, next(ends))
    if name == "spheres":
        second = cga.sphere(place + to1 * (sense * r2 + gap * r1)[:, None], r2)
        return cga.sphere(place + to1 * r1[:, None], r1), second
    plane = cga.plane(to1, ((place + (gap * r1)[:, None] * to1) * to1).sum(-1))
    return cga.sphere(place + to1 * r1[:, None], r1), plane


FAMILIES = (
    "coplanar circles",
    "circles",
    "circles that nearly share a tangent",
    "circle and tangent",
    "point pairs",
    "spheres",
    "sphere and plane",
)


@pytest.mark.slow
def test_touching_circles_with_integer_coordinates() -> None:
    a, b = integer_circles(np.random.default_rng(1), 5000)
    error, known = worst(objects.rotor_between(a, b))
    print(error)
    assert known >= 4990 and error < 1


def test_the_pair_that_was_found() -> None:
    """Its logarithm is <R>_2; it was off by 4 %."""
    a, b = cga.circle([-1, -2, 2], [1, 1, 0], 2.0), cga.circle([-1, -2, -1], [-1, -1, 0], 1.0)
    r = objects.rotor_between(a, b)
    assert r.log().status == Status.OK
    assert np.abs((r.log() - r.grade(2)).values).max() <= 1e-15
    assert np.abs((r.log().exp() - r).values).max() <= 1e-15
    assert np.abs((r.sqrt() * r.sqrt() - r).values).max() <= 1e-15
    middle = objects.interpolate(a, b, alpha=0.5, method="rotor")
    half = objects.rotor_between(a, middle)
    assert np.abs((half * half - r).values).max() <= 1e-14


@pytest.mark.parametrize("name", FAMILIES)
def test_objects_that_touch_or_nearly_do(name: str) -> None:
    """Every gap, near and a thousand units away, with sizes from 1/3 to 3 and from 1e-3 to 1e3."""
    gap, far, decades = (np.tile(x.ravel(), COUNT) for x in np.meshgrid(GAPS, (0.0, 1e3), (0.5, 3.0)))
    error, known = worst(objects.rotor_between(*touching(name, gap, far, decades, len(gap), 7)))
    print(error, known / len(gap))
    assert error < 1
    assert known > 0.5 * len(gap)


@pytest.mark.slow
@pytest.mark.parametrize("far", [0.0, 1e3])
@pytest.mark.parametrize("name", FAMILIES)
def test_sizes_from_the_tiny_to_the_huge(name: str, far: float) -> None:
    """Sizes from 1e-10 to 1e10: rounding of a rotor may take it off the group, which is told, or it is right."""
    gap = np.tile(np.array(GAPS), COUNT)
    error, known = worst(objects.rotor_between(*touching(name, gap, far, 10.0, len(gap), 7)), told=1e-9)
    print(error, known / len(gap))
    assert error < 1
    assert known > 0.15 * len(gap)


# -- against 50 digits -------------------------------------------------------------------------------------------


def exact_log(r: Multivector) -> Multivector:
    """The logarithm of the unit rotor nearest to R: of its 2^40th root a few terms of artanh, times 2^40."""
    square = r * ~r
    s0, s4 = square.grade(0), square.grade(4)
    r = r * (1 - s4 / (2 * s0)) / sqrt(s0)
    for _ in range(40):
        r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
        norm = sqrt((1 + r0) * (1 + r0) - (r4 * r4).grade(0))
        k = sqrt(1 + r0 + norm)
        r = k / 2 + r4 / (2 * k) + (v * k - (r4 * v).grade(2) / k) / (2 * norm)
    v = r.grade(2)
    return (v - (v * v * v).grade(2) / 6) * 2**40


@cache
def small_families() -> list[Any]:
    pairs = [touching(name, gap, 0.0, 1.0, 2, 3) for name in FAMILIES for gap in GAPS[::3]]
    return [objects.rotor_between(*pair) for pair in pairs]


@pytest.mark.slow
def test_logarithms_at_50_digits() -> None:
    """log of the rotor as it is given, to |R|^3 and |B|: what rounding of R and of B does."""
    for r in small_families():
        log = r.log()
        for row, b, status in zip(columns(r).T, columns(log).T, np.asarray(r.status), strict=True):
            if status == Status.OK:
                exact = exact_log(precise(EVEN, row, PRECISE))
                error = np.array([abs(float(v) - float(x)) for v, x in zip(EVEN.values(exact), b, strict=True)])
                size = absolute_product(row[:, None], row[:, None], row[:, None]) + np.abs(b)[:, None]
                assert (error <= 1e-13 * shared(size)[:, 0]).all()


@pytest.mark.slow
def test_exponentials_at_50_digits() -> None:
    for r in small_families():
        log = r.log()
        b, own = columns(log), columns(log.exp())
        scale = bound(own, b)
        for k in range(len(b.T)):
            x = series_exp(precise(BIVECTOR, [b[BLADES.index(blade), k] for blade in BIVECTOR.blades], PRECISE))
            error = np.array([abs(float(v) - float(y)) for v, y in zip(EVEN.values(x), own[:, k], strict=True)])
            assert (error <= 1e-14 * scale[:, k]).all()
