"""Instances of generated C: one precision and one vector width each, compiled from the same text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Instance:
    """One precision and vector width.

    Attributes
    ----------
    tag : str
    bits : int
        Of a number.
    bytes : str
        Of a vector, as the text says it.
    level : int
        Of x86-64 processors that run it, which are asked first: 3 for AVX2, 4 for AVX-512; 0: all.
    """

    tag: str
    bits: int
    bytes: str
    level: int = 0

    @property
    def wide(self) -> bool:
        """Whether it needs a processor that is asked first."""
        return self.level > 0


BASELINE = (Instance("f64_base", 64, "BS_BASELINE_BYTES"), Instance("f32_base", 32, "BS_BASELINE_BYTES"))
WIDE = (Instance("f64_v3", 64, "32", 3), Instance("f32_v3", 32, "32", 3))
#: Of kernels, and of algorithms on several items: series have at most `WIDE`.
WIDEST = (Instance("f64_v4", 64, "64", 4), Instance("f32_v4", 32, "64", 4))
SCALAR = (Instance("f64_scalar", 64, "0"), Instance("f32_scalar", 32, "0"))
#: Of algorithms: one item after the other.
ONE_BY_ONE = (Instance("f64", 64, "0"), Instance("f32", 32, "0"))
#: What wheels carry. Tests add SCALAR; a kernel made at run time takes only what this processor uses.
PORTABLE = BASELINE + WIDE
#: What kernels, and algorithms on several items, are compiled for.
OF_KERNELS = PORTABLE + WIDEST
#: All of them by name.
BY_TAG = {i.tag: i for i in OF_KERNELS + SCALAR}
