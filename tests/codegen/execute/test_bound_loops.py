"""Compiled loops keep what is bound to them."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.execute.items import CLoop
from bladesmith.codegen.language import InOut, Vector
from bladesmith.codegen.programs.algorithms import algorithm_extension

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def doubled(x: InOut[Vector[3]]) -> None:
    """Twice as much."""
    for i in range(3):
        x[i] *= 2.0


def test_arrays_live_as_long_as_what_they_are_bound_to() -> None:
    loop = CLoop(extension.load(algorithm_extension(doubled.function_for(doubled.declared_arguments()))), "f64")

    class Watched(np.ndarray):
        """An array that can be watched."""

    array = np.ones((5, 3)).view(Watched)
    alive = weakref.ref(array)
    run = loop.bind([loop.hold(array)], loop.integers([3]), loop.integers([0]))
    del array
    gc.collect()
    assert alive() is not None
    run(0, 5)
    np.testing.assert_array_equal(alive(), np.full((5, 3), 2.0))
    del run
    gc.collect()
    assert alive() is None
