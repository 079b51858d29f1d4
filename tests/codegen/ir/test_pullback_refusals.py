"""Reverse derivatives of algorithms: memory that is not bounded, and arguments that do not fit, are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import Int, Real, sin

from ...support.targets.pullbacks import in_place, of_any_size, operators

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def until_small(x: Real) -> Real:
    """A loop of any number of steps, each of which counts."""
    while x > 1e-3:
        x = sin(x) * x
    return x


@algorithm
def of_count(x: Real, n: Int) -> Real:
    """The same, of as many as a caller says."""
    for _ in range(n):
        x = sin(x)
    return x


@algorithm
def with_bound(x: Real, n: Int) -> Real:
    """The same, bounded."""
    for _ in range(min(n, 20)):
        x = sin(x)
    return x


@algorithm
def without_need(x: Real, n: Int) -> Real:
    """A loop of any number of steps that needs nothing kept."""
    total = 0.0
    for k in range(n):
        total += x * float(k)
    return total


@algorithm
def too_long(x: Real) -> Real:
    """More than is kept."""
    for _ in range(200000):
        x = sin(x)
    return x


def test_memory_is_bounded() -> None:
    place = rf"test_pullback_refusals.py:{until_small.text.first + 3}: .* each step of this loop.*derivative\(\.\.\.\)"
    with pytest.raises(errors.AlgorithmError, match=place):
        until_small.vjp(1.0)(1.0)
    with pytest.raises(errors.AlgorithmError, match=r"range\(min\(n, 100\)\)"):
        of_count.vjp(1.0, 3)(1.0)
    with pytest.raises(errors.AlgorithmError, match=r"keeps 200000 numbers, .* 131072 fit"):
        too_long.vjp(1.0)(1.0)
    assert np.isclose(with_bound.vjp(1.0, 3)(1.0)[0], with_bound.derivative("x")(1.0, 3, 1.0)[1], rtol=1e-15)
    assert with_bound.vjp(0.3, -2)(1.5) == (1.5,)
    assert without_need.vjp(2.0, 1000)(1.0) == (499500.0,)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: operators.vjp(np.ones(3)), errors.InputError, "takes 2 arguments"),
        (lambda: operators.vjp(np.ones(3), 1.0)(1.0), errors.InputError, "2 cotangents .out_bar, result_bar., not 3"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones(3), 1.0), errors.ShapeError, r"out_bar has shape \(3,\)"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones((2, 2)), 1.0), errors.ShapeError, "more than there are"),
        (lambda: operators.vjp(np.ones(3), 1.0)(np.ones(2), "a"), errors.InputError, "result_bar"),
        (lambda: operators.vjp(np.ones(3), 1.0, wrt=["z"]), errors.InputError, "there are: x, y"),
        (lambda: in_place.pullback("n"), errors.InputError, "no parameter of real numbers 'n'"),
        (lambda: of_any_size.pullback("x").source(), errors.InputError, "give the arguments of a call"),
    ],
)
def test_what_is_refused(call: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        call()
