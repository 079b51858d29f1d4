"""What tests of multivectors share."""

from __future__ import annotations

from typing import Any

import pytest

import bladesmith as bs


@pytest.fixture
def alg() -> Any:
    return bs.algebra(3)
