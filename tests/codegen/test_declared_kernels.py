"""Declared kernels where people go wrong: selections, calls, threads, names, constants, mixed arguments, plans."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith import pga3d as pga
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.errors import InputError, KindError, TraceError
from bladesmith.codegen.trace.outputs import status


@codegen.kernel(cga.kind("point"))
def double(x: Any) -> Any:
    return 2 * x


def scalar_kernel(formula: Callable[..., Any], count: int = 1, name: str = "f") -> Any:
    return codegen.kernel(*[codegen.scalar] * count, algebra=cga, name=name)(formula)


# -- what the exact layer may not call zero ------------------------------------------------------------


def test_deep_selections_do_not_vanish() -> None:
    def deep(a: Multivector) -> Multivector:
        v = a.constant(3)
        for i in range(14):
            v = codegen.select(a < i + 1, v, a.constant(0))
        return 2 * v

    assert scalar_kernel(deep)(np.array([-1.0, 5.0])).ravel().tolist() == [6.0, 0.0]


def test_called_kernels_with_roots_and_comparisons_ask_for_lanes() -> None:
    root = scalar_kernel(lambda a: codegen.sqrt(1 + codegen.sqrt(2 + codegen.sqrt(3 + a * a))), name="root")

    def many(a: Multivector) -> Multivector:
        total = a.constant(0)
        for i in range(5):
            total = total + root(a + i)
        return total

    kernel = scalar_kernel(many)
    np.testing.assert_allclose(kernel(0.5).ravel(), kernel.reference(0.5).ravel(), rtol=1e-14)
    pick = scalar_kernel(lambda a, v: codegen.select(a > 0, v + 1, v), 2, name="pick")

    def nested(a: Multivector) -> Multivector:
        v = a.constant(0)
        for i in range(6):
            v = pick(a - i, v)
        return v

    assert scalar_kernel(nested)(np.array([9.0, 2.5])).ravel().tolist() == [6.0, 3.0]


def test_two_kernels_of_one_name_are_not_confused() -> None:
    first = scalar_kernel(lambda a: a * a, name="same")
    second = scalar_kernel(lambda a: a + 1, name="same")
    both = scalar_kernel(lambda a: first(a) + 100 * second(a))
    assert both.on("c").__name__  # made lazily
    with pytest.raises(TraceError, match="two different kernels are called 'same'"):
        both(3.0)


def test_constants_that_the_exact_layer_cannot_hold() -> None:
    for formula in (lambda a: a * (2**31 - 1), lambda a: a / (2**31 - 1)):
        with pytest.raises(TraceError, match="2147483647"):
            scalar_kernel(formula)(2.0)
    assert scalar_kernel(lambda a: a * 2**31)(2.0).ravel()[0] == 2.0**32


def test_conformal_rotors_lose_no_coefficient() -> None:
    rotor = cga.translator((1, 2, 3)) * cga.rotor((1, 1, 0), 0.7) * cga.dilator(2.0) * cga.transversor((0.1, 0.2, 0.3))
    known = rotor.as_kind("rotor_conformal")
    free = cga.multivector(rotor.as_kind(cga.layout("rotor_conformal")).copy(), grades=[0, 2, 4])
    for other in (cga.no, cga.ni, cga.e1, cga.point((1, 2, 3))):
        difference = (known * other) - (free * other)
        assert np.allclose(difference.values, 0, atol=1e-12)


# -- formulas ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "formula",
    [
        lambda x: x if x > 0 else -x,
        lambda x: codegen.select(0 < x < 1, x, -x),
        lambda x: codegen.select(x > 0 and x < 1, x, -x),
        lambda x: max(x, 1 - x),
        lambda x: codegen.select(not (x > 0), x, -x),
    ],
)
def test_comparisons_have_no_truth_value(formula: Callable[..., Any]) -> None:
    with pytest.raises(TraceError, match=r"codegen\.select"):
        scalar_kernel(formula)(1.0)


@pytest.mark.parametrize(
    "formula",
    [
        lambda x: codegen.sqrt(-1),
        lambda x: (),
        lambda x: x / 0,
        lambda x: x + float("nan"),
        lambda x: x + 1e400,
        lambda x: x * (1 + 2j),
        lambda x: codegen.select(x, x, x),
        lambda x: x**0.5,
        lambda x: x + cga.point(np.zeros((2, 3))),
    ],
)
def test_what_goes_wrong_in_a_formula_is_a_trace_error(formula: Callable[..., Any]) -> None:
    with pytest.raises(TraceError):
        scalar_kernel(formula)(1.0)


@pytest.mark.slow
def test_objects_of_the_algebra_are_constants_of_a_formula() -> None:
    @codegen.kernel(cga.kind("point"), cga.kind("point"))
    def line(a: Multivector, b: Multivector) -> Multivector:
        return (a ^ b ^ cga.ni) * 2

    a, b = cga.point((0, 0, 0)), cga.point((1, 0, 0))
    np.testing.assert_allclose(line(a, b).values, ((a ^ b ^ cga.ni) * 2).as_kind(line(a, b).kind.layout).values)


def test_declarations_are_checked_at_once() -> None:
    with pytest.raises(TraceError, match="2 kinds were declared"):
        scalar_kernel(lambda x: x, 2)
    with pytest.raises(TraceError, match=r"@codegen\.kernel"):
        codegen.kernel(lambda x: x)
    with pytest.raises(TraceError, match="name="):
        codegen.kernel(codegen.scalar, algebra=cga)(lambda x: x)
    with pytest.raises(InputError, match="from 1 to"):
        codegen.numbers(10**9)
    with pytest.raises(InputError, match="no target"):
        scalar_kernel(lambda x: x).on("fortran")


def test_arguments_by_name() -> None:
    kernel = scalar_kernel(lambda a, b: a - b, 2)
    assert kernel(b=1.0, a=3.0).ravel()[0] == 2.0 == kernel(3.0, b=1.0).ravel()[0]
    with pytest.raises(InputError, match="each once"):
        kernel(1.0, a=2.0)


# -- calls in formulas, derivatives --------------------------------------------------------------------


@pytest.mark.compiles
def test_rows_and_statuses_of_called_kernels() -> None:
    powers = scalar_kernel(lambda x: codegen.row([x, x * x, x * x * x]), name="powers")
    total = scalar_kernel(lambda x: powers(x)[2] - powers(x)[0])
    assert total(2.0).ravel()[0] == 6.0 == total.reference(2.0).ravel()[0]

    def checked(x: Multivector) -> Any:
        return codegen.sqrt(x), status(codegen.select(x > 0, x.constant(0), x.constant(6)))

    inner = scalar_kernel(checked, name="checked")

    def outer(x: Multivector) -> Any:
        root, code = inner(x * x)
        return 2 * root, status(code)

    kernel = scalar_kernel(outer)
    assert kernel(3.0)[0].ravel()[0] == 6.0 == kernel.reference(3.0)[0].ravel()[0]
    np.testing.assert_allclose(kernel.derivative("x")(3.0).ravel(), 2.0)


@pytest.mark.compiles
def test_second_derivatives_and_blades_of_derivatives() -> None:
    @codegen.kernel(codegen.scalar, algebra=pga)
    def path(a: Multivector) -> Multivector:
        return a**3 * a.basis("e1") + a.basis("e2")

    value, slope = path(2.0), path.derivative("a")
    assert slope(2.0).shape == value.shape
    np.testing.assert_allclose(slope.derivative("a")(2.0), [12.0, 0.0])

    @codegen.kernel(pga.layout("plane"))
    def square(x: Multivector) -> Multivector:
        return (x * x).grade(0)

    twice = square.derivative("x").derivative("x")
    one, two = np.array([1.0, 2, 3, 4]), np.array([0.0, 1, 0, 1])
    np.testing.assert_allclose(twice(one, two, two).ravel(), [4.0])


def test_stumpff_functions_of_zero() -> None:
    kernel = scalar_kernel(lambda x: codegen.stumpff2(x * 0) + codegen.stumpff3(x * 0) * x)
    np.testing.assert_allclose(kernel(6.0).ravel(), [1.5])


# -- calls ---------------------------------------------------------------------------------------------


def test_arrays_prove_nothing() -> None:
    @codegen.kernel(cga.kind("motor"), cga.kind("point"))
    def move(m: Multivector, x: Multivector) -> Multivector:
        return m >> x

    x = cga.point((1, 2, 3))
    assert move(cga.translator((1, 0, 0)).as_kind("motor"), x).kind == cga.kind("point")
    assert move(np.ones(8), x).kind.is_layout
    with pytest.raises(KindError):
        move(cga.multivector(np.ones(8), blades=["1", "e12", "e13", "e1ni", "e23", "e2ni", "e3ni", "e123ni"]), x)


@pytest.mark.compiles
def test_first_use_from_many_threads() -> None:
    @codegen.kernel(cga.kind("motor"), cga.kind("line"))
    def turn(m: Multivector, x: Multivector) -> Multivector:
        return m * x * ~m

    motor, line = cga.rotor((0, 0, 1), 0.5, point=(1, 0, 0)), cga.line((0, 1, 0), (1, 0, 0))
    barrier, results, faults = threading.Barrier(6), [], []

    def call(precision: Any) -> None:
        barrier.wait()
        try:
            results.append(turn(motor.astype(precision), line.astype(precision)).values.astype(float))
        except BaseException as fault:
            faults.append(fault)

    threads = [threading.Thread(target=call, args=(p,)) for p in (np.float64, np.float32) * 3]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not faults
    assert all(np.allclose(r, results[0], atol=1e-5) for r in results)


def test_plans_read_their_own_arrays() -> None:
    kernel = scalar_kernel(lambda a, b: a * b, 2)
    given = np.arange(10)[::2]
    plan = kernel.plan(given, 3.0)
    plan()
    assert plan.results[0].ravel().tolist() == [0, 6, 12, 18, 24]
    plan.arrays[0][...] = 5.0  # an argument that had to be converted was copied: this is the copy
    plan()
    assert plan.results[0].ravel().tolist() == [15.0] * 5


def test_kernels_are_pickled_by_name() -> None:
    assert pickle.loads(pickle.dumps(double)) is double
    inner = codegen.kernel(cga.kind("point"), name="inner")(lambda x: 3 * x)
    with pytest.raises((pickle.PicklingError, AttributeError)):
        pickle.dumps(inner)


def test_arguments_that_are_named_as_coefficients_of_others_are_their_own() -> None:
    alg = bs.algebra(10)  # labels such as e1_2

    @codegen.kernel(alg.layout("bivector"), codegen.numbers(3), codegen.numbers(1))
    def wide(x: Any, x_e1: Any, x_e1_: Any) -> Any:
        return x * x_e1[2] * x_e1_[0]

    values = np.arange(45.0)
    for target in ("c", "numpy", *(["numba"] if find_spec("numba") else [])):
        found = wide.on(target)(values, [1.0, 2.0, 3.0], [5.0])
        np.testing.assert_array_equal(found, 15 * values)


@pytest.mark.parametrize(
    "formula",
    [
        lambda m: pga.e0 * m, lambda m: pga.e1 ^ m, lambda m: pga.e1 | m, lambda m: pga.e012 & m, lambda m: pga.e0 + m,
        lambda m: pga.e12 - m, lambda m: pga.rotor((0, 0, 1), 0.3) >> m, lambda m: pga.e0 * m.grade(0),
    ],
)  # fmt: skip
def test_constant_multivectors_stand_on_the_left_too(formula: Callable[[Any], Any]) -> None:
    m = pga.random("motor", seed=1)
    kernel = codegen.kernel(pga.kind("motor"), name="left")(formula)
    found, expected = kernel.on("numpy")(m), formula(m)
    np.testing.assert_allclose(found.values, expected.as_kind(found.kind).values, atol=1e-15)


@pytest.mark.parametrize("digits", [0, -5, 2.5, True, "50", 10**9])
def test_references_have_a_digit_at_least(digits: Any) -> None:
    kernel = scalar_kernel(lambda a: a / 3)
    assert str(kernel.reference(1.0, digits=np.int64(30))[0]).startswith("0.333333333333")
    with pytest.raises(InputError, match="digits is"):
        kernel.reference(1.0, digits=digits)
