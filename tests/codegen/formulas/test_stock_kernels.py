"""Every stock kernel against exact evaluation of its formula, on the widest instance in double precision; those of
every sixth module on every instance and precision, whose text is the same and which are compiled at first use (all of
them under BLADESMITH_FULL_BARS=1).

An error may be 8 units of roundoff times the running first-order bound of the formula as written. Polynomial
kernels are compared with exact rationals, the others with 50 digits. The instances must agree bit for bit.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.algebra.loader import STOCK
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.checks.errors import compare, exact_rows
from bladesmith.codegen.checks.operands import operand_cases
from bladesmith.codegen.compiler import bind_library
from bladesmith.codegen.execute.bound_kernels import BoundKernel, Library
from bladesmith.codegen.execute.numba_jit import NumbaKernel, NumbaLibrary
from bladesmith.codegen.optimise.variants import select_variant
from bladesmith.codegen.targets.c.instances import OF_KERNELS, Instance
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.targets.cuda.printer import cuda_source
from bladesmith.codegen.trace.kernel import Kernel, interface
from bladesmith.core.registry import stock_algebra

from ...support.cuda import compiled_for_gpus
from ...support.effort import FULL
from ...support.targets.stock_kernels import all_kernels, declared, traced

ITEMS = 24 if FULL else 9  # eight lanes and one more
#: Kernels of every so many modules run on all instances, from the second on: in each algebra some have all operations.
SHARE = 1 if FULL else 6


@cache
def stock(name: str) -> Library:
    library = stock_algebra(name).stock.library
    assert library is not None
    return library


@cache
def stock_numba(name: str, module: str) -> NumbaLibrary:
    text = resources.files("bladesmith.generated").joinpath(name, "kernels", f"{module}.py").read_text("utf-8")
    return NumbaLibrary(text, compiled=False)


@cache
def stock_forms(name: str) -> dict[str, str]:
    text = resources.files("bladesmith.generated").joinpath(name, "manifest.json").read_text("utf-8")
    return {entry["symbol"]: entry["variant"] for entry in json.loads(text)["kernels"]}


@cache
def kept_forms(name: str) -> dict[str, Any]:
    text = resources.files("bladesmith.generated").joinpath(name, "variants.json").read_text("utf-8")
    return dict(json.loads(text))


def instances_of(algebra: str, kernel: Kernel) -> list[Instance]:
    """Those on which a kernel is tested, the portable ones first."""
    modules = sorted({formula.__module__ for formula, *_ in declared(algebra).values()})
    runnable = [i for i in OF_KERNELS if runs(i)]
    if modules.index(kernel.formula.__module__) % SHARE == 1 % SHARE:
        return runnable
    return [i for i in runnable if i.bits == 64][-1:]


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels(), ids=lambda v: str(v))
def test_stock_kernel_is_exact_to_its_bound(algebra: str, name: str) -> None:
    library, kernel = stock(algebra), traced(algebra, name)
    compiled: BoundKernel = bind_library(library, kernel, name)
    reduced = stock_forms(algebra)[name].startswith("reduced")
    columns = NumbaKernel(stock_numba(algebra, kernel.formula.__module__.rpartition(".")[2]), name, *interface(kernel))
    tested = instances_of(algebra, kernel)
    for dtype in (np.float64, np.float32):
        tags = [i.tag for i in tested if i.bits == 8 * np.dtype(dtype).itemsize]
        if not tags:
            continue
        for case, arrays in operand_cases(kernel, dtype, ITEMS):
            exact = exact_rows(kernel, arrays)
            answers = {}
            for instance in tags:
                assert library.use(instance, name)
                answers[instance] = compiled(*arrays)
            answers["numba's text"] = columns(*arrays)
            first, *others = answers
            fault = compare(kernel, arrays, answers[first], exact, reduced).fault
            assert not fault, f"{name} on {first}, {case}, {fault}"
            for instance in others:  # the same numbers, so as near to the exact ones
                pairs = zip(_listed(answers[instance]), _listed(answers[first]), strict=True)
                same = all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in pairs)
                assert same, f"{name} on {instance} has other bits, {case}"


def _listed(result: Any) -> list[np.ndarray]:
    return list(result) if isinstance(result, tuple) else [result]


@pytest.mark.parametrize("name", STOCK)
def test_every_stock_kernel_of_the_manifest_is_compiled(name: str) -> None:
    assert set(stock(name).index) == set(declared(name))


#: Where they are optimised, 100 kernels at once take minutes.
CUDA_PART = 20
PARTS = [(name, start) for name in STOCK for start in range(0, len(declared(name)), CUDA_PART)][:: 1 if FULL else 3]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "start"), PARTS)
def test_stock_kernels_compile_for_cuda(name: str, start: int) -> None:
    """Needs the NVRTC package and no device; the same bodies as C's, so their bits are checked where a device is."""
    kernels = [traced(name, each) for each in list(declared(name))[start : start + CUDA_PART]]
    # the variants of C: a search takes ten times as long
    variants = [select_variant(kernel, kept_forms(name)[symbol(kernel)]) for kernel in kernels]
    compiled = compiled_for_gpus(cuda_source(variants))
    assert not compiled.log.strip("\0 \n") and compiled.image
