"""`classify` against exact arithmetic: the sign of Gram's determinant of the vectors that an object is the dual of.

A sphere, circle or point pair is the meet of one, two or three spheres and planes, so its exact name follows from the
floating-point coefficients of these. It must be found wherever the determinant is more than the tolerance of the terms
that the coefficients were summed from.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Multivector
from bladesmith import cga3d as cga

COUNT = 8_000  # of each of some hundred families
TOLERANCE = 4096 * 2.0**-52
REAL = {1: "sphere", 2: "circle", 3: "point pair"}


def integers(values: np.ndarray) -> np.ndarray:
    """Floating-point numbers times 2^400, as Python integers."""
    mantissa, exponent = np.frexp(values)
    shift = np.where(values == 0, 0, exponent - 53 + 400).astype(object)
    whole = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    assert (shift >= 0).all()
    return whole << shift


def exact_sign(vectors: list[np.ndarray]) -> np.ndarray:
    """Sign of Gram's determinant of rows e1, e2, e3, no, ni: +1 for real objects, -1 for imaginary ones."""
    rows = [integers(v) for v in vectors]

    def inner(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a[:, :3] * b[:, :3]).sum(-1) - a[:, 3] * b[:, 4] - a[:, 4] * b[:, 3]

    g = [[inner(a, b) for b in rows] for a in rows]
    det = g[0][0]
    if len(rows) > 1:
        det = g[0][0] * g[1][1] - g[0][1] ** 2
    if len(rows) > 2:
        det = det * g[2][2] + 2 * g[0][1] * g[1][2] * g[0][2] - g[0][0] * g[1][2] ** 2 - g[1][1] * g[0][2] ** 2
    return np.sign(det).astype(int)


def written(vectors: list[np.ndarray]) -> np.ndarray:
    """Scale of the errors of the squared outer product: sums of absolute terms by weight (-1, 0, 1)."""
    sizes = [(np.abs(v[:, 3]), np.abs(v[:, :3]).sum(-1), np.abs(v[:, 4])) for v in vectors]

    def times(x: Any, y: Any) -> Any:
        return (x[0] * y[1] + x[1] * y[0], x[0] * y[2] + x[2] * y[0] + x[1] * y[1], x[1] * y[2] + x[2] * y[1])

    low, level, high = reduce(times, sizes)
    return np.asarray(2 * low * high + level**2)


def check(objects: list[Multivector], meet: Multivector, least: float) -> None:
    """The names of all items whose sign is known; these are at least so large a part."""
    vectors = [np.stack([x.dual()[b] for b in ("e1", "e2", "e3", "no", "ni")], -1) for x in objects]
    sign = exact_sign(vectors)
    name = REAL[len(objects)]
    expected = np.where(sign > 0, name, f"imaginary {name}")
    square = np.abs((meet * ~meet)["1"])
    known = square > 8 * TOLERANCE * written(vectors)
    assert known.mean() >= least
    wrong = known & (cga.classify(meet) != expected)
    assert not wrong.any(), (np.flatnonzero(wrong)[:5], expected[wrong][:5], cga.classify(meet)[wrong][:5])
    assert bs.objects.is_blade(meet[known][:200]).all() or (written(vectors) > 1e6).any()


@pytest.mark.parametrize(("distance", "least"), [(0.0, 0.99), (1.0, 0.99), (1e2, 0.9), (1e4, 0.5)])
@pytest.mark.parametrize("decades", [0, 3])
@pytest.mark.parametrize("family", ["general", "coaxial"])
def test_rounds_against_exact_signs(family: str, decades: int, distance: float, least: float) -> None:
    rng = np.random.default_rng([int(distance), decades, family == "coaxial"])
    size = 10.0 ** rng.uniform(-decades, decades, COUNT)
    about = distance * rng.normal(size=(COUNT, 3))
    normal, other = rng.normal(size=(2, COUNT, 3))
    center = about + size[:, None] * rng.normal(size=(COUNT, 3))
    if family == "coaxial":  # centres on the normal through the origin: the circle's weight +1 can cancel
        center = normal * (rng.normal(size=COUNT) * size + distance)[:, None]
    radius = size * np.abs(rng.normal(size=COUNT))
    offset = (normal * center).sum(-1) + size * rng.normal(size=COUNT) * np.linalg.norm(normal, axis=-1)
    sphere, plane = cga.sphere(center, radius), cga.plane(normal, offset)
    check([sphere, plane], sphere & plane, least)
    second = cga.plane(other, (other * center).sum(-1) + size * rng.normal(size=COUNT))
    check([sphere, plane, second], sphere & (plane & second), least / 2)
    imaginary = (sphere.dual() + radius * cga.ni).undual()
    check([imaginary], imaginary, least)
    check([imaginary, plane], imaginary & plane, least)
    if distance <= 1:
        near = center + size[:, None] * (normal if family == "coaxial" else other)
        spheres = cga.sphere(near, size * np.abs(rng.normal(size=COUNT)))
        check([sphere, spheres], sphere & spheres, 0.8)


def test_weights_that_cancel() -> None:
    """Imaginary circles about an axis through the origin, as far from it as their radius is large: x^2 = r^2."""
    x = cga.sphere([-0.4177715, 0.3445797, -0.1888267], 0.8936766)
    x = x & cga.plane([-0.7284357, 0.6008169, -0.3292424], -0.4095255)
    assert bs.objects.is_blade(x) and cga.classify(x) == "imaginary circle"
    rng = np.random.default_rng(1)
    normal = rng.normal(size=(COUNT, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    size = 10.0 ** rng.uniform(-3, 3, COUNT)
    a, d = np.abs(rng.normal(size=(2, COUNT))) * size
    # about d n, of squared radius -d^2: a sphere about (d + a) n of squared radius a^2 - d^2 where it is real
    d = np.minimum(d, 0.9 * a)
    spheres = cga.sphere((d + a)[:, None] * normal, np.sqrt(a**2 - d**2))
    planes = cga.plane(normal, d)
    circles = spheres & planes
    low, high = (np.stack([np.abs(circles[f"{b}{v}"]) for b in ("e12", "e13", "e23")]).max(0) for v in ("no", "ni"))
    assert (high <= 1e-14 * low * (d + a) ** 2).all()
    check([spheres, planes], circles, 0.9)


def test_far_rounds_are_not_flat() -> None:
    for far in (1e6, 1e7, 5e7):
        for radius in (1e2, 1e3):
            if radius < 2e-5 * far:
                continue
            sphere, plane = cga.sphere([far, far, 0.0], radius), cga.plane([1.0, 2.0, 3.0], 3 * far)
            second = cga.plane([2.0, -1.0, 1.0], far)
            objects = {"sphere": 2.0 * sphere, "circle": sphere & plane, "point pair": sphere & (plane & second)}
            assert {cga.classify(x) for x in objects.values()} == set(objects)
    line = cga.line([1e12, 1.0, 2.0], [0.0, 0.0, 1.0])
    assert cga.classify(2.0 * line) == "line"


def test_tangents_are_tangent() -> None:
    rng = np.random.default_rng(2)
    center = rng.integers(-1000, 1000, size=(COUNT, 3)).astype(float)
    radius = 2.0 ** rng.integers(-9, 10, COUNT)
    axis = np.eye(3)[rng.integers(0, 3, COUNT)]
    sphere, plane = cga.sphere(center, radius), cga.plane(axis, (axis * center).sum(-1) + radius)
    assert set(cga.classify(sphere & plane)) == {"tangent plane"}
    across = np.roll(axis, 1, axis=-1)
    assert set(cga.classify(sphere & (plane & cga.plane(across, (across * center).sum(-1))))) == {"tangent vector"}


def test_lines_through_the_origin() -> None:
    """Their moments are nothing but rounding."""
    rng = np.random.default_rng(3)
    a = rng.normal(size=(COUNT, 3))
    b = -rng.uniform(0.1, 10, COUNT)[:, None] * a
    assert set(cga.classify(cga.point(a) ^ cga.point(b) ^ cga.ni)) == {"line"}
    pga = bs.pga3d
    assert set(pga.classify(pga.point(a) & pga.point(b))) == {"line"}


@pytest.mark.parametrize(("distance", "least"), [(0.0, 1e-8), (1.0, 1e-8), (100.0, 1e-4)])
def test_what_is_no_blade(distance: float, least: float) -> None:
    rng = np.random.default_rng(4)
    move = cga.translator(distance * rng.normal(size=(COUNT, 3)))
    circles, others = (
        cga.circle(rng.normal(size=(COUNT, 3)), rng.normal(size=(COUNT, 3)), rng.uniform(0.5, 2, COUNT)) for _ in "ab"
    )
    for step, names in ((1e-1, {"not a blade"}), (least, {"not a blade"}), (1e-15, {"circle"})):
        mixed = move >> (circles + step * others)
        # sums of circles whose planes are parallel, or that have two points in common, are nearly circles
        defect = np.abs((circles * others + others * circles).grade(4).values).max(-1)
        assert set(cga.classify(mixed)[defect > 0.1]) == names
    lines = cga.line(rng.normal(size=(COUNT, 3)), rng.normal(size=(COUNT, 3)))
    pitched = lines + 1e-9 * lines.dual().grade(2).outer(cga.ni)  # screws of pitch 1e-9
    assert set(cga.classify(pitched)) == {"not a blade"}


@pytest.mark.slow
def test_single_precision() -> None:
    rng = np.random.default_rng(5)
    center, normal = rng.normal(size=(2, COUNT, 3)).astype(np.float32)
    sphere = cga.sphere(center, np.abs(rng.normal(size=COUNT)).astype(np.float32))
    imaginary = (sphere.dual() + cga.ni.astype(np.float32) * 4).undual()
    plane = cga.plane(normal, np.zeros(COUNT, np.float32))
    names = cga.classify((sphere & plane).astype(np.float32))
    assert (sphere & plane).dtype == np.float32 and set(names) <= {"circle", "imaginary circle", "tangent plane"}
    assert set(cga.classify(imaginary & plane)) <= {"imaginary circle", "circle", "tangent plane"}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_scale_of_the_coefficients_changes_no_name(dtype: Any) -> None:
    """Neither twice an object nor one whose squares are beyond the range of numbers; motions included."""
    pga = bs.pga3d
    a, b, c, d = np.random.default_rng(6).normal(size=(4, 200, 3))
    pair = cga.point(a) ^ cga.point(b)
    circle = pair ^ cga.point(c)
    screw = pga.line(a, b) * pga.line(c, d)
    families = {
        "point": cga.point(a), "point pair": pair, "circle": circle, "sphere": circle ^ cga.point(d),
        "line": pair ^ cga.ni, "plane": circle ^ cga.ni, "translator": cga.translator(a), "motor": screw,
        "not a blade": pga.line(a, b) + pga.line(c, d),
    }  # fmt: skip
    decades = (-150, 0, 150, 300) if dtype is np.float64 else (-15, 0, 15, 30)
    for name, x in families.items():
        for decade in decades:
            scaled = x.astype(dtype).copy() * (2 * 10.0**decade)
            assert set(x.algebra.classify(scaled)) == {name}, decade
    mixed = cga.multivector(np.stack([(f * circle[0]).grade(3).values for f in (1.0, 1e150, np.nan, 0.0)]), grades=[3])
    assert cga.classify(mixed).tolist() == ["circle", "circle", "invalid", "zero"]
