"""Names that a target, its headers or generated text have as well; static values of all kinds; indented text."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import Bool, Int, Real, Static, Vector, int_zeros, sin, zeros

needs_compiler = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def select(
    work: Vector[3], integers: Real, select: Real, result0: Real, i: Int, strides: Real, errno: Real, linux: Real
) -> tuple[Real, Real]:
    """Names of generated text, of macros, and its own."""
    local = zeros(2)
    order = int_zeros(2)
    order[0] = i
    local[0] = work[1] + integers + select + strides + errno + linux
    return local[0] + result0 * order[0], local[1]


@algorithm
def angle(x: Real) -> Real:
    """A function of the headers is called so."""
    return sin(x) + 1.0


@algorithm
def bs_min(x: Real) -> Real:
    """Another one."""
    return min(angle(x), 2.0)


@algorithm
def NAN(x: Real) -> Real:
    """A macro."""
    return bs_min(x) + 1.0


FUNCTIONS = (angle,)


@algorithm
def with_angle(x: Real) -> Real:
    """A number that is called as the function that it comes from."""
    angle = FUNCTIONS[0](x)
    return angle + NAN(x)


def indented() -> Any:
    @algorithm
    def shifted(x: Real) -> Real:
        """Text
        at the beginning of a line."""
        # A comment there.
        return x + 1.0

    return shifted


@algorithm
def chosen(x: Real, kind: Static) -> Real:
    """Another text for each static value."""
    if kind == "A":
        return x
    if kind == "true":
        return 2.0 * x
    if kind == "1":
        return 3.0 * x
    return 4.0 * x if kind == 1 else 5.0 * x


@algorithm
def all_chosen(x: Real) -> Real:
    """Values whose names are nearly alike."""
    first = chosen(x, "A") + 10.0 * chosen(x, "a") + 100.0 * chosen(x, "true")
    return first + 1e3 * chosen(x, "1") + 1e4 * chosen(x, 1) + 1e5 * chosen(x, 2)


@algorithm
def signed(flag: Bool, x: Real) -> Real:
    return x if flag else -x


@algorithm
def least(n: Int) -> Int:
    """The least integer."""
    return n + -9223372036854775808


CASES: list[tuple[Any, tuple[Any, ...], Any]] = [
    (select, (np.arange(3.0), 2.0, 3.0, 4.0, 5, 6.0, 7.0, 8.0), (47.0, 0.0)),
    (with_angle, (0.0,), 3.0),
    (indented(), (2.0,), 3.0),
    (all_chosen, (1.0,), 543251.0),
    (chosen, (1.0, "\u00b2"), 5.0),
    (chosen, (1.0, "a" * 300), 5.0),
    (signed, (2**32, 1.0), 1.0),
    (least, (1,), -(2**63) + 1),
]
IDS = [f"{case[0].name}{k}" for k, case in enumerate(CASES)]


@needs_compiler
@pytest.mark.parametrize(("function", "arguments", "expected"), CASES, ids=IDS)
def test_names_and_values_in_c(function: Any, arguments: Any, expected: Any) -> None:
    assert function(*arguments) == expected
    assert function.reference(*arguments) == expected


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize(("function", "arguments", "expected"), CASES, ids=IDS)
def test_names_and_values_on_numba(function: Any, arguments: Any, expected: Any) -> None:
    assert function.on("numba")(*arguments) == expected
