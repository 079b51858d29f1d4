"""Which instance of the generated code this processor uses."""

from __future__ import annotations

from functools import cache

from .targets.instances import BASELINE, WIDE, Instance


@cache
def has_wide_vectors() -> bool:
    """Whether the processor runs x86-64-v3 code, as NumPy found when it was imported."""
    try:
        from numpy._core._multiarray_umath import __cpu_features__ as features  # type: ignore[import-not-found]
    except ImportError:  # NumPy 1.x
        from numpy.core._multiarray_umath import __cpu_features__ as features  # type: ignore
    return bool(features.get("AVX2", False))


def instances(precision: str) -> tuple[Instance, ...]:
    """The one instance that a kernel made at run time is compiled for."""
    chosen = WIDE if has_wide_vectors() else BASELINE
    return tuple(i for i in chosen if i.tag.startswith(precision))
