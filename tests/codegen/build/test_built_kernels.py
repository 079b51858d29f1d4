"""Declared kernels that are in the cache: neither traced nor printed again, and never those of another declaration."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.build import source_digest, text_cache
from bladesmith.codegen.trace.outputs import status

from ...support.build.extension_parts import forget

pytestmark = pytest.mark.compiles

ROTOR, CIRCLE = cga.rotor((0, 0, 1), 0.3).as_kind("motor"), cga.circle((1, 0, 0), (0, 0, 1), 1.0)


def moved(weight: int = 1) -> KernelFunction:
    """A kernel as a new process declares it; ``weight`` is what its formula's helper reads."""

    def helper(x: Any) -> Any:
        return weight * x

    @codegen.kernel(cga.kind("motor"), cga.kind("circle"))
    def move_by_helper(m, x):  # type: ignore[no-untyped-def]
        return helper(m * x * ~m)

    return move_by_helper


def test_a_kernel_in_the_cache_is_not_traced(cache_dir: Path) -> None:
    first, second = moved(), moved()
    expected = first(ROTOR, CIRCLE)
    found = second(ROTOR, CIRCLE)
    assert first._traced is not None and second._traced is None
    assert found.kind is expected.kind is cga.kind("circle") and (found.values == expected.values).all()
    assert (second(ROTOR.values, CIRCLE.values) == expected.values).all() and second._traced is None
    assert second.operations == first.operations and second._traced is not None


def test_a_changed_helper_is_another_kernel(cache_dir: Path) -> None:
    once, twice = moved(1)(ROTOR, CIRCLE), moved(2)(ROTOR, CIRCLE)
    assert (twice.values == 2 * once.values).all()


def test_every_precision_is_kept_for_itself(cache_dir: Path) -> None:
    single = [a.values.astype(np.float32) for a in (ROTOR, CIRCLE)]
    expected = moved()(*single)
    moved()(ROTOR, CIRCLE)
    kernel = moved()
    assert kernel(*single).dtype == np.float32 and (kernel(*single) == expected).all() and kernel._traced is None


def test_statuses_rows_and_several_results_are_kept(cache_dir: Path) -> None:
    def declare() -> KernelFunction:
        @codegen.kernel(codegen.numbers(2), cga.kind("point"), codegen.scalar)
        def several(row, x, t):  # type: ignore[no-untyped-def]
            code = codegen.select(t < 0, t.constant(1), t.constant(0))
            return x + row[0], codegen.row([t, row[1]]), status(code)

        return several

    x, rows = cga.point(np.ones((3, 3))), np.arange(6.0).reshape(3, 2)
    first, second = declare(), declare()
    times = np.array([1.0, -1.0, 2.0])
    for one, other in zip(first(rows, x, times), second(rows, x, times), strict=True):
        assert (getattr(one, "values", one) == getattr(other, "values", other)).all()
        assert getattr(one, "kind", None) == getattr(other, "kind", None)
    assert second._traced is None


def test_records_without_their_unit_or_damaged_ones_are_made_again(cache_dir: Path) -> None:
    expected = moved()(ROTOR, CIRCLE).values
    for folder in cache_dir.glob("bs_*move_by_helper*"):
        shutil.rmtree(folder)
    with pytest.MonkeyPatch.context() as patch:
        forget(patch)
        kernel = moved()
        assert (kernel(ROTOR, CIRCLE).values == expected).all() and kernel._traced is not None
    (group,) = cache_dir.glob("text_built_*")
    (record,) = group.glob("*[0-9a-f].json")
    for content in ("[]", '["a", "b", [["c"]]]', "{", '["a", "b", 1]'):
        text_cache.write(group.name.removeprefix("text_"), {record.name: content})
        kernel = moved()
        assert (kernel(ROTOR, CIRCLE).values == expected).all() and kernel._traced is not None
    record.write_bytes(b"")
    assert (moved()(ROTOR, CIRCLE).values == expected).all()


def test_the_stamp_follows_every_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = tmp_path / "codegen"
    for folder in (root / "trace" / "__pycache__", tmp_path / "templates" / "c"):
        folder.mkdir(parents=True)
    files = [root / "api.py", root / "trace" / "trace.py", tmp_path / "templates" / "c" / "kernel.h.j2"]
    old = source_digest.LOADED - 1000

    def stamp() -> str | None:
        source_digest.stamp.cache_clear()
        return source_digest.stamp()

    monkeypatch.setattr(source_digest, "ROOT", root)
    try:
        assert [file.write_text("1") for file in files] and [os.utime(file, (old, old)) for file in files]
        seen = {stamp()}
        (root / "trace" / "__pycache__" / "trace.pyc").write_text("1")
        assert stamp() in seen and None not in seen
        for file in files:
            file.write_text("22")
            assert stamp() is None  # younger than what runs
            os.utime(file, (old, old))
            seen.add(stamp())
        os.utime(files[0], (old, old + 1))
        seen.add(stamp())
        files[1].rename(root / "trace" / "tracing.py")
        seen.add(stamp())
        assert len(seen) == 6 and None not in seen
    finally:
        source_digest.stamp.cache_clear()
