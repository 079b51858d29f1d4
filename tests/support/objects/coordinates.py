"""Random coordinates, and rows of conformal objects made of points."""

from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.formulas.objects import conformal

from ..formulas import Array, Traced, multivector, rows, stock

CGA, PGA, PLANE = stock("cga3d"), stock("pga3d"), stock("cga2d")
V, N = "euclidean", "number"
COUNT = 200
SPATIAL = pytest.mark.parametrize("algebra", [CGA, PGA], ids=lambda a: a.name)


def vectors(seed: int, *, scale: float = 1.0, size: int = 3, count: int = 1) -> Any:
    values = np.random.default_rng(seed).normal(size=(count, COUNT, size)) * scale
    return values[0] if count == 1 else values


def positive(seed: int) -> Array:
    return np.random.default_rng(seed).uniform(0.1, 3, COUNT)


def outer_of_points(*points: Array, flat: bool = False) -> Array:
    """A ^ B ^ ..., plainly, as rows of the kind with all blades of that grade."""
    point = CGA.kind("point")
    total = multivector(point, Traced(CGA, conformal.point, V)(points[0]))
    for p in points[1:]:
        total = total ^ multivector(point, Traced(CGA, conformal.point, V)(p))
    if flat:
        total = total ^ total.basis("ni")
    kinds = {2: "bivector", 3: "trivector", 4: "quadvector", 5: "pseudoscalar"}
    return rows(CGA.kind(kinds[total.grades[0]]), total)


def widened(kind: str, values: Array, grade: str) -> Array:
    return rows(CGA.kind(grade), multivector(CGA.kind(kind), values))
