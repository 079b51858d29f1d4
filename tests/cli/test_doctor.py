"""What the doctor says of an installation, and the kernel cache."""

import json
from unittest import mock

import pytest

from bladesmith.cli import doctor, main
from bladesmith.codegen import version
from bladesmith.codegen.build import cache, extension
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.errors import MissingExtraError

needs_compiler = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


def test_doctor(capsys):
    assert main.run(["doctor"]) == 0
    out = capsys.readouterr().out
    assert all(f"{title}:" in out for title in doctor.SECTIONS)
    assert str(cache.directory()) in out and version.__version__ in out


def test_doctor_as_json(capsys):
    assert main.run(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == list(doctor.SECTIONS)
    assert all(isinstance(value, str) for facts in found.values() for value in facts.values())
    assert not any("failed" in facts for facts in found.values()), found


def test_doctor_on_a_bare_machine(capsys, monkeypatch, tmp_path):
    """No compiler, no cache to write to, and a section that fails: still a report and status 0."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("CC", "/nonexistent")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    monkeypatch.setattr(doctor.nvrtc, "_library", mock.Mock(side_effect=MissingExtraError("cuda", "Compiling")))
    monkeypatch.setitem(doctor.SECTIONS, "processor", lambda: 1 / 0)
    assert main.run(["doctor"]) == 0
    out = capsys.readouterr().out
    for part in ["CC='/nonexistent' does not run", "not writable", "bladesmith[numba]", "bladesmith[cuda]"]:
        assert part in out
    assert "ZeroDivisionError" in out


@needs_compiler
def test_doctor_tells_fresh_from_stale(monkeypatch, tmp_path):
    folder, headers = tmp_path / "tiny2d", tmp_path / "c"
    folder.mkdir()
    headers.mkdir()
    (headers / "platform.h").write_text("")
    (folder / "kernels.cdef").write_text("const char *bs_source_hash(void); int bs_kernel_count(void);")
    (folder / "kernels.c").write_text(
        '#include "platform.h"\n'
        "const char *bs_source_hash(void) { return BS_SOURCE_HASH; }\n"
        "int bs_kernel_count(void) { return 3; }\n"
    )
    module = extension.load(extension.generated_extension(folder, headers))
    monkeypatch.setattr(doctor, "_extension", lambda name: module)
    assert doctor._freshness(folder, headers) == "3 kernels, compiled from these sources"
    (headers / "scene.h").write_text("/* not included */")
    assert "STALE" not in doctor._freshness(folder, headers)
    (headers / "platform.h").write_text("/* changed */")
    assert "STALE" in doctor._freshness(folder, headers)
    monkeypatch.setattr(doctor, "_extension", lambda name: None)
    assert "compiled at first use" in doctor._freshness(folder, headers)


@needs_compiler
def test_cache_lists_and_clears(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(extension, "_loading", extension._Loading())
    assert main.run(["cache"]) == 0
    assert capsys.readouterr().out == f"0 entries, 0.0 kB, in {tmp_path / 'cache'}\n"
    extension.load(ExtensionSource("listed", "int one(void);", "int one(void) { return 1; }"))
    assert main.run(["cache"]) == 0
    assert "bs_listed_" in capsys.readouterr().out
    assert main.run(["cache", "--clear"]) == 0
    assert "removed 1 " in capsys.readouterr().out
    assert cache.entries() == []


def test_a_cache_that_is_a_file_is_told(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file"))
    for arguments in (["cache"], ["cache", "--clear"]):
        assert main.run(arguments) == 2
        assert cache.DIRECTORY_VARIABLE in capsys.readouterr().err
