"""`bladesmith export`: what it writes, and what it refuses before it writes."""

from __future__ import annotations

from pathlib import Path

import pytest

from bladesmith.cli.main import run

from ..support.checkout import CHECKOUT

EXAMPLES = CHECKOUT / "examples" / "kinematics"
MODULE = """
from bladesmith import codegen, pga3d
from bladesmith.codegen.language import Real

@codegen.kernel(pga3d.kind("motor"), pga3d.kind("point"))
def move(m, x):
    return m >> x

@codegen.algorithm
def cube(x: Real) -> Real:
    return x * x * x

number = 1
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "exported_module.py").write_text(MODULE)
    (tmp_path / "failing_module.py").write_text("1 / 0\n")
    (tmp_path / "generated").mkdir()
    (tmp_path / "leaving_module.py").write_text("raise SystemExit(0)\n")
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "file", "says"),
    [
        (["vga2d", "--only", "sandwich*"], "vga2d.h", "vga2d_sandwich_rotor_vector("),
        (["exported_module:move", "--name", "mine", "--derivative", "m"], "mine.h", "mine_move_d_m("),
        (["exported_module:cube", "--dtype", "float32"], "cube.h", "float cube_cube(float x)"),
        ([str(EXAMPLES / "arm.toml")], "arm.h", "arm_jacobian("),
        ([str(EXAMPLES / "delta.toml"), "--name", "picker"], "picker.h", "picker_forward("),
    ],
)
def test_each_source_is_written(arguments: list[str], file: str, says: str, folder: Path) -> None:
    assert run(["export", *arguments, "--language", "c99", "-o", "out"]) == 0
    assert [p.name for p in (folder / "out").iterdir()] == [file]
    assert says in (folder / "out" / file).read_text()


def test_a_header_may_stand_apart(folder: Path) -> None:
    assert run(["export", "exported_module:move", "-l", "c99", "-o", "out", "--name", "mine", "--split"]) == 0
    assert {p.name for p in (folder / "out").iterdir()} == {"mine.h", "mine.c"}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nothing"], "module:name"),
        (["missing.urdf"], "cannot be read"),
        (["vga2d", "--only", "rotate"], "no kernel 'rotate'"),
        (["vga2d", "--name", "double"], "'double' is a word of c99"),
        (["vga2d", "--derivative", "m"], "--derivative has no meaning here"),
        (["vga2d", "--tip", "tool"], "--tip has no meaning here"),
        (["exported_module:nobody"], "cannot be imported"),
        (["exported_module:number"], "no kernel and no algorithm"),
        (["no_module:move"], "cannot be imported"),
        (["failing_module:move"], "cannot be imported: ZeroDivisionError"),
        (["leaving_module:move"], "cannot be imported: SystemExit"),
        (["VGA3D"], "did you mean 'vga3d'"),
        (["exported_module.py:move"], "Write exported_module:move"),
        (["part/exported_module.py:move"], "Write part.exported_module:move"),
        (["generated"], "is a folder. Give the spec file (.toml)"),
        (["exported_module:move", "--derivative", "z"], "z"),
        (["exported_module:move", "--only", "x"], "--only has no meaning here"),
        ([str(EXAMPLES / "arm.toml"), "--only", "x"], "--only has no meaning here"),
    ],
)
def test_bad_input_is_refused_before_anything_is_written(
    arguments: list[str], says: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["export", *arguments, "--language", "c99", "-o", "out"]) in (1, 2)
    assert says in capsys.readouterr().err
    assert not (folder / "out").exists()
