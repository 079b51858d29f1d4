"""Points and quadrics of the algebras whose vectors, or bivectors, hold all quadratic monomials of a position.

QCGA: Breuils, Nozick, Sugimoto, Hitzer, "Quadric conformal geometric algebra of R^(9,6)", 2018. DCGA: Easter, Hitzer,
"Double conformal geometric algebra", 2017.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ..objects.euclidean import coordinates

#: The third of three equal parts in which constants stand at ni1, ni2, ni3.
PARTS = 3


def point(position: Multivector) -> Multivector:
    """x + (x1^2 ni1 + x2^2 ni2 + x3^2 ni3)/2 + x1 x2 ni4 + x1 x3 ni5 + x2 x3 ni6 + no1 + no2 + no3."""
    x = coordinates(position)
    pairs = [(x[0], x[1]), (x[0], x[2]), (x[1], x[2])]
    squares = [c * c / 2 * position.basis(f"ni{i + 1}") for i, c in enumerate(x)]
    mixed = [a * b * position.basis(f"ni{i + 4}") for i, (a, b) in enumerate(pairs)]
    return position.sum([position, *squares, *mixed, *(position.basis(f"no{i}") for i in (1, 2, 3))])


def quadric(squares: Multivector, mixed: Multivector, linear: Multivector, constant: Multivector) -> Multivector:
    """The vector q with point(x) . q = a x^2 + b y^2 + c z^2 + d x y + e x z + f y z + g x + h y + i z + j.

    ``squares`` holds a, b, c; ``mixed`` d, e, f; ``linear`` g, h, i.
    """
    parts = [-2 * c * linear.basis(f"no{i + 1}") for i, c in enumerate(coordinates(squares))]
    parts += [-c * linear.basis(f"no{i + 4}") for i, c in enumerate(coordinates(mixed))]
    parts += [-constant / PARTS * linear.basis(f"ni{i}") for i in (1, 2, 3)]
    return linear.sum([linear, *parts])


def double_point(position: Multivector) -> Multivector:
    """C(x) ^ C'(x): the points of the two copies of CGA."""
    x = [position["e1"], position["e2"], position["e3"]]
    half = position.sum(c * c for c in x) / 2
    first = position.sum([position, half * position.basis("ni"), position.basis("no")])
    second = [c * position.basis(f"e{i + 4}") for i, c in enumerate(x)]
    return first ^ position.sum([*second, half * position.basis("mi"), position.basis("mo")])
