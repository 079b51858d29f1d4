"""Points and lines of conformal geometry at 50 digits."""

from __future__ import annotations

import numpy as np

from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.rings.protocol import PrecisionRing

RING = PrecisionRing(50)
mpf = RING.context.mpf


def exact(x):
    return from_values(cga3d(), RING, (1, 2, 4), [mpf(float(v)) for v in x])


def scalar(x):
    return from_values(cga3d(), RING, (0,), [mpf(x)])


def coordinates(x):
    return np.array([x[name].scalar() for name in ("e1", "e2", "e3")])
