"""All roots of a polynomial as the eigenvalues of its companion matrix: balancing, then QR steps with two implicit
shifts on the Hessenberg form, eigenvalues only. The printed method's solver, as numpy.roots has it from LAPACK.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import InOut, Int, Matrix, Real, Reals, Static, empty, epsilon, sqrt

#: QR steps for one eigenvalue before giving up; after FRESH steps without success the shift changes.
PATIENCE, FRESH = 60, 10
#: A shift that is no eigenvalue of a corner of the matrix, relative to its last two subdiagonal entries.
SHIFT = 1.5


@inlined
def balance(h: InOut[Matrix], n: Int) -> None:
    """Scale rows and columns by powers of two until their sums of absolute values are within a factor of two."""
    is_changed = True
    while is_changed:
        is_changed = False
        for i in range(n):
            column = 0.0
            row = 0.0
            f = 1.0
            for j in range(n):
                column += 0.0 if j == i else abs(h[j, i])
                row += 0.0 if j == i else abs(h[i, j])
            before = column + row
            if not (column > 0.0 and row > 0.0 and before - before == 0.0):
                continue
            while column < row * 0.5:
                column *= 2.0
                row *= 0.5
                f *= 2.0
            while column >= row * 2.0:
                column *= 0.5
                row *= 2.0
                f *= 0.5
            if not column + row < 0.95 * before:
                continue
            is_changed = True
            for j in range(n):
                h[i, j] /= f
            for j in range(n):
                h[j, i] *= f


@inlined
def sweep(m: InOut[Matrix], first: Int, last: Int, total: Real, product: Real) -> None:
    """One sweep over rows ``first`` to ``last``; sum and product of the two shifts."""
    # first column of (H - s1)(H - s2)
    p = m[first, first] * (m[first, first] - total) + m[first, first + 1] * m[first + 1, first] + product
    q = m[first + 1, first] * (m[first, first] + m[first + 1, first + 1] - total)
    r = m[first + 1, first] * m[first + 2, first + 1]
    for k in range(first, last):
        has_three = k < last - 1
        if k > first:
            p = m[k, k - 1]
            q = m[k + 1, k - 1]
            r = m[k + 2, k - 1] if has_three else 0.0
        size = abs(p) + abs(q) + abs(r)
        if size == 0.0:
            continue
        p /= size
        q /= size
        r /= size
        # the reflection 1 - v w^T that maps (p, q, r) to (-norm, 0, 0)
        root = sqrt(p * p + q * q + r * r)
        norm = -root if p < 0.0 else root
        v1 = q / (p + norm)
        v2 = r / (p + norm)
        w0 = (p + norm) / norm
        w1 = q / norm
        w2 = r / norm
        if k > first:
            m[k, k - 1] = -norm * size
            m[k + 1, k - 1] = 0.0
            if has_three:
                m[k + 2, k - 1] = 0.0
        for j in range(k, last + 1):
            dot = m[k, j] + v1 * m[k + 1, j] + (v2 * m[k + 2, j] if has_three else 0.0)
            m[k, j] -= dot * w0
            m[k + 1, j] -= dot * w1
            if has_three:
                m[k + 2, j] -= dot * w2
        for i in range(first, min(k + 3, last) + 1):
            dot = w0 * m[i, k] + w1 * m[i, k + 1] + (w2 * m[i, k + 2] if has_three else 0.0)
            m[i, k] -= dot
            m[i, k + 1] -= dot * v1
            if has_three:
                m[i, k + 2] -= dot * v2


@inlined
def eigenvalues(re: InOut[Reals], im: InOut[Reals], m: InOut[Matrix], n: Int) -> Int:
    """Real and imaginary parts of the eigenvalues of a Hessenberg matrix; how many were found, all but rarely."""
    count = 0
    last = n - 1
    steps = 0
    shift = 0.0  # taken off the whole diagonal so far
    while last >= 0:
        first = last
        while first > 0:
            near = abs(m[first, first]) + abs(m[first - 1, first - 1])
            if abs(m[first, first - 1]) <= epsilon() * near:
                break
            first -= 1
        if first == last:
            re[count] = m[last, last] + shift
            im[count] = 0.0
            count += 1
            last -= 1
            steps = 0
            continue
        total = m[last, last] + m[last - 1, last - 1]
        product = m[last, last] * m[last - 1, last - 1] - m[last, last - 1] * m[last - 1, last]
        if first == last - 1:
            half = 0.5 * (m[last - 1, last - 1] - m[last, last])
            mean = 0.5 * total + shift
            square = half * half + m[last, last - 1] * m[last - 1, last]
            root = sqrt(-square if square < 0.0 else square)
            # real: distances from the last diagonal entry, the larger one, and the other from their product
            far = half - root if half < 0.0 else half + root
            apart = m[last, last - 1] * m[last - 1, last]
            beside = 0.0 if far == 0.0 else -apart / far
            base = m[last, last] + shift
            re[count] = mean if square < 0.0 else base + far
            im[count] = root if square < 0.0 else 0.0
            re[count + 1] = mean if square < 0.0 else base + beside
            im[count + 1] = -root if square < 0.0 else 0.0
            count += 2
            last -= 2
            steps = 0
            continue
        steps += 1
        if steps > PATIENCE:
            break
        if steps % FRESH == 0:
            off = abs(m[last, last - 1]) + abs(m[last - 1, last - 2])
            corner = m[last, last]
            for i in range(last):
                m[i, i] -= corner
            shift += corner
            m[last, last] = 0.0
            total = SHIFT * off
            product = off * off
        sweep(m, first, last, total, product)
    return count


@algorithm
def polynomial_roots(degree: Static, powers: Reals, n: Int, re: InOut[Reals], im: InOut[Reals]) -> Int:
    """Roots of the sum of ``powers[k] x^k`` for k up to n, at most the degree.

    Their number, which is less than n if the highest powers are missing, or if the iteration does not end.
    """
    h = empty(degree, degree)
    while n > 0 and powers[n] == 0.0:
        n -= 1
    for i in range(n):
        for j in range(n):
            h[i, j] = -powers[n - 1 - j] / powers[n] if i == 0 else 1.0 if i == j + 1 else 0.0
    balance(h, n)
    return eigenvalues(re, im, h, n)  # type: ignore[no-any-return]
