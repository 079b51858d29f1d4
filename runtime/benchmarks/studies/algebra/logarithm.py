"""log of motors and of rotors with dilation, beside the textbook's acos and `clifford`."""

from __future__ import annotations

from ...harness.algebras import cga3d
from . import exponentials, precise

STUDY = exponentials.study(
    "log",
    name="logarithm",
    title="The logarithm of a rotor",
    # the rotors themselves: an answer is right if its exponential, with 50 digits, is the rotor
    reference=lambda m: precise.multivectors(cga3d.kind(m.rotor_kind), m.rotors),
    error=exponentials.log_error,
    source="thesis 2.5, 3.4; Dorst and Valkenburg, Square root and logarithm of rotors in 3D CGA (2011)",
    notes="The rotors are rounded to double precision, so half a unit in the last place of them is the least error.",
)
