"""Names, options and folders that cannot be exported: an error that says so, before anything is written."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import bladesmith as bs
from bladesmith import codegen, pga3d
from bladesmith.codegen.algebra.loader import PRESETS, STOCK
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import LANGUAGES, ExportOptions
from bladesmith.codegen.language import Real
from bladesmith.codegen.library.kernels import library_variants
from bladesmith.errors import BladesmithError, InputError


@codegen.kernel(pga3d.kind("motor"), pga3d.kind("point"))
def move(m, x):
    return m >> x


@codegen.kernel(codegen.scalar, codegen.scalar, algebra=pga3d, name="int")
def product(double, final):
    return double * final


def called(name: str) -> codegen.KernelFunction:
    return codegen.kernel(pga3d.kind("point"), name=name)(lambda x: 2 * x)


@pytest.mark.parametrize(
    ("export", "says"),
    [
        (lambda folder: move.export("rust", folder), "'move' is a word of rust"),
        (lambda folder: product.export("c99", folder, name="kw"), "argument 'double' is a word of c99"),
        (lambda folder: product.export("cpp", folder, name="kw"), "function 'int' is a word of cpp"),
        (lambda folder: move.export("js", folder, dtype="float32"), "js has no numbers of type 'float32'"),
        (lambda folder: move.export("c99", folder, dtype="float16"), "no numbers of type 'float16'"),
        (lambda folder: move.export("cobol", folder), "no language 'cobol'"),
        (lambda folder: move.export("c99", folder, name=3), "is 3, and no text"),
        (lambda folder: move.export("c99", folder, name="../evil"), "'../evil' cannot be exported"),
        (lambda folder: move.export("c99", folder, derivatives="m"), "derivatives is a list"),
        (lambda folder: move.export("c99", folder, derivatives=["q"]), "no argument 'q'"),
        (lambda folder: move.export("c99", folder, jacobians=5), "jacobians is a list"),
        (lambda folder: move.export("rust", folder, name="m", split=True), "has no header apart"),
        (lambda folder: move.export("C99", folder), "did you mean 'c99'"),
        (lambda folder: move.export(["c99"], folder), "no language"),
        (lambda folder: move.export("cpp", folder, name="random"), "cannot be called 'random'"),
        (lambda folder: move.export("cpp", folder, name="NAN"), "'NAN' is a word of cpp"),
        (lambda folder: move.export("rust", folder, name="main"), "cannot be called 'main'"),
        (lambda folder: move.export("glsl", folder, name="gl_moves"), "cannot be called 'gl_moves'"),
        (lambda folder: called("T").export("cpp", folder), "'T' is taken"),
        (lambda folder: called("Math").export("js", folder), "'Math' is taken"),
    ],
)
def test_refused(export: Callable[[Path], Any], says: str, tmp_path: Path) -> None:
    with pytest.raises(BladesmithError, match=says):
        export(tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("folder", [3, None, "null\0", b"bytes"])
def test_what_is_no_folder_is_refused(folder: Any) -> None:
    with pytest.raises(InputError):
        move.export("c99", folder)


def test_one_file_that_cannot_be_written_leaves_none(tmp_path: Path) -> None:
    (tmp_path / "own.c").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        move.export("c99", tmp_path, name="own", split=True)
    assert [path.name for path in tmp_path.iterdir()] == ["own.c"]


def test_an_argument_that_is_named_twice_has_one_derivative(tmp_path: Path) -> None:
    (path,) = move.export("c99", tmp_path, derivatives=["m", "m"], jacobians=["x", "x"])
    assert path.read_text().count("static inline") == 3


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BladesmithError, match="cannot be written"):
        move.export("c99", tmp_path / "file")


@pytest.mark.parametrize("language", [x for x in LANGUAGES if x != "rust"])
def test_names_that_are_words_elsewhere_are_taken(language: str, tmp_path: Path) -> None:
    assert all(path.stat().st_size for path in move.export(language, tmp_path))


@codegen.algorithm
def strange(x: Real) -> Real:
    """Ends a comment */ here, */ and "quotes" \\ too."""
    return x


@pytest.mark.parametrize("language", LANGUAGES)
def test_notes_cannot_end_a_comment(language: str, tmp_path: Path) -> None:
    for path in strange.export(language, tmp_path):
        assert "comment */ here" not in path.read_text()


def test_layouts_of_one_name_are_structs_of_their_own(tmp_path: Path) -> None:
    algebra = bs.algebra(5)
    shared = [1, 2, 4, 8, 16, 3, 5, 9]
    kinds = [algebra.layout_of([*shared, other]) for other in (17, 6, 10)]
    assert {k.name for k in kinds} == {"blades9"}

    @codegen.kernel(*kinds)
    def added(x, y, z):
        return x + y + z

    (path,) = added.export("c99", tmp_path)
    structs = re.findall(r"^\} (\w+);", path.read_text(), re.MULTILINE)
    assert len(structs) == len(set(structs)) == 4
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Werror", "-fsyntax-only", path], check=True)


@codegen.algorithm
def hidden(x: Real) -> Real:
    "Turns the text \u202e round, ends it \0 or the line \u2028 here."
    return x


@pytest.mark.parametrize("language", LANGUAGES)
def test_notes_have_nothing_that_cannot_be_seen(language: str, tmp_path: Path) -> None:
    for path in hidden.export(language, tmp_path):
        assert path.read_text().replace("\n", "").isprintable()


@pytest.mark.parametrize(
    ("algebra", "only"),
    [
        *(("vga2d", f"{product}_multivector_multivector") for product in ("inner", "outer", "geometric")),
        ("pga2d", "inner_*"), ("dcga", "*_vector_vector"), ("qcga", "inner_vector_vector"),
        *(pytest.param(name, "*", marks=pytest.mark.slow) for name in (*STOCK, *PRESETS)),
    ],
)  # fmt: skip
def test_every_algebra_has_names_for_its_results(algebra: str, only: str, tmp_path: Path) -> None:
    variants = library_variants(load_spec(stock_spec_path(algebra)), [only])
    (path,) = export(variants, tmp_path, ExportOptions("c99", algebra))
    structs = re.findall(r"^\} (\w+);", path.read_text(), re.MULTILINE)
    assert variants and len(structs) == len(set(structs))
    if (algebra, only) == ("vga2d", "inner_multivector_multivector"):
        assert "vga2d_blades3" in structs


@pytest.mark.parametrize("language", LANGUAGES)
def test_vectors_are_not_called_as_the_scalar(language: str, tmp_path: Path) -> None:
    plane = bs.algebra(2, vectors="s t")
    with pytest.raises(InputError, match="vector 's'"):
        codegen.kernel(plane.kind("multivector"), name="twice")(lambda a: a + a).export(language, tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("vectors", ["int auto", "sample x", "struct y"])
def test_blades_are_no_words_of_shaders(vectors: str, tmp_path: Path) -> None:
    plane = bs.algebra(2, vectors=vectors)
    with pytest.raises(InputError, match="the blade '.*' is a word of glsl"):
        codegen.kernel(plane.kind("vector"), name="twice")(lambda a: a + a).export("glsl", tmp_path / "new")
    assert not (tmp_path / "new").exists()
