"""Entries of the kernel cache as files: whom they serve, and what is no entry, however it came there."""

import os
import shutil
import stat
from dataclasses import replace

import pytest

from bladesmith.codegen.build import cache, text_cache
from bladesmith.codegen.build.extension import load
from bladesmith.errors import CompileError

from ...support.build.extension_parts import forget
from ...support.build.kernel_cache import ADD, needs_compiler, needs_posix, only_entry

pytestmark = [needs_compiler, needs_posix]


@pytest.fixture
def umask():
    before = os.umask(0o027)
    yield 0o027
    os.umask(before)


def test_entries_serve_all_whom_the_umask_lets_in(cache_dir, umask):
    load(ADD)
    text_cache.write("words", {"a": "b"})
    found = [cache_dir, *cache_dir.rglob("*")]
    assert len(found) > 6
    for path in found:
        expected = (0o777 if path.is_dir() or path.suffix == cache.LIBRARY_SUFFIX else 0o666) & ~umask
        if cache_dir / "locks" not in (path, path.parent):
            assert stat.S_IMODE(path.stat().st_mode) == expected, path


def _nested(entry):
    (entry / cache.RECORD).write_text("[" * 100_000)


def _pipe_for(name):
    def spoil(entry):
        path = entry / name.format(entry.name)
        path.unlink()
        os.mkfifo(path)

    return spoil


def _link_to_nothing(entry):
    shutil.rmtree(entry)
    entry.symlink_to(entry.parent / "nowhere")


def _file(entry):
    shutil.rmtree(entry)
    entry.write_text("")


SPOILED = {
    "a record of nested arrays": _nested,
    "a pipe for a record": _pipe_for(cache.RECORD),
    "a pipe for a library": _pipe_for(f"{{}}{cache.LIBRARY_SUFFIX}"),
    "a link to nothing": _link_to_nothing,
    "a file": _file,
}


@pytest.mark.parametrize("spoil", SPOILED.values(), ids=SPOILED)
def test_what_is_no_entry_is_built_again_where_it_was(cache_dir, monkeypatch, spoil):
    load(ADD)
    entry = only_entry(cache_dir)
    spoil(entry)
    for _ in range(2):
        forget(monkeypatch)
        assert load(ADD).lib.add(1.0, 2.0) == 3.0
        assert not cache._private and cache._library_if_intact(entry, cache.LIBRARY_SUFFIX)


def test_a_pipe_for_a_text_is_none(cache_dir):
    text_cache.write("words", {"a": "b"})
    (path,) = cache_dir.glob("*/a")
    path.unlink()
    os.mkfifo(path)
    assert text_cache.read("words", "a") is None
    text_cache.write("words", {"a": "b"})
    assert text_cache.read("words", "a") == "b"


def test_no_room_anywhere_is_an_error_with_a_remedy(cache_dir, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file"))
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path / "file"))
    for name in ("first", "second"):
        with pytest.raises(CompileError, match=f"cannot be written.*{cache.DIRECTORY_VARIABLE}"):
            load(replace(ADD, name=name))
