"""`bladesmith render`, `mesh` and `view` where something is wrong: one line tells it, and no file is lost."""

from __future__ import annotations

import time

import pytest

from bladesmith import tracer
from bladesmith.cli.main import run


@pytest.fixture
def path(tmp_path):
    place = tmp_path / "scene.toml"
    ball = "[[surfaces]]\nkind = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\n"
    place.write_text("[camera]\nposition = [0, -8, 2]\nlook_at = [0, 0, 0]\n" + ball)
    return place


def test_a_page_never_takes_the_place_of_its_scene(path, capsys):
    path = path.rename(path.with_suffix(".html"))
    before = path.read_bytes()
    assert run(["view", str(path), "-o", str(path)]) == 2
    assert "the place of the scene file" in capsys.readouterr().err and path.read_bytes() == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "none/a.obj"], "InputError: none/a.obj: there is no folder none."),
        (["-o", "a.obj", "--extent", "nan"], "extent is nan"),
        (["-o", "a.obj", "--extent", "-1"], "extent is -1.0; a positive number is needed"),
        (["-o", "a.obj", "--rings", "99999999999"], "rings is 99999999999"),
        (["-o", "a.obj", "--surface", "1"], "there is no surface 1; the scene has 1, from 0"),
    ],
)
def test_wrong_options_of_meshes(path, options, message, capsys, monkeypatch):
    pytest.importorskip("trimesh")
    monkeypatch.chdir(path.parent)
    assert run(["mesh", str(path), *options]) != 0
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line and [p.name for p in path.parent.iterdir()] == ["scene.toml"]


def test_a_long_preparation_is_explained(path, capsys, monkeypatch):
    from bladesmith.cli import options, render

    plain = tracer.Scene.layers

    def slow(self, width, *rest, **named):
        time.sleep(0.3 if width == 1 else 0.0)
        return plain(self, width, *rest, **named)

    monkeypatch.setattr(tracer.Scene, "layers", slow)
    monkeypatch.setattr(options, "PATIENCE", 0.05)
    arguments = ["render", str(path), "-o", str(path.parent / "a.png"), "--width", "8", "--height", "6"]
    assert run([*arguments, "--progress"]) == 0
    told = capsys.readouterr().err
    assert told.startswith(render.NOTICE) and "8 x 6 pixels in " in told
    assert float(told.split("after ")[1].split(" s of preparation")[0]) >= 0.3
    assert run([*arguments, "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_sizes_are_refused_before_anything_is_compiled(path, monkeypatch, capsys):
    monkeypatch.setattr(tracer.Scene, "layers", lambda *_, **__: pytest.fail("compiled"))
    for wrong in (
        ["--width", "0"],
        ["--height", "1000000", "--width", "1000000"],
        ["--antialias", "65"],
        ["--samples", "1"],
    ):
        assert run(["render", str(path), "-o", str(path.parent / "a.png"), *wrong]) == 2
        assert capsys.readouterr().err.startswith("SceneError: ")


def test_an_interrupt_while_the_picture_is_written_is_told(path, monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    target = path.parent / "a.png"
    monkeypatch.setattr("bladesmith.tracer.output.image._save", stopped)
    assert run(["render", str(path), "-o", str(target), "--width", "8", "--height", "6", "--quiet"]) == 1
    assert capsys.readouterr().err == f"interrupted while {target} was written; what is not there is lost\n"
    assert not target.exists()
