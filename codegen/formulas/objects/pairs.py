"""Point pairs by their middle and the half vector to their second end.

A short pair's half vector has digits of its own, which the difference of two end points has lost where these are
rounded.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...status import Status
from ...trace.outputs import Result, named
from ..products.outcome import outcome, where_or_nan
from .conformal import pair_of, round_center


def pair_about(middle: Multivector, half: Multivector) -> tuple[Multivector, Result]:
    """The unit pair A ^ B with A = middle - half, B = middle + half. SINGULAR: the half is zero."""
    return pair_of(middle, half)


def pair_middle_half(pair: Multivector) -> tuple[Result, Result, Result]:
    """Middle and half vector of a unit point pair. SINGULAR: it is a flat point."""
    middle, along, regular = round_center(pair)
    half = along / where_or_nan(regular, (along * along).grade(0))
    return named("middle", middle), named("half", half), outcome(pair, (~regular, Status.SINGULAR))
