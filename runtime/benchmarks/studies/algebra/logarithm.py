"""log of motors and of rotors with dilation, beside the textbook's acos and `clifford`."""

from __future__ import annotations

from typing import Any

from ..study import Study
from . import exponentials, precise


def truth(m: exponentials.Motions) -> list[Any]:
    """The rotors themselves: an answer is right if its exponential, with 50 digits, is the rotor."""
    from ... import cga3d

    return precise.multivectors(cga3d.kind(m.rotor_kind), m.rotors)


STUDY = Study(
    name="logarithm",
    title="The logarithm of a rotor",
    methods=exponentials.methods("log", exponentials.textbook_log),
    cases=exponentials.CASES,
    reference=truth,
    error=exponentials.log_error,
    unit="of the rotor's largest coefficient",
    count=100,
    answer=exponentials.in_words("log"),
    copies=exponentials.COPIES,
    source="thesis 2.5, 3.4; Dorst and Valkenburg, Square root and logarithm of rotors in 3D CGA (2011)",
    notes="The rotors are rounded to double precision, so half a unit in the last place of them is the least error.",
)
