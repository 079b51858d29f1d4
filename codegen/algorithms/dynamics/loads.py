"""Simulations: wrenches on bodies, and accelerations that these would give to free ones.

Annotations are evaluated: sizes are those of the kind of simulation.
"""

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import CFunction, inlined, still_inlined
from ...ir.loops.language import InOut, Int, IntRows, Out, Real, Reals, Rows, Vector, empty, epsilon, sqrt, zeros
from ...ir.loops.types import INT, REAL, ArrayType, Parameter
from .records import LAW_NUMBERS, Body, Code, Coupling, Parts, Spring, work_records

OK, USER_FAILED = int(Code.OK), int(Code.USER_FAILED)
POINT, LAW = Spring.extent("anchor")[0], Spring.extent("stiffness")[0]
SPRING_SIZE = Spring.size
COUPLING_SIZE, COUPLING_LAWS = Coupling.size, Coupling.extent("laws")[0]


class LoadAlgorithms(NamedTuple):
    """Loads of one kind of simulation.

    Attributes
    ----------
    add_wrenches : algorithm
        Rows of the wrenches on all bodies.
    free_accelerations : algorithm
        Accelerations that these would give to free bodies, or to one in the subspace of its pins; their rows.
    """

    add_wrenches: algorithm
    free_accelerations: algorithm


#: Values of a function of a user at a time and a state; not 0 if it failed.
user_values = CFunction(
    "user_values",
    [
        *(Parameter(name, INT) for name in ("handle", "which", "item")), Parameter("t", REAL),
        Parameter("state", ArrayType(REAL, (14,))), Parameter("values", ArrayType(REAL, (None,)), "inout"),
    ],
    [INT], "bladesmith.codegen.execute.numba_callbacks", is_still=True,
)  # fmt: skip


@still_inlined
def blur_of(body: Body, row: Vector[6]) -> Real:
    """What a wrench does to a body, by energy, adds this to the rounding of its accelerations."""
    square = 0.0
    for j in range(6):
        square += row[j] * row[j] * body.roots[j] * body.roots[j]
    return epsilon() * sqrt(square)


@inlined
def state_of(b: Int, motors: Reals, twists: Reals, state: Out[Vector[14]]) -> None:
    """Motor and twist of a body."""
    for j in range(8):
        state[j] = motors[8 * b + j]
    for j in range(6):
        state[8 + j] = twists[6 * b + j]


def load_algorithms(parts: Parts, k: Any) -> LoadAlgorithms:
    """Loads of a kind of simulation.

    Parameters
    ----------
    parts : Parts
    k : named tuple of KernelSpec
    """
    bodies_count, size, loads, blurs, identity = parts.bodies, parts.size, parts.loads, parts.blurs, parts.identity
    a_velocity = parts.linear[0]
    in_subspace, keeps = parts.mode == "subspace", parts.functions > 0
    laws = tuple((getattr(k, name), *place) for name, *place in parts.laws)
    uses_body = bool(laws) or not {"gravity", "body_wrench", "world_wrench"}.isdisjoint(loads)
    work = work_records(parts)
    Work: Any = work.numbers
    Integers: Any = work.integers
    add_springs: Any = None
    add_couplings: Any = None
    add_user_loads: Any = None

    if "spring" in loads or "coupling" in loads:

        @inlined
        def end_state(
            b: Int, motors: Vector[8 * bodies_count], twists: Vector[size], r: Out[Vector[8]], rate: Out[Vector[6]]
        ) -> None:
            """Motor and twist of a spring's body, or of the world."""
            if b >= 0:
                r[:] = motors[8 * b : 8 * b + 8]
                rate[:] = twists[6 * b : 6 * b + 6]
            else:
                r[:] = identity
                rate[:] = 0.0

    if "spring" in loads:

        @algorithm
        def add_springs(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], w: InOut[Work], p: InOut[Integers],
            motors: Vector[8 * bodies_count], twists: Vector[size], rows: InOut[Vector[size]],
        ) -> None:  # fmt: skip
            """Rows of the wrenches of springs at their two ends."""
            r = empty(8)
            s = empty(8)
            rate = empty(6)
            other_rate = empty(6)
            for i in range(p.springs):
                at = p.spring_offset + SPRING_SIZE * i
                a, b = springs[i, 0], springs[i, 1]
                end_state(a, motors, twists, r, rate)
                end_state(b, motors, twists, s, other_rate)
                own, other = k.spring(
                    r, rate, numbers[at : at + 3], s, other_rate, numbers[at + POINT : at + POINT + 3],
                    numbers[at + LAW : at + LAW + 3],
                )  # fmt: skip
                for j in range(6):
                    if a >= 0:
                        rows[6 * a + j] += own[j]
                    if b >= 0:
                        rows[6 * b + j] += other[j]
                if blurs:
                    reach = numbers[at + LAW + 1]  # of what is subtracted where the spring's ends are
                    for j in range(3):
                        reach += abs(numbers[at + j]) + abs(numbers[at + POINT + j])
                    if p.blurred != 0 and a >= 0:
                        pull = epsilon() * numbers[at + LAW] * reach * bodies[a].roots[a_velocity]
                        w.blur[a] += blur_of(bodies[a], own) + pull
                    if p.blurred != 0 and b >= 0:
                        pull = epsilon() * numbers[at + LAW] * reach * bodies[b].roots[a_velocity]
                        w.blur[b] += blur_of(bodies[b], other) + pull

    if "coupling" in loads:
        braking = tuple((law, first, last) for law, first, last, has_motor, _ in laws if not has_motor)

        @algorithm
        def add_couplings(
            numbers: Reals, bodies: Rows[Body], springs: IntRows[2], w: InOut[Work], p: InOut[Integers],
            motors: Vector[8 * bodies_count], twists: Vector[size], rows: InOut[Vector[size]],
        ) -> None:  # fmt: skip
            """Rows of the wrenches of laws between two bodies: of the one's motion as the other sees it."""
            r = empty(8)
            s = empty(8)
            rate = empty(6)
            other_rate = empty(6)
            own = empty(6)
            other = empty(6)
            for i in range(p.couplings):
                at = p.spring_offset + SPRING_SIZE * p.springs + COUPLING_SIZE * i
                a, b = springs[p.springs + i, 0], springs[p.springs + i, 1]
                end_state(a, motors, twists, r, rate)
                end_state(b, motors, twists, s, other_rate)
                own_laws = numbers[at + COUPLING_LAWS : at + COUPLING_LAWS + LAW_NUMBERS]
                seen = k.relative_twist(r, rate, s, other_rate)
                for law, first, last in braking:
                    own[:] = law(seen, numbers[at : at + 3], own_laws[first:last])
                    other[:] = k.counter_wrench(r, s, own)
                    for j in range(6):
                        rows[6 * a + j] += own[j]
                        rows[6 * b + j] += other[j]
                    if blurs and p.blurred != 0:
                        w.blur[a] += blur_of(bodies[a], own)
                        w.blur[b] += blur_of(bodies[b], other)

    if "user" in loads:

        @algorithm
        def add_user_loads(
            bodies: Rows[Body], user_loads: IntRows[3], w: InOut[Work], p: InOut[Integers], t: Real,
            motors: Vector[8 * bodies_count], twists: Vector[size], rows: InOut[Vector[size]],
        ) -> Int:  # fmt: skip
            """Rows of the wrenches that functions of users give; a status."""
            state = empty(14)
            part = empty(6)
            for i in range(p.loads):
                b = user_loads[i, 0]
                if keeps:  # noqa: SIM108
                    wrench = w.values[user_loads[i, 2]]
                else:
                    wrench = zeros(6)
                failed = 0
                if not keeps or p.held == 0:
                    state_of(b, motors, twists, state)
                    failed = user_values(p.handle, user_loads[i, 2], p.item, t, state, wrench)
                if failed != 0:
                    return USER_FAILED
                if user_loads[i, 1] != 0:
                    part[:] = k.wrench_to_body(motors[8 * b : 8 * b + 8], wrench[0:6])
                else:
                    part[:] = k.covector_of(wrench[0:6])
                for j in range(6):
                    rows[6 * b + j] += part[j]
                if blurs and p.blurred != 0:
                    w.blur[b] += blur_of(bodies[b], part)
            return OK

    @algorithm
    def add_wrenches(
        numbers: Reals, bodies: Rows[Body], springs: IntRows[2], user_loads: IntRows[3], w: InOut[Work],
        p: InOut[Integers], t: Real, motors: Vector[8 * bodies_count], twists: Vector[size], rows: Out[Vector[size]],
    ) -> Int:  # fmt: skip
        """Rows of the wrenches on all bodies; a status."""
        if laws:
            given = empty(6)
        for b in range(bodies_count):
            if uses_body:
                body = bodies[b]
            row = rows[6 * b : 6 * b + 6]
            row[:] = 0.0
            if blurs and p.blurred != 0:
                w.blur[b] = 0.0
            if "gravity" in loads:
                row[:] = k.pull(motors[8 * b : 8 * b + 8], body.center, body.weight)
                if blurs and p.blurred != 0:
                    w.blur[b] += blur_of(body, row)
            if "body_wrench" in loads:
                for j in range(6):
                    row[j] += body.wrench[j]
                if blurs and p.blurred != 0:
                    w.blur[b] += blur_of(body, body.wrench)
            if "world_wrench" in loads:
                carried = k.wrench_to_body(motors[8 * b : 8 * b + 8], body.world)
                for j in range(6):
                    row[j] += carried[j]
                if blurs and p.blurred != 0:
                    w.blur[b] += blur_of(body, carried)
            for law, first, last, has_motor, has_twist in laws:
                if has_motor and has_twist:
                    given[:] = law(
                        motors[8 * b : 8 * b + 8], twists[6 * b : 6 * b + 6], body.center, body.laws[first:last]
                    )
                elif has_motor:
                    given[:] = law(motors[8 * b : 8 * b + 8], body.center, body.laws[first:last])
                else:
                    given[:] = law(twists[6 * b : 6 * b + 6], body.center, body.laws[first:last])
                for j in range(6):
                    row[j] += given[j]
                if blurs and p.blurred != 0:
                    w.blur[b] += blur_of(body, given)
        if "spring" in loads:
            add_springs(numbers, bodies, springs, w, p, motors, twists, rows)
        if "coupling" in loads:
            add_couplings(numbers, bodies, springs, w, p, motors, twists, rows)
        if "user" in loads:
            status = add_user_loads(bodies, user_loads, w, p, t, motors, twists, rows)
            return int(status)
        return OK

    @inlined
    def free_accelerations(
        bodies: Rows[Body], w: InOut[Work], p: InOut[Integers], twists: Vector[size], rows: InOut[Vector[size]],
        accelerations: Out[Vector[size]],
    ) -> None:  # fmt: skip
        """Accelerations of free bodies, or in the subspace of pins; rows of the rotation are added to those given."""
        momentum = empty(6)
        for b in range(bodies_count):
            body = bodies[b]
            rate = twists[6 * b : 6 * b + 6]
            if in_subspace:
                for i in range(6):
                    momentum[i] = 0.0
                    for j in range(6):
                        momentum[i] += body.mass[i, j] * rate[j]
            else:
                for j in range(6):
                    momentum[j] = body.metric[j] * rate[j]
            turning = k.gyroscopic(rate, momentum)
            for j in range(6):
                rows[6 * b + j] += turning[j]
            if blurs and p.blurred != 0:
                w.blur[b] += blur_of(body, turning)
            if in_subspace:
                for i in range(6):
                    accelerations[i] = 0.0
                    for j in range(6):
                        accelerations[i] += body.compliance[i, j] * rows[j]
            else:
                for j in range(6):
                    accelerations[6 * b + j] = body.inverse[j] * rows[6 * b + j]

    return LoadAlgorithms(add_wrenches, free_accelerations)
