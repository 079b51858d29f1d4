"""Where the parts of merging's state are: what the algorithms share with their callers. Constants alone."""

from __future__ import annotations

#: Where the parts of a landmark begin, behind the position; of flats and points this is all:
DIRECTION = 3
CURVATURE = 6
FLAT_MARKS = 7
#: Of rounds, and flats among them: position and curvature of the inverse, N, the coefficients on the orthonormal basis.
INVERSE = 7
INVERSE_CURVATURE = 10
NORM = 11
COEFFICIENTS = 12

#: Columns of slots: how often the object has changed, -1 if it is gone; its place in the tree's order, and its leaf;
VERSION, PLACE, LEAF = range(3)
#: the slot of its nearest object, -1 for none, and the version that this had; its place in the queue, -1 for none.
NEAREST, SEEN, QUEUED = range(3, 6)
SLOT = 6
#: Columns of nodes: objects that are left; the places in the tree's order that are below.
ALIVE, BEGIN, END = range(3)
NODE = 3
#: Counts: objects that the tree was built over, its leaves;
BUILT, LEAVES = range(2)
#: objects that are left, slots in the queue, merges, costs that were computed.
LIVE, WAITING, MERGES, EVALUATIONS = range(2, 6)
COUNTS = 6
#: Limits: the greatest cost of a pair that is merged; the rounding of positions, as a length.
THRESHOLD, SLACK = range(2)

#: Objects of a leaf, at most.
LEAF_SIZE = 12
#: Levels of any tree.
DEEPEST = 40
