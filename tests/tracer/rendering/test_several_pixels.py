"""Pixels of pictures, several at once: the bits of single pixels, and when they are used."""

from __future__ import annotations

import copy
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.codegen.build import extension
from bladesmith.codegen.programs.tracer import several_rays as programs
from bladesmith.codegen.programs.tracer.several_rays import meets_several
from bladesmith.codegen.targets.c.instances import WIDE
from bladesmith.curves import KochanekBartels
from bladesmith.tracer.rendering import driver, row_bands, several_rays
from bladesmith.tracer.rendering.canvas import RenderInterrupted

from ...support.tracer.rendering import ALL, same
from ...support.tracer.scenes import SCENE

UNUSED = 1 << 60
TUBE = [((-0.9, 0.0, -0.3), (1, 0.2, 0.3), 1.0), ((1.0, 0.3, 0.4), (1, -0.3, 0.1), 0.7)]
RIBBON = [((-0.9, 0, -0.6), (-0.9, 0.2, 0.6)), ((1.0, 0.3, -0.5), (0.8, -0.3, 0.7))]
pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """All pixels are computed several at once; which fraction of each range is left to single ones."""
    found: list[float] = []
    several_of = several_rays.several_pixels_of

    def counted(needs: Any, samples: int, integers: Any, reals: Any, picture: Any, color: Any) -> Any:
        part = several_of(needs, samples, integers, reals, picture, color)
        assert part is not None
        first = int(picture[2])

        def both(begin: int, end: int) -> None:
            part(begin, end)
            found.append(float(np.isnan(color.reshape(-1, 3)[begin - first : end - first, 0]).mean()))

        return both

    monkeypatch.setattr(driver, "MANY_SAMPLES", 1)
    monkeypatch.setattr(several_rays, "PICTURES_PAY", 1)
    monkeypatch.setattr(driver, "several_pixels_of", counted)
    return found


def plain(random: np.random.Generator) -> list[Any]:
    """A checkered floor, spheres and a disc, all mirrors."""
    look = {"color": random.uniform(0, 1, 3), "reflectivity": random.choice([0.0, 0.3, 1.0])}
    floor = tracer.Plane((0, 0, 1), -1.0, material={"checker": (0.1, 0.2, 0.3), "reflectivity": 0.2})
    balls = [tracer.Sphere(random.normal(size=3), random.uniform(0.2, 0.8), material=look) for _ in range(3)]
    return [floor, *balls, tracer.Disc(random.normal(size=3), random.normal(size=3), 0.9, material=look)]


def mixed(random: np.random.Generator) -> list[Any]:
    """The same with a tube and a ribbon."""
    look = {"color": random.uniform(0, 1, 3), "reflectivity": 0.4}
    return [*plain(random), tracer.EvolvedCircles(TUBE, material=look), tracer.EvolvedPointPairs(RIBBON, material=look)]


def spline(random: np.random.Generator) -> list[Any]:
    """Pieces of a free curve, two tubes, no mirrors."""
    knots = [cga3d.circle((np.cos(a), np.sin(a), 0), (-np.sin(a), np.cos(a), 0), random.uniform(0.2, 0.4))
             for a in (0.0, 1.5, 3.0, 4.5)]  # fmt: skip
    return [tracer.EvolvedCircles(KochanekBartels(knots)), tracer.EvolvedCircles(TUBE)]


def scene_of(surfaces: list[Any], random: np.random.Generator, origin: Any = (0.3, -4.0, 0.8)) -> tracer.Scene:
    """Two lamps, one of them on a surface, or where its normal begins."""
    on = surfaces[1].center + (0, 0, surfaces[1].radius) if isinstance(surfaces[1], tracer.Sphere) else (1, 0, 0.3)
    lights = [tracer.Light(random.normal(size=3) * 4, (0.8, 0.7, 0.9)), tracer.Light(on, (0.4, 0.5, 0.3))]
    return tracer.Scene(tracer.Camera.look_at(origin, (0, 0, 0)), lights, surfaces, reflections=4)


def check(scene: tracer.Scene, monkeypatch: pytest.MonkeyPatch, width: int, height: int, **options: Any) -> Any:
    """All layers, the same as those of single pixels."""
    if not meets_several(scene.needs):
        pytest.skip("this processor has no wide vectors")
    found = scene.layers(width, height, ALL, **options)
    with monkeypatch.context() as patch:
        patch.setattr(driver, "MANY_SAMPLES", UNUSED)
        same(found, scene.layers(width, height, ALL, **options))
    return found


@pytest.mark.compiles
@pytest.mark.parametrize("surfaces", [plain, mixed, spline])
def test_random_scenes(surfaces: Any, left: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Mirrors, checkers, lamps on surfaces; sizes that fill no vector; several samples; two threads; few are left."""
    for seed in range(4):
        random = np.random.default_rng(seed)
        scene = scene_of(surfaces(random), random)
        found = check(scene, monkeypatch, 61, 43, antialias=1 + seed % 3, threads=2)
        assert found["color"].std() > 0.01
    assert np.median(left) < 0.05  # of nearly cospherical pieces it is a quarter
    np.testing.assert_array_equal(scene.render(61, 43, antialias=1), scene.layers(61, 43, ["color"])["color"])


@pytest.mark.compiles
def test_four_lanes(left: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Processors without AVX-512."""
    monkeypatch.setattr(programs, "INSTANCE", WIDE[0])
    monkeypatch.setattr(several_rays, "_loaded", several_rays._loaded.__wrapped__)
    random = np.random.default_rng(11)
    check(scene_of(mixed(random), random), monkeypatch, 61, 43)
    assert left


@pytest.mark.compiles
@pytest.mark.parametrize("origin", [(0.0, -0.1, 0.1), (0.0, -1.5, -1.0), (0.0, -3.0, 0.0), (0.0, -1e7, 0.0)])
def test_cameras_of_all_sorts(origin: Any, left: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the tube; on the floor; in the plane of a circle, whose pixels are left to single rays; far away."""
    surfaces = [*plain(np.random.default_rng(7)), tracer.EvolvedCircles([((0, 0, 0.2), (1, 0, 0), 1.0), TUBE[1]],
                material={"reflectivity": 0.4}), tracer.EvolvedPointPairs(RIBBON)]  # fmt: skip
    check(scene_of(surfaces, np.random.default_rng(8), origin), monkeypatch, 37, 29, antialias=1)
    assert max(left) > 0.0 or origin[1] < -1e6


@pytest.mark.compiles
def test_bands_and_interrupts(left: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Bands of an executor, rounded to float32 too; what was painted before an interrupt is what it would have been."""
    monkeypatch.setattr(row_bands, "RAYS_PER_BAND", 200)
    random = np.random.default_rng(3)
    scene = scene_of(mixed(random), random)
    whole = check(scene, monkeypatch, 50, 40)
    with ThreadPoolExecutor(2) as pool:
        same(scene.layers(50, 40, ALL, executor=pool), whole)
    assert len(left) > 5
    np.testing.assert_array_equal(scene.render(50, 40, dtype=np.float32), whole["color"].astype(np.float32))
    count = len(left)
    scene_of(plain(random), random).render(50, 40, dtype=np.float32)
    assert len(left) == count  # computed in single precision

    def stop(progress: Any) -> None:
        if progress.done > progress.total / 3:
            raise KeyboardInterrupt

    with pytest.raises(RenderInterrupted) as caught:
        scene.layers(200, 160, ALL, threads=1, progress=stop)
    partial, all_of_it = caught.value.partial, scene.render(200, 160)
    assert 0.3 < partial.fraction_done < 1.0
    np.testing.assert_array_equal(partial.image[partial.done], all_of_it[partial.done])


def test_when_they_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """From many samples on, once so many were asked for, or where they were compiled before."""
    asked: list[Any] = []
    scene = copy.copy(SCENE)
    if not meets_several(scene.needs):
        pytest.skip("this processor has no wide vectors")
    made = False
    monkeypatch.setattr(several_rays, "_was_made", lambda *given: made)
    monkeypatch.setattr(several_rays, "_loaded", lambda *given: asked.append(given))
    monkeypatch.setattr(several_rays, "_seen", {})
    monkeypatch.setattr(driver, "MANY_SAMPLES", 2000)
    monkeypatch.setattr(several_rays, "PICTURES_PAY", 7000)
    scene.render(40, 40, antialias=1)
    assert not several_rays._seen
    scene.render(50, 50, antialias=1)
    scene.render(25, 25, antialias=2)
    assert not asked and list(several_rays._seen.values()) == [5000]
    scene.render(50, 50, antialias=1)
    assert [name for name, _ in asked] == ["pixels"]
    asked.clear()
    made = True
    monkeypatch.setattr(several_rays, "_seen", {})
    scene.render(50, 50, antialias=1)
    assert [name for name, _ in asked] == ["pixels"]
