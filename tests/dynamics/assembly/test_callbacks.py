"""Derivatives of functions of time by differences: paths that repeat themselves, or end."""

import numpy as np
import pytest

from bladesmith.codegen.errors import InputError
from bladesmith.common import finite_differences


@pytest.mark.parametrize("behind", range(finite_differences.POINTS))
def test_weights_are_exact_on_polynomials(behind):
    places = np.arange(finite_differences.POINTS) - behind
    first, second = finite_differences.weights(behind)
    for power in range(finite_differences.POINTS):
        values = places.astype(float) ** power
        size = np.abs(second * values).max() + 1
        assert abs(first @ values - (power == 1)) < 1e-14 * size
        assert abs(second @ values - 2 * (power == 2)) < 1e-14 * size


@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("rate, duration, off", [(1, 1, 1e-10), (4 * np.pi, 1, 1e-9), (20 * np.pi, 30, 1e-8),
                                                 (2e3, 1, 1e-8), (1e6, 1e-3, 1e-6)])  # fmt: skip
def test_derivatives_of_what_repeats_itself(rate, duration, off, bounded):
    def place(t):
        if bounded and not 0 <= t <= duration:
            raise InputError("the table ends")
        return np.array([np.cos(rate * t), np.sin(rate * t), 1.0])

    found = finite_differences.Differences(place, (0.0, float(duration)))
    for t in np.linspace(0, duration, 9):
        value, first, second = found(t)
        assert np.abs(first / rate - [-value[1], value[0], 0]).max() < off
        assert np.abs(second / rate**2 + [value[0], value[1], 0]).max() < off


def test_failures_inside_are_told():
    def place(t):
        if t > 0.4:
            raise InputError("no more")
        return np.ones(2)

    with pytest.raises(InputError, match="no more"):
        finite_differences.Differences(place, (0.0, 1.0))
