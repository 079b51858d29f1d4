"""Instances of generated C: one precision and one vector width each, compiled from the same text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Instance:
    """One precision and vector width; ``wide`` ones need a processor that is asked first."""

    tag: str
    bits: int
    bytes: str
    wide: bool = False


BASELINE = (Instance("f64_base", 64, "BS_BASELINE_BYTES"), Instance("f32_base", 32, "BS_BASELINE_BYTES"))
WIDE = (Instance("f64_v3", 64, "32", True), Instance("f32_v3", 32, "32", True))
SCALAR = (Instance("f64_scalar", 64, "0"), Instance("f32_scalar", 32, "0"))
#: Of algorithms: one item after the other.
ONE_BY_ONE = (Instance("f64", 64, "0"), Instance("f32", 32, "0"))
#: What wheels carry. Tests add SCALAR; a kernel made at run time takes only what this processor uses.
PORTABLE = BASELINE + WIDE
#: All of them by name.
BY_TAG = {i.tag: i for i in PORTABLE + SCALAR}
