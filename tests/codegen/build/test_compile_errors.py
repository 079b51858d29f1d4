"""Extensions that cannot be compiled: no compiler, bad text, no headers; folders of generated sources."""

import pytest

from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build import toolchain
from bladesmith.codegen.build.extension import generated_extension, load
from bladesmith.codegen.build.flags import compiled_files, source_hash
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.errors import CompileError, CompilerMissingError, SpecError

from ...support.build.kernel_cache import ADD, needs_compiler


@pytest.mark.parametrize(
    ("cc", "says"), [("/nonexistent/cc", "CC='/nonexistent/cc'"), ("'open", "CC="), ("", "no C compiler")]
)
def test_missing_compiler_names_the_remedy(cache_dir, monkeypatch, tmp_path, cc, says):
    monkeypatch.setattr(toolchain, "find_spec", lambda _: None)  # ziglang would be one
    monkeypatch.setenv("CC", cc)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerMissingError, match="Install gcc or clang") as caught:
        load(ADD)
    assert says in str(caught.value) and "numba" in str(caught.value)


@needs_compiler
def test_bad_c_text_is_reported_and_kept(cache_dir):
    broken = ExtensionSource("broken", "double f(double);", "double f(double x) { return x + y; }")
    with pytest.raises(CompileError, match="'y' undeclared|undeclared identifier 'y'") as caught:
        load(broken)
    assert "\n" not in str(caught.value)
    assert caught.value.source.is_file() and str(caught.value.source) in str(caught.value)
    with pytest.raises(CompileError):
        load(broken)
    assert not list(cache_dir.glob("bs_*")) and not list(cache_dir.glob(".bs_*"))


@needs_compiler
def test_bad_declarations_are_reported(cache_dir):
    with pytest.raises(CompileError, match="declarations of broken"):
        load(ExtensionSource("broken", "duoble f(double);", ""))


@needs_compiler
def test_without_python_headers_the_library_is_opened_plainly(cache_dir, monkeypatch):
    monkeypatch.setattr(build, "_include", lambda: "/nonexistent")
    module = load(ADD)
    assert module.lib.add(1.0, 2.0) == 3.0
    out = module.ffi.new("double[1]")
    module.lib.scale(out, module.ffi.new("double[1]", [2.0]), 1, 4.0)
    assert out[0] == 8.0


@needs_compiler
def test_generated_folder_compiles_with_its_hash(cache_dir, tmp_path):
    folder, headers = tmp_path / "tiny2d", tmp_path / "shared"
    folder.mkdir()
    headers.mkdir()
    (headers / "platform.h").write_text("#define TWO 2\n")
    (folder / "kernels.cdef").write_text("int two(void); const char *bs_source_hash(void);")
    (folder / "kernels.c").write_text(
        '#include "platform.h"\nint two(void) { return TWO; }\n'
        "const char *bs_source_hash(void) { return BS_SOURCE_HASH; }\n"
    )
    module = load(generated_extension(folder, headers))
    expected = source_hash(compiled_files(folder, headers))
    assert module.lib.two() == 2
    assert module.ffi.string(module.lib.bs_source_hash()).decode() == expected
    (headers / "platform.h").write_text("#define TWO 3\n")
    assert source_hash(compiled_files(folder, headers)) != expected
    assert load(generated_extension(folder, headers)).lib.two() == 3


def test_generated_folder_without_sources_is_refused(tmp_path):
    with pytest.raises(SpecError, match="bladesmith generate"):
        generated_extension(tmp_path, tmp_path)


def test_source_hash_separates_names_and_texts():
    assert source_hash({"a": "b", "c": "d"}) == source_hash({"c": "d", "a": "b"})
    assert len({source_hash(files) for files in [{"a": "bc"}, {"ab": "c"}, {"a": "b", "c": ""}, {}]}) == 4
    assert len(source_hash({})) == 16


@needs_compiler
def test_what_the_linker_says_is_reported(cache_dir):
    absent = ExtensionSource("absent", "int f(void);", "int f(void) { return 1; }", {}, ("-lbladesmith_absent",))
    with pytest.raises(CompileError, match="bladesmith_absent"):
        load(absent)
