"""Serial chains: what their algorithms take."""

from __future__ import annotations

from typing import Any

from ..ir.loops.language import Real, Vector
from ..ir.loops.records import record

#: A joint: offset from the joint before, axis, rotation and advance for a unit of its coordinate.
Joint: Any = record("Joint", offset=Vector[3], axis=Vector[3], rotation=Real, advance=Real)
#: A frame of a link: position relative to the joint, and rotor.
Frame: Any = record("Frame", position=Vector[3], rotor=Vector[4])
#: A pose to reach, relative to the first joint.
Goal: Any = record("Goal", rotor=Vector[4], position=Vector[3])
#: A search: what of a rotation in radians, and of a distance in units of length, may remain; the length that counts as
#: a radian; and the largest distance from the first joint, infinite if it is not known.
Search: Any = record("Search", tolerance=Real, length=Real, reach=Real)
