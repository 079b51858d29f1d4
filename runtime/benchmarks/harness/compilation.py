"""The compiler at work on one formula: kind, operations, C, and its error against 50 digits. Printed by the demo."""

from __future__ import annotations

import inspect
import time
from dataclasses import dataclass

import numpy as np

from ... import codegen
from ...codegen.formulas.objects.blades import blade_projector
from ...codegen.optimise.variants import Operations
from ...core.multivector import Multivector
from .algebras import cga3d as cga

#: Number of results that are compared with the reference.
COMPARED = 100
#: Digits of the reference.
DIGITS = 50
#: Items of the timed batch.
TIMED = 100_000
#: Number of timings of a batch, of which the least counts.
REPEATS = 5


@codegen.kernel(cga.kind("circle"), cga.kind("circle"), codegen.scalar)
def blend(x, y, alpha):  # type: ignore[no-untyped-def]  # shown as it stands
    z = alpha * x + (1 - alpha) * y
    return blade_projector(z) * z


@dataclass(frozen=True)
class Compilation:
    """Results of compiling and running the formula.

    Parameters
    ----------
    formula, source : str
        The formula in Python, and the generated C.
    kind : str
        Proved kind of the result.
    operations : Operations
        Operation counts of the C text.
    traced_seconds, compiled_seconds : float
        Times from the formula to the C text, and from there to the first result.
    nanoseconds : float
        Time per item of a batch.
    error : float
        Largest error of ``compared`` results, relative to the largest coefficient of the reference.
    alpha : float
        Argument of the largest error.
    """

    formula: str
    source: str
    kind: str
    operations: Operations
    traced_seconds: float
    compiled_seconds: float
    nanoseconds: float
    error: float
    alpha: float
    compared: int = COMPARED
    digits: int = DIGITS
    timed: int = TIMED


def compile_blend() -> Compilation:
    """Trace, optimize and compile the formula, time it, and compare it with itself on 50-digit numbers."""
    start = time.perf_counter()
    source = blend.source("c")
    traced = time.perf_counter()
    a = cga.circle(center=(0, 0, 0), normal=(0, 0, 1), radius=1.0)
    b = cga.circle(center=(0, 1, 2), normal=(0, 0.5, 1), radius=0.6)
    alphas = np.linspace(0, 1, COMPARED)
    circles = blend(a, b, alphas)
    compiled = time.perf_counter()
    error, alpha = max((_error(row, a, b, alpha), alpha) for row, alpha in zip(circles.values, alphas, strict=True))
    return Compilation(
        inspect.getsource(blend.formula).replace("  # type: ignore[no-untyped-def]  # shown as it stands", ""),
        source,
        circles.kind.name,
        blend.operations,
        traced - start,
        compiled - traced,
        _nanoseconds(a, b),
        error,
        float(alpha),
    )


def _error(row: np.ndarray, a: Multivector, b: Multivector, alpha: float) -> float:
    exact = blend.reference(a, b, alpha, digits=DIGITS)
    return float(max(abs(x - float(v)) for v, x in zip(row, exact, strict=True)) / max(map(abs, exact)))


def _nanoseconds(a: Multivector, b: Multivector) -> float:
    alphas, best = np.linspace(0, 1, TIMED), np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        blend(a, b, alphas)
        best = min(best, time.perf_counter() - start)
    return best / TIMED * 1e9
