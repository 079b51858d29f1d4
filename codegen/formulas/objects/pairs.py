"""Point pairs by their middle and the half vector to their second end.

A short pair's half vector has digits of its own, which the difference of two end points has lost where these are
rounded.
"""

from __future__ import annotations

from ..multivector import Multivector
from ..status import Status
from ..trace import Result, named
from .conformal import infinity, point, round_center
from .euclidean import direction_of
from .outcome import only_if, outcome


def pair_about(middle: Multivector, half: Multivector) -> tuple[Multivector, Result]:
    """The unit pair A ^ B with A = middle - half, B = middle + half. SINGULAR: the half is zero.

    With M the point in the middle and h the half, A ^ B = 2 (M + h^2/2 n_inf) ^ (h + (h . M) n_inf).
    """
    h, scale = direction_of(half)
    ni = infinity(half)
    dual_sphere = point(middle) * scale + ni / (2 * scale)  # over |h|
    return dual_sphere ^ (h + (h | middle) * ni), outcome(half, (~(scale > 0), Status.SINGULAR))


def pair_middle_half(pair: Multivector) -> tuple[Result, Result, Result]:
    """Middle and half vector of a unit point pair. SINGULAR: it is a flat point."""
    middle, along, regular = round_center(pair)
    half = along / only_if(regular, (along * along).grade(0))
    return named("middle", middle), named("half", half), outcome(pair, (~regular, Status.SINGULAR))
