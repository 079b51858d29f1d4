"""How integers of arrays are stored, the largest number, and functions that are in C's own library."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.ir.loops.algorithm import Algorithm, CFunction, in_library
from bladesmith.codegen.ir.loops.tangent import tangent
from bladesmith.codegen.ir.loops.types import INT, REAL, ArrayType, Parameter
from bladesmith.codegen.language import Bytes, InOut, Int, Ints32, Real, Reals, Vector, int_empty, largest
from bladesmith.codegen.programs.algorithms import algorithm_text, numba_text

needs_compiler = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def count_up(x: Reals, found: InOut[Ints32], flags: InOut[Bytes]) -> Int:
    """Products of stored integers, which need more bits than they are stored in; numbers as large as there are."""
    waiting = int_empty(2)
    waiting[0] = 0
    for i in range(len(x)):
        waiting[0] += found[i] * found[i]
        found[i] = i - 2**31
        flags[i] = 255 if x[i] < largest() else flags[i] + 1
    return waiting[0]


FOUND, FLAGS = np.array([2**31 - 1, -5, 1 << 20], np.int32), np.array([7, 8, 9], np.uint8)
X = np.array([np.finfo(np.float64).max, 1.0, np.nan])


@needs_compiler
def test_integers_of_fewer_bits() -> None:
    expected = count_up.reference(X, FOUND, FLAGS)
    found = count_up(X, FOUND, FLAGS)
    assert [a.dtype for a in found[:2]] == [np.int32, np.uint8]
    assert found[0].tolist() == expected[0].tolist() == [-(2**31), 1 - 2**31, 2 - 2**31]
    assert found[1].tolist() == expected[1].tolist() == [8, 255, 10]
    assert found[2] == expected[2] == (2**31 - 1) ** 2 + 25 + (1 << 40)
    single = count_up(X[1:].astype(np.float32), FOUND[1:], FLAGS[1:])
    assert single[1].tolist() == [255, 10]


@pytest.mark.compiles
@pytest.mark.peers
def test_integers_of_fewer_bits_on_numba() -> None:
    for ours, theirs in zip(count_up.on("numba")(X, FOUND, FLAGS), count_up.reference(X, FOUND, FLAGS), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_arrays_that_are_stored_in_other_bits_are_refused(tmp_path) -> None:
    @algorithm
    def wide(found: InOut[Ints32]) -> None:
        """Takes 32 bits."""
        found[0] = 1

    with pytest.raises(errors.AlgorithmError, match=r"stored as Int32, and gets Int8, in `wide\(flags\)`.*copy"):

        @algorithm
        def narrow(flags: InOut[Bytes]) -> None:
            """Gives 8."""
            wide(flags)

    with pytest.raises(errors.AlgorithmError, match="stored as Int32, and gets Int, in `wide"):

        @algorithm
        def fixed() -> None:
            """Gives 64, in an array whose size is known."""
            x = int_empty(4)
            wide(x)


@Algorithm
def helper(x: Real) -> Real:
    """The number itself."""
    return x


@in_library
def doubled(x: Real) -> Real:
    """The double of a number."""
    return 2.0 * helper(x)


@Algorithm
def quadruple(x: Real) -> Real:
    """Four times a number."""
    once = doubled(x)
    return doubled(once)


ONLY_C = CFunction("only_c", [Parameter("x", ArrayType(INT, (2,)), "inout")])


@Algorithm
def calls_c(row: Vector[2]) -> Real:
    """Calls what is in C alone."""
    state = int_empty(2)
    ONLY_C(state)
    return row[0]


def test_functions_in_the_library_are_called_in_c_and_printed_for_others() -> None:
    text = algorithm_text(quadruple.instance())
    assert "FN(doubled)(x)" in text and "S FN(doubled)(" not in text and "FN(helper)" not in text
    other = numba_text("quadruple", {"loop": quadruple.instance()})
    assert "def doubled(" in other and "def helper(" in other
    assert quadruple(3.0) == 12.0


def test_functions_of_c_alone_are_refused_elsewhere() -> None:
    assert "FN(only_c)(state)" in algorithm_text(calls_c.instance())
    with pytest.raises(errors.AlgorithmError, match="only_c is a function of C alone"):
        numba_text("calls_c", {"loop": calls_c.instance()})
    with pytest.raises(errors.AlgorithmError, match="only_c is a function of C alone"):
        calls_c.reference([1.0, 2.0])


MEASURED = CFunction("measured", [Parameter("x", REAL)], [REAL])


@Algorithm
def calls_measured(x: Real) -> Real:
    """A number that C alone has."""
    y = MEASURED(x)
    return 2.0 * y


def test_functions_of_c_alone_return_numbers_and_have_no_derivative() -> None:
    assert "FN(measured)(x)" in algorithm_text(calls_measured.instance())
    with pytest.raises(errors.AlgorithmError, match="measured is a function of C alone"):
        tangent(calls_measured.instance(), frozenset(("x",)))
