"""Jacobians of mechanisms: requested speeds for given ones, by elimination in an order made for the mechanism.

The unknown speeds that nobody requests are eliminated a link at a time; what is left is small. Or all at once, by
orthogonal directions of the rows.
"""

# Annotations are evaluated here: sizes of records are those of the call of `jacobian_algorithms`.
from typing import Any, NamedTuple

from ...algorithms.weighted_rows import WeightedRows
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import InOut, Int, Ints, Matrix, Out, Real, Reals, Rows, Vector, empty
from .records import Cut, Driven, Elimination, Link, Loop, Output, PathStep, Shared, Sizes, Target, Tolerances
from .rows import MechanismRows, fill_matrix

#: An element of a row that is more than its rounding.
LEFT = 1e-14
#: Larger numbers are not finite.
HUGE = 1e300

#: Outputs can move while inputs rest; inputs are not allowed.
DONE, OPEN, NOT_ALLOWED, NOT_FINITE = range(4)
#: What a row is used for: a link's columns, or those that are left.
FOR_LINK, FOR_REST = 1, 2


class JacobianAlgorithms(NamedTuple):
    """Jacobians by the planned elimination, and by all rows at once."""

    elimination: algorithm
    general: algorithm


@algorithm
def fill_table(matrix: Matrix, driven: Rows[Driven], sizes: Sizes, numbers: Reals, table: Out[Reals]) -> None:
    """Rows on unknown speeds, and behind them what each input gives the rows: driven joints, then speeds of targets."""
    n = sizes.columns
    width = n + len(driven) + sizes.speeds
    for i in range(sizes.rows):
        for j in range(n):
            table[width * i + j] = matrix[i, j]
        for k in range(len(driven)):
            table[width * i + n + k] = -matrix[i, driven[k].column]
            table[width * i + driven[k].column] = 0.0
        for k in range(sizes.speeds):
            given = 0.0
            if i >= sizes.cuts:
                given = numbers[sizes.right + sizes.speeds * (i - sizes.cuts) + k]
            table[width * i + n + len(driven) + k] = given


@algorithm
def eliminate(
    plan: Elimination, entries: Ints, columns: Int, width: Int, least: Real, table: InOut[Reals], line: InOut[Reals],
    used: InOut[Ints], pivot: InOut[Ints],
) -> None:  # fmt: skip
    """Eliminate the columns of a link, as far as its rows depend on them, by the largest element of these columns."""
    for _ in range(plan.count):
        row = -1
        column = -1
        most = least
        for n in range(plan.row, plan.row + plan.rows):
            i = entries[n]
            if used[i] != 0:
                continue
            for j in range(plan.first, plan.first + plan.count):
                if pivot[j] < 0 and abs(table[width * i + j]) > most:
                    most = abs(table[width * i + j])
                    row = i
                    column = j
        if row < 0:
            return
        used[row] = FOR_LINK
        pivot[column] = row
        own = width * row
        divisor = table[own + column]
        for j in range(plan.first, plan.first + plan.count):
            line[j] = table[own + j]
        for m in range(plan.other, plan.other + plan.others):
            line[entries[m]] = table[own + entries[m]]
        for j in range(columns, width):
            line[j] = table[own + j]
        for n in range(plan.row, plan.row + plan.rows):
            other = width * entries[n]
            if used[entries[n]] != 0 or table[other + column] == 0.0:
                continue
            share = table[other + column] / divisor
            for j in range(plan.first, plan.first + plan.count):
                table[other + j] -= share * line[j]
            for m in range(plan.other, plan.other + plan.others):
                table[other + entries[m]] -= share * line[entries[m]]
            for j in range(columns, width):
                table[other + j] -= share * line[j]
            table[other + column] = 0.0


@algorithm
def reduce_rest(
    kept: Ints, rows: Int, width: Int, least: Real, table: InOut[Reals], line: InOut[Reals], used: InOut[Ints],
    pivot: InOut[Ints],
) -> None:  # fmt: skip
    """Eliminate the columns that are left from all rows but one, by the largest element (Gauss and Jordan)."""
    for _ in range(len(kept)):
        row = -1
        column = -1
        most = least
        for i in range(rows):
            if used[i] != 0:
                continue
            for n in range(len(kept)):
                j = kept[n]
                if pivot[j] < 0 and abs(table[width * i + j]) > most:
                    most = abs(table[width * i + j])
                    row = i
                    column = j
        if row < 0:
            return
        used[row] = FOR_REST
        pivot[column] = row
        own = width * row
        divisor = table[own + column]
        for j in range(width):
            line[j] = table[own + j]
        for i in range(rows):
            if i == row or used[i] == FOR_LINK or table[width * i + column] == 0.0:
                continue
            share = table[width * i + column] / divisor
            for j in range(width):
                table[width * i + j] -= share * line[j]


@algorithm
def output_twist(
    output: Output, path: Rows[PathStep], links: Rows[Link], free: Rows[6], speeds: Vector, twist: Out[Vector[6]]
) -> None:
    """The twist of a body for speeds of all coordinates."""
    twist[:] = 0.0
    for s in range(output.step, output.step + output.steps):
        link = links[path[s].link]
        for j in range(link.first, link.first + link.count):
            for i in range(6):
                twist[i] += free[j, i] * speeds[j]


@algorithm
def write_outputs(
    outputs: Rows[Output], path: Rows[PathStep], links: Rows[Link], free: Rows[6], maps: Rows[36], numbers: Reals,
    driven: Rows[Driven], speeds: Vector, inputs: Int, k: Int, jacobian: Out[Reals],
) -> None:  # fmt: skip
    """What is requested, for speeds of all coordinates with one of an input: its column of a Jacobian."""
    at = k
    unit = 1.0
    if k < len(driven):
        at = driven[k].place
        unit = numbers[driven[k].unit]
    twist = empty(6)
    for n in range(len(outputs)):
        output = outputs[n]
        if output.column >= 0:
            jacobian[at + inputs * output.row] = numbers[output.map] * speeds[output.column] * unit
        else:
            output_twist(output, path, links, free, speeds, twist)
            for i in range(output.rows):
                total = 0.0
                for j in range(6):
                    total += maps[n, 6 * i + j] * twist[j]
                jacobian[at + inputs * (output.row + i)] = total * unit


@algorithm
def largest_output(
    outputs: Rows[Output], path: Rows[PathStep], links: Rows[Link], free: Rows[6], speeds: Vector
) -> Real:
    """The largest of what is requested, for speeds that inputs leave open."""
    twist = empty(6)
    most = 0.0
    for n in range(len(outputs)):
        output = outputs[n]
        if output.column >= 0:
            most = max(most, abs(speeds[output.column]))
        else:
            output_twist(output, path, links, free, speeds, twist)
            for i in range(6):
                most = max(most, abs(twist[i]))
    return most


@algorithm
def checked(status: Int, x: Reals) -> Int:
    """The status of a Jacobian, unless some of its numbers are not finite."""
    finite = True
    for i in range(len(x)):
        finite = finite and abs(x[i]) < HUGE
    return status if finite else NOT_FINITE


def jacobian_algorithms(r: MechanismRows, system: WeightedRows, room: int) -> JacobianAlgorithms:
    """The algorithms for mechanisms of up to ``room`` rows and columns.

    Parameters
    ----------
    r : MechanismRows
    system : WeightedRows
        Of this size.
    room : int
    """
    Numbers: Any = system.numbers
    Indices: Any = system.integers
    find_directions, least_change = system.find_directions, system.least_change

    @algorithm
    def fill_rows(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, relative: Rows[8],
        motors: InOut[Rows[8]], carry: InOut[Rows[36]], free: InOut[Rows[6]], rows: InOut[Rows[6]],
        errors: InOut[Reals], off: InOut[Reals], table: Out[Reals], s: InOut[Numbers],
    ) -> Real:  # fmt: skip
        """Rows at a pose; the largest error of what joints share."""
        position = empty(3)
        r.forward_kinematics(links, numbers, relative, motors, carry, free)
        off_joints = r.link_residuals(links, shared, numbers, relative, off)
        off_loops = r.loop_residuals(cuts, shared, numbers, motors, errors, rows)
        for n in range(len(targets)):
            r.target_rows(targets, numbers, motors, rows, position, n)
        fill_matrix(loops, path, links, free, rows, sizes.columns, s.matrix)
        fill_table(s.matrix, driven, sizes, numbers, table)
        return max(off_joints, off_loops)

    @algorithm
    def solve_rest(
        outputs: Rows[Output], path: Rows[PathStep], links: Rows[Link], free: Rows[6], driven: Rows[Driven], kept: Ints,
        sizes: Sizes, numbers: Reals, maps: Rows[36], open_: Real, table: Reals, used: Ints, pivot: Ints,
        jacobian: Out[Reals],
    ) -> Int:  # fmt: skip
        """Columns of the Jacobian from the eliminated rows: the status."""
        speeds = empty(room)
        columns = sizes.columns
        inputs = len(driven) + sizes.speeds
        width = columns + inputs
        status = DONE
        for k in range(inputs):
            most = 0.0
            singular = (
                False  # what is not allowed by a row of which little is left: by rounding, next to a singular pose
            )
            for i in range(sizes.rows):
                value = abs(table[width * i + columns + k])
                if used[i] != 0 or not value > open_:
                    continue
                most = max(most, value)
                for n in range(len(kept)):
                    singular = singular or abs(table[width * i + kept[n]]) > LEFT
            if most > open_:
                status = OPEN if singular else NOT_ALLOWED
            for j in range(columns):  # those that nothing defines rest
                speeds[j] = 0.0
                if pivot[j] >= 0:
                    speeds[j] = table[width * pivot[j] + columns + k] / table[width * pivot[j] + j]
            for n in range(len(driven)):
                speeds[driven[n].column] = 1.0 if n == k else 0.0
            write_outputs(outputs, path, links, free, maps, numbers, driven, speeds, inputs, k, jacobian)
        for k in range(len(kept)):  # what no row defines may move, and what hangs on it
            column = kept[k]
            if pivot[column] >= 0:
                continue
            for j in range(columns):  # outputs do not depend on those that were eliminated
                speeds[j] = 1.0 if j == column else 0.0
            for n in range(len(kept)):
                row = pivot[kept[n]]
                if row >= 0:
                    speeds[kept[n]] = -table[width * row + column] / table[width * row + kept[n]]
            if largest_output(outputs, path, links, free, speeds) > open_:
                status = OPEN
        return status

    @algorithm
    def elimination(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, tolerances: Tolerances,
        outputs: Rows[Output], plan: Rows[Elimination], entries: Ints, kept: Ints,
        points: Reals, given: Rows[8], jacobian: Out[Reals], residuals: Out[Reals], statuses: Out[Ints],
        relative: InOut[Rows[8]], motors: InOut[Rows[8]], carry: InOut[Rows[36]], free: InOut[Rows[6]],
        rows: InOut[Rows[6]], errors: InOut[Reals], off: InOut[Reals], maps: InOut[Rows[36]], table: InOut[Reals],
        line: InOut[Reals], used: InOut[Ints], pivot: InOut[Ints], s: InOut[Numbers],
    ) -> None:  # fmt: skip
        """The Jacobian at motors of bodies, its status, and the largest error of what joints share."""
        width = sizes.columns + len(driven) + sizes.speeds
        least = tolerances.redundant
        r.set_links(links, given, relative)
        residuals[0] = fill_rows(
            links, shared, cuts, targets, loops, path, driven, sizes, numbers, relative, motors, carry, free, rows,
            errors, off, table, s,
        )  # fmt: skip
        r.set_maps(outputs, numbers, points, motors, maps)
        for i in range(sizes.rows):
            used[i] = 0
        for j in range(sizes.columns):
            pivot[j] = -1
        for n in range(len(plan)):
            eliminate(plan[n], entries, sizes.columns, width, least, table, line, used, pivot)
        reduce_rest(kept, sizes.rows, width, least, table, line, used, pivot)
        status = solve_rest(
            outputs, path, links, free, driven, kept, sizes, numbers, maps, tolerances.open, table, used, pivot,
            jacobian,
        )  # fmt: skip
        statuses[0] = checked(status, jacobian)

    @algorithm
    def solve_directions(
        outputs: Rows[Output], path: Rows[PathStep], links: Rows[Link], free: Rows[6], driven: Rows[Driven],
        sizes: Sizes, numbers: Reals, maps: Rows[36], tolerances: Tolerances, table: Reals, jacobian: Out[Reals],
        s: InOut[Numbers], indices: InOut[Indices],
    ) -> Int:  # fmt: skip
        """Columns of the Jacobian by orthogonal directions of all rows: the status."""
        weights = empty(room)
        values = empty(room)
        speeds = empty(room)
        columns = sizes.columns
        inputs = len(driven) + sizes.speeds
        width = columns + inputs
        status = DONE
        for j in range(columns):
            weights[j] = 1.0
        for n in range(len(driven)):
            weights[driven[n].column] = 0.0
        for i in range(sizes.rows):
            s.sizes[i] = 0.0
            s.noise[i] = 0.0
        find_directions(s, indices, sizes.rows, columns, weights, tolerances.redundant, 0)
        for k in range(inputs):
            most = 0.0
            for i in range(sizes.rows):
                values[i] = table[width * i + columns + k]
            for j in range(columns):
                speeds[j] = 0.0
            least_change(s, indices, columns, weights, values, speeds)
            for i in range(sizes.rows):
                rest = values[i]
                for j in range(columns):
                    rest -= table[width * i + j] * speeds[j]
                most = max(most, abs(rest))
            if most > tolerances.open:
                status = NOT_ALLOWED
            for n in range(len(driven)):
                speeds[driven[n].column] = 1.0 if n == k else 0.0
            write_outputs(outputs, path, links, free, maps, numbers, driven, speeds, inputs, k, jacobian)
        for c in range(columns):  # unit speeds, less what rows see of them
            if weights[c] == 0.0:
                continue
            for j in range(columns):
                speeds[j] = 1.0 if j == c else 0.0
            for _ in range(2):
                for n in range(indices.rank):
                    share = 0.0
                    for j in range(columns):
                        share += s.direction[n, j] * speeds[j]
                    for j in range(columns):
                        speeds[j] -= share * s.direction[n, j]
            if largest_output(outputs, path, links, free, speeds) > tolerances.open:
                status = OPEN
        return status

    @algorithm
    def general(
        links: Rows[Link], shared: Rows[Shared], cuts: Rows[Cut], targets: Rows[Target], loops: Rows[Loop],
        path: Rows[PathStep], driven: Rows[Driven], sizes: Sizes, numbers: Reals, tolerances: Tolerances,
        outputs: Rows[Output],
        points: Reals, given: Rows[8], jacobian: Out[Reals], residuals: Out[Reals], statuses: Out[Ints],
        relative: InOut[Rows[8]], motors: InOut[Rows[8]], carry: InOut[Rows[36]], free: InOut[Rows[6]],
        rows: InOut[Rows[6]], errors: InOut[Reals], off: InOut[Reals], maps: InOut[Rows[36]], table: InOut[Reals],
        s: InOut[Numbers], indices: InOut[Indices],
    ) -> None:  # fmt: skip
        """As `elimination`, all unknown speeds at once: the least ones."""
        r.set_links(links, given, relative)
        residuals[0] = fill_rows(
            links, shared, cuts, targets, loops, path, driven, sizes, numbers, relative, motors, carry, free, rows,
            errors, off, table, s,
        )  # fmt: skip
        r.set_maps(outputs, numbers, points, motors, maps)
        status = solve_directions(
            outputs, path, links, free, driven, sizes, numbers, maps, tolerances, table, jacobian, s, indices
        )
        statuses[0] = checked(status, jacobian)

    return JacobianAlgorithms(elimination, general)
