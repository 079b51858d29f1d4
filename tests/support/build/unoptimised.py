"""A compiler that does not optimise: results have the same bits, and half of the time of many tests is gcc's."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest

from bladesmith.codegen.build.toolchain import compiler

from ...conftest import TEST_CACHE

#: Its level is the last word.
SCRIPT = '#!/bin/sh\nexec {command} "$@" -O0\n'


def unoptimised_compiler() -> str | None:
    """The path of one, for the variable CC; None where there is no compiler, or no shell.

    It is always the same, so that what is compiled by it serves the next session too.
    """
    found = compiler()
    if found is None or os.name != "posix":
        return None
    script = Path(TEST_CACHE, "unoptimised", "cc")
    script.parent.mkdir(parents=True, exist_ok=True)
    part = script.with_name(f"cc.{os.getpid()}")
    part.write_text(SCRIPT.format(command=shlex.join(found.command)))
    part.chmod(0o755)
    part.replace(script)
    return str(script)


@pytest.fixture
def unoptimised(monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs are compiled without optimising."""
    if script := unoptimised_compiler():
        monkeypatch.setenv("CC", script)
