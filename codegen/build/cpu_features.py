"""CPU features: the instance of the generated code that this processor runs best."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from ..targets.c.instances import OF_KERNELS, Instance


@cache
def _features() -> Mapping[str, bool]:
    """Features of the processor, as NumPy found them when it was imported."""
    try:
        from numpy._core._multiarray_umath import __cpu_features__ as features  # type: ignore[import-not-found]
    except ImportError:  # NumPy 1.x
        from numpy.core._multiarray_umath import __cpu_features__ as features  # type: ignore
    return features  # type: ignore[no-any-return]


def has_wide_vectors() -> bool:
    """Return whether the processor runs x86-64-v3 code."""
    return bool(_features().get("AVX2", False))


def runs(instance: Instance) -> bool:
    """Return whether the processor runs an instance."""
    if instance.level == 4:
        return bool(_features().get("AVX512_SKX", False))  # F, DQ, BW and VL of it
    return not instance.wide or has_wide_vectors()


def vector_options() -> tuple[str, ...]:
    """Option of the compiler that selects text for x86-64-v3 in drivers that do not ask the processor at run time."""
    return ("-DBS_RUNS_V3=1",) if has_wide_vectors() else ()


def best_instances(precision: str) -> tuple[Instance, ...]:
    """The one instance of a precision that kernels, and algorithms on several items, are compiled for at run time."""
    return tuple(i for i in OF_KERNELS if i.tag.startswith(precision) and runs(i))[-1:]


def processor_name() -> str:
    """Name of the processor, as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, "") or platform.processor() or platform.machine()
