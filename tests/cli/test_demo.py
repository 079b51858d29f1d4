"""`bladesmith demo`: its pictures, an interrupt, what its page says."""


import pytest

from bladesmith.cli import demo, main


@pytest.mark.compiles
def test_the_demo_renders_the_scene_as_it_is_shown(tmp_path):
    from PIL import Image

    said = demo.parts.render_part(demo.parts.Page(tmp_path, 48), 1, shows_bars=True)
    with Image.open(tmp_path / "scene.png") as picture:
        assert picture.size == (48, 32) and said.startswith("48 x 32 pixels")  # 768 x 512, smaller


def interrupt(*_):
    raise KeyboardInterrupt


@pytest.mark.compiles
def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main.run(["demo", "-o", str(tmp_path / "file" / "d"), "--quiet"]) == main.BAD_INPUT
    assert "cannot be written: Not a directory" in capsys.readouterr().err


def test_the_demo_keeps_what_was_done_before_an_interrupt(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(demo.parts, "compile_part", interrupt)
    assert main.run(["demo", "-o", str(tmp_path / "d"), "--width", "48", "--quiet"]) == main.INTERRUPTED
    page = (tmp_path / "d" / "index.html").read_text()
    assert (tmp_path / "d" / "scene.png").exists() and 'src="scene.png"' in page
    assert "48 x 32 pixels" in page and "was interrupted" in page and "objects.png" not in page
    assert "index.html" in capsys.readouterr().err


@pytest.mark.compiles
def test_the_formula_of_the_demo_is_what_the_page_says():
    from bladesmith.benchmarks.harness.compilation import blend, compile_blend

    made = compile_blend()
    assert made.formula.splitlines()[1] == "def blend(x, y, alpha):" and "type:" not in made.formula
    assert f"blend {made.operations.multiplications} mul" in made.source
    assert made.kind == "circle" and blend.traced.outputs[0].kind.name == "circle"
    assert 0 < made.error < 1e-14
