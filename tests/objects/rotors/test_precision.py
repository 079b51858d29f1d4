"""Rotors, mirrors and similarities between objects: what they do to the objects, and the rotors at 50 digits.

The oracle builds the objects from points with mpmath and takes the thesis's own form of the rotor, (2.4) with the sign
corrected: at 50 digits its cancellations do no harm.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import Status, objects
from bladesmith import cga2d as plane_cga
from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.multivector import Multivector, from_values, sqrt
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.dispatch.formulas import evaluate

from ...support.formulas import stock

PRECISE = PrecisionRing(50)
COUNT = 100_000
#: What is left of R ~R - 1: the objects' own is of the size of their largest products, which may be 1000.
UNIT = 1e-11
MIXTURES = [
    ("point_pair", "point_pair"),
    ("point_pair", "flat_point"),
    ("line", "line"),
    ("circle", "circle"),
    ("line", "circle"),
    ("circle", "line"),
    ("plane", "plane"),
    ("sphere", "sphere"),
    ("plane", "sphere"),
    ("sphere", "plane"),
]
KINDS = ("point_pair", "line", "circle", "plane", "sphere")
GRADES = {"point_pair": 2, "flat_point": 2, "line": 3, "circle": 3, "plane": 4, "sphere": 4}
NAMES = {2: "bivector", 3: "trivector", 4: "quadvector"}


# -- objects and how far they are apart ------------------------------------------------------------------------


def placed(kind: str, center: Any, axis: Any, radius: Any, dtype: Any = float) -> Any:
    """An object from a place, a direction and a size."""
    c, m, r = (np.asarray(v, dtype) for v in (center, axis, radius))
    m = m / np.linalg.norm(m, axis=-1, keepdims=True)
    made = {
        "point_pair": lambda: cga.point_pair(c - m * r[..., None], c + m * r[..., None]),
        "flat_point": lambda: cga.flat_point(c),
        "line": lambda: cga.line(c, m),
        "circle": lambda: cga.circle(c, m, r),
        "plane": lambda: cga.plane(m, np.asarray((c * m).sum(-1), dtype)),
        "sphere": lambda: cga.sphere(c, r),
    }[kind]()
    assert made.dtype == np.dtype(dtype)
    return made


def parameters(rng: np.random.Generator, count: int, spread: bool = False) -> tuple[Any, Any, Any]:
    """Random places, directions and sizes; ``spread``: scales from 1e-3 to 1e3."""
    scale = 10 ** rng.uniform(-3, 3, count) if spread else np.ones(count)
    return rng.normal(size=(count, 3)) * scale[:, None], rng.normal(size=(count, 3)), rng.uniform(0.1, 3, count) * scale


def random_objects(kind: str, rng: np.random.Generator, count: int, spread: bool = False, dtype: Any = float) -> Any:
    return placed(kind, *parameters(rng, count, spread), dtype)


def coefficients(x: Any, grade: int = 0) -> Any:
    """Of one grade, on all blades of it, in double precision; where blades allow several, that of objects."""
    g = grade or max(x.grades)  # the sandwich of a plane may have a scalar part by its blades
    return x.grade(g).as_kind(NAMES[g], check=False).values.astype(float)


def negative(x: Any) -> Any:
    return (-x).as_kind(x.kind)


def square(x: Any) -> Any:
    return (x.values.astype(float) ** 2).sum(-1)


def largest(x: Any) -> Any:
    return np.abs(coefficients(x)).max(-1)


def target(r: Any, y: Any) -> Any:
    """Coefficients that R x ~R should have: a sphere that is not unique goes to its negative."""
    flips = (np.asarray(r.status) == Status.NOT_UNIQUE) & (y.grades == (4,)) & (r.kind.name != "motor")
    return np.where(np.asarray(flips)[..., None], -coefficients(y), coefficients(y))


def assert_takes(r: Any, x: Any, y: Any, tolerance: float = 1e-13, relative: bool = False) -> None:
    """R x ~R = y to tolerance * max(1, |R|^2), over the objects' size where ``relative``; R is unit, <R>_0 >= 0."""
    assert np.isfinite(r.values).all()
    size = np.maximum(1, square(r))
    error = np.abs(coefficients(r >> x) - target(r, y)).max(-1)
    if relative:
        error = error / np.maximum(1, np.maximum(largest(x), largest(y)))
    assert np.max(error / size, initial=0) <= tolerance
    assert np.max(np.abs((r * ~r - 1.0).values).max(-1) / size, initial=0) <= UNIT / 1e-13 * tolerance
    assert (r["1"] >= 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("first, second", MIXTURES)
def test_every_mixture_at_the_scale_of_one(first: str, second: str) -> None:
    rng = np.random.default_rng(1)
    x, y = random_objects(first, rng, COUNT), random_objects(second, rng, COUNT)
    r = objects.rotor_between(x, y)
    assert_takes(r, x, y)
    if GRADES[first] < 4:
        assert (r.status == Status.OK).all()


@pytest.mark.parametrize("first, second", MIXTURES)
def test_every_mixture_at_any_scale(first: str, second: str) -> None:
    rng = np.random.default_rng(2)
    x, y = random_objects(first, rng, 20_000, spread=True), random_objects(second, rng, 20_000, spread=True)
    assert_takes(objects.rotor_between(x, y), x, y, relative=True)


@pytest.mark.compiles
@pytest.mark.parametrize("first, second", [("circle", "circle"), ("line", "line"), ("plane", "sphere")])
def test_single_precision(first: str, second: str) -> None:
    rng = np.random.default_rng(3)
    x = random_objects(first, rng, 20_000, dtype=np.float32)
    y = random_objects(second, rng, 20_000, dtype=np.float32)
    r = objects.rotor_between(x, y)
    assert r.dtype == np.float32
    assert_takes(r, x, y, 1e-13 * float(np.finfo(np.float32).eps / np.finfo(float).eps), relative=True)


@pytest.mark.parametrize("kind", [*KINDS, "flat_point"])
def test_an_object_with_itself_gives_one(kind: str) -> None:
    x = random_objects(kind, np.random.default_rng(4), 200)
    r = objects.rotor_between(x, x)
    assert (r.status == Status.OK).all()
    assert np.max(np.abs((r - 1.0).values).max(-1) / np.maximum(1, square(x))) <= 1e-15


# -- against 50 digits -----------------------------------------------------------------------------------------


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


# -- near what is singular, and there --------------------------------------------------------------------------


EXPONENTS = (0.5, 1, 2, 3, 4, 5, 6, 6.5, 7, 7.5, 8, 10, 12, 14, 15, 16, 18)


@pytest.mark.parametrize("kind", ["point_pair", "line", "circle", "plane"])
def test_near_opposite_objects_lose_nothing(kind: str) -> None:
    """pi - e between the axes, in the same place and elsewhere: refined, then turned; never a bad sign or NaN."""
    angle = np.pi - 10.0 ** -np.array(EXPONENTS)
    axis = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], -1)
    one = np.ones(len(angle))
    for shift, ratio in (((0, 0, 0), 1.0), ((0, 0, 0), 2.0), ((0.3, 1.0, -0.4), 1.5), ((0, 0, 2.0), 1.0)):
        x = placed(kind, np.zeros((len(angle), 3)), np.tile([0.0, 0, 1], (len(angle), 1)), one)
        y = placed(kind, np.tile(np.asarray(shift, float), (len(angle), 1)), axis, ratio * one)
        r = objects.rotor_between(x, y)
        assert np.isin(np.asarray(r.status), [Status.OK, Status.NOT_UNIQUE]).all()
        assert_takes(r, x, y)


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


CIRCLE = cga.circle((0.3, -0.2, 1.0), (1.0, 2.0, 0.5), 1.3)
LINE = cga.line((0.3, 1.0, 2.0), (1.0, 0.4, -2.0))
PLANE = cga.plane((1.0, 2.0, 3.0), 1.5)
SPHERE = cga.sphere((1.0, 0.5, -0.2), 0.7)
PAIR = cga.point_pair((1.0, 2.0, 0.0), (0.0, 0.5, 1.0))
FLAT_POINT = cga.flat_point((1.0, 2.0, 3.0))
TURNED = {
    "pair reversed": (PAIR, negative(PAIR)),
    "line reversed": (LINE, negative(LINE)),
    "circle reversed": (CIRCLE, negative(CIRCLE)),
    "plane reversed": (PLANE, negative(PLANE)),
    "flat point reversed": (FLAT_POINT, (-FLAT_POINT).as_kind("bivector")),
    "flat point far away reversed": (
        cga.flat_point((1.0, 2.0, 300.0)),
        (-cga.flat_point((1.0, 2.0, 300.0))).as_kind("bivector"),
    ),
    "flat point reversed, elsewhere": (FLAT_POINT, (-cga.flat_point((1.0, 0.0, 3.0))).as_kind("bivector")),
    "opposite lines apart": (LINE, cga.line((1.0, 1.0, 1.0), (-1.0, -0.4, 2.0))),
    "opposite planes apart": (PLANE, cga.plane((-1.0, -2.0, -3.0), 4.0)),
    "opposite planes that coincide": (cga.plane((0, 0, 1.0), 2.0), cga.plane((0, 0, -1.0), -2.0)),
    "circle and its axis": (cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0), cga.line((0, 0, 0.0), (0, 0, 1.0))),
    "another circle and its axis": (CIRCLE, cga.line((0.3, -0.2, 1.0), (1.0, 2.0, 0.5))),
    "axis and circle": (cga.line((0.3, -0.2, 1.0), (1.0, 2.0, 0.5)), CIRCLE),
    "opposite coaxial circles": (CIRCLE, cga.circle((1.3, 1.8, 1.5), (-1.0, -2.0, -0.5), 2.0)),
    "opposite concentric circles": (CIRCLE, cga.circle((0.3, -0.2, 1.0), (-1.0, -2.0, -0.5), 2.0)),
    "opposite concentric pairs": (PAIR, cga.point_pair((-0.5, -0.25, 1.5), (1.5, 2.75, -0.5))),
    "pairs head to tail": (cga.point_pair((0, 0, 0.0), (1.0, 0, 0)), cga.point_pair((1.0, 0, 0), (2.0, 3.0, 0))),
    "pair to its end and infinity": (PAIR, cga.flat_point((0.0, 0.5, 1.0))),
    "tangent circles side by side": (cga.circle((0, 0, 0.0), (0, 0, 1), 1.0), cga.circle((3.0, 0, 0), (0, 0, 1), 2.0)),
    "circle and a tangent": (cga.line((1.0, 0, 0), (0, -1.0, 0)), cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)),
    "circle and a line beside it": (cga.line((3.0, 0, 0), (0, -1.0, 0)), cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)),
}
FLIPPED = {
    "sphere inside out": (SPHERE, negative(SPHERE)),
    "spheres apart": (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((10.0, 0, 0), 2.0)),
    "spheres tangent from outside": (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((3.0, 0, 0), 2.0)),
    "concentric, one inside out": (cga.sphere((0, 0, 0.0), 1.0), negative(cga.sphere((0, 0, 0.0), 2.0))),
    "plane that leaves its tangent sphere": (cga.plane((0, 0, 1.0), 1.0), cga.sphere((0, 0, 0.0), 1.0)),
}


@pytest.mark.parametrize("name", TURNED)
def test_where_no_unique_rotor_exists_the_first_is_turned(name: str) -> None:
    x, y = TURNED[name]
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE
    assert np.abs(coefficients(r >> x) - coefficients(y)).max() <= 1e-14
    assert np.abs((r * ~r - 1.0).values).max() <= 1e-14
    first = r.values[np.nonzero(r.values)[0][0]]
    assert first > 0  # <R>_0 >= 0, or the first coefficient that is not zero


@pytest.mark.parametrize("name", ["line reversed", "plane reversed", "circle reversed", "pair reversed"])
def test_an_object_and_its_negative_are_half_a_turn_apart(name: str) -> None:
    """About an axis perpendicular to the object's: R R = -1, and R is a motion."""
    r = objects.rotor_between(*TURNED[name])
    assert np.abs((r * r + 1.0).values).max() <= 1e-14
    motion = r.as_kind("motor").parameters()
    assert np.isclose(motion.angle, np.pi) and abs(motion.advance) <= 1e-14


@pytest.mark.parametrize("name", FLIPPED)
def test_spheres_go_to_the_same_sphere_inside_out(name: str) -> None:
    x, y = FLIPPED[name]
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE
    assert np.abs(coefficients(r >> x) + coefficients(y)).max() <= 1e-14


def test_spheres_that_touch_from_inside_and_planes_that_enter_are_regular() -> None:
    pairs = [
        (cga.sphere((0, 0, 0.0), 1.0), cga.sphere((1.0, 0, 0), 2.0)),
        (cga.sphere((0, 0, 0.0), 1.0), cga.plane((0, 0, -1.0), -1.0)),
    ]
    for x, y in pairs:
        r = objects.rotor_between(x, y)
        assert r.status == Status.OK
        assert_takes(r, x, y)


def test_what_is_nearly_a_rotor_becomes_one() -> None:
    """R ~R = 1 to rounding, also where the error is of grade 4, which does not commute with R."""
    rng = np.random.default_rng(14)
    x, y = random_objects("circle", rng, 500), random_objects("circle", rng, 500)
    even = objects.rotor_between(x, y).as_kind("even")
    near = even + cga.multivector(1e-3 * rng.normal(size=even.values.shape), blades=even.blades)
    r = evaluate(cga, "rotors.unit_rotor", near.as_kind("even")).value
    assert np.max(np.abs((r * ~r - 1.0).values).max(-1) / square(r)) <= 1e-14
    assert np.max(np.abs((r - even).values).max(-1) / square(r)) <= 0.1


coordinate = st.floats(-3, 3)
direction = st.tuples(coordinate, coordinate, coordinate).filter(lambda v: np.linalg.norm(v) > 0.1)
place = st.tuples(coordinate, coordinate, coordinate)


@pytest.mark.slow
@settings(max_examples=60)
@given(
    st.sampled_from(MIXTURES), place, direction, st.floats(0.05, 5), place, direction, st.floats(0.05, 5), st.booleans()
)
def test_any_pair_has_a_rotor(
    kinds: Any, c1: Any, m1: Any, r1: float, c2: Any, m2: Any, r2: float, nearly: bool
) -> None:
    if nearly:  # the second where the first is, reversed, but for a little
        c2 = np.asarray(c1) + 1e-9 * np.asarray(c2)
        m2 = -np.asarray(m1) + 1e-9 * np.asarray(m2)
    x, y = placed(kinds[0], c1, m1, r1), placed(kinds[1], c2, m2, r2)
    r = objects.rotor_between(x, y)
    assert r.status in (Status.OK, Status.NOT_UNIQUE)
    assert_takes(r, x, y, 1e-12, relative=True)


# -- points ----------------------------------------------------------------------------------------------------


def test_points_are_translated() -> None:
    a, b = np.random.default_rng(8).normal(size=(2, 50, 3)) + 1e3
    for r in (objects.rotor_between(cga.point(a), cga.point(b)), objects.trs_rotor(cga.point(a), cga.point(b))):
        assert r.kind.name == "translator"
        assert np.allclose((r >> cga.point(a)).parameters().xyz, b, rtol=1e-14)


# -- mirrors ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first, second", MIXTURES)
def test_mirrors(first: str, second: str) -> None:
    rng = np.random.default_rng(9)
    x, y = random_objects(first, rng, 5000), random_objects(second, rng, 5000)
    m = objects.mirror_between(x, y)
    assert m.grades == x.grades
    apart = np.asarray(objects.rotor_between(x, y).status) == Status.NOT_UNIQUE  # spheres whose mirror is imaginary
    assert ((np.asarray(m.status) == Status.IMAGINARY) == apart).all()
    assert np.isnan(m.values[apart]).all() and np.isfinite(m.values[~apart]).all()
    gamma = -1 if GRADES[first] == 4 else 1
    x, y, m = x[~apart], y[~apart], m[~apart]
    error = np.abs(coefficients(m * x * m, GRADES[first]) - gamma * coefficients(y)).max(-1)
    assert np.max(error / np.maximum(1, square(m)) / np.maximum(1, largest(x))) <= 1e-11


def test_the_mirror_of_two_planes_halves_their_angle() -> None:
    m = objects.mirror_between(cga.plane((1.0, 0, 0), 0.0), cga.plane((0, 1.0, 0), 0.0)).parameters()
    assert np.allclose(m.normal, np.array([1, 1, 0]) / np.sqrt(2)) and np.isclose(m.offset, 0)


def test_mirrors_that_do_not_exist() -> None:
    for name in ("line reversed", "opposite lines apart", "opposite planes apart", "circle and its axis"):
        assert objects.mirror_between(*TURNED[name]).status == Status.SINGULAR
    for name in ("sphere inside out", "spheres tangent from outside"):
        assert objects.mirror_between(*FLIPPED[name]).status == Status.SINGULAR
    assert objects.mirror_between(*FLIPPED["spheres apart"]).status == Status.IMAGINARY
    assert objects.mirror_between(*TURNED["opposite coaxial circles"]).status == Status.IMAGINARY
    with pytest.raises(bs.errors.SingularError, match="mirror_between: it is IMAGINARY"):
        objects.mirror_between(*FLIPPED["spheres apart"], strict=True)


# -- similarities ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["point_pair", "circle", "sphere"])
@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_similarities(kind: str, shift: float) -> None:
    """They take x1 to x2, every distance to its multiple, and infinity to infinity."""
    rng = np.random.default_rng(10)
    (c1, m1, r1), (c2, m2, r2) = parameters(rng, 2000), parameters(rng, 2000)
    c1, c2 = c1 + shift, c2 + shift
    x, y = placed(kind, c1, m1, r1), placed(kind, c2, m2, r2)
    z = objects.trs_rotor(x, y)
    assert (z.status == Status.OK).all() and (z["1"] >= 0).all()
    transversion = [str(blade) for blade in z.blades if "no" in str(blade) and "ni" not in str(blade)]
    assert all((z[blade] == 0).all() for blade in transversion)
    assert np.max(np.abs((z * ~z - 1.0).values).max(-1) / np.maximum(1, square(z))) <= 1e-14
    offset = rng.normal(size=(2000, 3)) * r1[:, None]
    images = [z >> cga.point(p) for p in (c1, c1 + offset)]
    places = [np.stack([x[e] / x["no"] for e in ("e1", "e2", "e3")], -1) for x in images]
    assert np.max(np.abs(places[0] - c2) / (1 + shift)) <= 1e-12
    ratio = np.linalg.norm(places[1] - places[0], axis=-1) / np.linalg.norm(offset, axis=-1)
    assert np.max(np.abs(ratio * r1 / r2 - 1)) <= 1e-11 * max(1, shift / 10)
    if shift == 0:
        error = np.abs(coefficients(z >> x) - coefficients(y)).max(-1)
        assert np.max(error / largest(y) / np.maximum(1, square(z))) <= 1e-13


@pytest.mark.parametrize("kind", ["line", "plane", "flat_point"])
def test_flats_are_moved_without_scaling(kind: str) -> None:
    rng = np.random.default_rng(11)
    x, y = random_objects(kind, rng, 500), random_objects(kind, rng, 500)
    z = objects.trs_rotor(x, y)
    assert (z.status == Status.OK).all()
    assert np.max(np.abs(z["noni"])) <= 1e-15
    assert np.max(np.abs(coefficients(z >> x) - coefficients(y)).max(-1)) <= 1e-13


def test_similarities_that_are_not_unique_or_not_there() -> None:
    circle = cga.circle((0, 0, 0.0), (0, 0, 1.0), 1.0)
    for tilt in (0.0, 1e-16, 1e-15, 1e-13, 1e-9, 1e-3):
        other = cga.circle((1.0, 2.0, 3.0), (0, tilt, -1.0), 2.0)
        z = objects.trs_rotor(circle, other)
        assert z.status == (Status.NOT_UNIQUE if tilt < 1e-14 else Status.OK)
        assert np.abs(coefficients(z >> circle) - coefficients(other)).max() <= 1e-14
    z = objects.trs_rotor(SPHERE, negative(SPHERE))
    assert z.status == Status.NOT_UNIQUE and np.abs((z - 1.0).values).max() <= 1e-14
    lines_among_circles = cga.line([(0, 0, 0.0), (1.0, 0, 0)], (0, 0, 1.0))
    z = objects.trs_rotor(circle, lines_among_circles)
    assert (z.status == Status.SINGULAR).all() and np.isnan(z.values).all()
    with pytest.raises(bs.errors.SingularError, match="trs_rotor: item 0 is SINGULAR"):
        objects.trs_rotor(circle, lines_among_circles, strict=True)


# -- what users hand over ----------------------------------------------------------------------------------------


def test_bad_operands() -> None:
    with pytest.raises(bs.errors.GradeError, match="same grade"):
        objects.rotor_between(LINE, PLANE)
    with pytest.raises(bs.errors.GradeError):
        objects.mirror_between(cga.point((0, 0, 0.0)), cga.point((1.0, 0, 0)))
    with pytest.raises(bs.errors.InputError):
        objects.rotor_between(LINE, 3.0)
    with pytest.raises(bs.errors.AlgebraMismatchError):
        objects.rotor_between(LINE, plane_cga.circle((0, 0.0), 1.0))
    with pytest.raises(bs.errors.ShapeError):
        objects.rotor_between(random_objects("line", np.random.default_rng(0), 2), cga.line(np.eye(3), np.eye(3)))


@pytest.mark.parametrize("function", [objects.rotor_between, objects.mirror_between, objects.trs_rotor])
def test_bad_items_are_named_and_the_others_are_done(function: Any) -> None:
    circles = cga.circle([(0, 0, 0.0), (1.0, 0, 0), (2.0, 0, 0)], (0, 0.6, 0.8), [1.0, -1.0, 2.0])
    found = function(circles, CIRCLE)
    assert list(found.status) == [Status.OK, Status.INVALID, Status.OK]
    assert np.isnan(found.values[1]).all() and np.isfinite(found.values[[0, 2]]).all()
    with pytest.raises(bs.errors.SingularError, match="item 1 is INVALID"):
        function(CIRCLE, circles, strict=True)
    twice = cga.multivector(np.stack([2 * CIRCLE.values, CIRCLE.values]), grades=[3])
    assert list(function(twice, CIRCLE).status) == [Status.INVALID, Status.OK]


def test_shapes_broadcast_and_may_be_empty() -> None:
    rng = np.random.default_rng(12)
    x, y = random_objects("circle", rng, 3)[:, None], random_objects("line", rng, 4)
    r = objects.rotor_between(x, y)
    assert r.shape == (3, 4)
    assert r[2, 1].isclose(objects.rotor_between(x[2, 0], y[1]))
    assert objects.rotor_between(x[2, 0], y[1]).shape == ()
    for function in (objects.rotor_between, objects.mirror_between, objects.trs_rotor):
        assert function(x[:0, 0], x[:0, 0]).shape == (0,)


def test_singular_far_and_ordinary_items_of_one_batch_do_not_mix() -> None:
    """Each item is what it is alone, whatever else is in the batch."""
    singles = [TURNED["circle reversed"], TURNED["circle and its axis"], (CIRCLE, LINE)]
    singles.append((cga.circle((1e6, 0, 0), (0, 0, 1), 1.0), cga.circle((1e6, 1, 0), (0, 1, 1), 2.0)))
    wide = [tuple(x.as_kind("circle") for x in pair) for pair in singles]
    r = objects.rotor_between([a for a, _ in wide], [b for _, b in wide])
    for i, pair in enumerate(wide):
        alone = objects.rotor_between(*pair)
        assert r[i].status == alone.status
        assert np.array_equal(r[i].values, alone.values)


@pytest.mark.compiles
def test_in_the_plane() -> None:
    rng = np.random.default_rng(13)
    p, q, radius = rng.normal(size=(500, 2)), rng.normal(size=(500, 2)), rng.uniform(0.1, 2, 500)
    x, y = plane_cga.point_pair(p, q), plane_cga.point_pair(q + 1, p * 2)
    r = objects.rotor_between(x, y)
    assert np.max(np.abs((r >> x).grade(2).values - y.values).max(-1) / square(r) / square(y)) <= 1e-13
    x, y = plane_cga.circle(p, radius), plane_cga.circle(q, 1.0)
    r = objects.rotor_between(x, y)
    sign = np.where(np.asarray(r.status) == Status.NOT_UNIQUE, -1.0, 1.0)[:, None]
    assert (sign < 0).any() and (sign > 0).any()
    assert np.max(np.abs((r >> x).grade(3).values - sign * y.values).max(-1) / square(r) / square(y)) <= 1e-13
    x, y = plane_cga.line((0, 0.0), (1.0, 0)), plane_cga.line((1.0, 1.0), (-1.0, 0))
    r = objects.rotor_between(x, y)
    assert r.status == Status.NOT_UNIQUE and np.allclose(
        (r >> x).grade(3).as_kind("line", check=False).values, y.values
    )
