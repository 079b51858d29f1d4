"""Models that several tests of registration use."""

import pytest

from ..support.registration import noisy_lines


@pytest.fixture(scope="module")
def models():
    """A query and its reference, lines with noise and outliers."""
    return noisy_lines()
