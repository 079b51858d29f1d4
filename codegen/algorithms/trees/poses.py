"""Trees of links: poses of all links, by recursion over the joints.

Rotors and positions as in chains: positions are relative to a base, joints are given where all coordinates are zero.
"""

from __future__ import annotations

from typing import Any

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import Ints, Out, Reals, Rows, Vector, empty
from ..chain_records import Frame, Joint
from ..chains import advance_algorithm


def pose_algorithm(k: Any, identity: tuple[float, ...], room: int) -> algorithm:
    """The algorithm of poses, for trees of up to ``room`` joints.

    Parameters
    ----------
    k : ChainKernels
    identity : tuple of float
        The rotor 1.
    room : int
    """
    advance = advance_algorithm(k)

    @algorithm
    def poses(
        joints: Rows[Joint], parents: Ints, coordinates: Ints, frames: Rows[Frame], carriers: Ints, base: Vector[3],
        x: Reals, motors: Out[Rows[8]],
    ) -> None:  # fmt: skip
        """Motors of frames that joints carry, each moved by one of the coordinates; -1 is the root."""
        rotors = empty(room, 4)
        positions = empty(room, 3)
        q = empty(4)
        p = empty(3)
        frame_q = empty(4)
        frame_p = empty(3)
        for j in range(len(joints)):
            i = parents[j]
            if i >= 0:
                q[:] = rotors[i]
                p[:] = positions[i]
            else:
                q[:] = identity
                p[:] = (0.0, 0.0, 0.0)
            advance(q, p, joints[j], x[coordinates[j]])
            rotors[j][:] = q
            positions[j][:] = p
        for f in range(len(frames)):
            frame = frames[f]
            i = carriers[f]
            if i >= 0:
                frame_q[:], frame_p[:] = k.frame_pose(rotors[i], positions[i], frame.position, frame.rotor)
            else:
                frame_q[:] = frame.rotor
                frame_p[:] = frame.position
            motors[f][:] = k.compose(frame_q, frame_p, base)

    return poses
