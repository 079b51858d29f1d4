"""Units of stock kernels: compiled at install, compiled at first use, and what serves without either."""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import best_instances, has_wide_vectors
from bladesmith.codegen.errors import InputError, SpecError
from bladesmith.codegen.execute.bound_kernels import BoundKernel
from bladesmith.dispatch import stock_kernels

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
#: A small module and two kernels of it.
MODULE, CROSS, ROW = "twists", "pga3d_screw_cross_twist_twist", "pga3d_screw_row_twist"
ROWS = [np.random.default_rng(i).normal(size=(9, 6)) for i in (1, 2)]
NO_COMPILER = "/bin/false"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of a generated folder, whose tables nobody else fills."""
    copy = tmp_path / "pga3d"
    shutil.copytree(
        stock_kernels.bundled_folder("pga3d"), copy, ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    )
    with (copy / "kernels.c").open("a", encoding="utf-8") as text:
        text.write(f"/* {tmp_path} */\n")
    return copy


def kernels(folder: Path) -> stock_kernels.StockKernels:
    found = stock_kernels.StockKernels(bs.pga3d, folder, stock_kernels.read_manifest(folder))
    assert found.library is not None, "the tables alone take little time to compile"
    return found


def bound(found: stock_kernels.StockKernels, symbol: str) -> BoundKernel:
    entry = next(e for entries in found.entries.values() for e in entries if e.symbol == symbol)
    kernel = found.bound(entry)
    assert isinstance(kernel, BoundKernel)
    return kernel


def written(folder: Path, kernel: BoundKernel, *arrays: Any) -> Any:
    """The same by the Python text."""
    return stock_kernels.PlainKernel(folder / "kernels" / f"{MODULE}.py", kernel.symbol, kernel.inputs, kernel.outputs)(
        *arrays
    )


def test_a_unit_is_compiled_when_its_first_kernel_is_called(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    with (folder / "kernels" / f"{MODULE}.c").open("a", encoding="utf-8") as text:
        text.write(f"/* {folder} */\n")  # in no cache
    found = kernels(folder)
    cross, row = bound(found, CROSS), bound(found, ROW)
    caplog.set_level(logging.INFO, "bladesmith")
    for dtype, precision in ((np.float64, "f64"), (np.float32, "f32")):
        caplog.clear()
        rows = [r.astype(dtype) for r in ROWS]
        for _ in range(2):
            assert np.array_equal(cross(*rows), written(folder, cross, *rows))
            assert np.array_equal(row(rows[0]), written(folder, row, rows[0]))
        (instance,) = best_instances(precision)
        (line,) = [r.getMessage() for r in caplog.records]
        assert line.startswith(f"compiled pga3d_{MODULE}_{instance.tag} in ")


def test_single_items_take_the_short_way_once_there_is_a_loop(folder: Path) -> None:
    cross = bound(kernels(folder), CROSS)
    one = [r[0].copy() for r in ROWS]
    assert not cross.is_pair and cross.pair is not None
    first = cross(*one)
    assert cross.is_pair and np.array_equal(cross.pair(*one), first)


def test_without_a_compiler_the_text_serves(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    found = kernels(folder)
    cross, row = bound(found, CROSS), bound(found, ROW)
    assert cross.provide(False), "double precision is compiled while there is a compiler"
    monkeypatch.setenv("CC", NO_COMPILER)
    single = [r.astype(np.float32) for r in ROWS]
    caplog.set_level(logging.WARNING, "bladesmith")
    for _ in range(2):
        assert np.array_equal(cross(*single), written(folder, cross, *single))
        assert np.array_equal(row(single[0]), written(folder, row, single[0]))
    (line,) = [r.getMessage() for r in caplog.records]
    assert MODULE in line and "plain Python" in line
    with pytest.raises(InputError, match="not compiled for float32"):
        cross.plan(*single)
    assert cross.provide(False) and np.array_equal(cross(*ROWS), written(folder, cross, *ROWS))


#: Its own process: the table of the installed kernels is the process's, and other tests may have filled it.
UNITS_OF_THE_INSTALL = """
import bladesmith as bs
from bladesmith.dispatch import stock_kernels
folder = stock_kernels.bundled_folder("cga3d")
manifest = stock_kernels.read_manifest(folder)
installed, found, stale = (stock_kernels.StockKernels(bs.cga3d, folder, manifest) for _ in range(3))
library = installed.library
linked = {module for module, instance, _ in installed._linked_units if "f64" in instance}
symbol = next(s for s, module in installed._modules.items() if module in linked and s in library.index)
assert not library.lib.bs_has(library.index[symbol], False)
found.__dict__["_linked_units"] = installed._linked_units
assert found.library is not None and found.library is not stale.library
changed = {(module, i, f"{made_of}?"): unit for (module, i, made_of), unit in installed._linked_units.items()}
stale.__dict__["_linked_units"] = changed
entries = {e.symbol: e for each in installed.entries.values() for e in each}
assert not stale.bound(entries[symbol]).provide(False)
assert found.bound(entries[symbol]).provide(False)
"""


def test_units_of_the_install_serve_while_their_text_is_the_same(tmp_path: Path) -> None:
    folder = stock_kernels.bundled_folder("cga3d")
    if stock_kernels.StockKernels(bs.cga3d, folder, stock_kernels.read_manifest(folder))._installed_module is None:
        pytest.skip("the stock kernels are not built")
    environment = {**os.environ, "CC": NO_COMPILER, "BLADESMITH_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", UNITS_OF_THE_INSTALL], env=environment, check=True)


def test_a_processor_without_the_wide_instance(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As where a wheel was made on another machine: the instance that runs here is compiled."""
    if not has_wide_vectors():
        pytest.skip("no device with AVX2")
    found = kernels(folder)
    assert found.library is not None

    class Narrow:
        def __init__(self, lib: Any) -> None:
            self.lib = lib

        def __getattr__(self, name: str) -> Any:
            return getattr(self.lib, name)

        def bs_instance_runs(self, instance: int) -> bool:
            return instance < 2

    cross = bound(found, CROSS)
    found.library.lib = Narrow(found.library.lib)
    assert np.array_equal(cross(*ROWS), written(folder, cross, *ROWS))
    has = [name for i, name in enumerate(found.library.instances) if found.library.lib.bs_instance_has(i, cross.index)]
    assert has == ["f64_base"]


def test_a_folder_without_its_texts_names_the_remedy(folder: Path) -> None:
    found = kernels(folder)
    (folder / "kernels" / f"{MODULE}.c").unlink()
    with pytest.raises(SpecError, match="bladesmith generate"):
        extension.generated_unit(folder, stock_kernels.headers(), MODULE, best_instances("f64")[0])
    cross = bound(found, CROSS)
    assert np.array_equal(cross(*ROWS), written(folder, cross, *ROWS))
    with pytest.raises(SpecError, match="bladesmith generate"):
        stock_kernels.PlainKernel(folder / "kernels" / "absent.py", CROSS, cross.inputs, cross.outputs)
