"""Rows of numbers that describe bodies and springs: simulations in C and NumPy read them by these names."""

from __future__ import annotations

from ...ir.loops.language import Matrix, Real, Vector
from ...ir.loops.records import record

#: A rigid body: diagonal of its mass matrix, the inverses and their roots; weight and where it acts, in the body;
#: constant wrenches of the world and of the body; angular and linear damping; the mass matrix and the inverse of what
#: pins allow of it; numbers of the flows of a free rotation; principal moments.
BODY = record(
    "Body", metric=Vector[6], inverse=Vector[6], roots=Vector[6], weight=Vector[3], center=Vector[3], world=Vector[6],
    wrench=Vector[6], drag=Vector[2], mass=Matrix[6, 6], compliance=Matrix[6, 6], flows=Vector[9], moments=Vector[3],
)  # fmt: skip
#: A spring: its ends, stiffness, length at rest, and damping.
SPRING = record("Spring", point=Vector[3], anchor=Vector[3], stiffness=Real, length=Real, damping=Real)
#: The fields of its two ends.
SPRING_ENDS = ("point", "anchor")

#: Their places in C.
C_TEXT = BODY.c_text("BS_BODY") + SPRING.c_text("BS_SPRING")
