"""The compiler of the package ziglang, where the system has none: programs run, to the bits of gcc (and, with all bars,
of numba)."""

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen.build import toolchain
from bladesmith.codegen.execute import bound_kernels
from bladesmith.codegen.targets.capabilities import NO, NUMBA, PROGRAMS

from ..support.build.chapters import SWEEPS
from ..support.build.numba_code import shared_numba_code
from ..support.effort import FULL

CHAPTERS = Path(__file__).parents[1] / "support" / "build" / "chapters.py"


def run(folder: Path, name: str, *level: str, **variables: str) -> dict[str, np.ndarray]:
    """Results of all chapters from a process of its own, and but for gcc from a cache of its own."""
    out = folder / f"{name}.npz"
    cache = {} if name == "gcc" else {"BLADESMITH_CACHE_DIR": str(folder / name)}
    env = {**os.environ, **cache, **variables}
    done = subprocess.run([sys.executable, str(CHAPTERS), str(out), *level], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return dict(np.load(out))


@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.peers
def test_every_program_runs_by_ziglang_to_the_bits_of_gcc(tmp_path):
    """Of gcc as users have it; zig optimises nothing, but with all bars."""
    assert find_spec("ziglang"), "the extra ci has it"
    if not shutil.which("gcc"):
        pytest.skip("no gcc to compare with")
    expected = run(tmp_path, "gcc", CC="gcc")
    by_zig = run(tmp_path, "zig", "" if FULL else "-O0", CC="", PATH=str(tmp_path))
    assert (tmp_path / "zig" / "zig").is_dir()  # its libraries are in our cache
    assert {key.rpartition(" ")[0] for key in expected} == {*PROGRAMS, SWEEPS}
    assert by_zig.keys() == expected.keys()
    for key, values in by_zig.items():
        assert values.tobytes() == expected[key].tobytes(), key


@pytest.mark.slow
@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(not FULL, reason="no full bars: a minute for what the numba tests of each program compare, too")
def test_every_program_runs_by_numba_to_the_bits_of_gcc(tmp_path):
    if not shutil.which("gcc"):
        pytest.skip("no gcc to compare with")
    expected = run(tmp_path, "gcc", CC="gcc")
    with shared_numba_code(tmp_path / "numba"):
        found = run(tmp_path, "numba", CC="/nonexistent/cc")
    named = {name for name in PROGRAMS if NUMBA.programs[name] != NO}
    assert {key.rpartition(" ")[0] for key in found} == {*named, SWEEPS}
    for key, values in found.items():
        assert values.tobytes() == expected[key].tobytes(), key


def test_without_the_package_there_is_none(monkeypatch, tmp_path):
    monkeypatch.setattr(toolchain, "find_spec", lambda _: None)
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert toolchain.compiler() is None


def test_a_library_without_a_loop_that_runs_is_an_error():
    class Lib:
        bs_initialize = staticmethod(lambda: None)
        bs_kernel_count = bs_instance_count = staticmethod(lambda: 1)
        bs_kernel_name = staticmethod(lambda _: b"cga3d_moved")
        bs_instance_name = staticmethod(lambda _: b"f64_v3")
        bs_has = staticmethod(lambda kernel, single: 0)

    class FFI:
        string = staticmethod(lambda text: text)

    module = type("Module", (), {"lib": Lib, "ffi": FFI})
    with pytest.raises(bound_kernels.LoopError, match="cga3d_moved was compiled for f64_v3"):
        bound_kernels.Library(module)
