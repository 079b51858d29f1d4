"""Layouts of a scene: materials, lights and camera, and what the loops over rays keep; C and NumPy read them from here.

A scene is two flat arrays, of integers and of real numbers. The integers begin with a `SCENE`, which says where all
else begins in both, and a `TABLE` for each kind of surface that the program has.
"""

from __future__ import annotations

from typing import Any

from ...ir.loops.language import Int, Matrix, Real, Vector
from ...ir.loops.records import record

#: What a surface looks like; the color of the other squares of a checkered one, and two vectors that count squares.
MATERIAL: Any = record(
    "Material", color=Vector[3], ambient=Real, diffuse=Real, specular=Real, shininess=Real, reflectivity=Real,
    second=Vector[3], across=Matrix[2, 3],
)  # fmt: skip
#: A point light.
LIGHT: Any = record("Light", position=Vector[3], color=Vector[3])
#: Motor of the camera; focal length, width and height of the image plane.
CAMERA: Any = record("Camera", motor=Vector[8], lens=Vector[3])
#: Colors of the horizon and of the zenith.
SKY: Any = record("Sky", horizon=Vector[3], zenith=Vector[3])
#: At the beginning of the real numbers: largest absolute coordinate of a box, and the box around all.
BOUNDS: Any = record("Bounds", reach=Real, whole=Vector[6])

#: Numbers of lights, of reflections that are followed, of rays along each side of a pixel; how roots of rays and
#: evolved surfaces are found, and samples of the sampled method. Then where materials, lights, camera and sky begin
#: among the real numbers. Of the tree: items, kind and row of each; the first that has no box and is always asked;
#: their place; nodes, and where C has them, or other targets boxes (real) and parts.
SCENE: Any = record(
    "Scene", lights=Int, depth=Int, grid=Int, method=Int, samples=Int,
    materials_at=Int, lights_at=Int, camera_at=Int, sky_at=Int,
    items=Int, unbounded=Int, items_at=Int, nodes=Int, tree_at=Int, boxes_at=Int, parts_at=Int,
)  # fmt: skip
#: Rows of a kind of surface; where their constants and boxes begin, six numbers each, and their surfaces' places in the
#: scene's list.
TABLE: Any = record("Table", rows=Int, constants_at=Int, boxes_at=Int, ids_at=Int)

#: A ray.
RAY: Any = record("Ray", origin=Vector[3], direction=Vector[3])
#: A point on a ray, t in units of its direction. Parameter of the surface's curve, where it has one, and of its piece
#: from 0 to 1; the point in the world, and in the surface's own frame.
HIT: Any = record("Hit", t=Real, alpha=Real, at=Real, point=Vector[3], local=Vector[3])
#: What is looked for: points with t_min < t < t_max. Then where the nearest row begins that said that the ray is
#: singular, or invalid; the largest number if none did.
SEARCH: Any = record("Search", t_min=Real, t_max=Real, singular=Real, invalid=Real)
#: Room for hits: with room for one it is the nearest, and t_max falls. Of points at the same t that of the lowest
#: surface number counts, and of one surface that of the lowest row, in whatever order they are asked. Hits so far; kind
#: and row that is asked, and of the hit; how roots are found; status of the row that is asked; rows and boxes that were
#: asked.
STATE: Any = record(
    "State", room=Int, count=Int, kind=Int, index=Int, hit_kind=Int, hit_index=Int, method=Int, samples=Int, status=Int,
    cost=Int,
)  # fmt: skip
#: All points of a line so far, and 1 where one of them is too far away for a number: nothing is told of that line.
GATHERED: Any = record("Gathered", total=Int, lost=Int)
#: A picture, or a band of its pixels: size of the whole, and the pixel that the arrays begin with, in reading order.
#: Then which layers are asked for: color is `COLOR`, or `LEFT_OVER` of pixels whose color is no number yet.
PICTURE: Any = record(
    "Picture", width=Int, height=Int, first=Int, color=Int, normal=Int, depth=Int, alpha=Int, cost=Int
)
COLOR, LEFT_OVER = 1, 2
#: Status of a ray of several that is left to the search of single rays.
DEFERRED = 255

#: Pairs of numbers between which a piece of a curve is real.
SPANS = 4
#: What rows of pieces of curves begin with: center of the piece's frame, in the world, length of its unit, and one over
#: it; parameter of the curve where the piece begins, and how long it is there; center and radius of a sphere around the
#: surface, in the frame; spans of the piece's parameter where it is real.
PIECE: Any = record(
    "Piece", center=Vector[3], unit=Real, inverse=Real, start=Real, length=Real, bound=Vector[4],
    spans=Vector[2 * SPANS],
)  # fmt: skip
#: What a surface's parameters begin with: the same without the sphere. Its controls follow.
GIVEN = PIECE.size - PIECE.shapes["bound"][0]
#: The tree over boxes: parts of a node, what stands where there is none, and levels that it has at most.
PARTS, NO_PART, LEVELS = 4, -(2**31), 48
#: Nodes that wait while others are searched: all but one of each level's, and all of one more.
WAITING_NODES = (LEVELS + 1) * PARTS
#: Integers of a ray on its way through the tree: C has a structure there.
TRAVERSAL = WAITING_NODES + 32

_LAYOUTS = {
    "BS_BOUNDS": BOUNDS, "BS_LAYOUT": SCENE, "BS_TABLE": TABLE, "BS_RAY": RAY, "BS_HIT": HIT, "BS_SEARCH": SEARCH,
    "BS_STATE": STATE,
}  # fmt: skip
_TREE = f"BS_PARTS = {PARTS}, BS_NO_PART = -2147483647 - 1, BS_TREE_STACK = {WAITING_NODES}"
#: What C reads of them.
C_TEXT = "".join(layout.c_text(prefix) for prefix, layout in _LAYOUTS.items()) + f"/* Tree */\nenum {{ {_TREE} }};\n"
