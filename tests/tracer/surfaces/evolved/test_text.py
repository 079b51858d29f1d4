"""The text of points, normals and constants run as Python, with 16 and with 50 digits, beside what is compiled."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.ir.loops import language
from bladesmith.codegen.programs.tracer.records import HIT, RAY, SEARCH, STATE
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.codegen.programs.tracer.surfaces.functions import curve_algorithms
from bladesmith.codegen.status import Status
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.surface_tables import build_surface_tables

TUBE = [((0.5 * i, 0.1 * i * i, 0.4 * i), (0.3, 0.1 * i, 1.0), 1.0 + 0.1 * i) for i in range(5)]
RIBBON = [((-1.0, -0.5 + 0.3 * i, 0.7 * i), (1.0 - 0.2 * i, 0.4, 0.6 * i)) for i in range(5)]
#: Two pairs of parallel segments: a ray in its plane meets every carrier.
FLAT = [((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)), ((-1.0, 0.0, 1.0), (1.0, 0.0, 1.0))]
SURFACES = {
    "linear tube": lambda: tracer.EvolvedCircles(TUBE[:2]),
    "tube of degree 4": lambda: tracer.EvolvedCircles(TUBE, align=True, gaps=True),
    "linear ribbon": lambda: tracer.EvolvedPointPairs(RIBBON[:2]),
    "ribbon of degree 4": lambda: tracer.EvolvedPointPairs(RIBBON, align=True, gaps=True),
    "flat ribbon": lambda: tracer.EvolvedPointPairs(FLAT),
}
#: Beside rays in general: in the plane of the first circle or segment, where the text has its special cases.
RAYS = 6
IN_PLANE = [((-4.0, 0.1, 0.0), (1.0, 0.02, 0.0)), ((-4.0, 0.0, 0.3), (1.0, 0.0, 0.1)), ((-4.0, 0.0, 0.0), (1, 0, 0))]


def points(algorithms: Any, row: Any, origin: Any, direction: Any) -> tuple[list[list[Any]], int]:
    """t, alpha, point and normal of all points of a line, by t; and the status."""
    ray, search, state = language.zeros(RAY), language.zeros(SEARCH), STATE.zeros()
    hits, normal = language.zeros(64, HIT), language.zeros(3)
    for i in range(3):
        ray[i], ray[3 + i] = language.number(origin[i]), language.number(direction[i])
    state.room, search.t_min, search.t_max = 64, -language.largest(), language.largest()
    algorithms.by_method["isolate"](row, ray, search, hits, state, np.zeros(1, np.int64))
    found = []
    for hit in (HIT.view(hits[i]) for i in range(state.count)):
        algorithms.normal(normal, row, ray, hit)
        found.append([hit.t, hit.alpha, *hit.point, *normal])
    return sorted(found), state.status


@pytest.mark.compiles
@pytest.mark.slow
@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("digits", [16, 50])
def test_compiled_points_are_those_of_the_text(name: str, digits: int) -> None:
    surface = SURFACES[name]()
    kind = surface_kind(surface.program_kind)
    engine = engine_for(needs([kind.name], pictures=False))
    (constants,) = build_surface_tables(engine, [surface])[kind.name].constants
    (parameters,) = surface.parameters.copy()
    spans, bound = kind.slice("spans"), kind.slice("bound")
    parameters[bound.start : bound.start + spans.stop - spans.start] = constants[spans]  # where the surface is real
    random = np.random.default_rng(3)
    origins = np.array([*3 * random.normal(size=(RAYS, 3)), *(origin for origin, _ in IN_PLANE)])
    aims = 0.5 * random.normal(size=(RAYS, 3)) - origins[:RAYS]
    directions = np.array([*aims, *(direction for _, direction in IN_PLANE)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    compiled = surface.intersect(origins, directions)
    algorithms = curve_algorithms(kind, ("isolate",))
    count = 0
    with mpmath.workdps(digits), language.number_type(np.float64 if digits == 16 else mpmath.mp):
        row = language.zeros(kind.constants)
        algorithms.prepare([language.number(float(x)) for x in parameters], row)
        assert row[bound.stop - 1] == language.largest()
        row[bound] = [language.number(float(x)) for x in constants[bound]]
        assert np.allclose(row.astype(float), constants, rtol=1e-13, atol=1e-13)
        for i in range(len(origins) if digits == 16 else RAYS):  # in the plane rounding decides
            origin, direction = origins[i], directions[i]
            found, status = points(algorithms, row, origin, direction)
            assert status == compiled.status[i] and len(found) == compiled.count[i]
            for j, (t, alpha, *place) in enumerate(np.array(found, float).reshape(-1, 8)):
                count += 1
                facing = -np.sign(np.dot(place[3:], direction)) or 1.0
                assert np.allclose(
                    [t, alpha, *place[:3], *(facing * np.array(place[3:]))],
                    [compiled.t[i, j], compiled.alpha[i, j], *compiled.point[i, j], *compiled.normal[i, j]],
                    rtol=0, atol=1e-9,
                )  # fmt: skip
    assert count >= 2 and (name != "flat ribbon" or Status.SINGULAR in compiled.status)
