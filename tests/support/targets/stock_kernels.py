"""Stock kernels as they are declared."""

from __future__ import annotations

from functools import cache
from typing import Any

from bladesmith.codegen.algebra.loader import STOCK, algebra_from_data
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.declarations import declared_kernels
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.trace.kernel import Kernel
from bladesmith.codegen.trace.trace import trace


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


def all_kernels() -> list[tuple[str, str]]:
    return [(algebra, name) for algebra in STOCK for name in declared(algebra)]
