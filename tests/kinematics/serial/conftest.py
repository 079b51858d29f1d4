"""Oracles of serial chains have fifty digits."""

import mpmath as mp
import pytest

from ...oracles.serial_chains import DIGITS


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(DIGITS):
        yield
