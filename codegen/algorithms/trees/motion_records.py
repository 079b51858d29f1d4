"""Motion of trees of links in the coordinates of their joints: what its algorithms take.

A state has n coordinates, then n speeds. Joints have one freedom each; a ball is three of them with no mass between,
about axes that are the world's at the start. Its coordinates are a rotation vector from a reference that moves on with
each step, and its speeds are the angular velocity along the link's axes.
"""

from __future__ import annotations

from typing import Any

from ...ir.loops.language import Int, Real, Vector
from ...ir.loops.records import record
from ..dynamics.records import LAW_NUMBERS, Iteration

#: What of a joint's coordinate is special: nothing; that it is the second or third of a ball. Of the first of a ball it
#: is the ball's number.
PLAIN, IN_BALL = -1, -2
#: A link while accelerations are computed: its frame relative to its parent; its twist, what its rate is besides joint
#: accelerations, its rate; articulated inertia and bias; momentum of the joint's unit twist, and the inverse of what
#: the joint feels; what is left for it to accelerate, and the force on it; rounding of its acceleration; its pose.
#: Beside these: forces of loops on the link and along its joint, what is left of them there, and what they do to both.
LinkWork: Any = record(
    "LinkWork", turn=Vector[9], displacement=Vector[3], omega=Vector[6], drift=Vector[6], rate=Vector[6],
    inertia=Vector[21], bias=Vector[6], momentum=Vector[6], compliance=Real, left=Real, force=Real, blur=Real,
    rotor=Vector[4], position=Vector[3], push=Vector[6], given=Real, pushed=Real, response=Vector[6], answer=Real,
)  # fmt: skip
#: A joint that closes a loop: its place in the frames of both links, which are parallel at the start, its axis, and
#: which rotations it forbids (see loops.py).
Loop: Any = record("Loop", point=Vector[3], other_point=Vector[3], axis=Vector[3], rotations=Real)
#: A row of a loop, rotations and translations along axes of its first link; or of a coupling, two factors of speeds.
#: Its integers are: kind, links (-1: the world) or joints, the loop, and two ranges of links that it pushes.
LoopRow: Any = record("LoopRow", angular=Vector[3], linear=Vector[3])
#: A row while accelerations are computed: its wrench in the world, its error, the rate of that, what the rate's rate is
#: without multipliers; what is wanted of a correction, the multiplier, and its change in a round. Of the first row also
#: how many rows depend on others, nearly, and how much all of them do.
RowWork: Any = record(
    "RowWork", wrench=Vector[6], error=Real, rate=Real, right=Real, wanted=Real, multiplier=Real, change=Real,
    soft=Real, depth=Real,
)  # fmt: skip
#: A body that a link carries: mass, first moment and tensor as of `Link`, center of mass, constant wrenches of the body
#: and of the world, numbers of laws of loads, and its own frame, all in the frame of the link but the world's wrench.
TreeBody: Any = record(
    "TreeBody", mass=Real, moment=Vector[3], tensor=Vector[6], center=Vector[3], wrench=Vector[6], world=Vector[6],
    laws=Vector[LAW_NUMBERS], position=Vector[3], rotor=Vector[4],
)  # fmt: skip
#: Springs, dampers, friction and limits of a joint: see `formulas.mechanics.joint_laws`.
JointLaw: Any = record(
    "JointLaw", stiffness=Real, rest=Real, damping=Real, friction=Real, slip=Real, lower=Real, upper=Real,
    stop_stiffness=Real, stop_damping=Real,
)  # fmt: skip
#: Tolerances, the step of schemes with a fixed one, and the length that counts as a radian.
Settings: Any = record("Settings", rtol=Real, atol=Real, longest_step=Real, length=Real)
#: Whether there are wrenches of the world, laws of bodies, laws of joints, and whether loads need poses; of the scheme
#: whether it chooses its steps, and its sizes: see `WorkRecords` of algorithms/dynamics.
Options: Any = record(
    "Options", world=Int, laws=Int, joint_laws=Int, poses=Int, adapts=Int, stages=Int, all_stages=Int, dense_rows=Int,
    method_order=Int,
)  # fmt: skip
#: What a simulation keeps between calls, besides its state: as `kept_record` of algorithms/dynamics has it; of loops
#: how many rows depended on others at the start, how much they did at most, and what `Reached` tells of that. Of
#: implicit steps the speed, in units a second, below which one counts as none, how many steps of the least length
#: follow each other, and what collocated.py keeps.
KeptMotion: Any = record(
    "KeptMotion", time=Real, next_step=Real, dense_time=Real, dense_step=Real, has_dense=Real, least_time=Real,
    watched=Vector[3], soft=Real, depth=Real, singular=Vector[2], pace=Real, least_steps=Real,
    iteration=Iteration,
)  # fmt: skip
