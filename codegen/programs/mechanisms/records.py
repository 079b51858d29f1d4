"""Tables of a mechanism: what its algorithms take beside its numbers.

Offsets are places in the mechanism's numbers: of twists (f, 6) that a joint leaves, rows (m, 6) of what it forbids.
"""

from __future__ import annotations

from typing import Any

from ...ir.loops.language import Int, Real
from ...ir.loops.records import record

#: A body, its place among those of an item, and the joint towards its parent, -1: the fixed body; parents come first.
#: Its columns: the first, and how many; offset of their twists in its parent's frame. What the joint forbids: how many
#: rows, offsets of the inverse (6, m) of its rows and of its values (m); its objects: the first, and how many. Whether
#: bodies have it as a parent.
Link: Any = record(
    "Link", body=Int, parent=Int, first=Int, count=Int, free=Int, rows=Int, inverse=Int, values=Int, object=Int,
    objects=Int, bears=Int,
)  # fmt: skip
#: A coordinate that is given: its column and its link; offset of the row (6) that measures it in a displacement, or
#: -1 where not coordinates are given but displacements; whether it is the same after a whole turn; its place among the
#: inputs of a Jacobian, and the offset of the factor of what it is given in.
Driven: Any = record("Driven", column=Int, link=Int, measure=Int, turns=Int, place=Int, unit=Int)
#: An object that the bodies of a joint share: index of its layout, coefficients, their offset, and that of the
#: object's part (m, coefficients) of the joint's rows.
Shared: Any = record("Shared", layout=Int, length=Int, offset=Int, part=Int)
#: A joint that closes a loop: its bodies, -1: the fixed one; its first row, and how many; their offset, or -1 where
#: they change with the pose; that of its values (m); its objects.
Cut: Any = record("Cut", a=Int, b=Int, first=Int, rows=Int, matrix=Int, values=Int, object=Int, objects=Int)
#: A pose or a position that a body is to have: the body, its first row, and how many (6 or 3); offsets of the point,
#: in the mechanism's numbers, and of what it is to be, in those of an item.
Target: Any = record("Target", body=Int, first=Int, rows=Int, point=Int, goal=Int)
#: Rows of a cut or target: the first, and how many; steps of its path, the first, and how many.
Loop: Any = record("Loop", first=Int, rows=Int, step=Int, steps=Int)
#: A link on the path around a loop, and 1 or -1.
PathStep: Any = record("PathStep", link=Int, sign=Int)
#: Columns of a link are eliminated from some rows, which have some other columns, too: the first column, and how
#: many; of rows and of other columns the offset in the list of indices, and how many.
Elimination: Any = record("Elimination", first=Int, count=Int, row=Int, rows=Int, other=Int, others=Int)
#: Rows and columns of a mechanism, rows of its cuts alone, numbers of all targets of an item, speeds of targets that
#: are inputs, the offset of what they give the targets' rows, rows of Jacobians.
Sizes: Any = record("Sizes", rows=Int, columns=Int, cuts=Int, goals=Int, speeds=Int, right=Int, outputs=Int)
#: Independent fraction of a row below which it is redundant; of a unit speed, what counts as rounding; length of a
#: step at most, in radians and in the mechanism's unit; errors that are zero; and errors that are rounding once they
#: decrease no more.
Tolerances: Any = record("Tolerances", redundant=Real, open=Real, step=Real, closed=Real, nearly=Real)
#: A requested speed: that of a column, one row, times the number at the offset ``map``; or, where this is -1, the twist
#: of a body by the steps of its path, six rows, by the matrix there, or three, the velocity of a point: its place and
#: the unit of length are among the points of a call, at that offset. Its first row, and how many.
Output: Any = record("Output", row=Int, rows=Int, column=Int, body=Int, map=Int, step=Int, steps=Int)
