"""Trees of links: what their algorithms take besides the joints of chains."""

from __future__ import annotations

from typing import Any

from ...ir.loops.language import Real, Vector
from ...ir.loops.records import record

#: A link: mass, first moment and tensor (xx, xy, xz, yy, yz, zz) about the origin of its frame, along the axes that are
#: parallel to the root's where all joints are at zero.
Link: Any = record("Link", mass=Real, moment=Vector[3], tensor=Vector[6])
#: What displaces the link of a joint: its coordinate; a frame, position and rotor; nothing beyond the joint before.
COORDINATE, FRAME, SAME = 0, 1, 2
