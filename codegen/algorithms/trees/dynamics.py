"""Trees of links: inverse dynamics, mass matrix and forward dynamics by recursion over the joints.

Newton and Euler's equations from link to link, composite rigid bodies, and articulated bodies (Featherstone, Rigid Body
Dynamics Algorithms, 5.3, 6.2, 7.3). Links are numbered so that a parent comes before its children; the parent of a
link on the root is -1. Everything is in the frames of the links, so that no digits are lost with the length of a chain.

A joint with several freedoms (a ball, a root that floats) is as many joints one behind the other, of which the first is
displaced by a `Frame` among the coordinates, the others not at all, and only the last carries a link with an inertia.
Their axes are fixed in that link, so that speeds are components of its twist: the rate of the twist has v S x V of each
with the twist V of the link before all of them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Ints, Matrix, Out, Reals, Rows, Vector, empty, zeros
from ..chain_records import Joint
from .records import COORDINATE, FRAME, SAME, Link

UNIT = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class TreeKernels(NamedTuple):
    """The formulas of formulas/mechanics/articulated.py that the loops call, for one algebra."""

    joint_rotation: Any
    joint_displacement: Any
    frame_rotation: Any
    to_child: Any
    add_motion: Any
    add_velocity: Any
    link_motion: Any
    link_velocity: Any
    add_to_parent: Any
    joint_force: Any
    link_wrench: Any
    link_bias: Any
    joint_momentum: Any
    add_link: Any
    rigid_inertia: Any
    articulated_momentum: Any
    release: Any
    add_articulated: Any
    joint_acceleration: Any
    rest_rate: Any


class TreeAlgorithms(NamedTuple):
    """Loops over the joints of a tree, for one item."""

    inverse_dynamics: algorithm
    mass_matrix: algorithm
    forward_dynamics: algorithm


def tree_algorithms(k: TreeKernels, room: int, has_frames: bool) -> TreeAlgorithms:
    """The algorithms of trees of up to ``room`` joints.

    Parameters
    ----------
    k : TreeKernels
    room : int
    has_frames : bool
        Whether joints may be displaced by frames; otherwise each by the coordinate of its number.
    """

    @algorithm
    def place_links(
        joints: Rows[Joint], kinds: Ints, places: Ints, x: Reals, turns: Out[Matrix], displacements: Out[Matrix]
    ) -> None:
        """Rotation and displacement of each link, relative to its parent."""
        for j in range(len(joints)):
            joint = joints[j]
            i = places[j] if has_frames else j
            if has_frames and kinds[j] == FRAME:
                for r in range(3):
                    displacements[j, r] = joint.offset[r] + x[i + r]
                rotor = empty(4)
                for r in range(4):
                    rotor[r] = x[i + 3 + r]
                turns[j][:] = k.frame_rotation(rotor)
            elif has_frames and kinds[j] == SAME:
                displacements[j][:] = 0.0
                turns[j][:] = UNIT
            else:
                displacements[j][:] = k.joint_displacement(joint.offset, joint.axis, joint.advance * x[i])
                if joint.rotation != 0.0:
                    turns[j][:] = k.joint_rotation(joint.axis, joint.rotation * x[i])
                else:
                    turns[j][:] = UNIT

    @algorithm
    def inverse_dynamics(
        joints: Rows[Joint], links: Rows[Link], parents: Ints, kinds: Ints, places: Ints, gravity: Vector[3],
        x: Reals, speeds: Reals, accelerations: Reals, forces: Out[Reals],
    ) -> None:  # fmt: skip
        """Forces of the joints that a motion takes."""
        turns = empty(room, 9)
        displacements = empty(room, 3)
        omegas = empty(room, 6)
        rates = empty(room, 6)
        wrenches = empty(room, 6)
        if has_frames:
            before = zeros(6)
            carried = empty(6)
        nothing = zeros(6)
        n = len(joints)
        start = k.rest_rate(gravity)
        place_links(joints, kinds, places, x, turns, displacements)
        for j in range(n):
            joint = joints[j]
            link = links[j]
            i = parents[j]
            if has_frames and kinds[j] != COORDINATE:
                if has_frames and kinds[j] == SAME:
                    omegas[j][:] = omegas[i]
                    carried[:] = rates[i]
                else:
                    if i >= 0:
                        before[:] = k.to_child(turns[j], displacements[j], omegas[i])
                        carried[:] = k.to_child(turns[j], displacements[j], rates[i])
                    else:
                        before[:] = 0.0
                        carried[:] = k.to_child(turns[j], displacements[j], start)
                    omegas[j][:] = before
                omegas[j][:], rates[j][:] = k.add_motion(
                    joint.axis, joint.rotation, joint.advance, speeds[j], accelerations[j], before, omegas[j], carried
                )
            elif i >= 0:
                omegas[j][:], rates[j][:] = k.link_motion(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, speeds[j],
                    accelerations[j], omegas[i], rates[i],
                )  # fmt: skip
            else:
                omegas[j][:], rates[j][:] = k.link_motion(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, speeds[j],
                    accelerations[j], nothing, start,
                )  # fmt: skip
            wrenches[j][:] = k.link_wrench(link.mass, link.moment, link.tensor, omegas[j], rates[j])
        for j in range(n - 1, -1, -1):
            joint = joints[j]
            i = parents[j]
            forces[j] = k.joint_force(joint.axis, joint.rotation, joint.advance, wrenches[j])
            if has_frames and kinds[j] == SAME:
                wrenches[i][:] = wrenches[j]
            elif i >= 0:
                wrenches[i][:] = k.add_to_parent(turns[j], displacements[j], wrenches[j], wrenches[i])

    @algorithm
    def mass_matrix(
        joints: Rows[Joint], links: Rows[Link], parents: Ints, kinds: Ints, places: Ints, x: Reals, matrix: Out[Reals]
    ) -> None:
        """Forces of all joints for a unit of acceleration of each, row by row."""
        turns = empty(room, 9)
        displacements = empty(room, 3)
        masses = empty(room)
        moments = empty(room, 3)
        tensors = empty(room, 6)
        momentum = empty(6)
        nothing = zeros(6)
        n = len(joints)
        place_links(joints, kinds, places, x, turns, displacements)
        for j in range(n):
            link = links[j]
            masses[j] = link.mass
            moments[j][:] = link.moment
            tensors[j][:] = link.tensor
        for i in range(n * n):
            matrix[i] = 0.0
        for j in range(n - 1, -1, -1):
            joint = joints[j]
            momentum[:] = k.joint_momentum(masses[j], moments[j], tensors[j], joint.axis, joint.rotation, joint.advance)
            matrix[n * j + j] = k.joint_force(joint.axis, joint.rotation, joint.advance, momentum)
            i = j
            while parents[i] >= 0:
                if not has_frames or kinds[i] != SAME:
                    momentum[:] = k.add_to_parent(turns[i], displacements[i], momentum, nothing)
                i = parents[i]
                other = joints[i]
                entry = k.joint_force(other.axis, other.rotation, other.advance, momentum)
                matrix[n * i + j] = entry
                matrix[n * j + i] = entry
            i = parents[j]
            if has_frames and kinds[j] == SAME:
                masses[i] = masses[j]
                moments[i][:] = moments[j]
                tensors[i][:] = tensors[j]
            elif i >= 0:
                moments[i][:], tensors[i][:] = k.add_link(
                    turns[j], displacements[j], masses[j], moments[j], tensors[j], moments[i], tensors[i]
                )
                masses[i] += masses[j]

    @algorithm
    def forward_dynamics(
        joints: Rows[Joint], links: Rows[Link], parents: Ints, kinds: Ints, places: Ints, gravity: Vector[3],
        x: Reals, speeds: Reals, forces: Reals, accelerations: Out[Reals],
    ) -> None:  # fmt: skip
        """Accelerations of the joints under forces; not finite where a joint feels no inertia."""
        turns = empty(room, 9)
        displacements = empty(room, 3)
        omegas = empty(room, 6)
        drifts = empty(room, 6)
        inertias = empty(room, 21)
        biases = empty(room, 6)
        momenta = empty(room, 6)
        compliances = empty(room)
        left = empty(room)
        if has_frames:
            before = zeros(6)
        nothing = zeros(6)
        n = len(joints)
        start = k.rest_rate(gravity)
        place_links(joints, kinds, places, x, turns, displacements)
        for j in range(n):
            joint = joints[j]
            link = links[j]
            i = parents[j]
            if has_frames and kinds[j] != COORDINATE:
                if has_frames and kinds[j] == SAME:
                    omegas[j][:] = omegas[i]
                else:
                    before[:] = 0.0
                    if i >= 0:
                        before[:] = k.to_child(turns[j], displacements[j], omegas[i])
                    omegas[j][:] = before
                omegas[j][:], drifts[j][:] = k.add_velocity(
                    joint.axis, joint.rotation, joint.advance, speeds[j], before, omegas[j]
                )
            elif i >= 0:
                omegas[j][:], drifts[j][:] = k.link_velocity(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, speeds[j], omegas[i]
                )
            else:
                omegas[j][:], drifts[j][:] = k.link_velocity(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, speeds[j], nothing
                )
            inertias[j][:] = k.rigid_inertia(link.mass, link.moment, link.tensor)
            biases[j][:] = k.link_bias(link.mass, link.moment, link.tensor, omegas[j])
        for j in range(n - 1, -1, -1):
            joint = joints[j]
            i = parents[j]
            momenta[j][:], felt = k.articulated_momentum(inertias[j], joint.axis, joint.rotation, joint.advance)
            compliances[j] = 1.0 / felt
            bias = k.joint_force(joint.axis, joint.rotation, joint.advance, biases[j])
            left[j] = forces[j] - bias
            if i >= 0:
                inertias[j][:], biases[j][:] = k.release(
                    inertias[j], biases[j], drifts[j], momenta[j], compliances[j], left[j]
                )
                if has_frames and kinds[j] == SAME:
                    inertias[i][:] = inertias[j]
                    biases[i][:] = biases[j]
                else:
                    inertias[i][:] = k.add_articulated(turns[j], displacements[j], inertias[j], inertias[i])
                    biases[i][:] = k.add_to_parent(turns[j], displacements[j], biases[j], biases[i])
        for j in range(n):
            joint = joints[j]
            i = parents[j]
            # the twist of a link is no longer needed: its rate takes its place
            if i >= 0:
                accelerations[j], omegas[j][:] = k.joint_acceleration(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, drifts[j], momenta[j],
                    compliances[j], left[j], omegas[i],
                )  # fmt: skip
            else:
                accelerations[j], omegas[j][:] = k.joint_acceleration(
                    turns[j], displacements[j], joint.axis, joint.rotation, joint.advance, drifts[j], momenta[j],
                    compliances[j], left[j], start,
                )  # fmt: skip

    return TreeAlgorithms(inverse_dynamics, mass_matrix, forward_dynamics)
