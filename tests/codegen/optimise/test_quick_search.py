"""Kernels that somebody waits for: a short search, whose form is in the cache for the next process."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d, codegen
from bladesmith.codegen import compiler
from bladesmith.codegen.build import kernel_cache, text_cache
from bladesmith.codegen.optimise import variants


def moved(kind):
    return codegen.kernel(cga3d.kind("motor"), cga3d.kind(kind), name=f"moved_{kind}")(lambda m, x: m * x * ~m)


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("BLADESMITH_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(kernel_cache.source_digest, "digest", lambda files: "0" * 64)
    for each in (kernel_cache._forms, kernel_cache._touch):
        each.cache_clear()
        monkeypatch.setattr(kernel_cache, each.__name__, each.__wrapped__)
    return tmp_path


def test_a_form_is_searched_once(own_cache, monkeypatch):
    first = moved("line").variant
    monkeypatch.setattr(variants, "_search", lambda *_: pytest.fail("it was searched again"))
    again = moved("line").variant
    assert again.name == first.name == "reduced0"
    assert again.operations == first.operations
    assert compiler.print_source([again]) == compiler.print_source([first])


def test_a_form_of_something_else_is_searched(own_cache):
    line, plane = moved("line"), moved("plane")
    wanted = plane.variant.operations
    group = kernel_cache._forms()
    text_cache.write(group, {f"{plane.traced.fingerprint}.json": text_cache.read(group, _name_of(line)) or "{}"})
    assert moved("plane").variant.operations == wanted
    text_cache.write(group, {f"{plane.traced.fingerprint}.json": "[1"})
    assert moved("plane").variant.operations == wanted


def _name_of(kernel):
    assert kernel.variant
    return f"{kernel.traced.fingerprint}.json"


def total(roots):
    return variants.count(roots, {}).total


@pytest.mark.parametrize("kind, most", [("line", 95), ("plane", 44), ("sphere", 70), ("point", 60)])
def test_a_short_search_finds_what_a_long_one_does(kind, most):
    assert variants.select_variant(moved(kind).traced, quick=True).operations.total <= most


def test_the_cheapest_form_within_the_bound_is_taken(monkeypatch):
    kernel = moved("plane").traced
    best = variants.select_variant(kernel, quick=True)
    ratio, least = variants.error_ratio, best.operations.total
    monkeypatch.setattr(variants, "error_ratio", lambda k, roots: np.inf if total(roots) == least else ratio(k, roots))
    other = variants.select_variant(moved("plane").traced, quick=True)
    assert best.operations.total < other.operations.total <= variants.as_written(kernel).operations.total
