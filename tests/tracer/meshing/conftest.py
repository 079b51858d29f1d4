"""Surfaces that several tests of meshes use."""

import pytest

from bladesmith.curves import KochanekBartels
from bladesmith.tracer import EvolvedCircles

from ...support.tracer.meshes import necklace


@pytest.fixture(scope="module")
def ring():
    """A closed tube."""
    return EvolvedCircles(KochanekBartels(necklace(), closed=True))
