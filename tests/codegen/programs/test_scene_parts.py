"""Scene programs in parts: the same bits as in one text, no warnings, and parts that the next scene has already."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.build import cache
from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build.extension import compiler, load
from bladesmith.codegen.programs.tracer.scene import OF_KERNELS, QUICK, SCALAR, needs, scene_program
from bladesmith.tracer.rendering import row_bands
from bladesmith.tracer.rendering.engines import CEngine
from bladesmith.tracer.scene import scene as scenes

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
CIRCLES = [((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0), ((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), 0.6)]
PAIRS = [((-2.0, 0.0, 0.0), (-1.0, 0.5, 0.2)), ((-2.2, 0.3, 2.0), (-1.0, 1.0, 1.5))]


def evolved_scene() -> tracer.Scene:
    surfaces = [
        tracer.EvolvedCircles(CIRCLES, material=tracer.Material(reflectivity=0.3)),
        tracer.EvolvedPointPairs(PAIRS),
        tracer.Sphere((1.5, 0.0, 1.0), 0.5),
        tracer.Plane((0, 0, 1), -0.2),
    ]
    return tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], surfaces)


def plain_scene() -> tracer.Scene:
    surfaces = [tracer.Sphere((0.0, 0.0, 1.0), 0.9), tracer.Plane((0, 0, 1), -0.2)]
    return tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], surfaces)


def answers(scene: tracer.Scene) -> list[np.ndarray]:
    """A picture, and what rays meet."""
    origins, directions = CAMERA.rays(48, 36)
    hits = scene.intersect(origins, directions)
    return [scene.render(32, 24), hits.t, hits.surface, hits.point, hits.normal, hits.status]


@pytest.mark.compiles
@pytest.mark.parametrize("make", [evolved_scene, plain_scene])
def test_parts_give_the_bits_of_the_whole(make, monkeypatch):
    wanted = make().needs
    assert scene_program(wanted).parts
    in_parts = answers(make())
    whole = CEngine(wanted, load(replace(scene_program(wanted), parts=()).extension()))
    asked = []
    for module in (scenes, row_bands):
        monkeypatch.setattr(module, "engine_of", lambda needs, target: asked.append(needs) or whole)
    in_one = answers(make())
    assert wanted in asked
    assert np.isfinite(in_parts[1]).any() and np.isnan(in_parts[1]).any()
    for ours, theirs in zip(in_parts, in_one, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_part_does_not_depend_on_the_rest_of_the_scene():
    every = [
        needs(["evolved_circles_1"], pictures=False),
        needs(["sphere", "evolved_circles_1"], reflection=True, checker=True, layers=True),
        needs(["evolved_circles_1", "evolved_point_pairs_2"], rows=100),
    ]
    units = [part.unit() for wanted in every for part in scene_program(wanted).parts]
    circles = [unit.parts() for unit in units if unit.name == "evolved_circles_1"]
    assert len(circles) == len(every) and all(parts == circles[0] for parts in circles)
    by_method = [scene_program(needs(["evolved_circles_1"], [m])).parts[0].unit() for m in ("isolate", "companion")]
    assert by_method[0].parts() != by_method[1].parts()


@pytest.mark.compiles
def test_parts_are_there_for_the_next_scene(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path))
    monkeypatch.setattr(build, "_loading", build._Loading())
    for wanted in (needs(["evolved_point_pairs_1"], pictures=False), needs(["plane", "evolved_point_pairs_1"])):
        load(scene_program(wanted).extension())
    entries = sorted(path.name.rsplit("_", 1)[0] for path in tmp_path.glob("bs_*"))
    assert entries == ["bs_evolved_point_pairs_1", "bs_scene", "bs_scene", "bs_scene_module"]


def test_what_is_vector_code_gets_all_that_compilers_do():
    parts = {part.name: part for part in scene_program(needs(["plane", "sphere"], single=True)).parts}
    assert parts["scene_wide"].options == () and all(
        f"BS_TAG {i.tag}\n" in parts["scene_wide"].source for i in OF_KERNELS
    )
    parts = scene_program(needs(["evolved_circles_1"], single=True)).parts
    assert [part.options for part in parts] == [QUICK] * 2
    assert [f"BS_TAG {i.tag}\n" in part.source for i, part in zip(SCALAR, parts, strict=True)] == [True] * 2
    assert not scene_program(needs(["disc"])).parts
