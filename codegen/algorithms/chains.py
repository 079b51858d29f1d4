"""Serial chains: loops over joints, of poses, Jacobians and twists.

A pose of a frame is a rotor q and the position p of its origin, as formulas/mechanics/chains.py has it; positions are
relative to the first joint. Joints, frames and options are data: one text serves all chains of an algebra.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import InOut, Int, Matrix, Out, Real, Reals, Rows, Vector, empty, zeros
from .chain_frames import JacobianFrame
from .chain_records import Frame, Joint
from .chain_search import search_algorithm


class ChainKernels(NamedTuple):
    """The formulas of formulas/mechanics/chains.py that the loops call, for one algebra."""

    joint_position: Any
    rotate: Any
    link_direction: Any
    frame_pose: Any
    compose: Any
    unit_twist: Any
    column: Any
    body_column: Any
    link_twist: Any
    decompose: Any
    pose_error: Any


class ChainAlgorithms(NamedTuple):
    """Loops over the joints of a chain, for one item."""

    forward: algorithm
    jacobian: algorithm
    twists: algorithm
    inverse: algorithm


def advance_algorithm(k: Any) -> algorithm:
    """The step from joint to joint, of chains and trees.

    Parameters
    ----------
    k : ChainKernels
    """

    @algorithm
    def advance(q: InOut[Vector[4]], p: InOut[Vector[3]], joint: Joint, x: Real) -> None:
        """Move a pose on to the next joint: the pose behind it."""
        p[:] = k.joint_position(q, p, joint.offset, joint.axis, joint.advance * x)
        if joint.rotation != 0.0:
            q[:] = k.rotate(q, joint.axis, joint.rotation * x)

    return advance


def chain_algorithms(k: ChainKernels, identity: tuple[float, ...], room: int) -> ChainAlgorithms:
    """The algorithms of chains of up to ``room`` joints.

    Parameters
    ----------
    k : ChainKernels
    identity : tuple of float
        The rotor 1.
    room : int
    """

    advance = advance_algorithm(k)

    @algorithm
    def forward(joints: Rows[Joint], frames: Rows[Frame], base: Vector[3], x: Reals, motors: Out[Rows[8]]) -> None:
        """Motors of the frames of the last links, as many as there are frames."""
        q = empty(4)
        p = zeros(3)
        q[:] = identity
        frame_q = empty(4)
        frame_p = empty(3)
        first = len(joints) - len(frames)
        for j in range(len(joints)):
            advance(q, p, joints[j], x[j])
            if j >= first:
                frame = frames[j - first]
                frame_q[:], frame_p[:] = k.frame_pose(q, p, frame.position, frame.rotor)
                motors[j - first][:] = k.compose(frame_q, frame_p, base)

    @algorithm
    def joint_axes(
        joints: Rows[Joint], tool: Frame, x: Reals, axes: Out[Matrix], positions: Out[Matrix],
        tool_q: Out[Vector[4]], tool_p: Out[Vector[3]],
    ) -> None:  # fmt: skip
        """Axis and position of each joint, and the pose of the tool."""
        q = empty(4)
        p = zeros(3)
        q[:] = identity
        for j in range(len(joints)):
            joint = joints[j]
            axes[j][:] = k.link_direction(q, joint.axis)
            advance(q, p, joint, x[j])
            positions[j][:] = p
        tool_q[:], tool_p[:] = k.frame_pose(q, p, tool.position, tool.rotor)

    @algorithm
    def jacobian(
        joints: Rows[Joint], tool: Frame, base: Vector[3], frame: Int, point: Vector[3], x: Reals,
        matrix: Out[Reals],
    ) -> None:  # fmt: skip
        """Matrix of six rows and a column for each joint: angular velocity and velocity."""
        axes = empty(room, 3)
        positions = empty(room, 3)
        q = empty(4)
        p = empty(3)
        column = empty(6)
        reference = empty(3)
        n = len(joints)
        joint_axes(joints, tool, x, axes, positions, q, p)
        if frame == JacobianFrame.ORIGIN:
            for i in range(3):
                reference[i] = -base[i]
        else:
            reference[:] = k.joint_position(q, p, point, (0.0, 0.0, 0.0), 0.0)
        for j in range(n):
            joint = joints[j]
            if frame == JacobianFrame.TOOL:
                column[:] = k.body_column(q, axes[j], positions[j], reference, joint.rotation, joint.advance)
            else:
                column[:] = k.column(axes[j], positions[j], reference, joint.rotation, joint.advance)
            for r in range(6):
                matrix[n * r + j] = column[r]

    @algorithm
    def twists(
        joints: Rows[Joint], base: Vector[3], x: Reals, speeds: Reals, accelerations: Reals,
        velocities: Out[Rows[6]], rates: Out[Rows[6]],
    ) -> None:  # fmt: skip
        """Twists of the last links and their rates, as many as there is room for."""
        q = empty(4)
        p = zeros(3)
        q[:] = identity
        position = empty(3)
        omega = zeros(6)
        rate = zeros(6)
        first = len(joints) - len(velocities)
        for j in range(len(joints)):
            joint = joints[j]
            axis = k.link_direction(q, joint.axis)
            advance(q, p, joint, x[j])
            for i in range(3):
                position[i] = p[i] + base[i]
            twist = k.unit_twist(axis, position, joint.rotation, joint.advance)
            omega[:], rate[:] = k.link_twist(omega, rate, twist, speeds[j], accelerations[j])
            if j >= first:
                velocities[j - first][:] = omega
                rates[j - first][:] = rate

    inverse = search_algorithm(k, joint_axes, room)
    return ChainAlgorithms(forward, jacobian, twists, inverse)
