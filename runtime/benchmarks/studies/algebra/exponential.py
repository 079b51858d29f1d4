"""exp of the bivectors of motions, beside the textbook's form and `clifford`."""

from __future__ import annotations

from ...harness.algebras import cga3d
from . import exponentials, precise


def series(m: exponentials.Motions) -> list[object]:
    """The series with 50 digits."""
    return [precise.exponential(b) for b in precise.multivectors(cga3d.kind(m.bivector_kind), m.bivectors)]


STUDY = exponentials.study(
    "exp",
    name="exponential",
    title="The exponential of a motion's bivector",
    # the series with 50 digits
    reference=lambda m: [
        precise.exponential(b) for b in precise.multivectors(cga3d.kind(m.bivector_kind), m.bivectors)
    ],
    error=exponentials.exp_error,
    source="thesis 6.2 and 2.5; Stumpff functions: docs/algebra/elementary.md",
)
