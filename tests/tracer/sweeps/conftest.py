"""What the tests of sweeps run under."""

import mpmath
import pytest


@pytest.fixture(autouse=True)
def fifty_digits():
    with mpmath.workdps(50):
        yield
