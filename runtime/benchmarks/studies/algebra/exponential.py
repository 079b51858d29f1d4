"""exp of the bivectors of motions, beside the textbook's form and `clifford`."""

from __future__ import annotations

from typing import Any

from ..study import Study
from . import exponentials, precise


def truth(m: exponentials.Motions) -> list[Any]:
    """The series with 50 digits."""
    from ... import cga3d

    return [precise.exponential(b) for b in precise.multivectors(cga3d.kind(m.bivector_kind), m.bivectors)]


STUDY = Study(
    name="exponential",
    title="The exponential of a motion's bivector",
    methods=exponentials.methods("exp", exponentials.textbook_exp),
    cases=exponentials.CASES,
    reference=truth,
    error=exponentials.exp_error,
    unit="of the rotor's largest coefficient",
    count=100,
    answer=exponentials.in_words("exp"),
    copies=exponentials.COPIES,
    source="thesis 6.2 and 2.5; Stumpff functions: docs/elementary.md",
)
