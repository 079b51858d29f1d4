"""Kernels in algorithms: those of users, of static tuples and of programs, on C, numba and with fifty digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen
from bladesmith.codegen import algorithm
from bladesmith.codegen.formulas.products import versors
from bladesmith.codegen.language import InOut, Int, Matrix, Real, Reals, Vector
from bladesmith.codegen.programs.kernel_spec import KernelSpec

from ...support.targets.algorithms import needs_compiler, references

cga = bs.cga3d
rng = np.random.default_rng(5)


@codegen.kernel(cga.kind("motor"), cga.kind("point"))
def moved(m, x):
    return m * x * ~m


@codegen.kernel(codegen.numbers(3), codegen.scalar, algebra=cga)
def norms(x, s):
    return codegen.row([x[0] * s, x[1] * s]), x[0] * x[0] + x[2]


@algorithm
def with_kernels(m: Vector[8], x: InOut[Vector[5]], n: Int) -> Real:
    """Kernels on rows, parts, tuples and numbers; a result over its own argument."""
    total = 0.0
    for i in range(n):
        x[:] = moved(m, x)
        part, square = norms((x[0], x[1], float(i)), total + 1.0)
        part[:], total = norms(x[1:4], square)
        total += part[0] - part[1]
    return total


#: What a number at run time selects.
BY_NUMBER = ((2, 5, moved), (7, 5, moved))


@algorithm
def selected_kernel(kind: Int, m: Vector[8], x: Reals, at: Int, out: InOut[Vector[5]]) -> None:
    """A kernel of a static tuple, on a part whose length it says."""
    for number, size, kernel in BY_NUMBER:
        if kind == number:
            out[:] = kernel(m, x[at : at + size])


def motor_rows(n: int) -> Any:
    rotor = cga.rotor(rng.normal(size=(n, 3)), rng.normal(size=n))
    return (cga.translator(rng.normal(size=(n, 3))) * rotor).as_kind(cga.kind("motor")).values


def points(n: int) -> Any:
    return cga.point(rng.normal(size=(n, 3))).as_kind(cga.kind("point")).values


#: Kernels' texts are rewritten formulas: their bits are those of one target as of another, not of the formula.
KERNELS = (motor_rows(8), points(8), np.arange(8))


@needs_compiler
@pytest.mark.compiles
@pytest.mark.peers
def test_kernels_in_algorithms() -> None:
    compiled, by_numba = with_kernels(*KERNELS), with_kernels.on("numba")(*KERNELS)
    expected = references(with_kernels, KERNELS, (), np.float64)
    for a, b, c in zip(compiled, by_numba, expected, strict=True):
        assert np.array_equal(a, b)
        assert np.allclose(a, c, rtol=1e-12)


def test_kernels_run_with_fifty_digits() -> None:
    context = mpmath.mp.clone()
    context.dps = 50
    m, x = motor_rows(1)[0], points(1)[0]
    point, total = with_kernels.reference(m, x, 3, numbers=context)
    double, sum_of_doubles = with_kernels.reference(m, x, 3)
    assert np.allclose([float(v) for v in point], double, rtol=1e-13)
    assert abs(float(total) - sum_of_doubles) < 1e-9 * abs(sum_of_doubles)
    assert total != float(total)


@needs_compiler
@pytest.mark.compiles
@pytest.mark.peers
def test_kernels_of_a_static_tuple() -> None:
    kinds, motors, rows = np.array([2, 7, 5, 2]), motor_rows(4), np.concatenate([np.zeros((4, 3)), points(4)], 1)
    given = kinds, motors, rows, np.full(4, 3), np.zeros((4, 5))
    found = selected_kernel(*given)
    assert np.array_equal(found, selected_kernel.on("numba")(*given))
    assert np.array_equal(found[kinds != 5], moved(motors, rows[:, 3:])[kinds != 5]) and not found[2].any()
    for each, expected in zip(zip(*given, strict=True), found, strict=True):
        assert np.allclose(selected_kernel.reference(*each), expected, rtol=1e-12)


turned = KernelSpec(versors.sandwich, ("motor", "point"), "turned")


@algorithm
def turned_twice(m: Vector[8], x: InOut[Vector[5]]) -> None:
    """A kernel as programs declare them."""
    for _ in range(2):
        x[:] = turned(m, x)


@needs_compiler
def test_kernels_of_programs_in_algorithms() -> None:
    m, x = motor_rows(8), points(8)
    found = turned_twice(m, x)
    expected = [turned_twice.reference(*each) for each in zip(m, x, strict=True)]
    assert np.allclose(found, expected, rtol=1e-12)


@codegen.kernel(codegen.numbers(3), codegen.scalar, algebra=cga)
def part_and_square(x, s):
    return codegen.row([x[1] * s, x[2] * s, x[0] * s]), x[0] * x[0]


@algorithm
def swapped_rows(rows: InOut[Matrix[2, 3]], s: Vector[3]) -> Real:
    """Two results of a kernel in one array."""
    part, square = norms(s, 2.0)
    rows[0][:], rows[1, 2] = part_and_square(rows[0], square)
    return part[0]


@needs_compiler
def test_two_results_of_a_kernel_in_one_array() -> None:
    rows, s = rng.normal(size=(2, 3)), rng.normal(size=3)
    found, first = swapped_rows(rows, s)
    square = s[0] * s[0] + s[2]
    assert first == 2.0 * s[0]
    assert np.allclose(found[0], rows[0][[1, 2, 0]] * square, rtol=1e-15)
    assert np.allclose(found[1], [*rows[1][:2], rows[0, 0] ** 2], rtol=1e-15)


def test_names_at_their_longest() -> None:
    """Names that derivatives make of them are shortened, and stay different; longer ones are refused when declared."""
    name = "a" * 64

    def formula(m, x):
        return m * x * ~m

    formula.__name__ = name
    kernel = codegen.kernel(cga.kind("motor"), cga.kind("point"))(formula)
    names = {kernel.tangent_signature(varying).symbol for varying in (("m",), ("x",), ("m", "x"))}
    names |= {kernel.derivative("m").name, kernel.derivative("x").name}
    assert len(names) == 5 and all(len(each.removeprefix("cga3d_")) <= 64 for each in names)
    formula.__name__ += "a"
    with pytest.raises(bs.errors.TraceError, match=r"64 at most.*name=\.\.\."):
        codegen.kernel(cga.kind("motor"), cga.kind("point"))(formula)
