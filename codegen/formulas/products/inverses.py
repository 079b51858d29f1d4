"""Inverses of general multivectors (thesis 1.2.5): Shirokov's, for every dimension and metric, and the closed
forms of Hitzer and Sangwine, to five dimensions. (The third, by matrices, needs a linear solver: see
`frames.left_multiplication`.) Versors have a cheaper one, `versors.versor_inverse`.

All work in the smallest algebra that holds x: only the basis vectors that x names count, and even multivectors
of n vectors form an algebra of n - 1. The determinant is one of the metric's polynomials, so a degenerate or
non-diagonal metric changes nothing.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.blades import grade
from ...algebra.multivector import Multivector
from ...errors import GradeError
from ...status import Status
from ...trace.outputs import Result
from .outcome import as_computed, is_finite, outcome, size, where_or_nan

#: Largest x V - 1 (sum of coefficients) of an inverse V. Where the determinant is rounding noise, so is the rest of
#: x Adj(x), and the residual is about 1 or larger; that of an ill-conditioned x is its condition times rounding.
RESIDUAL = Fraction(1, 16)
#: The closed forms end here.
MAX_HITZER_DIMENSION = 5


def effective_dimension(x: Multivector) -> int:
    """Number of basis vectors that the blades of x name."""
    used = 0
    for blade in x.terms:
        used |= blade
    return used.bit_count()


def representation_size(x: Multivector) -> int:
    """Size N of the matrices that represent the algebra of x: the degree of its determinant."""
    n = effective_dimension(x)
    if n and all(g % 2 == 0 for g in x.grades):
        n -= 1
    return int(2 ** ((n + 1) // 2))


def shirokov_adjugate(x: Multivector) -> Multivector:
    """Adj(x) with x Adj(x) = det(x): the recursion of Faddeev and LeVerrier with the trace N <.>_0.

    U_1 = x, U_(k+1) = x (U_k - C_k), C_k = N/k <U_k>_0; Adj = C_(N-1) - U_(N-1).
    """
    n = representation_size(x)
    if n == 1:
        return x.constant(1)
    power = x
    for k in range(1, n - 1):
        power = x * (power - Fraction(n, k) * power.grade(0))
    return Fraction(n, n - 1) * power.grade(0) - power


def hitzer_adjugate(x: Multivector) -> Multivector:
    """The closed forms of Hitzer and Sangwine: products of conjugates that leave a scalar.

    Raises
    ------
    GradeError
        Beyond five dimensions, where none is known.
    """
    n = effective_dimension(x)
    if n > MAX_HITZER_DIMENSION:
        raise GradeError(f"Hitzer's inverse goes to {MAX_HITZER_DIMENSION} dimensions, not {n}; use Shirokov's.")
    bar, hat, rev = x.conjugate(), x.involute(), ~x
    match n:
        case 0:
            return x.constant(1)
        case 1:
            return hat
        case 2:
            return bar
        case 3:
            return bar * hat * rev
        case 4:
            return bar * negate_grades(x * bar, 3, 4)
    rest = bar * hat * rev
    return rest * negate_grades(x * rest, 1, 4)


def negate_grades(x: Multivector, *grades: int) -> Multivector:
    """x with the sign of some grades changed."""
    return x.scale_blades(lambda b: -1 if grade(b) in grades else 1)


def determinant(x: Multivector) -> Multivector:
    """det(x) = <x Adj(x)>_0, zero exactly where x has no inverse."""
    return x.scalar_product(shirokov_adjugate(x))


def shirokov(x: Multivector) -> tuple[Multivector, Result]:
    """Inverse of a general multivector, any dimension and metric. Status: SINGULAR, INVALID (not finite)."""
    return _divide(x, shirokov_adjugate(x))


def hitzer(x: Multivector) -> tuple[Multivector, Result]:
    """Inverse of a general multivector, to five dimensions. Status: SINGULAR, INVALID (not finite)."""
    return _divide(x, hitzer_adjugate(x))


def _divide(x: Multivector, adjugate: Multivector) -> tuple[Multivector, Result]:
    det = x.scalar_product(adjugate)
    inverse = adjugate / det
    regular = size(x * as_computed(inverse) - 1) <= RESIDUAL
    finite = is_finite(x)
    value = inverse * where_or_nan(regular, x.constant(1))
    return value, outcome(x, (~finite, Status.INVALID), (~regular, Status.SINGULAR))
