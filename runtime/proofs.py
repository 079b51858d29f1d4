"""What is known of results: kinds proved at random exact points of their operands' kinds (no rules, no rounding).

A proof costs some milliseconds and is made once for each combination of kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from .codegen.algebra import Algebra as Mathematics
from .codegen.kinds import Kind, LaneSource
from .codegen.multivector import Multivector
from .codegen.rings import LaneRing

if TYPE_CHECKING:
    from .algebras import Algebra

#: Exact points per proof, as the code generator draws them where there are no roots.
LANES = 16
SEED = 20260101
#: Products of larger operands are not tried at points: their structure has to do.
MAX_TERMS = 4096


def member(kind: Kind, place: int) -> Multivector:
    """A random exact member for operand ``place``."""
    return _member(kind.algebra, kind, place)


@lru_cache(maxsize=256)
def _member(_: Mathematics, kind: Kind, place: int) -> Multivector:
    """The algebra is a key: kinds of two algebras of one name are equal."""
    return kind.sample(LaneSource(_RING, SEED + place))


_RING = LaneRing(LANES)


def result_kind(algebra: Algebra, formula: Callable[..., Any], kinds: Sequence[Kind]) -> Kind:
    """The narrowest kind of the algebra that a formula's value provably belongs to, else the layout of its blades.

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
        and kind.violated(value) is None
    ]
    best = min(fitting, key=lambda kind: (kind.size, -len(kind.constraints)), default=None)
    return best or algebra.layout_of(own)


def belongs(kind: Kind, to: Kind) -> bool:
    """Whether every member of ``kind`` is provably a member of ``to``."""
    if not set(kind.blades) <= set(to.blades):
        return False
    if not to.constraints:
        return True
    return bool(kind.constraints) and _belongs(kind.algebra, kind, to)


@lru_cache(maxsize=1024)
def _belongs(_: Mathematics, kind: Kind, to: Kind) -> bool:
    return to.violated(member(kind, 0)) is None
