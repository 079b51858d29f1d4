"""Symbols and new algebras: the first product of an algebra, and a symbolic rotor on a symbolic vector, beside others.

Processor time of one thread, the least of several runs; peers that are installed run in turns with ours.

    python benchmarks/bench_symbols.py
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

import bladesmith as bs

RUNS = 5
#: Numbers of vectors of algebras that are made anew, and bars in milliseconds.
DIMENSIONS = {3: 5, 5: 5, 8: 5, 12: 50, 15: 50}


def milliseconds(run: Callable[[], Any]) -> float:
    """Processor time of one run."""
    start = time.process_time()
    run()
    return (time.process_time() - start) * 1e3


def first_product(signature: list[int]) -> None:
    """An algebra that no earlier call has made, and one product of two of its vectors."""
    algebra = bs.algebra(signature=signature)
    n = len(signature)
    algebra.vector(np.ones(n)) * algebra.vector(np.arange(1.0, n + 1))


def ours() -> Callable[[], Any]:
    """R x ~R in Cl(4,1), of a rotor with a symbol at each even blade."""
    algebra = bs.algebra(4, 1)
    return lambda: algebra.symbols("R", kind="even") >> algebra.symbols("x", kind="vector")


def kingdon() -> Callable[[], Any]:
    """The same with kingdon, whose first call of a pattern makes its function: a new algebra for each."""
    make: Any = import_module("kingdon").Algebra

    def run() -> Any:
        algebra = make(4, 1)
        return algebra.evenmv(name="R") >> algebra.vector(name="x")

    return run


def galgebra() -> Callable[[], Any]:
    """The same with galgebra."""
    make: Any = import_module("galgebra.ga").Ga
    algebra = make("e*1|2|3|4|5", g=[1, 1, 1, 1, -1])

    def run() -> Any:
        rotor, x = algebra.mv("R", "spinor"), algebra.mv("x", "vector")
        return rotor * x * rotor.rev()

    return run


def main() -> None:
    """Print both tables."""
    bs.vga3d.e1 * bs.vga3d.e2  # everything is imported
    print("first product in a new algebra, ms (least of signatures with 0 to 4 negative squares)")
    for n, bar in DIMENSIONS.items():
        times = [milliseconds(lambda k=k, n=n: first_product([1] * (n - k) + [-1] * k)) for k in range(min(n, RUNS))]
        missed = "" if min(times) <= bar else " MISSED"
        print(f"  {n:2d} vectors: {min(times):6.2f} to {max(times):.2f}, bar {bar}{missed}")
    runs = {"bladesmith": ours()}
    for peer in (kingdon, galgebra):
        try:
            runs[peer.__name__] = peer()
        except ImportError:
            print(f"  {peer.__name__} is not installed")
    found: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(RUNS):
        for name, run in runs.items():
            found[name].append(milliseconds(run))
    print("symbolic even rotor on a vector of Cl(4,1), ms")
    for name, times in found.items():
        print(f"  {name:12s} {min(times):8.1f}  {min(times) / min(found['bladesmith']):6.1f} times")


if __name__ == "__main__":
    main()
