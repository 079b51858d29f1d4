"""The dense product of Cl(4,1) through 4 x 4 complex matrices: a third of the operations of the blade table.

On the null basis a multivector is x = A + B n0 + C n_inf + D (n0 ^ n_inf) with A, B, C, D in Cl(3,0). With the
idempotents P = -n0 n_inf/2, Q = -n_inf n0/2 and the units E12 = n0, E21 = -n_inf/2 it is the 2 x 2 matrix
x = (A - D) P + B E12 - 2 C E21 + (A + D) Q over Cl(3,0), whose odd units involute what they pass. Cl(3,0) is the
algebra of 2 x 2 complex matrices (Pauli). Errors are relative to the largest coefficients of each block, not to
each term: see docs/development/decisions/arithmetic.md.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...algebra.multivector import Multivector


@dataclass(frozen=True)
class Complex:
    """Complex number over scalar multivectors."""

    re: Multivector
    im: Multivector

    def conjugate(self) -> Complex:
        """re - i im."""
        return Complex(self.re, -self.im)

    def __neg__(self) -> Complex:
        return Complex(-self.re, -self.im)


#: Rows of a 2 x 2 complex matrix: p, q, r, s for [[p, q], [r, s]].
Matrix = tuple[Complex, Complex, Complex, Complex]


def pauli_matrix(x: Multivector) -> Matrix:
    """Matrix of an element of Cl(3,0): e1, e2, e3 are the Pauli matrices and e123 is i."""
    s, v1, v2, v3 = x["1"], x["e1"], x["e2"], x["e3"]
    i, b1, b2, b3 = x["e123"], x["e23"], -x["e13"], x["e12"]
    return (
        Complex(s + v3, i + b3),
        Complex(v1 + b2, b1 - v2),
        Complex(v1 - b2, b1 + v2),
        Complex(s - v3, i - b3),
    )


def from_pauli_matrix(m: Matrix, like: Multivector) -> Multivector:
    """Twice the element of Cl(3,0) with this matrix."""
    p, q, r, s = m
    parts = {
        "1": p.re + s.re, "e3": p.re - s.re, "e123": p.im + s.im, "e12": p.im - s.im,
        "e1": q.re + r.re, "e13": r.re - q.re, "e23": q.im + r.im, "e2": r.im - q.im,
    }  # fmt: skip
    return like.sum(value * like.basis(name) for name, value in parts.items())


def involution(m: Matrix) -> Matrix:
    """Matrix of the grade involution: the conjugate of the adjugate; signs only."""
    p, q, r, s = m
    return s.conjugate(), -r.conjugate(), -q.conjugate(), p.conjugate()


def blocks(x: Multivector) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Entries of the 2 x 2 matrix over Cl(3,0), each as a Pauli matrix."""
    a, b, c, d = (euclidean_part(x, name) for name in ("1", "no", "ni", "noni"))
    return pauli_matrix(a - d), pauli_matrix(b), pauli_matrix(-2 * c), pauli_matrix(a + d)


def euclidean_part(x: Multivector, null: str) -> Multivector:
    """The X in Cl(3,0) of the term X null, for null = 1, no, ni, noni."""
    nulls, _ = x.algebra.parse_blade("noni")
    wanted, _ = x.algebra.parse_blade(null)
    return x.new({b & ~nulls: c for b, c in x.terms.items() if b & nulls == wanted})


def _entries(pairs: list[tuple[Matrix, Matrix]], like: Multivector) -> Matrix:
    """Sum of matrix products, each coefficient as one sum."""

    def entry(row: int, column: int) -> Complex:
        re, im = [], []
        for x, y in pairs:
            for k in range(2):
                a, b = x[2 * row + k], y[2 * k + column]
                re += [a.re * b.re, -(a.im * b.im)]
                im += [a.re * b.im, a.im * b.re]
        return Complex(like.sum(re), like.sum(im))

    return entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)


def geometric_dense(a: Multivector, b: Multivector) -> Multivector:
    """Geometric product of dense multivectors of 3D CGA, through 4 x 4 complex matrices."""
    x11, x12, x21, x22 = blocks(a)
    y11, y12, y21, y22 = blocks(b)
    z11 = from_pauli_matrix(_entries([(x11, y11), (x12, involution(y21))], a), a)
    z12 = from_pauli_matrix(_entries([(x11, y12), (x12, involution(y22))], a), a)
    z21 = from_pauli_matrix(_entries([(x21, involution(y11)), (x22, y21)], a), a)
    z22 = from_pauli_matrix(_entries([(x21, involution(y12)), (x22, y22)], a), a)
    parts = {"1": (z11 + z22) / 4, "noni": (z22 - z11) / 4, "no": z12 / 2, "ni": z21 / -4}
    return a.sum(z ^ a.basis(null) for null, z in parts.items())
