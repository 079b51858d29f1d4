"""Basis blades: the one place that knows how basis vectors multiply.

Plain data and integer arithmetic only: no NumPy, no SymPy. Products of blades are computed on demand and cached; there
is no table of 4^n entries, so many dimensions cost nothing until they are used.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import combinations, groupby

from ..errors import BladeError, SignatureError, SpecError, one_line, suggest

#: Typed multivectors have at most this many dimensions; a blade is a bit mask of basis vectors.
MAX_DIMENSION = 24
#: In more dimensions the blades are too many for a list.
LISTED = 16
#: Letters of a name at most, and of the digest at the end of one that would be longer.
LONGEST_NAME, DIGITS = 64, 8
_IDENTIFIER = re.compile(rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST_NAME - 1}}}")
_LIKE_NUMBERED = re.compile(r"e(?:[0-9]|$)")
_NUMBERS = re.compile(r"e?([0-9]+)")
_METRIC_ENTRY = re.compile(r"-?[0-9]{1,400}(?:/0*[1-9][0-9]{0,400})?")  # every double is one
#: A sum of blades: bit masks with rational coefficients.
BladeTerms = tuple[tuple[int, Fraction], ...]


def metric_entry(value: object) -> Fraction:
    """An inner product of basis vectors as files write it: a whole number or a fraction, of at most 400 digits each.

    Raises
    ------
    SpecError
        If it is not that: `Fraction` would compute powers of ten of any size.
    """
    text = str(value)
    if not _METRIC_ENTRY.fullmatch(text):
        raise SpecError(f"an entry of the metric is {one_line(text)}; it is a whole number or a fraction such as 1/2.")
    return Fraction(text)


def check_dimension(n: int, what: str) -> None:
    """Check a number of basis vectors; ``what`` begins the message.

    Raises
    ------
    SignatureError
        If it exceeds `MAX_DIMENSION`.
    """
    if n > MAX_DIMENSION:
        raise SignatureError(f"{what}; typed multivectors go to {MAX_DIMENSION} dimensions. Use fewer basis vectors.")


def validated_identifier(name: object, what: str) -> str:
    """Return ``name`` if it is a plain ASCII identifier; names from users' files pass through here.

    Raises
    ------
    SignatureError
        If ``name`` is not a string of letters, digits and underscores that starts with a letter.
    """
    if not isinstance(name, str) or not _IDENTIFIER.fullmatch(name):
        raise SignatureError(
            f"{what} is {name!r}; a name is a letter followed by letters, digits or underscores "
            f"({LONGEST_NAME} at most)."
        )
    return name


def shortened_identifier(name: str) -> str:
    """A name that is made of others, as long as names may be."""
    if len(name) <= LONGEST_NAME:
        return name
    digest = hashlib.sha256(name.encode()).hexdigest()[:DIGITS]
    return f"{name[: LONGEST_NAME - DIGITS - 1]}_{digest}"


def grade(blade: int) -> int:
    """Grade of a blade given as a bit mask."""
    return blade.bit_count()


def outer_sign(a: int, b: int) -> int:
    """Sign of ``a ^ b`` for blades in storage order: +1, -1, or 0 when they share a vector."""
    if a & b:
        return 0
    swaps = 0
    a >>= 1
    while a:
        swaps += (a & b).bit_count()
        a >>= 1
    return -1 if swaps & 1 else 1


def reverse_sign(blade: int) -> int:
    """Sign that reversion gives a blade: (-1)^(g(g-1)/2)."""
    return -1 if grade(blade) & 2 else 1


class BladeBasis:
    """Blades over named basis vectors with a metric: order, names, products. Parameters as of `algebra.Algebra`."""

    def __init__(
        self,
        name: str,
        vectors: Sequence[str],
        metric: Sequence[Sequence[int | Fraction]],
        pseudoscalar: str | None = None,
    ) -> None:
        self.name = validated_identifier(name, "the algebra's name")
        self.vectors = tuple(vectors)
        self.metric = tuple(tuple(Fraction(g) for g in row) for row in metric)
        self._check()
        self._products: dict[tuple[int, int], BladeTerms] = {}
        self.pseudoscalar_sign = 1
        self.pseudoscalar_name = pseudoscalar
        if pseudoscalar is not None:
            blade, sign = self.parse_blade(pseudoscalar)
            if blade != self.full_blade:
                raise SignatureError(f"pseudoscalar {pseudoscalar!r} does not hold every vector of {self.name}.")
            self.pseudoscalar_sign = sign

    def _check(self) -> None:
        n = len(self.vectors)
        check_dimension(n, f"{self.name} has {n} dimensions")
        if len(set(self.vectors)) != n:
            raise SignatureError(f"the basis vectors of {self.name} are not distinct: {', '.join(self.vectors)}.")
        words = [label for label in self.vectors if not label.isdigit()]
        for label in words:
            validated_identifier(label, "a basis vector's label")
        for label in sorted(words):
            if any(other != label and other.startswith(label) for other in words) or _LIKE_NUMBERED.match(label):
                raise SignatureError(
                    f"the basis vector {label} of {self.name} cannot be told apart in a blade's name: no name begins "
                    "with another one, or with e and a digit."
                )
        rows_fit = len(self.metric) == n and all(len(row) == n for row in self.metric)
        if not rows_fit or any(self.metric[i][j] != self.metric[j][i] for i in range(n) for j in range(i)):
            raise SignatureError(f"the metric of {self.name} is not a symmetric {n} x {n} matrix.")

    # -- shape ---------------------------------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        """Number of basis vectors."""
        return len(self.vectors)

    @property
    def full_blade(self) -> int:
        """Bit mask of the blade of all vectors."""
        return (1 << self.dimension) - 1

    @cached_property
    def blades(self) -> tuple[int, ...]:
        """All blades, by grade, then by index: the order of coefficients everywhere.

        Raises
        ------
        SignatureError
            In more than `LISTED` dimensions.
        """
        self.check_listed()
        return tuple(blade for g in range(self.dimension + 1) for blade in self.blades_of_grade(g))

    def check_listed(self) -> None:
        """Check that a list of all blades is not too long.

        Raises
        ------
        SignatureError
            In more than `LISTED` dimensions.
        """
        if self.dimension > LISTED:
            raise SignatureError(
                f"{self.name} has 2^{self.dimension} blades, which are not listed.",
                remedy="Name those that are meant: by kind=, grades= or blades=, or in a dictionary",
            )

    def blades_of_grade(self, g: int) -> Iterator[int]:
        """Blades of one grade in storage order."""
        return map(sum, combinations([1 << i for i in range(self.dimension)], g))

    def order(self, blades: Iterable[int]) -> tuple[int, ...]:
        """Distinct blades in storage order."""
        return tuple(sorted(set(blades), key=self.blade_key))

    def blade_key(self, blade: int) -> tuple[int, tuple[int, ...]]:
        """Sort key of the storage order."""
        return grade(blade), tuple(i for i in range(self.dimension) if blade >> i & 1)

    @cached_property
    def is_diagonal(self) -> bool:
        """True where the basis is orthogonal."""
        n = self.dimension
        return all(self.metric[i][j] == 0 for i in range(n) for j in range(n) if i != j)

    @cached_property
    def signature(self) -> tuple[int, int, int]:
        """(p, q, r) of the metric, by symmetric elimination in exact arithmetic (Sylvester's law)."""
        g = [list(row) for row in self.metric]
        p = q = 0
        live = list(range(self.dimension))
        while live:
            pivot = next((i for i in live if g[i][i] != 0), None)
            if pivot is None:
                pair = next(((i, j) for i in live for j in live if g[i][j] != 0), None)
                if pair is None:
                    break
                i, j = pair  # no square left: e_i + e_j has the square 2 g_ij
                for k in range(self.dimension):
                    g[i][k] += g[j][k]
                for k in range(self.dimension):
                    g[k][i] += g[k][j]
                continue
            square = g[pivot][pivot]
            p, q = (p + 1, q) if square > 0 else (p, q + 1)
            live.remove(pivot)
            row = list(g[pivot])
            for i in live:
                factor = g[i][pivot] / square
                for k in range(self.dimension):
                    g[i][k] -= factor * row[k]
        return p, q, self.dimension - p - q

    @property
    def is_degenerate(self) -> bool:
        """True where the pseudoscalar is not invertible; then the dual is the map J (thesis 1.4.5)."""
        return self.signature[2] > 0

    # -- names ---------------------------------------------------------------------------------------------

    def blade_name(self, blade: int) -> str:
        """Readable name, for example ``"1"``, ``"e12"``, ``"e1noni"``, ``"e1_12"``; in the order of the vectors."""
        if blade == 0:
            return "1"
        joint = "_" if self.has_wide_labels else ""
        runs = self.label_runs(blade)
        return joint.join(("e" if run[0].isdigit() else "") + joint.join(run) for run in runs)

    def label_runs(self, blade: int) -> list[list[str]]:
        """Labels of a blade's vectors in storage order, those with numbers and those of letters in turn."""
        labels = [v for i, v in enumerate(self.vectors) if blade >> i & 1]
        return [list(run) for _, run in groupby(labels, str.isdigit)]

    @cached_property
    def has_wide_labels(self) -> bool:
        """True where numbers of vectors have several digits, so that their names need something between them."""
        return any(label.isdigit() and len(label) > 1 for label in self.vectors)

    def parse_blade(self, name: str | Sequence[int]) -> tuple[int, int]:
        """Blade and sign of a name in any order of vectors: ``"e21"`` is ``-e12``.

        Raises
        ------
        BladeError
            If the name holds a vector that the algebra does not have, or one twice.
        """
        labels = self._labels(name)
        blade, sign = 0, 1
        for label in labels:
            bit = 1 << self.vectors.index(label)
            sign *= outer_sign(blade, bit)
            blade |= bit
        if sign == 0:
            raise BladeError(f"blade {name!r} names a vector twice; a blade holds each vector once.")
        return blade, sign

    def _labels(self, name: str | Sequence[int]) -> list[str]:
        if not isinstance(name, str):
            if not isinstance(name, (tuple, list, range)):
                raise self._unknown(name)
            labels = [str(i) for i in name]
            for label in labels:
                if label not in self.vectors:
                    raise self._unknown(name)
            return labels
        if name in ("1", "", "e"):
            return []
        cut = self._cut(name)
        if cut is None and name[0] == "e":  # "enoni" is "noni", as "e12" is "12"
            cut = self._cut(name[1:])
        if cut is None:
            raise self._unknown(name)
        return cut

    def _cut(self, name: str) -> list[str] | None:
        """The labels of a blade's name; None where it has an unknown one."""
        labels, rest = [], name
        while rest:
            label, rest = self._first_label(rest)
            if label not in self.vectors:
                return None
            labels.append(label)
        return labels

    def _first_label(self, text: str) -> tuple[str, str]:
        """The label that a name begins with, and the rest. No label of letters begins with another."""
        if numbers := _NUMBERS.match(text):
            end = numbers.end() if self.has_wide_labels else numbers.start(1) + 1
            return text[numbers.start(1) : end], text[end:].removeprefix("_")
        label = next((v for v in self.vectors if not v.isdigit() and text.startswith(v)), "")
        return label, text[len(label) :].removeprefix("_")

    def _unknown(self, name: object) -> BladeError:
        hint = suggest(str(name), [self.blade_name(b) for b in self.blades]) if self.dimension <= 8 else ""
        return BladeError(f"{name!r} is not a blade of {self.name}{hint}; its vectors are {self._vector_names()}.")

    def _vector_names(self) -> str:
        return ", ".join(self.blade_name(1 << i) for i in range(self.dimension))

    # -- products ------------------------------------------------------------------------------------------

    def product(self, a: int, b: int) -> BladeTerms:
        """Geometric product of two blades as ``((blade, coefficient), ...)``."""
        key = (a, b)
        known = self._products.get(key)
        if known is None:
            known = self._products[key] = self._diagonal(a, b) if self.is_diagonal else self._general(a, b)
        return known

    def _diagonal(self, a: int, b: int) -> BladeTerms:
        swaps, rest = 0, a >> 1
        while rest:
            swaps += (rest & b).bit_count()
            rest >>= 1
        scale = Fraction(-1 if swaps & 1 else 1)
        common = a & b
        while common:
            low = common & -common
            i = low.bit_length() - 1
            scale *= self.metric[i][i]
            common ^= low
        return ((a ^ b, scale),) if scale else ()

    def _general(self, a: int, b: int) -> BladeTerms:
        """A = e_i ^ R, hence A B = e_i (R B) - (e_i . R) B, recursively on the grade of A."""
        if a == 0:
            return ((b, Fraction(1)),)
        low = a & -a
        i, rest = low.bit_length() - 1, a ^ low
        total: dict[int, Fraction] = {}
        for blade, scale in self.product(rest, b):
            if sign := outer_sign(low, blade):
                total[low | blade] = total.get(low | blade, Fraction(0)) + sign * scale
            for lower, inner in self._contract(i, blade):
                total[lower] = total.get(lower, Fraction(0)) + inner * scale
        for lower, inner in self._contract(i, rest):
            for blade, scale in self.product(lower, b):
                total[blade] = total.get(blade, Fraction(0)) - inner * scale
        return tuple((blade, total[blade]) for blade in self.order(total) if total[blade])

    def _contract(self, i: int, blade: int) -> list[tuple[int, Fraction]]:
        """Left contraction of basis vector ``i`` on a blade."""
        terms, sign = [], 1
        for j in range(self.dimension):
            if blade >> j & 1:
                if self.metric[i][j]:
                    terms.append((blade ^ (1 << j), sign * self.metric[i][j]))
                sign = -sign
        return terms
