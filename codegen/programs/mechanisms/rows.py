"""A mechanism at one pose: motors of its bodies, what its joints leave and forbid there, and their errors."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Matrix, Out, Real, Reals, Rows, Vector, empty
from .records import Cut, Link, Loop, Output, PathStep, Shared, Target


class MechanismKernels(NamedTuple):
    """The formulas that the loops call, for one algebra.

    Attributes
    ----------
    transforms, rates : tuple of (int, int, kernel)
        For each layout of shared objects: its index, its size, `transform_object` and `moved_rates`.
    """

    compose: Any
    relative: Any
    adjoint_matrix: Any
    adjoint: Any
    move_by_twist: Any
    twist_between: Any
    point_rates: Any
    moved_point: Any
    transforms: tuple[tuple[int, int, Any], ...]
    rates: tuple[tuple[int, int, Any], ...]


class MechanismRows(NamedTuple):
    """What a pose says of joints and targets."""

    set_links: algorithm
    forward_kinematics: algorithm
    link_residuals: algorithm
    loop_residuals: algorithm
    target_rows: algorithm
    target_residuals: algorithm
    set_maps: algorithm


@algorithm
def times(to: Out[Vector[6]], a: Vector[36], x: Vector[6]) -> None:
    """The product A x."""
    for i in range(6):
        total = 0.0
        for j in range(6):
            total += a[6 * i + j] * x[j]
        to[i] = total


@algorithm
def fill_matrix(
    loops: Rows[Loop], path: Rows[PathStep], links: Rows[Link], free: Rows[6], rows: Rows[6], columns: Int,
    matrix: Out[Matrix],
) -> None:  # fmt: skip
    """Rows of cuts and targets on all coordinates."""
    row = empty(6)
    for n in range(len(loops)):
        loop = loops[n]
        for i in range(loop.first, loop.first + loop.rows):
            for j in range(columns):
                matrix[i, j] = 0.0
        for s in range(loop.step, loop.step + loop.steps):
            step = path[s]
            link = links[step.link]
            sign = float(step.sign)
            for i in range(loop.first, loop.first + loop.rows):
                for k in range(6):
                    row[k] = sign * rows[i, k]
                for j in range(link.first, link.first + link.count):
                    total = 0.0
                    for k in range(6):
                        total += row[k] * free[j, k]
                    matrix[i, j] = total


def row_algorithms(k: MechanismKernels, identity: tuple[float, ...]) -> MechanismRows:
    """The algorithms for one algebra.

    Parameters
    ----------
    k : MechanismKernels
    identity : tuple of float
        The motor 1.
    """
    largest = max(size for _, size, _ in k.transforms)

    @algorithm
    def set_links(links: Rows[Link], given: Rows[8], relative: Out[Rows[8]]) -> None:
        """Bodies as their parents see them, from their motors."""
        base = empty(8)
        for b in range(len(links)):
            link = links[b]
            if link.parent < 0:
                base[:] = identity
            else:
                base[:] = given[links[link.parent].body]
            relative[b][:] = k.relative(base, given[link.body])

    @algorithm
    def forward_kinematics(
        links: Rows[Link], numbers: Reals, relative: Rows[8], motors: InOut[Rows[8]], carry: InOut[Rows[36]],
        free: Out[Rows[6]],
    ) -> None:  # fmt: skip
        """Motors of bodies, and twists of the world for unit speeds of coordinates."""
        for b in range(len(links)):
            link = links[b]
            if link.parent < 0:
                motors[b][:] = relative[b]
            else:
                motors[b][:] = k.compose(motors[link.parent], relative[b])
            if link.bears > 0:
                carry[b][:] = k.adjoint_matrix(motors[b])
        for b in range(len(links)):
            link = links[b]
            for c in range(link.count):
                unit = numbers[link.free + 6 * c : link.free + 6 * c + 6]
                if link.parent < 0:
                    free[link.first + c][:] = unit
                else:
                    times(free[link.first + c], carry[link.parent], unit)

    @algorithm
    def add_errors(
        shared: Shared, count: Int, numbers: Reals, motor: Vector[8], u: Out[Vector], first: Int,
        errors: InOut[Reals],
    ) -> None:  # fmt: skip
        """An object as a motor takes it, and what it adds to the errors of a joint."""
        for index, size, transform in k.transforms:
            if shared.layout == index:
                u[:size] = transform(motor, numbers[shared.offset : shared.offset + size])
                for i in range(count):
                    total = errors[first + i]
                    for j in range(size):
                        total += numbers[shared.part + size * i + j] * u[j]
                    errors[first + i] = total

    @algorithm
    def add_rates(shared: Shared, count: Int, numbers: Reals, u: Vector, rows: InOut[Matrix]) -> None:
        """What an object adds to the rows of a joint whose freedoms vary."""
        rates = empty(6 * largest)
        for index, size, moved_rates in k.rates:
            if shared.layout == index:
                rates[: 6 * size] = moved_rates(u[:size])
        for i in range(count):
            for e in range(6):
                total = rows[i, e]
                for j in range(shared.length):
                    total += numbers[shared.part + shared.length * i + j] * rates[shared.length * e + j]
                rows[i, e] = total

    @algorithm
    def link_residuals(
        links: Rows[Link], shared: Rows[Shared], numbers: Reals, relative: Rows[8], off: Out[Reals]
    ) -> Real:
        """Errors of the links' own joints, six for each link; the largest."""
        u = empty(largest)
        worst = 0.0
        for b in range(len(links)):
            link = links[b]
            for i in range(link.rows):
                off[6 * b + i] = -numbers[link.values + i]
            for n in range(link.object, link.object + link.objects):
                add_errors(shared[n], link.rows, numbers, relative[b], u, 6 * b, off)
            for i in range(link.rows):
                worst = max(worst, abs(off[6 * b + i]))
        return worst

    @algorithm
    def loop_residuals(
        cuts: Rows[Cut], shared: Rows[Shared], numbers: Reals, motors: Rows[8], errors: Out[Reals], rows: Out[Rows[6]]
    ) -> Real:
        """Errors of the joints that close loops, and their rows on relative twists of the world; the largest error."""
        u = empty(largest)
        other = empty(8)
        seen = empty(8)
        change = empty(6, 6)
        own = empty(6, 6)
        worst = 0.0
        for c in range(len(cuts)):
            cut = cuts[c]
            if cut.b < 0:
                other[:] = identity
            else:
                other[:] = motors[cut.b]
            if cut.a < 0:
                seen[:] = other
            else:
                seen[:] = k.relative(motors[cut.a], other)
                change[:] = k.adjoint(motors[cut.a])
            for i in range(cut.rows):
                errors[cut.first + i] = -numbers[cut.values + i]
                for j in range(6):
                    own[i, j] = numbers[cut.matrix + 6 * i + j] if cut.matrix >= 0 else 0.0
            for n in range(cut.object, cut.object + cut.objects):
                add_errors(shared[n], cut.rows, numbers, seen, u, cut.first, errors)
                if cut.matrix < 0:
                    add_rates(shared[n], cut.rows, numbers, u, own)
            for i in range(cut.rows):
                for j in range(6):
                    total = 0.0
                    if cut.a < 0:
                        total = own[i, j]
                    else:
                        for n in range(6):
                            total += own[i, n] * change[n, j]
                    rows[cut.first + i, j] = total
                worst = max(worst, abs(errors[cut.first + i]))
        return worst

    @algorithm
    def target_rows(
        targets: Rows[Target], numbers: Reals, motors: Rows[8], rows: Out[Rows[6]], position: Out[Vector[3]], n: Int
    ) -> None:
        """Rows of a target: a pose (6 rows, the world's twist) or a position (3)."""
        target = targets[n]
        rates = empty(6, 3)
        if target.rows == 6:
            for i in range(6):
                for j in range(6):
                    rows[target.first + i, j] = 1.0 if i == j else 0.0
        else:
            position[:] = k.moved_point(motors[target.body], numbers[target.point : target.point + 3])
            rates[:] = k.point_rates(position)
            for i in range(3):
                for j in range(6):
                    rows[target.first + i, j] = rates[j, i]

    @algorithm
    def target_residuals(
        targets: Rows[Target], numbers: Reals, goals: Reals, first: Int, motors: Rows[8], errors: Out[Reals],
        rows: Out[Rows[6]],
    ) -> Real:  # fmt: skip
        """Rows of targets, and errors: what is to be taken back; the largest."""
        position = empty(3)
        twist = empty(6)
        worst = 0.0
        for n in range(len(targets)):
            target = targets[n]
            at = first + target.goal
            target_rows(targets, numbers, motors, rows, position, n)
            if target.rows == 6:
                twist[:] = k.twist_between(motors[target.body], goals[at : at + 8])
            else:
                for i in range(3):
                    twist[i] = goals[at + i] - position[i]
            for i in range(target.rows):
                worst = max(worst, abs(twist[i]))
                errors[target.first + i] = -twist[i]
        return worst

    @algorithm
    def set_maps(outputs: Rows[Output], numbers: Reals, points: Reals, motors: Rows[8], maps: InOut[Rows[36]]) -> None:
        """Matrices from twists of bodies to what is requested of them, in units of the world."""
        position = empty(3)
        rates = empty(6, 3)
        for n in range(len(outputs)):
            output = outputs[n]
            if output.column >= 0:
                continue
            if output.rows == 6:
                maps[n][:] = numbers[output.map : output.map + 36]
                continue
            position[:] = k.moved_point(motors[output.body], points[output.map : output.map + 3])
            rates[:] = k.point_rates(position)
            for i in range(3):
                for j in range(6):
                    maps[n, 6 * i + j] = rates[j, i] * points[output.map + 3]

    return MechanismRows(
        set_links, forward_kinematics, link_residuals, loop_residuals, target_rows, target_residuals, set_maps
    )
