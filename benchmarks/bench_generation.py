"""Seconds to generate and to start: the stock algebras with and without their recorded forms, a new kernel, imports.

python benchmarks/bench_generation.py
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import resources
from pathlib import Path

GENERATED = Path(str(resources.files("bladesmith.generated")))


def cpu(work: Callable[[], object]) -> float:
    """Processor seconds of a call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def generate_stock(with_records: bool) -> None:
    """Derive and print all stock algebras."""
    from bladesmith.codegen.algebra.loader import STOCK
    from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
    from bladesmith.codegen.generator import generate

    for name in STOCK:
        records = json.loads((GENERATED / name / "forms.json").read_text("utf-8")) if with_records else None
        generate(load_spec(stock_spec_path(name)), records)


def new_kernel() -> None:
    """Trace, choose, print, compile and call a kernel that nobody has compiled before."""
    from bladesmith import cga3d, codegen

    @codegen.kernel(cga3d.kind("motor"), cga3d.kind("circle"), name=f"bench_{os.getpid()}")
    def move(m, x):  # type: ignore[no-untyped-def]
        return m * x * ~m

    move(cga3d.rotor((0, 0, 1), 0.3).as_kind("motor"), cga3d.circle((1, 0, 0), (0, 0, 1), 1.0))


def high_dimensions() -> None:
    """Outer and geometric products of points in Cl(8,2), typed products in Cl(9,6)."""
    import numpy as np

    import bladesmith as bs

    random = np.random.default_rng(1)
    algebra = bs.algebra(8, 2)
    points = [algebra.multivector(random.normal(size=(100, 10)), grades=[1]) for _ in range(4)]
    (points[0] ^ points[1] ^ points[2]) * points[3]
    algebra = bs.algebra(9, 6)
    algebra.multivector(random.normal(size=(10, 455)), grades=[3]) * algebra.multivector(
        random.normal(size=(10, 15)), grades=[1]
    )


def imports() -> tuple[float, float]:
    """Wall milliseconds of NumPy and of bladesmith after it, the best of several fresh interpreters."""
    program = (
        "import time; a = time.perf_counter(); import numpy; b = time.perf_counter(); import bladesmith; "
        "c = time.perf_counter(); print(b - a, c - b)"
    )
    runs = [
        tuple(
            float(x)
            for x in subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout.split()
        )
        for _ in range(7)
    ]
    return min(r[0] for r in runs) * 1e3, min(r[1] for r in runs) * 1e3


def main() -> None:
    """Print one line per figure, with its goal."""
    with tempfile.TemporaryDirectory() as cache:
        os.environ["BLADESMITH_CACHE_DIR"] = cache
        import bladesmith.codegen.generator  # SymPy and Jinja2 are not part of what is timed

        assert bladesmith.codegen.generator
        print(f"stock algebras from recorded forms   {cpu(lambda: generate_stock(True)):6.2f} s CPU (goal 5)")
        start = time.perf_counter()
        new_kernel()
        print(f"a new kernel, first call             {time.perf_counter() - start:6.2f} s     (goal 1)")
        start = time.perf_counter()
        high_dimensions()
        print(f"Cl(8,2) and Cl(9,6) products         {time.perf_counter() - start:6.2f} s     (goal 2)")
        numpy, ours = imports()
        print(f"import after NumPy's {numpy:.0f} ms          {ours:6.1f} ms    (goal 30)")
        print(f"stock algebras, forms searched       {cpu(lambda: generate_stock(False)):6.2f} s CPU (goal 60)")


if __name__ == "__main__":
    main()
