"""Rotors between objects against 50 digits.

The oracle builds the objects from points with mpmath and takes the thesis's own form of the rotor, (2.4) with the sign
corrected: at 50 digits its cancellations do no harm.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, objects
from bladesmith.codegen.algebra.multivector import Multivector, from_values, sqrt
from bladesmith.codegen.rings.protocol import PrecisionRing

from ...support.formulas import stock
from ...support.objects.rotors import MIXTURES, NAMES, coefficients, parameters, placed, square

PRECISE = PrecisionRing(50)


def precise_vector(v: Any) -> Multivector:
    """A Euclidean vector of mpmath numbers."""
    axes = [stock("cga3d").parse_blade(name)[0] for name in ("e1", "e2", "e3")]
    return from_values(stock("cga3d"), PRECISE, axes, [PRECISE.context.mpf(float(c)) for c in v])


def precise_point(v: Multivector) -> Multivector:
    return (v * v).grade(0) / 2 * v.basis("ni") + v + v.basis("no")


def precise_object(kind: str, center: Any, axis: Any, radius: Any) -> Multivector:
    """The same object, spanned by points with 50 digits."""
    c, m = precise_vector(center), precise_vector(axis)
    r = from_values(c.algebra, PRECISE, [0], [PRECISE.context.mpf(float(radius))])
    m = m / sqrt((m * m).grade(0))
    ni = c.basis("ni")
    if kind == "point_pair":
        return precise_unit(precise_point(c - r * m) ^ precise_point(c + r * m))
    if kind == "flat_point":
        return precise_point(c) ^ ni
    if kind == "line":
        return precise_unit(precise_point(c) ^ precise_point(c + m) ^ ni)
    u = precise_vector(np.eye(3)[int(np.argmin(np.abs(axis)))])
    u = u - (u * m).grade(0) * m
    u = u / sqrt((u * u).grade(0))
    v = -((m ^ u) * m.basis("e123")).grade(1)  # m x u
    if kind == "plane":
        return precise_unit(precise_point(c) ^ precise_point(c + u) ^ precise_point(c + v) ^ ni)
    on_circle = precise_point(c + r * u) ^ precise_point(c + r * v) ^ precise_point(c - r * u)
    if kind == "circle":
        return precise_unit(on_circle)
    x = precise_unit(on_circle ^ precise_point(c + r * m))
    return x if float((x.dual() | ni).scalar()) < 0 else -x  # outward


def precise_unit(x: Multivector) -> Multivector:
    return x / sqrt(-(x * ~x).grade(0))


def precise_rotor(x1: Multivector, x2: Multivector) -> Multivector:
    """(2.4) to (2.7) with S = 1/(2 beta) - beta K4."""
    (g,) = x1.grades
    gamma = -1 if g == 4 else 1
    k = 2 + gamma * (x1 * x2 + x2 * x1)
    k0, k4 = k.grade(0), k.grade(4)
    if g == 4:
        if k0.scalar() < 0:
            return precise_rotor(x1, -x2)
        return (1 + gamma * (x2 * x1)) / sqrt(k0)
    mu = k0 * k0 - (k4 * k4).grade(0)
    beta = 1 / sqrt(2 * (sqrt(mu) + k0))
    return (1 / (2 * beta) - beta * k4) * (1 + gamma * (x2 * x1)) / sqrt(mu)


def as_row(r: Any, x: Multivector) -> Any:
    """Coefficients of a precise multivector on a runtime multivector's blades, as float64."""
    layout = stock("cga3d").kind("even") if 0 in r.grades else stock("cga3d").kind(NAMES[max(r.grades)])
    values = dict(zip(layout.blades, layout.values(x), strict=True))
    return np.array([float(values[blade]) for blade in r._type.blades])


@cache
def precise_rotors(first: str, second: str, seed: int, count: int, shift: float) -> tuple[Any, Any, list[Multivector]]:
    """Parameters of random pairs near (shift, shift, shift), and their rotors at 50 digits."""
    rng = np.random.default_rng(seed)
    one, two = parameters(rng, count), parameters(rng, count)
    if shift:  # the place of an object of size 0.1 is not known to 9 digits of it
        one, two = (one[0] + shift, one[1], one[2] + 1), (two[0] + shift, two[1], two[2] + 1)
    exact = [
        precise_rotor(
            precise_object(first, *(p[i] for p in one)),
            precise_object(second, *(p[i] for p in two)),
        )
        for i in range(count)
    ]
    return one, two, exact


@pytest.mark.parametrize("first, second", MIXTURES)
def test_the_rotor_is_that_of_the_thesis(first: str, second: str) -> None:
    one, two, exact = precise_rotors(first, second, 5, 12, 0.0)
    r = objects.rotor_between(placed(first, *one), placed(second, *two))
    expected = np.stack([as_row(r, x) for x in exact])
    assert np.max(np.abs(r.values - expected).max(-1) / square(r)) <= 1e-12


@pytest.mark.parametrize("first, second", MIXTURES)
def test_rotors_a_million_units_away_keep_nine_digits(first: str, second: str) -> None:
    one, two, exact = precise_rotors(first, second, 6, 12, 1e6)
    r = objects.rotor_between(placed(first, *one), placed(second, *two))
    expected = np.stack([as_row(r, x) for x in exact])
    size = np.abs(expected).max(-1)
    assert np.max(np.abs(r.values - expected).max(-1) / size) <= 1e-9


@pytest.mark.parametrize("kind", ["line", "plane"])
def test_the_unique_rotor_is_kept_to_the_last_angle_that_tells_it(kind: str) -> None:
    one = (np.array([0.2, 1.0, -0.3]), np.array([0.0, 0.0, 1.0]), 1.0)
    for exponent in (1, 3, 5, 6):
        angle = np.pi - 10.0**-exponent
        two = (np.array([1.0, 0.5, 0.7]), np.array([np.sin(angle), 0.0, np.cos(angle)]), 1.0)
        r = objects.rotor_between(placed(kind, *one), placed(kind, *two))
        expected = as_row(r, precise_rotor(precise_object(kind, *one), precise_object(kind, *two)))
        assert r.status == Status.OK
        assert np.abs(r.values - expected).max() <= 1e-14 * 10.0**exponent * np.abs(expected).max()


@pytest.mark.parametrize("kind", ["line", "plane"])
def test_lines_and_planes_that_meet_keep_it_to_the_last_digit_of_the_sine(kind: str) -> None:
    """pi - e between them, in one place: unique while e is above 64 rounding units, and known to EPS/e."""
    place = np.array([0.2, 1.0, -0.3])
    one = (place, np.array([0.0, 0.0, 1.0]), 1.0)
    for exponent in (6.5, 6.8, 7, 8, 9, 10, 11, 12, 13):
        e = 10.0**-exponent
        two = (place, np.array([0.6 * e, 0.8 * e, -1.0]), 1.0)
        x, y = placed(kind, *one), placed(kind, *two)
        r = objects.rotor_between(x, y)
        expected = as_row(r, precise_rotor(precise_object(kind, *one), precise_object(kind, *two)))
        assert r.status == Status.OK
        assert np.abs(r.values - expected).max() <= 4e-15 / e
        assert np.abs(coefficients(r >> x) - coefficients(y)).max() <= 1e-14
    opposite = objects.rotor_between(placed(kind, *one), placed(kind, place, np.array([1e-15, 0, -1.0]), 1.0))
    assert opposite.status == Status.NOT_UNIQUE
