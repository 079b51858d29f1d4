"""Files that are there already: the same export is written again, what would lose other functions is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bladesmith import codegen, pga3d
from bladesmith.cli.main import run
from bladesmith.codegen.language import Real
from bladesmith.errors import InputError
from bladesmith.kinematics import Chain, DeltaRobot

ROWS = [(0.3, 0, 0.4, 0), (0.25, 3.0, 0, 0)]


@codegen.kernel(pga3d.kind("motor"), pga3d.kind("point"))
def carried(m, x):
    return m >> x


@codegen.algorithm
def cube(x: Real) -> Real:
    return x * x * x


def texts(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir()}


@pytest.mark.parametrize("language", ["c99", "cpp", "rust", "js", "glsl"])
def test_the_same_export_is_written_again_and_another_one_is_not(language: str, tmp_path: Path) -> None:
    own: dict[str, Any] = {"name": "own"}
    carried.export(language, tmp_path, **own)
    once = texts(tmp_path)
    carried.export(language, tmp_path, **own)
    assert texts(tmp_path) == once
    carried.export(language, tmp_path, derivatives=["m"], **own)  # nothing is lost: there is one function more
    more = texts(tmp_path)
    with pytest.raises(InputError, match=r"own\.\w+: exists, and holds functions .* has not: carried_d_m\. Give"):
        carried.export(language, tmp_path, **own)
    with pytest.raises(InputError, match=r"another export: carried, carried_d_m of .*test_overwriting:carried\."):
        cube.export(language, tmp_path, **own)
    assert texts(tmp_path) == more
    carried.export(language, tmp_path, overwrite=True, **own)
    assert texts(tmp_path) == once


@pytest.mark.parametrize("file", ["own.h", "own.c"])
@pytest.mark.parametrize("text", ["int mine;\n", "own: 3 notes\n", "\0\xff"])
def test_a_file_of_somebody_else_is_kept_and_nothing_is_written(file: str, text: str, tmp_path: Path) -> None:
    (tmp_path / file).write_text(text, "latin-1")
    with pytest.raises(InputError, match=r"is no file that bladesmith exported.*overwrite=True, --force"):
        cube.export("c99", tmp_path, name="own", split=True)
    assert [p.name for p in tmp_path.iterdir()] == [file] and (tmp_path / file).read_text("latin-1") == text
    cube.export("c99", tmp_path, name="own", split=True, overwrite=True)
    cube.export("c99", tmp_path, name="own", split=True)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (Chain.from_dh(ROWS, names=["a", "b"]), Chain.from_dh(ROWS, names=["a", "c"])),
        (Chain.from_dh(ROWS), DeltaRobot(0.4, 0.1, 0.5, 1.0)),
    ],
)
def test_robots_of_other_joints_are_other_exports(first: Any, second: Any, tmp_path: Path) -> None:
    for _ in range(2):
        first.export("c99", tmp_path, "robot")
    with pytest.raises(InputError, match="another export: .*motor.* of a chain of the joints"):
        second.export("c99", tmp_path, "robot")


def test_files_are_named_after_kernels_and_algebras_of_one_folder_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("overwriting_module.py").write_text(
        "from bladesmith import codegen, vga2d\n"
        'carried = codegen.kernel(vga2d.kind("rotor"), vga2d.kind("vector"), name="carried")(lambda m, x: m >> x)\n'
    )
    export: Callable[..., int] = lambda *words: run(["export", *words, "-l", "c99", "-o", "include"])  # noqa: E731
    assert export("vga2d", "--only", "sandwich*") == 0
    assert export("overwriting_module:carried", "--derivative", "m") == 0
    assert {p.name for p in Path("include").iterdir()} == {"vga2d.h", "carried.h"}
    before = texts(Path("include"))
    assert export("overwriting_module:carried", "--name", "vga2d") != 0
    assert "vga2d.h: exists, and holds another export: sandwich_" in capsys.readouterr().err
    assert texts(Path("include")) == before
    assert export("overwriting_module:carried", "--name", "vga2d", "--force") == 0
    assert "Source: overwriting_module:carried\n" in Path("include/vga2d.h").read_text()
