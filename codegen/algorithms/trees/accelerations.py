"""Motion of trees of links: accelerations of the joints under loads, and the states of the bodies that links carry.

Articulated bodies, as `forward_dynamics` of dynamics.py, for any number of links: what each needs is in the caller's
memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import (
    InOut,
    Int,
    IntRows,
    Ints,
    Out,
    Reals,
    Rows,
    Vector,
    empty,
    epsilon,
    zeros,
)
from ..chain_records import Joint
from ..chains import advance_algorithm
from ..dynamics.records import Spring
from .dynamics import UNIT
from .motion_records import PLAIN, JointLaw, LinkWork, Options, TreeBody
from .records import Link

ORIGIN = (0.0, 0.0, 0.0)


class MotionAlgorithms(NamedTuple):
    """Accelerations and states of a tree.

    Attributes
    ----------
    find_rates : algorithm
        Rates of coordinates and speeds.
    observe : algorithm
        Motors, twists and reactions of bodies, where rates were found with poses.
    """

    find_rates: algorithm
    observe: algorithm


def motion_algorithms(k: Any, chain: Any, identity: tuple[float, ...], laws: tuple[Any, ...]) -> MotionAlgorithms:
    """Accelerations of trees.

    Parameters
    ----------
    k : named tuple of KernelSpec
        Formulas of mechanics/articulated.py and link_poses.py, `joint_law`, `spring`.
    chain : ChainKernels
    identity : tuple of float
        The rotor 1.
    laws : tuple
        Laws of loads of one body: kernel, where its numbers begin and end, whether it takes the motor and the twist.
    """
    advance = advance_algorithm(chain)

    @algorithm
    def place_links(
        joints: Rows[Joint], balls: Ints, references: Reals, x: Reals, work: InOut[Rows[LinkWork]]
    ) -> None:
        """Rotation and displacement of each link, relative to its parent."""
        for j in range(len(joints)):
            joint = joints[j]
            link = work[j]
            if balls[j] == PLAIN:
                link.displacement[:] = k.joint_displacement(joint.offset, joint.axis, joint.advance * x[j])
                if joint.rotation != 0.0:
                    link.turn[:] = k.joint_rotation(joint.axis, joint.rotation * x[j])
                else:
                    link.turn[:] = UNIT
            else:
                link.displacement[:] = joint.offset
                b = balls[j]
                if b >= 0:
                    link.turn[:] = k.ball_rotation(references[4 * b : 4 * b + 4], x[j : j + 3])
                else:
                    link.turn[:] = UNIT

    @algorithm
    def find_poses(
        joints: Rows[Joint], parents: Ints, balls: Ints, references: Reals, x: Reals, work: InOut[Rows[LinkWork]]
    ) -> None:
        """Rotors and positions of all links."""
        q = empty(4)
        p = empty(3)
        for j in range(len(joints)):
            joint = joints[j]
            i = parents[j]
            if i >= 0:
                q[:] = work[i].rotor
                p[:] = work[i].position
            else:
                q[:] = identity
                p[:] = ORIGIN
            b = balls[j]
            if b == PLAIN:
                advance(q, p, joint, x[j])
            else:
                p[:] = chain.joint_position(q, p, joint.offset, joint.axis, 0.0)
                if b >= 0:
                    q[:] = k.ball_rotor(q, references[4 * b : 4 * b + 4], x[j : j + 3])
            work[j].rotor[:] = q
            work[j].position[:] = p

    @algorithm
    def end_state(c: Int, work: Rows[LinkWork], r: Out[Vector[8]], rate: Out[Vector[6]]) -> None:
        """Motor and twist of a spring's link, or of the world."""
        if c >= 0:
            r[:] = chain.compose(work[c].rotor, work[c].position, ORIGIN)
            rate[:] = work[c].omega
        else:
            r[:] = chain.compose(identity, ORIGIN, ORIGIN)
            rate[:] = 0.0

    @algorithm
    def find_loads(
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], options: Options,
        work: Rows[LinkWork], acting: InOut[Rows[6]],
    ) -> None:  # fmt: skip
        """Wrenches of loads on all bodies, in the frames of their links."""
        r = empty(8)
        s = empty(8)
        rate = empty(6)
        other_rate = empty(6)
        law_numbers = empty(3)
        given = empty(6)
        for b in range(len(bodies)):
            body = bodies[b]
            link = work[carriers[b]]
            total = acting[b]
            total[:] = body.wrench
            if options.world != 0:
                given[:] = k.screw_in_frame(link.rotor, link.position, body.world)
                for j in range(6):
                    total[j] += given[j]
            if options.laws != 0:
                for law, first, last, has_motor, has_twist in laws:
                    if has_motor:
                        r[:] = chain.compose(link.rotor, link.position, ORIGIN)
                    if has_motor and has_twist:
                        given[:] = law(r, link.omega, body.center, body.laws[first:last])
                    elif has_motor:
                        given[:] = law(r, body.center, body.laws[first:last])
                    else:
                        given[:] = law(link.omega, body.center, body.laws[first:last])
                    given[:] = k.wrench_of_powers(given)
                    for j in range(6):
                        total[j] += given[j]
        for i in range(len(springs)):
            spring = springs[i]
            a = spring_ends[i, 0]
            b = spring_ends[i, 1]
            ca = carriers[a] if a >= 0 else -1
            cb = carriers[b] if b >= 0 else -1
            end_state(ca, work, r, rate)
            end_state(cb, work, s, other_rate)
            law_numbers[0] = spring.stiffness
            law_numbers[1] = spring.length
            law_numbers[2] = spring.damping
            own, other = k.spring(r, rate, spring.point, s, other_rate, spring.anchor, law_numbers)
            if a >= 0:
                given[:] = k.wrench_of_powers(own)
                for j in range(6):
                    acting[a, j] += given[j]
            if b >= 0:
                given[:] = k.wrench_of_powers(other)
                for j in range(6):
                    acting[b, j] += given[j]

    @algorithm
    def find_tree_rates(
        joints: Rows[Joint], parents: Ints, balls: Ints, joint_laws: Rows[JointLaw], torques: Reals, links: Rows[Link],
        bodies: Rows[TreeBody], carriers: Ints, spring_ends: IntRows[2], springs: Rows[Spring], gravity: Vector[3],
        options: Options, with_poses: Int, references: Reals, x: Reals, work: InOut[Rows[LinkWork]],
        acting: InOut[Rows[6]], rates: InOut[Reals], at: Int,
    ) -> None:  # fmt: skip
        """Rates of a state, into a row of numbers from a place on; not finite where a joint feels no inertia."""
        nothing = zeros(6)
        n = len(joints)
        start = k.rest_rate(gravity)
        place_links(joints, balls, references, x, work)
        if with_poses != 0:
            find_poses(joints, parents, balls, references, x, work)
        for j in range(n):
            joint = joints[j]
            own = links[j]
            link = work[j]
            i = parents[j]
            if i >= 0:
                link.omega[:], link.drift[:] = k.link_velocity(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, x[n + j], work[i].omega
                )
            else:
                link.omega[:], link.drift[:] = k.link_velocity(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, x[n + j], nothing
                )
            link.inertia[:] = k.rigid_inertia(own.mass, own.moment, own.tensor)
            link.bias[:] = k.link_bias(own.mass, own.moment, own.tensor, link.omega)
            link.force = torques[j]
            if options.joint_laws != 0:
                law = joint_laws[j]
                passive = k.joint_law(x[j], x[n + j], law[0:9])
                link.force += passive
        find_loads(bodies, carriers, spring_ends, springs, options, work, acting)
        for b in range(len(bodies)):
            link = work[carriers[b]]
            for j in range(6):
                link.bias[j] -= acting[b, j]
        for j in range(n - 1, -1, -1):
            joint = joints[j]
            link = work[j]
            i = parents[j]
            link.momentum[:], felt = k.articulated_momentum(link.inertia, joint.axis, joint.rotation, joint.advance)
            link.compliance = 1.0 / felt
            bias = k.joint_force(joint.axis, joint.rotation, joint.advance, link.bias)
            link.left = link.force - bias
            if i >= 0:
                parent = work[i]
                link.inertia[:], link.bias[:] = k.release(
                    link.inertia, link.bias, link.drift, link.momentum, link.compliance, link.left
                )
                parent.inertia[:] = k.add_articulated(link.turn, link.displacement, link.inertia, parent.inertia)
                parent.bias[:] = k.add_to_parent(link.turn, link.displacement, link.bias, parent.bias)
        for j in range(n):
            joint = joints[j]
            link = work[j]
            i = parents[j]
            if i >= 0:
                acceleration, link.rate[:] = k.joint_acceleration(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, link.drift, link.momentum,
                    link.compliance, link.left, work[i].rate,
                )  # fmt: skip
            else:
                acceleration, link.rate[:] = k.joint_acceleration(
                    link.turn, link.displacement, joint.axis, joint.rotation, joint.advance, link.drift, link.momentum,
                    link.compliance, link.left, start,
                )  # fmt: skip
            felt_by_parent = link.left - acceleration / link.compliance
            link.blur = epsilon() * (abs(link.left) + abs(felt_by_parent)) * link.compliance
            rates[at + j] = x[n + j]
            rates[at + n + j] = acceleration
        for j in range(n):
            if balls[j] >= 0:
                # the coordinates' rates; speeds are the angular velocity, which one rotation of the three carries on
                spin = k.ball_rate(x[j : j + 3], x[n + j : n + j + 3])
                for i in range(3):
                    rates[at + j + i] = spin[i]
                rates[at + n + j] += x[n + j + 1] * x[n + j + 2]
                rates[at + n + j + 1] -= x[n + j] * x[n + j + 2]
                rates[at + n + j + 2] += x[n + j] * x[n + j + 1]

    @algorithm
    def observe(
        joints: Rows[Joint], bodies: Rows[TreeBody], carriers: Ints, ends: IntRows[2], work: Rows[LinkWork],
        acting: Rows[6], motors: InOut[Rows[8]], twists: InOut[Rows[6]], reactions: InOut[Rows[6]], at: Int,
    ) -> None:  # fmt: skip
        """States of all bodies, into rows from a place on; forces along joints are no reactions."""
        local = empty(6)
        count = len(bodies)
        for b in range(count):
            body = bodies[b]
            link = work[carriers[b]]
            q, p = chain.frame_pose(link.rotor, link.position, body.position, body.rotor)
            motors[at + b][:] = chain.compose(q, p, ORIGIN)
            twists[at + b][:] = k.screw_in_frame(body.rotor, body.position, link.omega)
            local[:] = k.link_wrench(body.mass, body.moment, body.tensor, link.omega, link.rate)
            for j in range(6):
                local[j] -= acting[b, j]
            reactions[at + b][:] = k.screw_from_frame(link.rotor, link.position, local)
        for j in range(len(joints)):
            joint = joints[j]
            link = work[j]
            if link.force != 0.0:
                local[:] = k.joint_wrench(joint.axis, joint.rotation, joint.advance, link.force)
                local[:] = k.screw_from_frame(link.rotor, link.position, local)
                for i in range(6):
                    reactions[at + ends[j, 0], i] -= local[i]
                    if ends[j, 1] >= 0:
                        reactions[at + ends[j, 1], i] += local[i]

    return MotionAlgorithms(find_tree_rates, observe)
