"""Paths that users give: text, bytes or a path; what cannot be written or read is an `InputError` of one line."""

import os

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import kinematics, plot, reform, registration, tracer
from bladesmith.errors import BladesmithError, InputError

CIRCLE = cga.circle((0, 0, 0), (0, 0, 1), 1.0)
MODEL = reform.Model(points=np.eye(3))


def draw_result(path):
    result = reform.register(MODEL, MODEL, samples=4, threads=1)
    registration.picture(result, MODEL, MODEL, path)


WRITERS = {
    "multivectors.npz": lambda path: bs.save(path, CIRCLE),
    "model.json": MODEL.save,
    "image.png": lambda path: tracer.save_image(path, np.zeros((4, 4, 3))),
    "mesh.obj": lambda path: tracer.mesh_of(tracer.Sphere((0, 0, 0), 1.0), 4, 4).save(path),
    "plot.png": lambda path: plot.save(path, plot.draw(CIRCLE)),
    "result.png": draw_result,
}
WRONG = [None, 3, [1], "", "a\0b.png", "no/such/folder/{name}", "{folder}", "x" * 300 + "{name}"]


@pytest.mark.parametrize("name", [n if n != "result.png" else pytest.param(n, marks=pytest.mark.slow) for n in WRITERS])
def test_writers_take_every_path(tmp_path, name):
    for folder in ("plain", 'with\nnewline "{{"'):
        (tmp_path / folder).mkdir()
        file = tmp_path / folder / name
        for path in (file, str(file), os.fsencode(file)):
            WRITERS[name](path)
            assert file.stat().st_size
            file.unlink()


@pytest.mark.parametrize("path", WRONG)
@pytest.mark.parametrize("name", [name for name in WRITERS if name != "result.png"])
def test_writers_refuse_what_is_no_file(tmp_path, monkeypatch, name, path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"folder-{name}").mkdir()
    if isinstance(path, str):
        path = path.replace("{name}", name).replace("{folder}", f"folder-{name}")
    with pytest.raises(BladesmithError) as error:
        WRITERS[name](path)
    assert "\n" not in str(error.value)
    assert [file.name for file in tmp_path.iterdir()] == [f"folder-{name}"]


def test_pictures_of_results_refuse_what_is_no_file(tmp_path):
    for path in (3, "a\0b.png", tmp_path / "no" / "a.png"):
        with pytest.raises(InputError):
            draw_result(path)


@pytest.mark.parametrize("load", [bs.load, bs.load_algebra, kinematics.load_urdf, tracer.Scene.load, tracer.Mesh])
@pytest.mark.parametrize("path", [None, 3, [1], "", "a\0b", b"none", "line\nbreak", "x" * 5000, "no/such.toml"])
def test_readers_say_on_one_line_what_is_wrong(load, path):
    with pytest.raises(BladesmithError) as error:
        load(path)
    assert "\n" not in str(error.value)
