"""Least squares of rows on motions: orthonormal directions of the rows, and the least motion that gives them values.

Rows are measured by kinetic energy: weights are roots of the inverse metric, so that one unit of mass or length is as
good as another. Directions are found by modified Gram-Schmidt, the row with the largest part of its own first (Golub
and Van Loan 5.2.8, 5.4.2), each orthogonalised twice; rows that are dependent are left out.
"""

# Annotations are evaluated here: sizes of records are those of the call of `weighted_rows`.
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.algorithm import still, with_tangent
from ..ir.loops.language import Bool, InOut, Int, IntVector, Matrix, Real, Vector, empty, sqrt, zeros
from ..ir.loops.records import Record, record

#: Columns beyond which it is faster to skip zeros of rows.
SPARSE = 96
#: A row whose weighted length is less than this fraction of the longest counts as zero.
NO_MOTION = 1e-11
#: Roundings of one row that add up, at most.
ROUNDINGS = 64.0
#: Beyond the limit of directions: the independent fraction of a row that counts. Less is rounding far from the origin.
COARSE = 1e-3


@dataclass(frozen=True, eq=False)
class WeightedRows:
    """Rows of a size, and what is done with them.

    Attributes
    ----------
    numbers, integers : Record
        Of one system of rows.

        - ``matrix``: the rows. ``right``, ``errors``, ``rates``, ``rounding``, ``unknown``: what callers keep for each.
        - ``sizes``: of the terms of its error; ``noise``: its rounding, weighted; ``scale``: its weighted length.
        - ``direction``, ``upper``, ``order``: the directions, the triangular matrix that gives them, and of which row
          each is; ``rank`` of them. ``excess``: 1 if rows beyond the limit are independent.
        - ``longest``, ``largest``: the most of scale and of sizes.
        - ``change``: the last one, see `least_change`.
        - The rest is for the algorithms.
    scale_rows : algorithm
        Weighted rows of length one: what comes before the directions.
    add_direction : algorithm
        One direction more; False if there is none.
    find_directions : algorithm
        Both.
    least_change : algorithm
        The least change of a motion, by energy, that gives the rows values.
    """

    numbers: Record
    integers: Record
    scale_rows: algorithm
    add_direction: algorithm
    find_directions: algorithm
    least_change: algorithm


@cache
def weighted_rows(rows: int, size: int, most_dense: int = SPARSE, is_open: bool = False) -> WeightedRows:
    """Systems of up to so many rows of a size, of which zeros are skipped beyond another; the bits are the same.

    If open, that is the largest size, and ``columns`` is the one in use; else nobody looks at it.
    """
    most = min(rows, size)
    sparse = size > most_dense
    Numbers: Any = record(
        "Rows", matrix=Matrix[rows, size], right=Vector[rows], errors=Vector[rows], rates=Vector[rows],
        sizes=Vector[rows], rounding=Vector[rows], noise=Vector[rows], unknown=Vector[rows], scale=Vector[rows],
        longest=Real, largest=Real, direction=Matrix[most, size], upper=Matrix[most, most],
        remainder=Matrix[rows, size], taken=Matrix[rows, most], norms=Vector[rows], least=Vector[rows],
        squares=Vector[rows], solution=Vector[most],
        change=Vector[size],
    )  # fmt: skip
    Integers: Any = record(
        "RowIndices", rank=Int, excess=Int, order=IntVector[most], bodies=IntVector[rows],
        powers=IntVector[rows],
        first=IntVector[rows], last=IntVector[rows], start=IntVector[most], end=IntVector[most],
    )  # fmt: skip

    @still
    def scale_rows(
        s: InOut[Numbers], indices: InOut[Integers], count: Int, columns: Int, weights: Vector[size], tolerance: Real
    ) -> None:
        """Weighted rows of length one, what of them counts as zero, and which columns are not zero."""
        width = columns if is_open else size
        longest = 0.0
        largest = 0.0
        for i in range(count):
            row = s.remainder[i]
            square = 0.0
            for j in range(width):
                row[j] = s.matrix[i, j] * weights[j]
                square += row[j] * row[j]
            scale = sqrt(square)
            s.scale[i] = scale
            longest = max(longest, scale)
            largest = max(largest, s.sizes[i])
        for i in range(count):
            row = s.remainder[i]
            rounding = ROUNDINGS * s.noise[i]
            scale = s.scale[i]
            if scale > max(NO_MOTION * longest, rounding):
                s.norms[i] = 1.0
                s.least[i] = max(tolerance, rounding / scale)
                for j in range(width):
                    row[j] /= scale
            else:
                s.norms[i] = 0.0
                s.least[i] = 1.0
            if sparse:
                first = width
                last = 0
                total = 0.0
                for j in range(width):
                    if row[j] == 0.0:
                        continue
                    first = first if last > 0 else j
                    last = j + 1
                    total += row[j] * row[j]
                s.squares[i] = total
                indices.first[i] = first
                indices.last[i] = last
        s.longest = longest
        s.largest = largest
        indices.rank = 0
        indices.excess = 0

    @algorithm
    def remove_direction(s: InOut[Numbers], indices: InOut[Integers], count: Int, columns: Int, k: Int) -> None:
        """Take a direction from the rows that are left."""
        q = empty(size)
        width = columns if is_open else size
        for j in range(width):
            q[j] = s.direction[k, j]
        start, end = 0, width
        if sparse:
            start, end = indices.start[k], indices.end[k]
        for i in range(count):
            if not s.norms[i] > 0.0:
                continue
            row = s.remainder[i]
            c = 0.0
            rest = 0.0
            if sparse and (indices.last[i] <= start or end <= indices.first[i]):
                rest = s.squares[i]
            else:
                first = min(start, indices.first[i]) if sparse else 0
                last = max(end, indices.last[i]) if sparse else width
                for j in range(start, end):
                    c += q[j] * row[j]
                for j in range(start, end):
                    row[j] -= c * q[j]
                for j in range(first, last):
                    rest += row[j] * row[j]
                if sparse:
                    indices.first[i] = first
                    indices.last[i] = last
                    s.squares[i] = rest
            s.taken[i, k] = c
            s.norms[i] = rest

    @still
    def add_direction(
        s: InOut[Numbers], indices: InOut[Integers], count: Int, columns: Int, k: Int, limit: Int
    ) -> Bool:
        """Direction k, behind those there are, of the row with the most of its own for its rounding; False if none.

        Which row that is differs between systems that are solved at once: rows are asked, not looked up.
        """
        width = columns if is_open else size
        if k >= (min(width, count) if is_open else most):
            return False
        q = empty(size)
        least = 0.0
        if sparse:
            start, end = 0, width
        while True:
            best = -1
            clearest = 1.0
            for i in range(count):
                clear = s.norms[i] / (s.least[i] * s.least[i])
                if clear > clearest:
                    best = i
                    clearest = clear
            if best < 0:
                return False
            for i in range(count):
                if i == best:
                    for j in range(width):
                        q[j] = s.remainder[i, j]
                    for j in range(k):
                        s.upper[j, k] = s.taken[i, j]
                    least = s.least[i]
                    s.norms[i] = 0.0
                    if sparse:
                        start, end = indices.first[i], indices.last[i]
            for i in range(k):  # once more: what rounding left
                low = indices.start[i] if sparse else 0
                high = indices.end[i] if sparse else width
                c = 0.0
                for j in range(low, high):
                    c += s.direction[i, j] * q[j]
                for j in range(low, high):
                    q[j] -= c * s.direction[i, j]
                if sparse and c != 0.0:
                    start = min(start, low)
                    end = max(end, high)
                s.upper[i, k] += c
            square = 0.0
            for j in range(width):
                square += q[j] * q[j]
            length = sqrt(square)
            if length > least:
                break
        s.upper[k, k] = length
        if limit > 0 and k == limit:
            indices.excess = 1 if length > COARSE else 0
            return False
        for j in range(width):
            s.direction[k, j] = q[j] / length
        indices.order[k] = best
        indices.rank = k + 1
        if sparse:
            indices.start[k] = start
            indices.end[k] = end
        remove_direction(s, indices, count, columns, k)
        return True

    @still
    def find_directions(
        s: InOut[Numbers], indices: InOut[Integers], count: Int, columns: Int, weights: Vector[size], tolerance: Real,
        limit: Int,
    ) -> None:  # fmt: skip
        """Directions of the first rows, as many as the limit at most unless that is zero.

        Stages of a step are a little off the constraints, where rows that depend on each other begin to differ: then
        there are no more directions than there were. Rows of which much is rounding come last, and rounding of a row
        is none.
        """
        scale_rows(s, indices, count, columns, weights, tolerance)
        k = 0
        more = True
        while more:
            more = add_direction(s, indices, count, columns, k, limit)
            k += 1

    @algorithm
    def solve_rows(
        s: Numbers, indices: Integers, columns: Int, weights: Vector[size], values: Vector[rows],
        x: InOut[Vector[size]],
        solution: InOut[Vector[most]], change: InOut[Vector[size]],
    ) -> None:  # fmt: skip
        """What `least_change` does."""
        width = columns if is_open else size
        for k in range(indices.rank):
            i = indices.order[k]
            value = values[i]
            for j in range(width):
                value -= s.matrix[i, j] * x[j]
            value /= s.scale[i]
            for j in range(k):
                value -= s.upper[j, k] * solution[j]
            solution[k] = value / s.upper[k, k]
        for j in range(width):
            change[j] = 0.0
        for k in range(indices.rank):
            for j in range(width):
                change[j] += s.direction[k, j] * solution[k]
        for j in range(width):
            x[j] += weights[j] * change[j]

    @algorithm
    def least_change_along(
        s: InOut[Numbers], indices: Integers, columns: Int, weights: Vector[size], values: Vector[rows],
        x: InOut[Vector[size]],
        d_s: InOut[Numbers], d_weights: Vector[size], d_values: Vector[rows], d_x: InOut[Vector[size]],
    ) -> None:  # fmt: skip
        """The same with its tangent, of A x = b with x - x0 = G A^T l, and G the squares of the weights.

        A dx = db - dA x, dx0 from dG A^T l + G dA^T l on: the directions at hand serve it too, none is differentiated.
        """
        width = columns if is_open else size
        force = zeros(size)
        right = empty(rows)
        multipliers = empty(most)
        solved = empty(most)
        change = empty(size)
        solve_rows(s, indices, columns, weights, values, x, s.solution, s.change)
        for m in range(indices.rank):
            k = indices.rank - 1 - m
            i = indices.order[k]
            multipliers[k] = s.solution[k]
            for j in range(k + 1, indices.rank):
                multipliers[k] -= s.upper[k, j] * multipliers[j]
            multipliers[k] /= s.upper[k, k]
            right[i] = d_values[i]
            for j in range(width):
                right[i] -= d_s.matrix[i, j] * x[j]
                force[j] += d_s.matrix[i, j] * (multipliers[k] / s.scale[i])
        for j in range(width):
            force[j] *= weights[j]
            if weights[j] > 0.0:
                force[j] += d_weights[j] / weights[j] * s.change[j]
            d_x[j] += weights[j] * force[j] + d_weights[j] * s.change[j]
        solve_rows(s, indices, columns, weights, right, d_x, solved, change)
        for j in range(width):
            d_s.change[j] = force[j] + change[j]

    @with_tangent(least_change_along)
    def least_change(
        s: InOut[Numbers], indices: Integers, columns: Int, weights: Vector[size], values: Vector[rows],
        x: InOut[Vector[size]],
    ) -> None:  # fmt: skip
        """The least change, by energy, of a motion x that gives the rows these values.

        In ``change`` it is times the roots of the metric: the rows of the force behind it are that times the roots
        again.
        """
        solve_rows(s, indices, columns, weights, values, x, s.solution, s.change)

    return WeightedRows(Numbers, Integers, scale_rows, add_direction, find_directions, least_change)
