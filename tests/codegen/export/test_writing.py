"""Exported files where the disc is full: the error says so, and what was there before stays."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.errors import InputError

from ...support.export.small import algorithm_to_export, shifted

ITEMS = [algorithm_to_export(shifted)]


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """Files cannot grow beyond so many bytes: writing fails in the middle, as on a full disc."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.parametrize("split", [False, True])
def test_a_file_that_does_not_fit_leaves_what_was_there(split: bool, tmp_path: Path) -> None:
    options = ExportOptions("c99", "full", split=split, overwrite=True)
    paths = export(ITEMS, tmp_path / "elsewhere", options)  # imports what it needs
    longest = max(p.stat().st_size for p in paths)
    (tmp_path / "full.h").write_text("before")
    with room_for(longest - 1), pytest.raises(InputError, match=r"cannot be written: File too large"):
        export(ITEMS, tmp_path, options)
    assert [p.name for p in tmp_path.iterdir() if p.is_file()] == ["full.h"]
    assert (tmp_path / "full.h").read_text() == "before"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device /dev/full")
def test_a_full_device_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "full.h").symlink_to("/dev/full")
    with pytest.raises(InputError, match=r"cannot be written: No space left on device"):
        export(ITEMS, tmp_path, ExportOptions("c99", "full"))


@pytest.mark.parametrize("option", ["split", "overwrite"])
def test_options_are_true_or_false(option: str) -> None:
    with pytest.raises(InputError, match=f"{option} is 'no'; True or False"):
        ExportOptions("c99", "f", **{option: "no"})  # type: ignore[arg-type]
