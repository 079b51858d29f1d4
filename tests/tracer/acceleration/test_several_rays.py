"""First hits of many rays on surfaces along curves, several at once: the bits of single rays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.codegen.build import extension
from bladesmith.codegen.programs.tracer.several_rays import meets_several
from bladesmith.curves import KochanekBartels
from bladesmith.tracer.rendering import driver, several_rays
from bladesmith.tracer.rendering.engines import Rays
from bladesmith.tracer.rendering.several_rays import are_in_order, several_rays_of

from ...oracles.references.families import FAMILIES, controls, rays
from ...support.tracer.lattices import CAMERA, FIELDS

CIRCLES = [((-0.9, 0.0, -0.3), (1, 0.2, 0.3), 1.0), ((-0.3, 0.2, 0.1), (1, 0, -0.2), 0.8),
           ((0.3, -0.2, 0.2), (1, 0.3, 0.2), 0.9), ((1.0, 0.3, 0.4), (1, -0.3, 0.1), 0.7)]  # fmt: skip
PAIRS = [((-0.9, 0, -0.6), (-0.9, 0.2, 0.6)), ((-0.3, 0.2, -0.7), (-0.3, -0.1, 0.6)),
         ((0.3, -0.2, -0.5), (0.4, 0.3, 0.6)), ((1.0, 0.3, -0.5), (0.8, -0.3, 0.7))]  # fmt: skip
SCENES = {
    "tubes": lambda: [tracer.EvolvedCircles([CIRCLES[0], CIRCLES[3]]), tracer.EvolvedCircles(CIRCLES)],
    "ribbons": lambda: [tracer.EvolvedPointPairs([PAIRS[0], PAIRS[3]]), tracer.EvolvedPointPairs(PAIRS)],
    "mixed": lambda: [
        tracer.Plane((0, 0, 1), -1.0), tracer.EvolvedCircles([CIRCLES[0], CIRCLES[3]]), tracer.Sphere((0, 0, 1), 0.7),
        tracer.EvolvedPointPairs([PAIRS[0], PAIRS[3]]), tracer.Disc((0, -1, 0), (0, 1, 0), 0.5),
        tracer.EvolvedCircles([CIRCLES[0], CIRCLES[3]]),
        tracer.EvolvedCircles(KochanekBartels([cga3d.circle((np.cos(a), np.sin(a), 0), (-np.sin(a), np.cos(a), 0), 0.3)
                                               for a in (0.0, 1.5, 3.0, 4.5)])),
    ],
}  # fmt: skip
pytestmark = [
    pytest.mark.compiles,
    pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
]


@pytest.fixture(autouse=True)
def several(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """All rays are found several at once; how many of them are left to single searches."""
    left: list[int] = []

    def counted(needs: Any, n: int) -> Any:
        loop = several_rays_of(needs, n)
        if loop is None:
            return None

        class Counted:
            def run(self, *given: Any) -> Any:
                found = loop.run(*given)
                left.append(len(found))
                return found

        return Counted()

    monkeypatch.setattr(driver, "MANY_RAYS", 1)
    monkeypatch.setattr(several_rays, "PAYS", 1)
    monkeypatch.setattr(driver, "are_in_order", lambda rays, n: True)
    monkeypatch.setattr(driver, "several_rays_of", counted)
    return left


def check(surfaces: Any, origins: Any, directions: Any, monkeypatch: pytest.MonkeyPatch, threads: int = 1) -> Any:
    """Hits, the same as those of single rays."""
    scene = tracer.Scene(CAMERA, [], surfaces)
    if not meets_several(scene.needs):
        pytest.skip("this processor has no wide vectors")
    found = scene.intersect(origins, directions, threads=threads)
    with monkeypatch.context() as patch:
        patch.setattr(driver, "MANY_RAYS", 1 << 60)
        single = scene.intersect(origins, directions, threads=threads)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found, name), getattr(single, name), err_msg=name)
    return found


@pytest.mark.parametrize("name", SCENES)
def test_pixels(name: str, several: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """A number of rays that fills no vector, one origin for all, two threads; few rays are left to single searches."""
    origins, directions = tracer.Camera.look_at((0, -4, 0.5), (0, 0, 0.1)).rays(131, 99)
    found = check(SCENES[name](), origins[0, 0], directions.reshape(-1, 3), monkeypatch, threads=2)
    assert found.hit.mean() > 0.2
    assert len(several) == 1 and several[0] < 0.02 * len(found.t)


@pytest.mark.parametrize("name", SCENES)
def test_rays_of_all_sorts(name: str, several: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """Through controls, along axes and in circles' planes, from within; huge, tiny, zero, and not finite."""
    random = np.random.default_rng(5)
    origins = random.normal(size=(1203, 3))
    directions = random.normal(size=(1203, 3))
    centers = np.array([c for c, _, _ in CIRCLES])
    normals = np.array([n for _, n, _ in CIRCLES])
    which = random.integers(0, 4, 200)
    origins[:200] = centers[which]
    directions[:200] = np.cross(normals[which], random.normal(size=(200, 3)))
    origins[200:300] = np.round(origins[200:300])
    directions[200:300] = np.eye(3)[random.integers(0, 3, 100)]
    origins[300:350] = np.array([p for p, _ in PAIRS])[random.integers(0, 4, 50)] - directions[300:350]
    directions[350:600] *= 10.0 ** random.uniform(-320, 300, (250, 1))
    origins[600:700] *= 10.0 ** random.uniform(-10, 308, (100, 1))
    directions[700] = 0.0
    directions[701:704] = np.diag([np.nan, np.inf, -np.inf])
    origins[704:707] = np.diag([np.nan, np.inf, -np.inf])
    check(SCENES[name](), origins, directions, monkeypatch)
    assert several[0] > 0


@pytest.mark.parametrize("name", ["circles_tangent", "circles_cospherical", "circles_cubic", "pairs_tangent",
                                  "pairs_cospherical", "pairs_grazing", "pairs_quadratic", "circles_far"])  # fmt: skip
def test_rays_of_references(name: str, several: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """Tangent, cospherical and far: what single rays find is compared with certified roots elsewhere."""
    family = FAMILIES[name]
    for number in range(4):
        several.clear()
        objects = controls(family, number, 0)
        origins, directions = rays(family, number, objects)
        kind = tracer.EvolvedCircles if family.kind == "circles" else tracer.EvolvedPointPairs
        check([kind(objects.given())], origins + objects.shift, directions, monkeypatch)


def test_order() -> None:
    """Pixels are in order, also from one origin; the same rays shuffled are not, nor are numbers that are none."""
    _, directions = tracer.Camera.look_at((0, -4, 0.5), (0, 0, 0.1)).rays(640, 480)
    rows = np.ascontiguousarray(directions.reshape(-1, 3))
    origin = np.zeros(3)
    shuffled = np.random.default_rng(0).permutation(rows)
    assert are_in_order(Rays(origin, 0, rows, 3), len(rows))
    assert are_in_order(Rays(rows, 3, rows, 3), len(rows))
    assert not are_in_order(Rays(origin, 0, shuffled, 3), len(rows))
    assert not are_in_order(Rays(shuffled, 3, rows, 3), len(rows))
    assert not are_in_order(Rays(origin, 0, np.full_like(rows, np.nan), 3), len(rows))
