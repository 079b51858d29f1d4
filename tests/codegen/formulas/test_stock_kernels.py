"""Every stock kernel against exact evaluation of its formula, on the widest instance in double precision; those of
every third module on every instance and precision, whose text is the same and which are compiled at first use (all of
them under BLADESMITH_FULL_BARS=1).

An error may be CONSTANT units of roundoff times the running first-order bound of the formula as written. Polynomial
kernels are compared with exact rationals, the others with 50 digits. The instances must agree bit for bit.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import pytest

from bladesmith import Status
from bladesmith.codegen.algebra.algebra import Kind
from bladesmith.codegen.algebra.loader import STOCK, algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.compiler import bind_library
from bladesmith.codegen.declarations import declared_kernels
from bladesmith.codegen.execute.arrays import BoundKernel, Library
from bladesmith.codegen.execute.cuda_compiler import compile_source
from bladesmith.codegen.execute.numba_jit import NumbaKernel, NumbaLibrary
from bladesmith.codegen.ir.graph import evaluate
from bladesmith.codegen.optimise.variants import select_variant
from bladesmith.codegen.rings.error_bound import BoundRing
from bladesmith.codegen.rings.protocol import FUNCTIONS
from bladesmith.codegen.targets.c.instances import OF_KERNELS, Instance
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.targets.cuda.printer import cuda_source
from bladesmith.codegen.trace.kernel import Kernel, interface
from bladesmith.codegen.trace.trace import trace
from bladesmith.core.registry import stock_algebra

from ...oracles.exact_rings import exact_items
from ...support.effort import FULL

#: Errors are held to this many units of roundoff times the bound; forms are admitted up to a ratio of 4.
CONSTANT = 8.0
ITEMS = 24 if FULL else 12
#: Kernels of every so many modules run on all instances.
SHARE = 1 if FULL else 3
#: Kernels whose numbers are high powers of lengths.
OVERFLOWING = ("delta_motion", "piece_pose")
#: Rounding of 50 digits where the exact answer is zero.
ORACLE = 1e-45


@cache
def stock(name: str) -> Library:
    library = stock_algebra(name).stock.library
    assert library is not None
    return library


@cache
def declared(name: str) -> dict[str, tuple[Any, ...]]:
    """Of each kernel of an algebra's spec what `trace` is given."""
    spec = load_spec(stock_spec_path(name))
    algebra = algebra_from_data(spec)
    declared = declared_kernels(algebra, spec["kernels"])
    return {f"{name}_{d.name}": (d.formula, d.kinds, d.name, algebra) for d in declared}


def traced(algebra: str, name: str) -> Kernel:
    """One kernel: all of them together take gigabytes, and a worker that runs some of the tests needs some of them."""
    formula, kinds, own, home = declared(algebra)[name]
    kernel = trace(formula, kinds, own, algebra=home)
    assert symbol(kernel) == name
    return kernel


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
    if modules.index(kernel.formula.__module__) % SHARE == 0:
        return runnable
    return [i for i in runnable if i.bits == 64][-1:]


def all_kernels() -> list[tuple[str, str]]:
    return [(algebra, name) for algebra in STOCK for name in declared(algebra)]


def rows(kind: Kind, seed: int, scale: float, dtype: Any) -> np.ndarray:
    source = NumericSource(ITEMS, seed, scale)
    if kind.form == "numbers":
        columns = [source.scalar() for _ in range(kind.size)]
    else:
        columns = kind.values(sample(kind, source))
    stacked = np.stack([np.broadcast_to(c, (ITEMS,)) for c in columns], -1).astype(dtype)
    return stacked[..., 0] if kind.is_scalar_argument else stacked


def near_unit(kind: Kind, seed: int, unit: float, near: float, dtype: Any) -> np.ndarray:
    own = rows(kind, seed, 1.0, np.float64)
    if kind.form != "multivector":
        return np.asarray(near * own + max(unit, 0.0)).astype(dtype)
    if kind.blades[0] != 0 or kind.is_layout:
        return own.astype(dtype)
    versor, neighbour = (sample(kind, Neighbours(seed, step)) for step in (0.0, near))
    product = kind.values(versor * ~neighbour)  # a versor times the reverse of a near one
    if any("x['1']" in text for text in kind.constraints):
        unit = 1.0  # -x is none of this kind
    return unit * np.stack([np.broadcast_to(v, (ITEMS,)) for v in product], -1).astype(dtype)


class Neighbours(NumericSource):
    """The same random numbers for the same seed, but for a relative step."""

    def __init__(self, seed: int, step: float) -> None:
        super().__init__(ITEMS, seed)
        self.step = step
        self.other = np.random.default_rng(seed + 1)

    def scalar(self) -> Any:
        return super().scalar() * (1 + self.step * self.other.normal(size=ITEMS))


def inputs(kernel: Kernel, dtype: Any) -> Iterator[list[np.ndarray]]:
    """Ordinary members, tiny and huge ones, equal ones, and layouts with zeros and one dominant coefficient."""
    big = 1e6 if dtype == np.float64 else 1e3
    for seed, scale in ((1, 1.0), (2, big), (3, 1 / big)):
        yield [rows(i.kind, seed + 10 * n, scale, dtype) for n, i in enumerate(kernel.inputs)]
    yield [rows(i.kind, 4, 1.0, dtype) for i in kernel.inputs]
    near = 1e-6 if dtype == np.float64 else 1e-3
    for unit in (1.0, -1.0):  # versors near 1 and -1, numbers near 1 and 0
        yield [near_unit(i.kind, 20 + n, unit, near, dtype) for n, i in enumerate(kernel.inputs)]
    if all(i.kind.is_layout for i in kernel.inputs):
        rng = np.random.default_rng(5)
        sparse = [rows(i.kind, 6 + n, 1.0, dtype) for n, i in enumerate(kernel.inputs)]
        yield [np.where(rng.random(a.shape) < 0.5, a, 0).astype(dtype) for a in sparse]


def exact_rows(kernel: Kernel, arrays: list[np.ndarray], epsilon: Fraction) -> list[list[list[Any]]]:
    """The formula itself, item by item: rationals where that is possible, else 50 digits."""
    rational = not any(n.op in FUNCTIONS for n in kernel.graph.nodes)
    columns = [np.reshape(a, (ITEMS, -1)).T.astype(float).tolist() for a in arrays]
    return exact_items(kernel, columns, rational, 50, epsilon)


def check(
    kernel: Kernel, arrays: list[np.ndarray], results: Any, exact: list[Any], unit: float, reduced: bool, where: str
) -> None:
    places = {}
    for n, (item, a) in enumerate(zip(kernel.inputs, arrays, strict=True)):
        for j in range(item.kind.size):
            places[n, j] = ((a if item.kind.is_scalar_argument else a[..., j]).astype(float), 0.0)
    bounded = evaluate(kernel.roots, places, BoundRing())
    start = 0
    outputs = results if isinstance(results, tuple) else (results,)
    for o, (output, values) in enumerate(zip(kernel.outputs, outputs, strict=True)):
        size = len(output.nodes)
        part = bounded[start : start + size]
        start += size
        table = np.asarray(values).reshape(ITEMS, size)
        own = [np.broadcast_to(np.maximum(b, np.abs(v)), (ITEMS,)) for v, b in part]
        if reduced:  # members are rounded, so off their constraints by a unit of the whole object, not of a coefficient
            own = [np.max(own, axis=0)] * size
        noise = ORACLE * np.max([np.abs(np.broadcast_to(v, (ITEMS,))) for v, _ in part], axis=0)
        # bounds are of first order: of the square of a rounding error they see nothing
        limits = [limit * unit * CONSTANT + noise + (CONSTANT * unit) ** 2 for limit in own]
        for i in range(ITEMS):
            for j in range(size):
                true = exact[i][o][j]
                if output.role == "status":
                    same = int(table[i, j]) == int(true) or overflows(kernel, outputs, i)
                    assert same, f"{where}: status of item {i}: {[a[i] for a in arrays]}"
                    continue
                got = float(table[i, j])
                if not np.isfinite(got) or not np.isfinite(limits[j][i]):
                    lost = not fits(true, table.dtype) or not fits(limits[j][i], table.dtype)
                    assert lost or overflows(kernel, outputs, i), f"{where}: {[a[i] for a in arrays]}"
                    continue
                error = abs(float(Fraction(got) - true)) if isinstance(true, Fraction) else abs(float(got - true))
                assert error <= limits[j][i] + np.finfo(table.dtype).smallest_subnormal, (
                    f"{where}: item {i}, coefficient {j}: {got!r} is off by {error:.3g}, allowed {limits[j][i]:.3g}; "
                    f"inputs {[a[i].tolist() for a in arrays]}"
                )


def overflows(kernel: Kernel, outputs: tuple[np.ndarray, ...], item: int) -> bool:
    """Whether a kernel that may says of an item that single precision overflows on the way: NaN, and INVALID."""
    *values, code = outputs
    if not kernel.name.startswith(OVERFLOWING) or values[0].dtype != np.float32:
        return False
    return int(code[item]) == Status.INVALID and all(np.isnan(v[item]).all() for v in values)


def fits(value: Any, dtype: Any) -> bool:
    """Whether a number of this precision can hold it."""
    return abs(float(value)) <= float(np.finfo(dtype).max)


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "name"), all_kernels(), ids=lambda v: str(v))
def test_stock_kernel_is_exact_to_its_bound(algebra: str, name: str) -> None:
    library, kernel = stock(algebra), traced(algebra, name)
    compiled: BoundKernel = bind_library(library, kernel, name)
    reduced = stock_forms(algebra)[name].startswith("reduced")
    columns = NumbaKernel(stock_numba(algebra, kernel.formula.__module__.rpartition(".")[2]), name, *interface(kernel))
    tested = instances_of(algebra, kernel)
    for dtype, unit in ((np.float64, 2.0**-53), (np.float32, 2.0**-24)):
        tags = [i.tag for i in tested if i.bits == 8 * np.dtype(dtype).itemsize]
        if not tags:
            continue
        for case, arrays in enumerate(inputs(kernel, dtype)):
            exact = exact_rows(kernel, arrays, Fraction(2 * unit))
            answers = {}
            for instance in tags:
                assert library.use(instance, name)
                answers[instance] = compiled(*arrays)
            answers["numba's text"] = columns(*arrays)
            first, *others = answers
            check(kernel, arrays, answers[first], exact, unit, reduced, f"{name} on {first}, case {case}")
            for instance in others:  # the same numbers, so as near to the exact ones
                pairs = zip(_listed(answers[instance]), _listed(answers[first]), strict=True)
                same = all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in pairs)
                assert same, f"{name} on {instance} has other bits, case {case}"


def _listed(result: Any) -> list[np.ndarray]:
    return list(result) if isinstance(result, tuple) else [result]


@pytest.mark.parametrize("name", STOCK)
def test_every_stock_kernel_of_the_manifest_is_compiled(name: str) -> None:
    assert set(stock(name).index) == set(declared(name))


#: Compiling 100 kernels at once takes minutes; parts of this size keep both processors busy.
CUDA_PART = 20
PARTS = [(name, start) for name in STOCK for start in range(0, len(declared(name)), CUDA_PART)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "start"), PARTS)
def test_stock_kernels_compile_for_cuda(name: str, start: int) -> None:
    """Needs the NVRTC package and no device; the same bodies as C's, so their bits are checked where a device is."""
    kernels = [traced(name, each) for each in list(declared(name))[start : start + CUDA_PART]]
    # the variants of C: a search takes ten times as long
    variants = [select_variant(kernel, kept_forms(name)[symbol(kernel)]) for kernel in kernels]
    compiled = compile_source(cuda_source(variants))
    assert not compiled.log.strip("\0 \n") and compiled.image
