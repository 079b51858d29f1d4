"""What the tests of all targets compare with."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from bladesmith.codegen.execute.bound_kernels import BoundKernel

from ...support.specimens import compiled_by_c


@pytest.fixture
def compiled_c() -> Callable[[str], BoundKernel]:
    """The specimens through the C target."""
    return compiled_by_c
