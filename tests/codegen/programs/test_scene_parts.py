"""Scene programs in parts: the same bits as in one text, no warnings, and parts that the next scene has already."""

from __future__ import annotations

import subprocess
from dataclasses import replace

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.build import cache
from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build.extension import compiler, load
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.programs.tracer.scene import EVERYTHING, PORTABLE, QUICK, SCALAR, needs, scene_program
from bladesmith.tracer.rendering import program, row_bands
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
    whole = program.Engine(wanted, load(replace(scene_program(wanted), parts=()).extension()))
    asked = []
    for module in (scenes, row_bands):
        monkeypatch.setattr(module, "engine_for", lambda needs: asked.append(needs) or whole)
    in_one = answers(make())
    assert wanted in asked
    assert np.isfinite(in_parts[1]).any() and np.isnan(in_parts[1]).any()
    for ours, theirs in zip(in_parts, in_one, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.compiles
@pytest.mark.parametrize(
    "wanted",
    [
        needs(["plane", "sphere"], single=True),
        needs(["sphere"], pictures=False),
        needs(["evolved_circles_1"], ["isolate"], single=True),
        needs(["evolved_circles_free_2"], ["companion", "sampled"]),
        needs(["evolved_point_pairs_1"], ["isolate", "companion", "sampled"]),
        needs(["evolved_point_pairs_free_2"], ["sampled"]),
    ],
    ids=lambda wanted: "_".join((*wanted.kinds, *wanted.methods)),
)
def test_parts_compile_without_a_warning(wanted, tmp_path):
    extension = scene_program(wanted).extension()
    for i, unit in enumerate((*extension.units, extension.main())):
        folder = tmp_path / str(i)
        folder.mkdir()
        for name, text in {**unit.headers, "unit.c": unit.source}.items():
            (folder / name).write_text(text)
        command = [*compiler().command, *C_FLAGS, *unit.options, *WARNING_FLAGS, "-c", "unit.c", "-o", "unit.o"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (unit.name, done.stderr[:2000])


@pytest.mark.compiles
def test_everything_in_one_text_compiles_without_a_warning(tmp_path):
    """As setup.py compiles it, but for the optimizations that take longest."""
    extension = replace(scene_program(EVERYTHING), parts=()).extension()
    for name, text in {**extension.headers, "kernels.c": extension.source}.items():
        (tmp_path / name).write_text(text)
    command = [*compiler().command, *C_FLAGS, *QUICK, *WARNING_FLAGS, "-c", "kernels.c", "-o", "kernels.o"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]


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
        f"BS_TAG {i.tag}\n" in parts["scene_wide"].source for i in PORTABLE
    )
    parts = scene_program(needs(["evolved_circles_1"], single=True)).parts
    assert [part.options for part in parts] == [QUICK] * 2
    assert [f"BS_TAG {i.tag}\n" in part.source for i, part in zip(SCALAR, parts, strict=True)] == [True] * 2
    assert not scene_program(needs(["disc"])).parts
