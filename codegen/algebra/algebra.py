"""Algebras and their kinds: named sets of blades with constraints that hold for every member.

Both are plain data: the constraints of a kind, and its random member, are text. `members` evaluates them, and
`kind_checks` proves that they fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import comb
from operator import index
from typing import Any, Protocol, SupportsIndex

from ..errors import KindError, SignatureError, one_line, suggest
from .blades import BladeBasis, check_dimension

#: Grades of more blades have no kind of their own.
MOST_BLADES = 1 << 13


class Sum(Protocol):
    """A sum of blades with coefficients in any ring: a multivector."""

    @property
    def terms(self) -> Mapping[int, Any]: ...
    @property
    def ring(self) -> Any: ...


class Algebra(BladeBasis):
    """A geometric algebra over named basis vectors with a constant, possibly non-diagonal, metric.

    Parameters
    ----------
    name : str
        Identifier, for example ``"cga3d"``.
    vectors : sequence of str
        Labels of the basis vectors in storage order: digits for e1, e2, ...; any other identifier stands for
        itself ("no", "ni").
    metric : sequence of sequences of int or Fraction
        The symmetric matrix of inner products of the basis vectors.
    pseudoscalar : str, optional
        Name of the blade that the dual and J are taken with (its order of vectors gives the sign). Default:
        all vectors in storage order.
    """

    @cached_property
    def kinds(self) -> dict[str, Kind]:
        """Kinds by name, in the order in which they were defined."""
        return {}

    def kind(self, name: str) -> Kind:
        """The kind of this name: its blades, with its constraints known.

        Raises
        ------
        KindError
            If the algebra has no such kind; the message names the nearest one.
        """
        try:
            return self.kinds[name]
        except (KeyError, TypeError):  # also what no dictionary has, such as a list
            hint = suggest(name, list(self.kinds)) if isinstance(name, str) else ""
            raise KindError(
                f"{self.name} has no kind {one_line(name)}{hint}; it has: {', '.join(self.kinds) or 'none'}."
            ) from None

    def layout(self, name: str) -> Kind:
        """The blades of a kind with nothing known of its coefficients."""
        return self.kind(name).layout

    def __repr__(self) -> str:
        p, q, r = self.signature
        return f"<Algebra {self.name}: Cl({p},{q},{r}) on {self._vector_names()}>"


@dataclass(frozen=True, eq=False)
class Kind:
    """Blades of an algebra, what is known of their coefficients, and a random member.

    Attributes
    ----------
    name : str
        Identifier, unique in the algebra; the layout of a kind carries the kind's name.
    blades : tuple of int
        Bit masks in storage order.
    constraints : tuple of str
        Expressions in ``x`` that vanish on every member. Empty for a layout.
    member : str
        Program for a random exact member; empty: every coefficient is free.
    form : str
        "multivector"; "number": a plain number per item, arrays without a component axis (`codegen.scalar`);
        "numbers": a row of plain numbers, which a formula sees as a tuple of scalars.
    """

    algebra: Algebra
    name: str
    blades: tuple[int, ...]
    constraints: tuple[str, ...] = ()
    member: str = ""
    form: str = "multivector"

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.blades)

    @cached_property
    def layout(self) -> Kind:
        """The same blades with nothing known."""
        return self if not self.constraints else replace(self, constraints=(), member="")

    @property
    def is_scalar_argument(self) -> bool:
        """True where arrays of this kind have no component axis."""
        return self.form == "number"

    @property
    def is_layout(self) -> bool:
        """True where nothing is known of the coefficients."""
        return not self.constraints

    @cached_property
    def identity(self) -> tuple[str, tuple[int, ...], tuple[str, ...], str]:
        """Key of equality: algebra, blades, constraints and form."""
        return self.algebra.name, self.blades, self.constraints, self.form

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Kind) and self.identity == other.identity)

    def __hash__(self) -> int:
        return hash(self.identity)

    def values(self, x: Sum) -> list[Any]:
        """Coefficients of ``x`` on this kind's blades, in order, zeros included."""
        zero = x.ring.constant(Fraction(0))
        return [x.terms.get(b, zero) for b in self.blades]

    def __repr__(self) -> str:
        return f"<{'layout' if self.is_layout else 'kind'} {self.name} of {self.algebra.name}>"


def add_plain_kinds(algebra: Algebra) -> None:
    """Kinds that every algebra has: one per grade, the even and odd parts, and everything (layouts all).

    In more than ten dimensions the grades of at most `MOST_BLADES` blades.
    """
    names = {0: "scalar", 1: "vector", 2: "bivector", 3: "trivector", 4: "quadvector"}
    n = algebra.dimension
    for g in range(n + 1):
        name = names.get(g, f"grade{g}")
        if g == n and n > 4:
            name = "pseudoscalar"
        if comb(n, g) <= MOST_BLADES:
            algebra.kinds.setdefault(name, Kind(algebra, name, tuple(algebra.blades_of_grade(g))))
    if n > 10:  # nobody means a layout of 2^n coefficients
        return
    even = tuple(b for b in algebra.blades if b.bit_count() % 2 == 0)
    odd = tuple(b for b in algebra.blades if b.bit_count() % 2 == 1)
    for name, blades in (("even", even), ("odd", odd), ("multivector", algebra.blades)):
        algebra.kinds.setdefault(name, Kind(algebra, name, blades))


def scalar_argument(algebra: Algebra) -> Kind:
    """Kind of a plain number per item: arrays of shape (...), without a component axis."""
    return Kind(algebra, "number", (0,), form="number")


def numbers(algebra: Algebra, count: int) -> Kind:
    """Kind of a row of ``count`` plain numbers."""
    return Kind(algebra, f"numbers{count}", (0,) * count, form="numbers")


def orthonormal(p: int, q: int = 0, r: int = 0, name: str | None = None) -> Algebra:
    """Cl(p, q, r) on orthonormal vectors: e1 .. ep square to +1, the next q to -1, the last r to 0.

    With r = 1 the null vector is e0 and comes first, so that ``orthonormal(3, 0, 1)`` is the usual PGA.

    Raises
    ------
    SignatureError
        If a count is not a non-negative integer, or p + q + r exceeds 24.
    """
    p, q, r = (_count(value, what) for value, what in ((p, "p"), (q, "q"), (r, "r")))
    n = p + q + r
    check_dimension(n, f"Cl({p},{q},{r}) has {n} dimensions")
    squares = [1] * p + [-1] * q + [0] * r
    labels = [str(i + 1) for i in range(n)]
    if r == 1:
        squares = [0, *squares[:-1]]
        labels = ["0", *labels[:-1]]
    metric = [[squares[i] if i == j else 0 for j in range(n)] for i in range(n)]
    return Algebra(name or f"cl{p}_{q}_{r}", labels, metric)


def _count(value: SupportsIndex, what: str) -> int:
    """A number of a signature; NumPy's integers count as such."""
    try:
        count = -1 if isinstance(value, bool) else index(value)
    except TypeError:
        count = -1
    if count < 0:
        raise SignatureError(f"{what} is {one_line(value)}; the numbers of a signature are non-negative integers.")
    return count
