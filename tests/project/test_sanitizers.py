"""All compiled programs under gcc's sanitizers: no access beyond an array, no overflow."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from ..support.checkout import CHECKOUT

pytestmark = pytest.mark.sanitizers

SCRIPT = CHECKOUT / "tests" / "support" / "sanitized.py"
#: Conversions of numbers that do not fit are not among the undefined ones of gcc.
FLAGS = "-fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all"
#: A compiler whose level is the last word: checks are the same at each, and half of the time would go into optimising.
SCRIPT_OF_COMPILER = '#!/bin/sh\nexec "{gcc}" {flags} "$@" -O0\n'
PARTS = (
    "a_tree_of_everything", "several_rays_at_once", "all_points", "a_registration", "some_chains", "merging",
    "some_mechanisms", "simulations", "products_by_table", "some_kernels",
)  # fmt: skip
PATIENCE = 600.0  # seconds, on a busy machine


def library(gcc, name):
    """The path of a library of gcc's; None where it has none: it says the name again."""
    found = subprocess.run([gcc, f"-print-file-name={name}"], capture_output=True, text=True).stdout.strip()
    return found if os.path.isabs(found) and os.path.exists(found) else None


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    gcc = shutil.which("gcc")
    libraries = [gcc and library(gcc, f"lib{name}.so") for name in ("asan", "ubsan")]
    if not sys.platform.startswith("linux") or not all(libraries):
        pytest.skip("no gcc with libasan and libubsan on Linux")

    checked = tmp_path_factory.mktemp("compiler") / "gcc"
    checked.write_text(SCRIPT_OF_COMPILER.format(gcc=gcc, flags=FLAGS))
    checked.chmod(0o755)

    def run(*parts):
        environment = {
            **os.environ,
            "CC": str(checked),
            "LD_PRELOAD": " ".join(libraries),
            "ASAN_OPTIONS": "detect_leaks=0",  # Python keeps much to the end
            "PYTHONMALLOC": "malloc",  # each object a block of its own, with fences around it
        }
        return subprocess.run(
            [sys.executable, str(SCRIPT), *parts], env=environment, capture_output=True, text=True, timeout=PATIENCE
        )

    return run


def test_sanitizers_find_what_is_wrong(run):
    done = run("a_mistake")
    assert done.returncode != 0 and "done" not in done.stdout, done.stdout
    assert "AddressSanitizer" in done.stderr or "runtime error" in done.stderr, done.stderr


@pytest.mark.parametrize("part", PARTS)
def test_programs_of_every_kind_are_clean(part, run):
    done = run(part)
    assert done.stdout.split("\n")[:-1] == [f"done {part}"], done.stderr[-4000:]
    assert done.returncode == 0, done.stderr[-4000:]
