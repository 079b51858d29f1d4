"""Tables of surfaces in compiled programs: how many rows they have room for."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith.errors import SceneError
from bladesmith.tracer.rendering.surface_tables import build_surface_tables


class Faceted:
    """A surface that says how many rows it has, and holds one."""

    program_kind = "facet"

    def __init__(self, rows):
        self.parameters = np.broadcast_to(np.zeros(9), (rows, 9))


def test_more_rows_than_can_be_numbered():
    with pytest.raises(SceneError, match="4294967292 facets .* has 2147483646 at most"):
        build_surface_tables(None, [Faceted(2**31 - 2), Faceted(2**31 - 2)])
