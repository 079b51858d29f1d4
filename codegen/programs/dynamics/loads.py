"""Loads of one body that a formula gives: the formula, and where its arguments are; those of `formulas.mechanics.laws`
are declared there alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ...algorithms.dynamics.records import LAW_NUMBERS, LawPlace
from ...errors import TraceError
from ...formulas.mechanics import mechanics
from ...formulas.mechanics.laws import LAWS
from ...trace.kernel import argument_names
from ...trace.rows import annotation

#: A body's state: what arguments of these names are.
STATE = ("motor", "twist")
#: The same in the laws.
_OF_STATE = {"r": "motor", "omega": "twist"}


class BodyLoad(NamedTuple):
    """A load of one body.

    Attributes
    ----------
    formula : callable
        From numbers and the body's state to a row of the wrench.
    kinds : str
        Of its arguments.
    arguments : tuple of str
        The body's state, ``motor`` or ``twist``, or a field of the record `Body`, such as ``center`` or ``laws[1]``.
    """

    formula: Callable[..., Any]
    kinds: str
    arguments: tuple[str, ...]


def _place_laws() -> dict[str, LawPlace]:
    found: dict[str, LawPlace] = {}
    first = 0
    for law in LAWS:
        *state, _, numbers = argument_names(law.formula)
        count = len(annotation(law.formula, numbers)._fields)
        has_motor, has_twist = (name in state for name in _OF_STATE)
        found[law.formula.__name__] = LawPlace(law.formula.__name__, first, first + count, has_motor, has_twist)
        first += count
    if first > LAW_NUMBERS:
        raise TraceError(f"laws of loads have {first} numbers.", remedy=f"Raise LAW_NUMBERS, which is {LAW_NUMBERS}")
    return found


#: Where the numbers of laws are in the field ``laws`` of bodies, and what else they take, by their names.
LAW_PLACES = _place_laws()
#: Those whose motions have Taylor series.
ANALYTIC_LAWS = frozenset(law.formula.__name__ for law in LAWS if law.is_analytic)


def _law_load(formula: Callable[..., Any]) -> BodyLoad:
    place = LAW_PLACES[formula.__name__]
    state = [name for name, has in zip(STATE, (place.has_motor, place.has_twist), strict=True) if has]
    kinds = [*state, "position", f"numbers{place.last - place.first}"]
    return BodyLoad(formula, ", ".join(kinds), (*state, "center", f"laws[{place.first}]"))


#: By the names of `LOADS`, in the order in which series add them up.
BODY_LOADS = {
    "gravity": BodyLoad(mechanics.pull, "motor, position, position", ("motor", "center", "weight")),
    "world_wrench": BodyLoad(mechanics.wrench_to_body, "motor, twist", ("motor", "world")),
    **{law.formula.__name__: _law_load(law.formula) for law in LAWS},
    "body_wrench": BodyLoad(mechanics.given_row, "numbers6", ("wrench",)),
}
