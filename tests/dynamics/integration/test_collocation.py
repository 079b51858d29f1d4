"""Coefficients of Radau IIA methods, against polynomials with 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from bladesmith.dynamics.integration.collocation import radau, stages_of


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_coefficients_are_those_of_polynomials(stages):
    """Nodes are the roots of d^(s-1)/dx^(s-1) of x^(s-1) (x - 1)^s; sums of powers come out as their integrals."""
    method, s = radau(stages), stages
    with mpmath.workdps(50):
        powers = [mpmath.binomial(s, k) * (-1) ** (s - k) for k in range(s + 1)]  # of (x - 1)^s
        rows = [powers[k] * mpmath.ff(s - 1 + k, s - 1) for k in range(s, -1, -1)]
        nodes = sorted(mpmath.re(x) for x in mpmath.polyroots(rows, maxsteps=200, extraprec=200))
        values = mpmath.matrix(s, s)
        integrals = mpmath.matrix(s, s)
        for i in range(s):
            for k in range(s):
                values[i, k], integrals[i, k] = nodes[i] ** k, nodes[i] ** (k + 1) / (k + 1)
        matrix = integrals * values**-1
        inverse = np.array((matrix**-1).tolist(), float)
    assert np.abs(method.c - np.array(nodes, float)).max() < 4e-16
    assert np.abs(method.inverse - inverse).max() < 1e-14 * np.abs(inverse).max()
    assert np.abs(np.triu(method.triangle, 1)).max() == 0
    # an inverse that is the triangle's and an upper one with ones on the diagonal
    upper = method.triangle @ np.array(matrix.tolist(), float)
    assert np.abs(np.tril(upper) - np.eye(s)).max() < 1e-13


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_the_estimate_is_zero_for_what_the_lower_order_integrates(stages):
    """z = t^k, k <= s, from the start: the rates there and the stages give h (b^ - b) f = 0."""
    method = radau(stages)
    for k in range(1, stages + 1):
        first = 1.0 if k == 1 else 0.0
        assert abs(first / method.triangle[0, 0] + method.estimate @ method.c**k) < 1e-13
    k = stages + 1
    assert abs(method.estimate @ method.c**k) > 1e-6


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_the_iteration_converges_on_all_that_is_stable(stages):
    method = radau(stages)
    for angle in (0.5, 0.75, 1.0):
        for size in 10.0 ** np.linspace(-3, 6, 200):
            z = size * np.exp(1j * np.pi * angle) * np.eye(stages)
            step = np.eye(stages) - np.linalg.solve(method.triangle - z, method.inverse - z)
            assert np.abs(np.linalg.eigvals(step)).max() < 0.71
    assert [stages_of(x) for x in (1e-3, 1e-5, 1e-9, 1e-14)] == [3, 5, 7, 7]
