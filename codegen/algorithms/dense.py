"""Dense linear algebra of small systems, in place: each method once, for every size and target."""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.algorithm import with_tangent
from ..ir.loops.language import INFINITY, InOut, Int, Matrix, Out, Real, Reals, Static, Vector, empty, sqrt, unrolled

#: Jacobi's sweeps: convergence is quadratic, and six suffice for any 8 x 8 matrix.
SWEEPS = 12
#: Squares of off-diagonal elements, relative to those of the diagonal, that end Jacobi's sweeps.
DIAGONAL = 1e-34
#: Of a pivot more than this fraction is left, where half the digits of a solution are right.
SAFE = 1e-8


@algorithm
def cholesky(a: InOut[Matrix]) -> None:
    """Cholesky factor of a symmetric positive semidefinite matrix, in its lower half.

    A pivot that is not positive gives a row of zeros (Golub and Van Loan 4.2.8).
    """
    n = len(a)
    for j in range(n):
        for k in range(j):
            a[j, j] -= a[j, k] * a[j, k]
        a[j, j] = sqrt(a[j, j] if a[j, j] > 0.0 else 0.0)
        inverse = 1.0 / a[j, j] if a[j, j] > 0.0 else 0.0
        for i in range(j + 1, n):
            for k in range(j):
                a[i, j] -= a[i, k] * a[j, k]
            a[i, j] *= inverse


@algorithm
def substitute_forward(factor: Matrix, b: InOut[Vector]) -> None:
    """Replace b by L^-1 b for a lower triangular matrix L; where L has a zero on its diagonal, by zero."""
    for i in range(len(b)):
        for k in range(i):
            b[i] -= factor[i, k] * b[k]
        b[i] = b[i] / factor[i, i] if factor[i, i] > 0.0 else 0.0


@algorithm
def substitute_backward(factor: Matrix, b: InOut[Vector]) -> None:
    """Replace b by L^-T b for a lower triangular matrix L; where L has a zero on its diagonal, by zero."""
    n = len(b)
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= factor[k, i] * b[k]
        b[i] = b[i] / factor[i, i] if factor[i, i] > 0.0 else 0.0


@algorithm
def solve_cholesky_along(factor: Matrix, b: InOut[Vector], d_factor: Matrix, d_b: InOut[Vector]) -> None:
    """The same with its tangent: of A x = b, where A = L L^T, A dx = db - dA x."""
    n = len(b)
    substitute_forward(factor, b)
    substitute_backward(factor, b)
    for i in range(n):  # L^T x and dL^T x: dA x is dL times the one, and L times the other
        turned = 0.0
        d_turned = 0.0
        for k in range(i, n):
            turned += factor[k, i] * b[k]
            d_turned += d_factor[k, i] * b[k]
        for k in range(i, n):
            d_b[k] -= d_factor[k, i] * turned + factor[k, i] * d_turned
    substitute_forward(factor, d_b)
    substitute_backward(factor, d_b)


@with_tangent(solve_cholesky_along)
def solve_cholesky(factor: Matrix, b: InOut[Vector]) -> None:
    """Replace b by (L L^T)^-1 b."""
    substitute_forward(factor, b)
    substitute_backward(factor, b)


@algorithm
def factor(a: InOut[Reals], n: Int, order: InOut[Reals], scales: InOut[Reals]) -> None:
    """Replace a matrix of n rows by its factors L and U, L with ones on its diagonal (Golub and Van Loan 3.4).

    Rows are brought to one size by ``scales``, so that pivots can be compared; ``order`` has the row of each pivot.
    """
    for i in range(n):
        most = 0.0
        for j in range(n):
            most = max(most, abs(a[n * i + j]))
        scales[i] = 1.0 / most if most > 0.0 else 1.0
        for j in range(n):
            a[n * i + j] *= scales[i]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            best = i if abs(a[n * i + k]) > abs(a[n * best + k]) else best
        order[k] = float(best)
        if best != k:
            for j in range(n):
                a[n * k + j], a[n * best + j] = a[n * best + j], a[n * k + j]
        inverse = 1.0 / a[n * k + k]
        for i in range(k + 1, n):
            if a[n * i + k] != 0.0:
                a[n * i + k] *= inverse
                for j in range(k + 1, n):
                    a[n * i + j] -= a[n * i + k] * a[n * k + j]


@algorithm
def solve_factored(factors: Reals, n: Int, order: Reals, scales: Reals, b: InOut[Reals]) -> None:
    """Replace n numbers b by the solution of a x = b, of the factors of a."""
    for i in range(n):
        b[i] *= scales[i]
    for k in range(n):
        other = int(order[k])
        b[k], b[other] = b[other], b[k]
    for i in range(n):
        for k in range(i):
            b[i] -= factors[n * i + k] * b[k]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= factors[n * i + k] * b[k]
        b[i] /= factors[n * i + i]


@algorithm
def diagonalize(a: InOut[Matrix], v: Out[Matrix], n: Static) -> None:
    """Eigenvalues on the diagonal and eigenvectors in the columns of v, by cyclic Jacobi (Golub and Van Loan 8.5).

    Of a symmetric matrix, of which the first n rows and columns are meant.
    """
    for p in range(n):
        for q in range(n):
            v[p, q] = 1.0 if p == q else 0.0
    for _ in range(SWEEPS):
        off = 0.0
        on = 0.0
        for p in range(n):
            on += a[p, p] * a[p, p]
            for q in range(p + 1, n):
                off += a[p, q] * a[p, q]
        if not off > DIAGONAL * on:
            break
        for p in range(n):
            for q in range(p + 1, n):
                if not abs(a[p, q]) > 0.0:
                    continue
                theta = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
                t = (-1.0 if theta < 0.0 else 1.0) / (abs(theta) + sqrt(theta * theta + 1.0))
                c = 1.0 / sqrt(t * t + 1.0)
                s = t * c
                for k in range(n):
                    kp, kq = a[k, p], a[k, q]
                    a[k, p], a[k, q] = c * kp - s * kq, s * kp + c * kq
                for k in range(n):
                    pk, qk, vp, vq = a[p, k], a[q, k], v[k, p], v[k, q]
                    a[p, k], a[q, k] = c * pk - s * qk, s * pk + c * qk
                    v[k, p], v[k, q] = c * vp - s * vq, s * vp + c * vq


@algorithm
def least_eigenvector(a: InOut[Matrix[4, 4]], vector: Out[Vector[4]]) -> tuple[Real, Real]:
    """Eigenvector of the least eigenvalue of a symmetric matrix; that value, and the distance to the next one."""
    v = empty(4, 4)
    diagonalize(a, v, 4)
    least = 0
    for p in range(1, 4):
        least = p if a[p, p] < a[least, least] else least
    following = INFINITY
    for p in range(4):
        following = a[p, p] if p != least and a[p, p] < following else following
    for k in range(4):
        vector[k] = v[k, least]
    return a[least, least], following - a[least, least]


@algorithm
def select_rank(values: InOut[Vector], rank: Int) -> Real:
    """The value that stands at a rank once values are in order; they are put in another order (Hoare's FIND)."""
    low = 0
    high = len(values) - 1
    while low < high:
        pivot = values[rank]
        i = low
        j = high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i > j:
                break
            values[i], values[j] = values[j], values[i]
            i += 1
            j -= 1
        if j < rank:
            low = i
        if rank < i:
            high = j
    return values[rank]


@algorithm
def solve_damped_rows(a: Matrix, n: Int, b: Vector, damping: Real, x: Out[Vector]) -> Real:
    """Least x and y with a x + damping y = b, by modified Gram-Schmidt on the rows; the square of b - a x.

    Golub and Van Loan 5.2.8, of the transpose.
    """
    m = len(b)
    directions = empty(m, len(a[0]) + m)
    parts = empty(m)
    for r in range(m):
        value = b[r]
        for j in range(n):
            directions[r, j] = a[r, j]
        for i in range(m):
            directions[r, n + i] = damping if i == r else 0.0
        for i in range(r):
            c = 0.0
            for j in range(n + m):
                c += directions[i, j] * directions[r, j]
            for j in range(n + m):
                directions[r, j] -= c * directions[i, j]
            value -= c * parts[i]
        square = 0.0
        for j in range(n + m):
            square += directions[r, j] * directions[r, j]
        length = sqrt(square)
        for j in range(n + m):
            directions[r, j] /= length
        parts[r] = value / length
    for j in range(n):
        x[j] = 0.0
        for r in range(m):
            x[j] += directions[r, j] * parts[r]
    left = 0.0
    for r in range(m):
        rest = b[r]
        for j in range(n):
            rest -= a[r, j] * x[j]
        left += rest * rest
    return left


@algorithm
def solve_damped(a: Matrix, n: Int, b: Vector, damping: Real, x: Out[Vector]) -> Real:
    """Least x and y with a x + damping y = b; the square of b - a x. Of a the first n columns are meant.

    By (a a^T + damping^2) z = b and x = a^T z, or where half the digits of that would be lost by modified Gram-Schmidt.
    """
    m = len(b)
    factor = empty(m, m)
    pivots = empty(m)
    z = empty(m)
    square = damping * damping
    for r in unrolled(m):
        for i in unrolled(r + 1):
            factor[r, i] = 0.0
    for j in range(n):
        for r in unrolled(m):
            for i in unrolled(r + 1):
                factor[r, i] += a[r, j] * a[i, j]
    is_safe = True
    for r in unrolled(m):  # L D L^T
        whole = factor[r, r] + square
        z[r] = b[r]
        pivots[r] = whole
        for i in unrolled(r):
            part = factor[r, i]
            for k in unrolled(i):
                part -= factor[r, k] * factor[i, k]
            factor[r, i] = part
        for i in unrolled(r):
            scaled = factor[r, i] * pivots[i]
            pivots[r] -= factor[r, i] * scaled
            factor[r, i] = scaled
            z[r] -= scaled * z[i]
        is_safe = is_safe and pivots[r] > SAFE * whole
        pivots[r] = 1.0 / pivots[r]
    if not is_safe:
        return solve_damped_rows(a, n, b, damping, x)
    for r in unrolled(m):
        z[m - 1 - r] *= pivots[m - 1 - r]
        for i in unrolled(m - r, m):
            z[m - 1 - r] -= factor[i, m - 1 - r] * z[i]
    for j in range(n):
        x[j] = 0.0
        for r in unrolled(m):
            x[j] += a[r, j] * z[r]
    left = 0.0
    for r in unrolled(m):
        rest = b[r]
        for j in range(n):
            rest -= a[r, j] * x[j]
        left += rest * rest
    return left


@algorithm
def rank_of(a: InOut[Matrix], n: Int, dependent: Real) -> Int:
    """Rank of the first n columns of a, by elimination: the longest row, off all others, then the next.

    Rows of which less is left than the dependent fraction of the longest count as zero; a is changed.
    """
    m = len(a)
    squares = empty(m)
    most = 0.0
    rank = 0
    for r in range(m):
        squares[r] = 0.0
        for j in range(n):
            squares[r] += a[r, j] * a[r, j]
        most = max(most, squares[r])
    for _ in range(m):
        best = 0
        for r in range(1, m):
            best = r if squares[r] > squares[best] else best
        if not squares[best] > dependent * dependent * most:
            break
        rank += 1
        for r in range(m):
            if r == best or squares[r] < 0.0:
                continue
            c = 0.0
            for j in range(n):
                c += a[r, j] * a[best, j]
            c /= squares[best]
            squares[r] = 0.0
            for j in range(n):
                a[r, j] -= c * a[best, j]
                squares[r] += a[r, j] * a[r, j]
        squares[best] = -1.0
    return rank
