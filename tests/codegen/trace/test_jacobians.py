"""All partial derivatives of a kernel: columns of the forward derivative, and differences with 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen
from bladesmith.codegen.errors import TraceError

pga = bs.pga3d


@codegen.kernel(pga.kind("motor"), pga.kind("point"))
def moved(m, x):
    return m >> x


@codegen.kernel(codegen.numbers(3), codegen.scalar, algebra=pga)
def waves(a, b):
    return codegen.sin(a[0] * b) + a[1] * a[2]


@pytest.mark.parametrize("wrt", ["m", "x"])
def test_columns_are_forward_derivatives(wrt: str) -> None:
    m, x = (pga.random(k, 5, seed=3) for k in (pga.kind("motor"), pga.kind("point")))
    derivative, size = moved.derivative(wrt), {"m": 8, "x": 4}[wrt]
    matrices = moved.jacobian(wrt)(m, x).reshape(5, -1, size)
    layout = pga.layout({"m": "motor", "x": "point"}[wrt])
    blades = derivative.traced.outputs[0].kind.blades
    rows = [moved.traced.outputs[0].kind.blades.index(b) for b in blades]
    for k in range(size):
        column = derivative(m, x, pga.wrap(layout, np.eye(size)[k])).values
        assert np.allclose(matrices[:, rows, k], column, rtol=1e-15, atol=1e-15)
    rest = np.delete(matrices, rows, axis=1)
    assert not rest.any()


def test_rows_of_numbers_have_jacobians() -> None:
    a, b = [0.3, -1.2, 7.5], 2.5
    with mpmath.workdps(50):
        exact = [mpmath.diff(lambda t: mpmath.sin(t * b) + a[1] * mpmath.mpf(a[2]), a[0]), a[2], a[1]]
    assert np.allclose(waves.jacobian("a")(a, b), np.array(exact, float), rtol=4e-16)
    assert np.allclose(waves.jacobian("b")(a, b), [a[0] * np.cos(a[0] * b)], rtol=4e-16)


def test_an_argument_that_is_none_is_refused() -> None:
    with pytest.raises(TraceError, match="no argument 'z'"):
        moved.jacobian("z")
