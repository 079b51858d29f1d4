"""Products of batches: nanoseconds per item of the runtime beside kingdon, clifford and structure-of-arrays C.

One thread, float64, random members of the kinds, everything warm; the best of several runs. The C is the kernel's
own body over separate arrays of coefficients, compiled for this machine with the best of a few sets of flags: what
a hand could reach with another layout of the data.

    python benchmarks/bench_products.py --items 1000000
"""

from __future__ import annotations

import argparse
import ctypes
import json
import logging
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import bladesmith as bs
from bladesmith.codegen.algebra.algebra import Kind
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.declarations import formula_by_name
from bladesmith.codegen.optimise.variants import select_variant
from bladesmith.codegen.targets.c.extension import bodies_text
from bladesmith.codegen.targets.c.printer import c_function
from bladesmith.codegen.trace.trace import trace

os.environ.setdefault("BLADESMITH_SPECIALISE", "0")
ROOT = Path(__file__).resolve().parent.parent
FLAG_SETS = (
    "-O3 -march=native -ffp-contract=off",
    "-O3 -march=native -ffp-contract=fast",
    "-O3 -march=native -mprefer-vector-width=256 -ffast-math",
)
REPEATS = 7
PEER_ITEMS = 100_000  # peers' temporary arrays of a million dense multivectors do not fit everywhere

#: Row of the table: algebra, operation, kinds of the operands.
ROWS = {
    "CGA motor on point": ("cga3d", "sandwich", "motor", "point"),
    "CGA motor on circle": ("cga3d", "sandwich", "motor", "circle"),
    "CGA motor times motor": ("cga3d", "geometric", "motor", "motor"),
    "CGA dense product": ("cga3d", "geometric", "multivector", "multivector"),
    "CGA vector ^ vector": ("cga3d", "outer", "vector", "vector"),
    "CGA meet of line and sphere": ("cga3d", "regressive", "line", "sphere"),
    "PGA motor on point": ("pga3d", "sandwich", "motor", "point"),
    "PGA motor times motor": ("pga3d", "geometric", "motor", "motor"),
    "PGA join of points": ("pga3d", "regressive", "point", "point"),
}


def best(run: Callable[[], Any], items: int, repeats: int = REPEATS) -> float:
    """Nanoseconds per item of the fastest run."""
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times) / items * 1e9


def members(kind: Kind, items: int, seed: int) -> np.ndarray:
    """Rows of random members."""
    x = sample(kind, NumericSource(items, seed))
    return np.stack([np.broadcast_to(v, (items,)) for v in kind.values(x)], -1)


def apply(operation: str, a: Any, b: Any) -> Any:
    """The operation by its operator."""
    return {
        "geometric": lambda: a * b,
        "outer": lambda: a ^ b,
        "regressive": lambda: a & b,
        "sandwich": lambda: a >> b,
    }[operation]()


def repeated(count: int, operation: str, a: Any, b: Any) -> None:
    """The operation again and again; a result is dropped before the next one is made."""
    for _ in range(count):
        apply(operation, a, b)


def ours(row: tuple[str, str, str, str], items: int) -> dict[str, float]:
    """The runtime on a batch of pairs, and on one left operand for all."""
    name, operation, first, second = row
    alg = getattr(bs, name)
    kinds = alg.kind(first), alg.kind(second)
    a, b = (alg.wrap(k, np.ascontiguousarray(members(k, items, i))) for i, k in enumerate(kinds))
    few_a, few_b = a[:1000], b[:1000]
    return {
        "batch": best(lambda: apply(operation, a, b), items),
        "one left operand": best(lambda: apply(operation, a[0], b), items),
        "in cache": best(lambda: repeated(100, operation, few_a, few_b), 100 * few_a.size),
    }


def structure_of_arrays(row: tuple[str, str, str, str], items: int) -> float:
    """The kernel's body over columns in C, with the best flags."""
    name, operation, first, second = row
    alg = getattr(bs, name)
    kinds = [alg.kind(first), alg.kind(second)]
    kernel = trace(formula_by_name(f"products.{operation}"), kinds, f"soa_{operation}", algebra=alg)
    source = _columns_source(kernel, items)
    rows = [np.ascontiguousarray(members(k, items, i).T) for i, k in enumerate(kinds)]
    out = np.empty((sum(len(o.nodes) for o in kernel.outputs), items))
    times = []
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "soa.c").write_text(source)
        for i, flags in enumerate(FLAG_SETS):
            library = Path(folder) / f"soa{i}.so"
            command = f"gcc -std=c11 {flags} -fno-math-errno -fopenmp-simd -shared -fPIC -I{ROOT}/templates/c/lib -w"
            subprocess.run([*command.split(), "soa.c", "-o", str(library), "-lm"], cwd=folder, check=True)
            run = ctypes.CDLL(str(library)).run
            pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (out, *rows)]
            times.append(best(lambda run=run, pointers=pointers: run(ctypes.c_long(items), *pointers), items))
    return min(times)


def _columns_source(kernel: Any, items: int) -> str:
    function = c_function(select_variant(kernel, quick=True))
    loads = "\n".join(
        f"    V {p.name}_in[{p.size}]; for (int j = 0; j < {p.size}; j++) {p.name}_in[j] = {p.name}[j * n + i];"
        for p in function.inputs
    )
    (result,) = function.outputs
    arguments = ", ".join(f"const double *restrict {p.name}" for p in function.inputs)
    call = f"FN({function.symbol})(r, {', '.join(p.name + '_in' for p in function.inputs)});"
    return f"""
#include "platform.h"
#define BS_BITS 64
#define BS_BYTES 0
#define BS_TAG soa
#include "instance.h"
{bodies_text([select_variant(kernel, quick=True)])}
void run(long n, double *restrict result, {arguments})
{{
#pragma omp simd
  for (long i = 0; i < n; i++) {{
{loads}
    V r[{result.size}];
    {call}
    for (int j = 0; j < {result.size}; j++) result[j * n + i] = r[j];
  }}
}}
"""


def with_kingdon(row: tuple[str, str, str, str], items: int) -> float:
    """kingdon on arrays of coefficients, orthonormal basis, the same blades where it can."""
    from kingdon import Algebra

    name, operation, first, second = row
    alg = getattr(bs, name)
    theirs = Algebra(*alg.signature)
    operands = []
    for i, k in enumerate((first, second)):
        x = alg.wrap(alg.kind(k), np.ascontiguousarray(members(alg.kind(k), items, i))).to_basis("orthonormal")
        keys = tuple(_kingdon_key(theirs, str(b)) for b in x.blades)
        operands.append(theirs.multivector(keys=keys, values=[np.ascontiguousarray(c) for c in x.values.T]))
    a, b = operands
    run = {
        "geometric": lambda: a * b, "outer": lambda: a ^ b, "regressive": lambda: a & b, "sandwich": lambda: a >> b,
    }[operation]  # fmt: skip
    return best(run, items, 3)


def _kingdon_key(theirs: Any, blade: str) -> int:
    return int(theirs.canon2bin["e" if blade == "1" else blade])


def with_clifford(row: tuple[str, str, str, str], items: int) -> float:
    """clifford's own product function in a numba loop, dense."""
    import clifford
    import numba

    name, operation, _, _ = row
    p, q, r = getattr(bs, name).signature
    layout, _ = clifford.Cl(p, q, r)
    gmt, adjoint = layout.gmt_func, layout.adjoint_func
    table = {"geometric": gmt, "outer": layout.omt_func}.get(operation)
    if operation not in ("geometric", "outer", "sandwich"):
        return float("nan")

    @numba.njit
    def loop(a, b, out):  # type: ignore[no-untyped-def]
        for i in range(len(a)):
            out[i] = table(a[i], b[i])

    @numba.njit
    def sandwich(a, b, out):  # type: ignore[no-untyped-def]
        for i in range(len(a)):
            out[i] = gmt(gmt(a[i], b[i]), adjoint(a[i]))

    random = np.random.default_rng(0)
    a, b = random.normal(size=(2, items, layout.gaDims))
    out = np.empty_like(a)
    run = sandwich if operation == "sandwich" else loop
    return best(lambda: run(a, b, out), items, 3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--items", type=int, default=1_000_000)
    parser.add_argument("--only", help="part of a row's name")
    parser.add_argument("--no-peers", action="store_true")
    parser.add_argument("--json", type=Path, help="write the numbers here too")
    options = parser.parse_args()
    logging.getLogger("kingdon").setLevel(logging.ERROR)
    found: dict[str, dict[str, float]] = {}
    columns = ["batch", "one left operand", "in cache", "SoA C", "kingdon", "clifford"]
    print(f"{'ns per item':32s}" + "".join(f"{c:>18s}" for c in columns))
    for name, row in ROWS.items():
        if options.only and options.only not in name:
            continue
        numbers = ours(row, options.items)
        numbers["SoA C"] = structure_of_arrays(row, options.items)
        if not options.no_peers:
            numbers["kingdon"] = with_kingdon(row, PEER_ITEMS)
            numbers["clifford"] = with_clifford(row, PEER_ITEMS // 10)
        found[name] = numbers
        print(f"{name:32s}" + "".join(f"{numbers.get(c, float('nan')):18.2f}" for c in columns), flush=True)
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
