"""exp, log and square root of rotors of Cl(4,1) and of small algebras, and of motors at every angle.

The oracle is the power series at 40 digits: exp by it, log by the series of what log returned.
"""

import math
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith.codegen.algebra.algebra import add_plain_kinds, orthonormal
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.errors import GradeError
from bladesmith.codegen.formulas.products import exponentials, invariant
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, multivector, stock
from ...support.objects.exponentials import (
    ANGLES,
    BIVECTOR,
    CGA,
    EVEN,
    PRECISE,
    ROUND_TRIP,
    SHIFTS,
    Space,
    compiled,
    largest,
    on_numbers,
    series_error,
    similarities,
    square_error,
)
from ...support.vectors import unit


@pytest.fixture(scope="module")
def rotors() -> tuple[list[Any], Array, Array]:
    cases, b = similarities()
    return cases, b, compiled(invariant.exp_bivector, BIVECTOR)(b)


@pytest.mark.slow
def test_exp_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, b, r = rotors
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(b[::5], r[::5], strict=True)]
    assert largest(errors, cases[::5]) < 8 * EPS


@pytest.mark.slow
def test_log_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, _, r = rotors
    log, status = compiled(invariant.log_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)]
    assert largest(errors, cases) < ROUND_TRIP / 4


@pytest.mark.slow
def test_sqrt_of_similarities(rotors: tuple[list[Any], Array, Array]) -> None:
    cases, _, r = rotors
    root, status = compiled(invariant.sqrt_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    errors = [square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)]
    assert largest(errors, cases) < ROUND_TRIP / 4


def test_logarithms_are_those_taken(rotors: tuple[list[Any], Array, Array]) -> None:
    """Where rounding R moves its planes little: log(exp(b)) is b itself, and not another logarithm."""
    cases, b, r = rotors
    log, _ = compiled(invariant.log_rotor, EVEN)(r)
    for (angle, g, shift, distance, _), own, found in zip(cases, b, log, strict=True):
        if angle <= math.pi + 1 and max(angle, g) >= 1e-3:
            assert np.abs(found - own).max() <= 1e-13 * max(np.abs(own).max(), distance * shift), (angle, g, shift)
        elif angle > math.pi + 1 and distance < 1e3 and shift < 1e3:
            rest = 2 * math.pi - angle  # a tilt of the axis by EPS/rest has a shift across, which counts 1/rest times
            allowed = 8 * EPS * (np.abs(own).max() / rest + shift / rest**2)
            assert np.abs(found - own).max() <= allowed, (angle, g, shift)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cga3d", "pga3d"])
def test_round_trips_of_motors(name: str) -> None:
    """The same bar for the formulas of motors: their own, and shorter."""
    algebra = stock(name)
    motor, twist = algebra.kind("motor"), algebra.kind("twist")
    rng, space, cases, values = np.random.default_rng(8), Space(algebra), [], []
    for angle, shift in product(ANGLES, SHIFTS):
        distance = (0, 1, 1e3)[len(cases) % 3]
        axis = unit(rng.normal(size=3)) if len(cases) % 4 else np.array([0.0, 0.0, 1.0])
        centre = unit(rng.normal(size=3)) * distance
        values.append([float(v) for v in twist.values(space.screw(angle, axis, axis * shift, centre))])
        cases.append((angle, shift, distance))
    b = np.array(values)
    r, _ = on_numbers(exponentials.exp_bivector, twist, b, motor)
    log, status = on_numbers(exponentials.log_motor, motor, r, twist)
    root, root_status = on_numbers(exponentials.sqrt_motor, motor, r, motor)
    assert np.all(status == Status.OK) and np.all(root_status == Status.OK)
    for errors in (
        [series_error(twist, x, motor, y) for x, y in zip(b[::4], r[::4], strict=True)],
        [series_error(twist, x, motor, y) for x, y in zip(log, r, strict=True)],
        [square_error(motor, x, y) for x, y in zip(root, r, strict=True)],
    ):
        assert largest(errors, cases) < ROUND_TRIP / 4


@cache
def oblique() -> Array:
    """Bivectors with transversions: random ones, and hyperbolic, parabolic, elliptic ones in general position."""
    rng, space = np.random.default_rng(9), Space(CGA)
    simple = []
    for k in range(12):
        bend = 1 - space.vector(rng.normal(size=3)) * space.one.basis("no")
        versor = space.translator(rng.normal(size=3)) * bend
        inverse = ~versor
        seed = (space.scaling(1.5, [0, 0, 0]), space.screw(0, [0, 0, 1], [0.5, 1, 0], [0, 0, 0]))[k % 2]
        if k % 3 == 0:
            seed = seed + space.screw((0.3, 3.0, 6.0, 1e-9)[k // 3], [0, 0, 1], [0, 0, 0], [0, 0, 0])
        simple.append([float(v) for v in BIVECTOR.values(versor * seed * inverse)])
    return np.concatenate([rng.normal(size=(12, 10)), rng.normal(size=(3, 10)) * 1e-9, np.array(simple)])


@pytest.mark.slow
def test_rotors_in_general_position() -> None:
    b = oblique()
    r = compiled(invariant.exp_bivector, BIVECTOR)(b)
    errors = [series_error(BIVECTOR, x, EVEN, y) for x, y in zip(b, r, strict=True)]
    assert largest(errors, list(b)) < 64 * EPS
    allowed = 4 * ROUND_TRIP  # planes that are oblique by a factor of 25 cost as much
    log, status = compiled(invariant.log_rotor, EVEN)(r)
    root, _ = compiled(invariant.sqrt_rotor, EVEN)(r)
    assert np.all(status == Status.OK)
    assert largest([series_error(BIVECTOR, x, EVEN, y) for x, y in zip(log, r, strict=True)], list(b)) < allowed
    assert largest([square_error(EVEN, x, y) for x, y in zip(root, r, strict=True)], list(b)) < allowed


@pytest.mark.slow
def test_what_is_no_rotor_is_invalid() -> None:
    r = compiled(invariant.exp_bivector, BIVECTOR)(oblique()[:12])
    bad = np.concatenate([2 * r, r + 1e-3, 0 * r, np.full((1, 16), np.nan), np.full((1, 16), np.inf)])
    for formula in (invariant.log_rotor, invariant.sqrt_rotor):
        value, status = compiled(formula, EVEN)(bad)
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))
        _, status = compiled(formula, EVEN)(r * (1 + 4e-16))
        assert np.all(status == Status.OK)


def test_single_precision() -> None:
    b = np.array([x for x, c in zip(similarities()[1], similarities()[0], strict=True) if c[3] < 1e3 and c[2] < 1e3])
    b = np.concatenate([b, oblique()[:12]]).astype(np.float32)
    r = compiled(invariant.exp_bivector, BIVECTOR).on("numpy")(b)
    assert r.dtype == np.float32
    log, status = compiled(invariant.log_rotor, EVEN).on("numpy")(r)
    answered = (status == Status.OK) | (status == Status.NOT_UNIQUE)
    assert answered.all() and log.dtype == np.float32
    exact, _ = on_numbers(invariant.exp_bivector, BIVECTOR, b.astype(float), EVEN)
    size = np.maximum(np.abs(b).max(1), np.abs(exact).max(1))
    assert np.max(np.abs(r - exact).max(1) / size) < 64 * np.finfo(np.float32).eps
    again, _ = on_numbers(invariant.exp_bivector, BIVECTOR, log.astype(float), EVEN)
    size = np.maximum(np.abs(log).max(1), np.abs(r).max(1))
    assert np.percentile(np.abs(again - r).max(1) / size, 99) < 64 * np.finfo(np.float32).eps


@pytest.mark.slow
@pytest.mark.parametrize("signature", [(3, 1), (1, 3), (4, 0), (0, 4), (4, 1), (1, 4), (5, 0), (2, 1), (1, 1), (2, 0)])
def test_other_signatures(signature: tuple[int, int]) -> None:
    algebra = orthonormal(*signature)
    add_plain_kinds(algebra)
    bivector, even = algebra.kind("bivector"), algebra.kind("even")
    b = np.random.default_rng(10).normal(size=(40, bivector.size))
    r, _ = on_numbers(invariant.exp_bivector, bivector, b, even)
    assert max(series_error(bivector, x, even, y) for x, y in zip(b[:8], r, strict=False)) < 32 * EPS
    log, status = on_numbers(invariant.log_rotor, even, r, bivector)
    root, _ = on_numbers(invariant.sqrt_rotor, even, r, even)
    assert np.all(status == Status.OK)
    again, _ = on_numbers(invariant.exp_bivector, bivector, log, even)
    size = np.maximum(np.abs(log).max(1), np.abs(r).max(1))[:, None]
    assert np.max(np.abs(again - r) / size) < 64 * ROUND_TRIP
    assert max(square_error(even, x, y) for x, y in zip(root, r, strict=True)) < ROUND_TRIP
    minus, codes = on_numbers(invariant.log_rotor, even, -np.eye(1, even.size), bivector)
    has_plane = max(signature) > 1
    assert codes[0] == (Status.NOT_UNIQUE if has_plane else Status.SINGULAR)
    if has_plane:
        again, _ = on_numbers(invariant.exp_bivector, bivector, minus, even)
        assert np.allclose(again, -np.eye(1, even.size), atol=1e-15)


def test_negative_translations_of_the_plane_have_no_logarithm() -> None:
    algebra = stock("cga2d")
    even, bivector = algebra.kind("even"), algebra.kind("bivector")
    one = from_values(algebra, PRECISE, (0,), [PRECISE.context.mpf(1)])
    shift = -(1 - one.basis("e1ni") / 2)
    bend = 1 + one.basis("e2no") / 3
    r = np.array([[float(v) for v in even.values(x)] for x in (shift, bend * shift * ~bend)])
    log, status = on_numbers(invariant.log_rotor, even, r, bivector)
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(log).any(1))


def test_signatures_that_do_not_decompose_are_refused() -> None:
    for signature in ((2, 2), (3, 2), (6, 0)):
        algebra = orthonormal(*signature)
        add_plain_kinds(algebra)
        with pytest.raises(GradeError, match="simple"):
            invariant.exp_bivector(multivector(algebra.kind("bivector"), np.ones(algebra.kind("bivector").size)))


numbers = st.floats(-3, 3).filter(lambda x: x == 0 or abs(x) > 1e-6)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(numbers, min_size=10, max_size=10))
def test_logarithms_of_small_bivectors_are_the_bivectors(coefficients: list[float]) -> None:
    """Below half a turn in all there is one logarithm near 1."""
    b = np.array(coefficients) / max(1.0, float(np.abs(coefficients).sum()))
    r, _ = on_numbers(invariant.exp_bivector, BIVECTOR, b, EVEN)
    log, status = on_numbers(invariant.log_rotor, EVEN, r, BIVECTOR)
    assert status == Status.OK
    assert np.allclose(log, b, rtol=0, atol=1e-14)


def test_kinds_of_results() -> None:
    cga = bs.cga3d
    dilator, transversor = cga.dilator(2.0), cga.transversor([1.0, 2.0, 3.0])
    rotor = cga.translator([1.0, 2.0, 3.0]) * cga.rotor([0.0, 0.0, 1.0], 0.5) * dilator
    for x, name in ((dilator, "dilator"), (transversor, "transversor"), (rotor, "rotor_conformal")):
        assert x.kind.name == name
        assert x.sqrt().kind == x.kind and x.log().exp().kind == x.kind
        assert (x.sqrt() * x.sqrt()).isclose(x, rtol=1e-14) and x.log().exp().isclose(x, rtol=1e-14)
    assert dilator.log().blades == cga.noni.blades
    assert (-dilator).log().status is Status.SINGULAR
    assert (-rotor).log().exp().isclose(-rotor, rtol=1e-13)


def test_algebras_without_a_closed_form() -> None:
    wide = bs.algebra(2, 2)
    b = wide.multivector(np.random.default_rng(1).normal(size=(3, 6)), grades=[2])
    r = b.exp()
    assert (r * ~r).isclose(wide.scalar(np.ones(3)), rtol=1e-12).all()
    with pytest.raises(bs.errors.NotARotorError):
        r.log()
