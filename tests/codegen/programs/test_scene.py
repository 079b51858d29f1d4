"""The scene compiler: a program holds what its scene needs and nothing else, and numbers are not a part of it."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.build.extension import compiler, extension_key, generated_extension, load
from bladesmith.codegen.programs.tracer.scene import EVERYTHING, needs, scene_program
from bladesmith.codegen.programs.tracer.surface_kinds import METHODS, stock_kinds, surface_kind
from bladesmith.curves import Bezier
from bladesmith.errors import CompilerMissingError, SceneError
from bladesmith.tracer.rendering import program
from bladesmith.tracer.rendering.engines import CEngine

CAMERA = tracer.Camera.look_at((0.0, -8.0, 2.0), (0.0, 0.0, 0.5))
CIRCLES = [((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0), ((0.0, 1.0, 2.0), (0.0, 0.5, 1.0), 0.6)]


def plain_scene(radius=1.0):
    return tracer.Scene(
        CAMERA, [tracer.Light((4, -6, 8))], [tracer.Sphere((0, 0, 1), radius), tracer.Plane((0, 0, 1), 0.0)]
    )


def evolved_scene():
    return tracer.Scene(CAMERA, [tracer.Light((4, -6, 8))], [tracer.EvolvedCircles(Bezier(CIRCLES))])


def library_of(scene: tracer.Scene) -> bytes:
    """The compiled file that a scene runs."""
    return Path(program.engine_for(scene.needs).module.__file__).read_bytes()


def test_a_scene_without_evolved_surfaces_compiles_no_evolved_code():
    plain, evolved = plain_scene(), evolved_scene()
    assert not any("evolved" in name for name in plain.kernels)
    assert {"cga3d_sphere_hit", "cga3d_plane_hit", "cga3d_camera_direction"} <= set(plain.kernels)
    assert "cga3d_disc_hit" not in plain.kernels and "cga3d_reflected_direction" not in plain.kernels
    assert "evolved" not in plain.program.files["kernels.c"]
    assert b"evolved" not in library_of(plain) and b"sphere_hits" in library_of(plain)
    assert {"cga3d_evolved_polynomial_1", "cga3d_evolved_meets_1", "cga3d_evolved_normal_1"} <= set(evolved.kernels)
    assert b"hits_evolved_circles_1" in library_of(evolved) and b"plane_hits" not in library_of(evolved)


def test_only_the_chosen_method_is_compiled():
    for method, own in (("isolate", "polynomial"), ("companion", "published_polynomial")):
        kernels = scene_program(needs(["evolved_circles_1"], [method])).kernels
        found = {other for other in ("polynomial", "published_polynomial") if f"cga3d_evolved_{other}_1" in kernels}
        assert found == {own}
    assert needs(["sphere"], ["companion"]) == needs(["sphere"])


def test_numbers_are_arguments():
    first, second = plain_scene(1.0), plain_scene(2.0)
    assert first.needs == second.needs
    assert program.engine_for(first.needs) is program.engine_for(second.needs)
    assert extension_key(first.program.extension()) == extension_key(second.program.extension())
    assert not np.array_equal(first.render(16, 12), second.render(16, 12))


def test_the_order_of_surfaces_does_not_matter_to_the_program():
    a = plain_scene()
    b = tracer.Scene(CAMERA, a.lights, a.surfaces[::-1])
    assert a.needs == b.needs


def test_programs_are_the_same_text_every_time():
    wanted = needs(["disc", "plane"], reflection=True)
    assert scene_program(wanted).source == scene_program(wanted).source
    assert wanted == needs(["plane", "disc", "plane"], reflection=True)


def test_unknown_names_never_reach_a_template():
    with pytest.raises(SceneError, match="did you mean 'sphere'"):
        needs(["sphare"])
    with pytest.raises(SceneError, match="did you mean 'sampled'"):
        needs(["evolved_circles_1"], ["sample"])


def test_rows_of_constants_have_the_declared_length():
    for kind in map(surface_kind, stock_kinds()):
        assert not kind.layout or sum(size for _, size in kind.layout) == kind.constants


@pytest.mark.compiles
@pytest.mark.skipif(compiler() is None, reason="no compiler")
def test_a_generated_folder_of_the_program_compiles_and_loads(tmp_path):
    """As setup.py and `bladesmith generate` treat every folder of generated/."""
    folder = tmp_path / "scene"
    folder.mkdir()
    for name, text in scene_program(needs(["sphere"])).files.items():
        (folder / name).write_text(text)
    module = load(generated_extension(folder, Path(str(resources.files("bladesmith.templates"))) / "c"))
    assert module.ffi.string(module.lib.bs_source_hash()) != b""
    rows = CEngine(needs(["sphere"]), module).prepare("sphere", np.array([[1.0, 2.0, 3.0, 0.5]]))
    assert rows.tolist() == [[1, 2, 3, 0.5]]


def test_what_the_wheel_carries_serves_every_scene():
    for kinds in ([], ["sphere"], list(stock_kinds())):
        for method in METHODS:
            assert EVERYTHING.covers(needs(kinds, [method], reflection=True, single=True))
    assert not needs(["sphere"]).covers(needs(["plane"]))


@pytest.mark.compiles
def test_without_a_compiler_the_general_program_renders_the_same(monkeypatch):
    scene = plain_scene()
    expected = scene.render(24, 18)
    general = program.engine_for(EVERYTHING)

    def missing(_):
        raise CompilerMissingError("no C compiler was found")

    monkeypatch.setattr(program, "load", missing)
    monkeypatch.setattr(program, "_stock", lambda: general)
    program.engine_for.cache_clear()
    try:
        again = plain_scene()
        np.testing.assert_array_equal(again.render(24, 18), expected)
        assert "cga3d_evolved_polynomial_1" in again.kernels  # it says what is really there
        monkeypatch.setattr(program, "_stock", lambda: None)
        monkeypatch.setattr(program, "find_spec", lambda _: None)
        program.engine_for.cache_clear()
        with pytest.raises(CompilerMissingError):
            plain_scene().render(8, 8)
    finally:
        program.engine_for.cache_clear()
