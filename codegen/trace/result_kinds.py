"""Kinds of results, proved at random exact points of their operands' kinds (no rules, no rounding).

A proof costs some milliseconds. The generator makes those of the products that its kernels serve, and writes them to
the manifest; the runtime makes the others, once for each combination of kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

from ..algebra.algebra import Algebra, Kind
from ..algebra.members import SampleSource, sample, violation
from ..algebra.multivector import Multivector
from ..rings.protocol import SampleRing

#: Exact points per proof, as the code generator draws them where there are no roots.
SAMPLES = 16
SEED = 20260101
_RING = SampleRing(SAMPLES)


def member(kind: Kind, index: int) -> Multivector:
    """A random exact member for operand ``index``."""
    return _member(kind.algebra, kind, index)


@lru_cache(maxsize=256)
def _member(_: Algebra, kind: Kind, index: int) -> Multivector:
    """The algebra is a key: kinds of two algebras of one name are equal."""
    return sample(kind, SampleSource(_RING, SEED + index))


def result_blades(
    algebra: Algebra, formula: Callable[..., Any], kinds: Sequence[Kind]
) -> tuple[Kind | None, tuple[int, ...]]:
    """The narrowest constrained kind that a formula's value provably belongs to, and the value's own blades.

    The formula may use sums and products only.
    """
    value = formula(*(member(kind, i) for i, kind in enumerate(kinds)))
    own = tuple(value.terms) or (0,)
    fitting = [
        kind
        for kind in algebra.kinds.values()
        if kind.constraints
        and set(own) <= set(kind.blades)
        and kind.size <= 2 * len(own)
        and violation(kind, value) is None
    ]
    return min(fitting, key=lambda kind: (kind.size, -len(kind.constraints)), default=None), own


def belongs(kind: Kind, to: Kind) -> bool:
    """Return whether every member of ``kind`` is provably a member of ``to``."""
    if not set(kind.blades) <= set(to.blades):
        return False
    if not to.constraints:
        return True
    return bool(kind.constraints) and _belongs(kind.algebra, kind, to)


@lru_cache(maxsize=1024)
def _belongs(_: Algebra, kind: Kind, to: Kind) -> bool:
    return violation(to, member(kind, 0)) is None


def operand_kinds_served(kind: Kind, operation: str, index: int) -> list[Kind]:
    """Kinds of operands that the runtime gives to the kernel of a product on ``kind``.

    For a layout all kinds on its blades; for the rotor of a sandwich also those whose members are all members of it.
    """
    kinds = kind.algebra.kinds.values()
    if kind.is_layout:
        return [kind, *(k for k in kinds if k.constraints and k.blades == kind.blades)]
    held = operation == "sandwich" and index == 0
    return [kind, *(k for k in kinds if held and k != kind and k.constraints and belongs(k, kind))]
