"""Where rays meet evolved surfaces, with certainty: exact rational arithmetic from the definition (python-flint).

The projection of a sum to a blade is the part of its skew matrix (`blades.py`) in the invariant plane of larger square.
With a curve's sums as polynomials in t the matrix is B(t); the blade is B1 = U + s V with s = sqrt(D), and so are the
condition F = (L v C)^2, or L ^ P for pairs, and its norm G = U^2 - D V^2, a polynomial with whole coefficients. Its
real roots are isolated, and each is one of F if U and V have opposite signs there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from math import comb, lcm

from flint import arb, ctx, fmpq, fmpz_poly

from ..sequences import cross
from .blades import INFINITY, METRIC, PAIRS, Skew, agree, complement, parity, pieces, point, unit_objects
from .families import Controls, Family

#: Bits of the first try, 51 digits; doubled until every sign is sure.
BITS, MOST_BITS = 170, 5_000
#: Newton steps from a start that is good to some 1e-8.
NEWTON = 8
#: No root may be as near as this to an end of the curve: it would be for rounding to decide.
NEAR_END = fmpq(1, 10**12)


class NotRealError(Exception):
    """The surface has no real object for some t, or its objects oppose each other."""


@dataclass(frozen=True)
class Piece:
    """One polynomial piece: 2 U and 2 V of the blade B1 = U + s V, and D = s^2; all with whole coefficients."""

    kind: str
    ends: int
    u: list[list[fmpz_poly]]
    v: list[list[fmpz_poly]]
    d: fmpz_poly
    p: fmpz_poly
    q4: fmpz_poly

    def condition(self, line: dict[tuple[int, int], int]) -> tuple[fmpz_poly, fmpz_poly]:
        """U and V of F."""
        if self.kind == "pairs":
            return tuple(  # type: ignore[return-value]
                reduce(lambda a, b: a + b, (line[i, j] * b[i][j] for i, j in PAIRS)) for b in (self.u, self.v)
            )
        even, odd = fmpz_poly([0]), fmpz_poly([0])
        for m in range(5):
            yu, yv = fmpz_poly([0]), fmpz_poly([0])
            rest = [k for k in range(5) if k != m]
            for i, j in combinations(rest, 2):
                k, n = (x for x in rest if x not in (i, j))
                weight = parity((m, i, j, k, n)) * line[i, j]
                if weight:
                    yu += weight * self.u[k][n]
                    yv += weight * self.v[k][n]
            even += METRIC[m] * (yu * yu + self.d * yv * yv)
            odd += 2 * METRIC[m] * yu * yv
        return even, odd

    def norm(self, even: fmpz_poly, odd: fmpz_poly) -> fmpz_poly:
        """G without the factors t (1 - t), which blades at the ends bring."""
        if self.q4 == 0:  # D = p^2: F itself is a polynomial
            return even + self.p * odd
        factor = fmpz_poly([0, 1, -1]) ** self.ends
        quotient, rest = divmod(even * even - self.d * odd * odd, factor)
        assert rest == 0
        return quotient

    def blade(self, t: arb) -> list[list[arb]]:
        """B1 at t, up to a positive factor."""
        s = self.d(t).sqrt()
        return [[self.u[i][j](t) + s * self.v[i][j](t) for j in range(5)] for i in range(5)]


def prepared(family: Family, objects: Controls) -> list[Piece]:
    """All pieces of a surface.

    Raises
    ------
    NotRealError
    """
    units = unit_objects(objects)
    if not all(agree(a, b) for a, b in zip(units, units[1:], strict=False)):
        raise NotRealError
    return [_piece(family.kind, controls) for controls in pieces(family, objects)]


def _piece(kind: str, controls: list[Skew]) -> Piece:
    n = len(controls) - 1
    scale = lcm(*(int(x.q) for c in controls for x in c.values()))
    t, one = fmpz_poly([0, 1]), fmpz_poly([1, -1])
    zero = fmpz_poly([0])
    b = [[zero] * 5 for _ in range(5)]
    for i, j in PAIRS:
        for k, c in enumerate(controls):
            b[i][j] += int((c[i, j] * scale).p) * comb(n, k) * t**k * one ** (n - k)
        b[j][i] = -b[i][j]
    m = [[METRIC[j] * b[i][j] for j in range(5)] for i in range(5)]
    m2 = _times(m, m)
    sign = 1 if kind == "pairs" else -1
    p2 = sign * sum((m2[i][i] for i in range(5)), zero)  # twice the sum of both squares
    p = fmpz_poly([int(c) // 2 for c in p2.coeffs()])
    assert 2 * p == p2
    fourth = sum((m2[i][j] * m2[j][i] for i in range(5) for j in range(5)), zero)
    d = fourth - p * p
    q4 = p * p - d  # four times the product of both squares
    _check_real(p, d, q4)
    u = [[2 * x - sign * p * y for x, y in zip(*rows, strict=True)] for rows in zip(_times(m2, b), b, strict=True)]
    v = [[sign * y for y in row] for row in b]
    return Piece(kind, 2 if kind == "circles" else 1, u, v, d, p, q4)


def _times(x: list[list[fmpz_poly]], y: list[list[fmpz_poly]]) -> list[list[fmpz_poly]]:
    return [[sum((x[i][k] * y[k][j] for k in range(5)), fmpz_poly([0])) for j in range(5)] for i in range(5)]


def _check_real(p: fmpz_poly, d: fmpz_poly, q4: fmpz_poly) -> None:
    """Raise unless both squares differ, and the larger is positive, for all t in [0, 1]."""
    if real_roots(d) or p(0) <= 0:
        raise NotRealError
    turns = real_roots(p if q4 == 0 else q4)
    if any(not p(t) > 0 for t in turns):  # the larger square changes its sign where the product vanishes
        raise NotRealError


def real_roots(polynomial: fmpz_poly, simple: bool = False) -> list[arb]:
    """Isolated real roots in [0, 1], each once; with ``simple`` multiple ones are refused."""
    if sign_changes(polynomial) == 0 and polynomial(0) != 0 and polynomial(1) != 0:
        return []
    found = []
    for root, times in polynomial.complex_roots():
        if root.imag == 0 and not (root.real < 0 or root.real > 1):
            if simple and times > 1:
                raise ArithmeticError("a multiple root: choose another seed")
            found.append(root.real)
    return found


def sign_changes(polynomial: fmpz_poly) -> int:
    """Descartes: at least as many as there are roots between 0 and 1."""
    shifted = fmpz_poly(polynomial.coeffs()[::-1])(fmpz_poly([1, 1]))
    signs = [c > 0 for c in shifted.coeffs() if c != 0]
    return sum(a != b for a, b in zip(signs, signs[1:], strict=False))


def roots(piece: Piece, origin: list[fmpq], direction: list[fmpq]) -> list[arb]:
    """Parameters in [0, 1] at which a line meets the surface of a piece, rising; more than 50 digits of each."""
    even, odd = piece.condition(_whole(origin, direction))
    polynomial = piece.norm(even, odd)
    bits = BITS
    while True:
        ctx.prec = bits
        found = _sure(piece, polynomial, even, odd, origin, direction)
        if found is not None:
            ctx.prec = BITS
            return found
        bits *= 2
        if bits > MOST_BITS:
            raise ArithmeticError("a sign stays unsure: choose another seed")


def extremum(piece: Piece, origin: list[fmpq], direction: list[fmpq], start: float) -> tuple[float, float]:
    """Where F is extreme near a start, and F there over its second derivative."""
    u, v = piece.condition(_whole(origin, direction))
    rows = [[p, p.derivative(), p.derivative().derivative()] for p in (u, v, piece.d)]
    ctx.prec = 4 * BITS
    t = arb(start)
    for _ in range(NEWTON):
        (u0, u1, u2), (v0, v1, v2), (d0, d1, d2) = ([p(t) for p in row] for row in rows)
        s = d0.sqrt()
        ds = d1 / (2 * s)
        dds = (d2 / 2 - ds * ds) / s
        second = u2 + 2 * ds * v1 + s * v2 + dds * v0
        t = (t - (u1 + ds * v0 + s * v1) / second).mid()
    found = float(t.mid()), float(((u0 + s * v0) / second).mid())
    ctx.prec = BITS
    return found


def _whole(origin: list[fmpq], direction: list[fmpq]) -> dict[tuple[int, int], int]:
    """A line o ^ d ^ n_inf, scaled to whole numbers."""
    line = complement([point(origin), [*direction, fmpq(0), fmpq(0)], INFINITY])
    scale = lcm(*(int(x.q) for x in line.values()))
    return {k: int((x * scale).p) for k, x in line.items()}


def _sure(
    piece: Piece, polynomial: fmpz_poly, even: fmpz_poly, odd: fmpz_poly, origin: list[fmpq], direction: list[fmpq]
) -> list[arb] | None:
    """The roots that belong to F, or None if more digits are needed."""
    found = []
    for t in real_roots(polynomial, simple=True):
        if piece.q4 != 0:
            sign = even(t) * odd(t)
            if not (sign < 0 or sign > 0):
                return None
            if sign > 0:
                continue
        if not (t > NEAR_END and t < 1 - NEAR_END):
            raise ArithmeticError("a root at an end of the curve: choose another seed")
        if piece.kind == "pairs":
            inside = _between_ends(piece.blade(t), origin, direction)
            if inside is None:
                return None
            if not inside:
                continue
        found.append(t)
    return sorted(found, key=lambda t: float(t.mid()))


def _between_ends(blade: list[list[arb]], origin: list[fmpq], direction: list[fmpq]) -> bool | None:
    """Whether a line that meets the carrier of a pair does so between the points; None if nobody knows yet.

    With infinity put into the pair once comes the direction, with that put in once more the middle.
    """
    way = [sum((METRIC[k] * row[k] * int(INFINITY[k]) for k in range(5)), arb(0)) for row in blade]
    centre = [sum((METRIC[k] * row[k] * way[k] for k in range(5)), arb(0)) for row in blade]
    weight = centre[4] - centre[3]
    middle = [x / weight for x in centre[:3]]
    half = (centre[3] + centre[4]) / weight - sum((x * x for x in middle), arb(0))
    o, d = ([arb(x) for x in v] for v in (origin, direction))
    across = cross(d, way[:3])
    apart = cross([m - x for m, x in zip(middle, o, strict=True)], way[:3])
    t = sum((a * b for a, b in zip(apart, across, strict=True)), arb(0)) / sum((a * a for a in across), arb(0))
    away = sum(((x + t * v - m) ** 2 for x, v, m in zip(o, d, middle, strict=True)), arb(0))
    return True if away < half else False if away > half else None
