"""Metrics as people write them: squares of vectors, a matrix, products of named vectors. All become exact fractions."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import islice
from numbers import Rational, Real
from operator import index
from typing import Any

from ..errors import SignatureError, SpecError, one_line, suggest
from .blades import MAX_DIMENSION, check_dimension, metric_entry, validated_identifier

Metric = list[list[Fraction]]
#: A binary fraction with a larger denominator is taken for a rounded decimal one, such as 0.1.
LARGEST_BINARY = 1 << 12
#: A numbered vector, as in e1 or e12.
_NUMBERED = re.compile(r"e([0-9]{1,4})")


def exact_entry(value: Any, what: str) -> Fraction:
    """An inner product of vectors: a whole number, a fraction, its text, or a float that is a binary fraction.

    Raises
    ------
    SignatureError
        If it is none of these: the metric is exact, and a rounded one would be another.
    """
    if isinstance(value, str):
        try:
            return metric_entry(value)
        except SpecError as error:
            raise SignatureError(error.what, where=what) from None
    try:
        return Fraction(index(value))
    except TypeError:
        pass
    if isinstance(value, Rational):  # also SymPy's
        return Fraction(int(value.numerator), int(value.denominator))
    if isinstance(value, Real):
        return _from_float(float(value), what)
    raise SignatureError(f"{what} is {one_line(value)}; it is a whole number or a fraction such as '1/2'.")


def _from_float(value: float, what: str) -> Fraction:
    if value - value != 0:
        raise SignatureError(f"{what} is {value}; it is a finite number.")
    fraction = Fraction(value)
    if fraction.denominator > LARGEST_BINARY:
        near = fraction.limit_denominator(1000)
        example = f"'{near}' or Fraction({near.numerator}, {near.denominator})" if near else "'p/q' or Fraction(p, q)"
        raise SignatureError(
            f"{what} is {value!r}, which is rounded; metrics are exact.", remedy=f"Write a fraction: {example}"
        )
    return fraction


def read_labels(vectors: str | Iterable[str]) -> list[str]:
    """Labels of vectors: ``"e1 e2 no"``, or a list of such names, gives ``["1", "2", "no"]``.

    Raises
    ------
    SignatureError
        If a name is no identifier, or stands there twice.
    """
    if isinstance(vectors, str):
        names: Sequence[Any] = vectors.replace(",", " ").split()
    else:
        try:
            names = list(islice(vectors, MAX_DIMENSION + 1))
        except TypeError:
            raise SignatureError(f"vectors is {one_line(vectors)}; it is a text such as 'e1 e2 no ni'.") from None
    check_dimension(len(names), "vectors names too many")
    labels = [_label(name) for name in names]
    if len(set(labels)) != len(labels):
        twice = next(name for i, name in enumerate(names) if labels[i] in labels[:i])
        raise SignatureError(f"vectors names {twice} twice.")
    return labels


def _label(name: Any) -> str:
    numbered = _NUMBERED.fullmatch(name) if isinstance(name, str) else None
    return numbered[1] if numbered else validated_identifier(name, "the name of a basis vector")


def usual_labels(metric: Metric) -> list[str]:
    """e1, e2, ...; a single null vector, orthogonal to all others, that comes first is e0."""
    null = [not any(row) for row in metric]
    start = 0 if null and null[0] and null.count(True) == 1 else 1
    return [str(start + i) for i in range(len(metric))]


def from_squares(squares: Iterable[Any]) -> Metric:
    """The diagonal metric of these squares.

    Raises
    ------
    SignatureError
        If one is not 1, -1 or 0.
    """
    try:
        values = list(islice(squares, MAX_DIMENSION + 1))
    except TypeError:
        values = [squares]
    check_dimension(len(values), "the signature has too many entries")
    entries = [exact_entry(value, f"entry {i} of the signature") for i, value in enumerate(values)]
    for i, entry in enumerate(entries):
        if entry not in (1, -1, 0):
            raise SignatureError(
                f"entry {i} of the signature is {entry}; they are the vectors' squares, 1, -1 or 0.",
                remedy="Write algebra(p, q, r) for numbers of vectors, and algebra(metric=...) for other squares",
            )
    return diagonal(entries)


def diagonal(entries: Sequence[Fraction]) -> Metric:
    """A metric with these squares and no other products."""
    return [[g if i == j else Fraction(0) for j in range(len(entries))] for i, g in enumerate(entries)]


def from_matrix(matrix: Any) -> Metric:
    """The metric of a square matrix: nested lists, an array, a SymPy matrix.

    Raises
    ------
    SignatureError
        If it is not square and symmetric, or an entry is not exact.
    """
    given = matrix.tolist() if hasattr(matrix, "tolist") else matrix
    try:
        rows = [list(row) for row in given]
    except TypeError:
        raise SignatureError(
            f"the metric is {one_line(matrix)}; it is a square matrix, or a dictionary such as {{'no|ni': -1}}."
        ) from None
    n = len(rows)
    check_dimension(n, f"the metric has {n} rows")
    if any(len(row) != n for row in rows):
        raise SignatureError(f"the metric is not square: {n} rows, of {', '.join(str(len(row)) for row in rows)}.")
    metric = [[exact_entry(g, f"entry ({i}, {j}) of the metric") for j, g in enumerate(r)] for i, r in enumerate(rows)]
    for i in range(n):
        for j in range(i):
            if metric[i][j] != metric[j][i]:
                raise SignatureError(
                    f"the metric is not symmetric: entry ({i}, {j}) is {metric[i][j]}, ({j}, {i}) is {metric[j][i]}."
                )
    return metric


def from_products(products: Mapping[Any, Any], labels: Sequence[str]) -> Metric:
    """The metric of inner products by names, ``{"no|ni": -1, "e1": 2}``; a vector that no key names squares to 1.

    Raises
    ------
    SignatureError
        If a key is no vector or pair of vectors of ``labels``, or says a product twice.
    """
    found: dict[tuple[int, int], Fraction] = {}
    for key, value in products.items():
        names = [part.strip() for part in key.split("|")] if isinstance(key, str) else []
        if len(names) not in (1, 2):
            raise SignatureError(
                f"{one_line(key)} in the metric is no product of vectors; write 'a|b', or 'a' for a square."
            )
        i, j = sorted(_place(name, labels) for name in (names[0], names[-1]))
        entry = exact_entry(value, f"{key} in the metric")
        if found.setdefault((i, j), entry) != entry:
            raise SignatureError(f"the metric gives {key} twice: {found[i, j]} and {entry}.")
    named = {i for pair in found for i in pair}
    metric = diagonal([Fraction(int(i not in named)) for i in range(len(labels))])
    for (i, j), entry in found.items():
        metric[i][j] = metric[j][i] = entry
    return metric


def _place(name: str, labels: Sequence[str]) -> int:
    try:
        return labels.index(_label(name))
    except (ValueError, SignatureError):
        known = [f"e{label}" if label.isdigit() else label for label in labels]
        raise SignatureError(
            f"the metric names the vector {one_line(name)}{suggest(name, known)}; there are {', '.join(known)}."
        ) from None
