"""Rows of numbers that describe materials and lights: scenes in C and NumPy read them by these names."""

from __future__ import annotations

from ...ir.loops.language import Matrix, Real, Vector
from ...ir.loops.records import record

#: What a surface looks like; the color of the other squares of a checkered one, and two vectors that count squares.
MATERIAL = record(
    "Material", color=Vector[3], ambient=Real, diffuse=Real, specular=Real, shininess=Real, reflectivity=Real,
    second=Vector[3], across=Matrix[2, 3],
)  # fmt: skip
#: A point light.
LIGHT = record("Light", position=Vector[3], color=Vector[3])

#: Their places in C.
C_TEXT = MATERIAL.c_text("BS_MATERIAL") + LIGHT.c_text("BS_LIGHT")
