"""The kernel cache: keys, directories that cannot be written, listing, clearing, a full disk."""

import logging
import os
import shutil
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from bladesmith.codegen.build import cache
from bladesmith.codegen.build import extension as build
from bladesmith.codegen.build.extension import extension_key, load
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.errors import SpecError

from ...support.build.extension_parts import forget
from ...support.build.kernel_cache import ADD, counting_compiler, needs_compiler, needs_posix, only_entry


@needs_compiler
def test_compiles_once_then_loads_from_the_cache(cache_dir, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "bladesmith")
    module = load(ADD)
    assert module.lib.add(1.0, 2.0) == 3.0
    out, x = module.ffi.new("double[2]"), module.ffi.new("double[2]", [1.0, 2.0])
    module.lib.scale(out, x, 2, 3.0)
    assert list(out) == [3.0, 6.0]
    assert load(ADD) is module
    forget(monkeypatch)
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert [record.message.split(" in ")[0] for record in caplog.records] == ["compiled adder"]


@needs_compiler
def test_prints_nothing(cache_dir, capfd):
    load(ADD)
    assert capfd.readouterr() == ("", "")


@needs_compiler
def test_a_terminal_is_told_once_of_a_long_compilation(cache_dir, monkeypatch, caplog):
    caplog.set_level(logging.WARNING, "bladesmith.compiling")
    compiled = build._compile

    def long(*arguments):
        time.sleep(0.1)
        return compiled(*arguments)

    monkeypatch.setattr(build, "_compile", long)
    build._tell_of_compiling.cache_clear()
    said = []
    for number, (patience, terminal) in enumerate([(0.01, False), (60.0, True), (0.01, True), (0.01, True)]):
        monkeypatch.setattr(build, "PATIENCE", patience)
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal, raising=False)
        load(replace(ADD, options=(f"-DX={number}",)))
        said.append([r.getMessage() for r in caplog.records if r.name == "bladesmith.compiling"])
    assert [len(x) for x in said] == [0, 0, 1, 1] and "it is kept for later runs" in said[-1][0]


@needs_compiler
@pytest.mark.parametrize(
    "other",
    [
        replace(ADD, name="adder2"),
        replace(ADD, cdef=ADD.cdef + " "),
        replace(ADD, source=ADD.source + "\n"),
        replace(ADD, headers={"shared.h": "#define SHARED_OFFSET 1.0\n"}),
        replace(ADD, headers={**ADD.headers, "more.h": ""}),
        replace(ADD, options=("-DX",)),
    ],
    ids=["name", "cdef", "source", "header text", "header", "options"],
)
def test_key_follows_every_part(other):
    assert extension_key(other) != extension_key(ADD)


@needs_compiler
@needs_posix
def test_key_follows_the_compiler(tmp_path, monkeypatch):
    before = extension_key(ADD)
    monkeypatch.setenv("CC", counting_compiler(tmp_path)[0])
    assert extension_key(ADD) != before


@needs_compiler
def test_key_follows_versions_and_flags(monkeypatch):
    keys = {extension_key(ADD)}
    for name, value in [("__version__", "9.9"), ("C_FLAGS", ("-O0",))]:
        with monkeypatch.context() as patch:
            patch.setattr(build, name, value)
            keys.add(extension_key(ADD))
    assert len(keys) == 3


@needs_compiler
def test_options_reach_the_compiler(cache_dir):
    extension = ExtensionSource("optional", "int x(void);", "int x(void) { return X; }", {}, ("-DX=7",))
    assert load(extension).lib.x() == 7


@pytest.mark.parametrize("name", ["", "a b", "../x", "naïve", "x;y"])
def test_names_that_are_no_identifiers_are_refused(name):
    with pytest.raises(SpecError, match="cannot name an extension"):
        replace(ADD, name=name)


@pytest.mark.parametrize("header", ["../shared.h", "/etc/passwd", "", ".hidden", "a/b.h"])
def test_header_names_stay_in_their_folder(header):
    with pytest.raises(SpecError, match="cannot name a header"):
        replace(ADD, headers={header: ""})


def test_whether_a_directory_can_be_written_is_found_out_by_trying(tmp_path):
    (tmp_path / "file").write_text("")
    assert cache.is_writable(tmp_path / "new" / "cache") and not list(tmp_path.glob("new"))
    assert not cache.is_writable(tmp_path / "file" / "cache")
    if Path("/proc/self").exists():
        assert not cache.is_writable(Path("/proc/bladesmith"))


@needs_compiler
def test_unusable_directory_falls_back_with_one_warning(cache_dir, tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file" / "cache"))
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert load(replace(ADD, name="another")).lib.add(1.0, 2.0) == 3.0
    warnings = [record.message for record in caplog.records if record.levelno == logging.WARNING]
    assert len(warnings) == 1 and "cannot be used" in warnings[0] and cache.DIRECTORY_VARIABLE in warnings[0]
    (private,) = cache._private
    assert len(list(private.glob("bs_*"))) == 2
    assert private.stat().st_mode & 0o077 == 0
    shutil.rmtree(private)


@needs_compiler
@needs_posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_directory_still_serves_what_it_holds(cache_dir, monkeypatch, caplog):
    load(ADD)
    cache_dir.chmod(0o555)
    try:
        forget(monkeypatch)
        load(ADD)
        assert not caplog.records
        load(replace(ADD, name="another"))
        assert len(caplog.records) == 1
    finally:
        cache_dir.chmod(0o755)


@needs_compiler
def test_listing_and_clearing(cache_dir):
    load(ADD)
    load(replace(ADD, name="another"))
    found = cache.entries()
    assert [entry.stem.rsplit("_", 1)[0] for entry in found] == ["bs_another", "bs_adder"]
    assert all(entry.library.is_file() and entry.size > 0 for entry in found)
    assert cache.clear() == (2, sum(entry.size for entry in found))
    assert cache.entries() == [] and cache.clear() == (0, 0)


@needs_compiler
def test_clearing_leaves_what_is_being_built(cache_dir):
    load(ADD)
    with cache._lock(cache_dir, only_entry(cache_dir).name):
        assert cache.clear() == (0, 0)
    assert len(cache.entries()) == 1


@needs_compiler
def test_the_oldest_entries_go_when_the_cache_is_full(cache_dir, monkeypatch):
    load(ADD)
    os.utime(only_entry(cache_dir) / "entry.json", (1, 1))
    load(replace(ADD, name="second"))
    monkeypatch.setattr(cache, "LIMIT_BYTES", 2 * max(entry.size for entry in cache.entries()))
    load(replace(ADD, name="third"))
    assert sorted(entry.stem.rsplit("_", 1)[0] for entry in cache.entries()) == ["bs_second", "bs_third"]


@needs_compiler
@needs_posix
def test_full_disk_falls_back(cache_dir, tmp_path, monkeypatch, caplog):
    full = "fatal error: error writing to out.s: No space left on device"
    command, _ = counting_compiler(tmp_path, f'case "$PWD" in "{cache_dir}"/*) echo "{full}" >&2; exit 1;; esac')
    monkeypatch.setenv("CC", command)
    assert load(ADD).lib.add(1.0, 2.0) == 3.0
    assert ["No space left" in record.message for record in caplog.records] == [True]
    shutil.rmtree(cache._private[0])
