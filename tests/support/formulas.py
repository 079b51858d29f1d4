"""What the tests of formulas share: stock algebras, random members as arrays, formulas traced and run on numbers.

Oracles here are independent of the closed forms under test: a scaled and squared series for exp, homogeneous
matrices for motions.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from bladesmith.codegen.algebra import loader
from bladesmith.codegen.algebra.algebra import Algebra, Kind, add_plain_kinds, orthonormal, scalar_argument
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.multivector import Multivector, from_values
from bladesmith.codegen.algebra.schema import stock_spec_path
from bladesmith.codegen.rings.protocol import NumericRing, PrecisionRing
from bladesmith.codegen.trace.kernel import Kernel
from bladesmith.codegen.trace.trace import trace

EPS = float(np.finfo(float).eps)
Array = np.ndarray


@cache
def stock(name: str) -> Algebra:
    """A stock algebra from its spec."""
    with open(stock_spec_path(name), "rb") as file:
        return loader.algebra_from_data(tomllib.load(file))


def kind_of(algebra: Algebra, text: str) -> Kind:
    """``motor``, ``~motor`` (its layout) or ``number``."""
    if text == "number":
        return scalar_argument(algebra)
    return algebra.layout(text[1:]) if text[0] == "~" else algebra.kind(text)


def members(kind: Kind, count: int, seed: int, scale: float = 1.0) -> Array:
    """Random members as rows."""
    if kind.is_scalar_argument:
        return np.random.default_rng(seed).normal(size=count) * scale
    x = sample(kind, NumericSource(count, seed, scale))
    return np.stack([np.broadcast_to(v, (count,)) for v in kind.values(x)], -1)


@cache
def _traced(formula: Callable[..., Any], kinds: tuple[Kind, ...], algebra: Algebra) -> Kernel:
    return trace(formula, kinds, algebra=algebra)


class Traced:
    """A formula declared on kinds: its kernel, and its values on arrays."""

    def __init__(self, algebra: Algebra, formula: Callable[..., Any], *kinds: str) -> None:
        self.kinds = tuple(kind_of(algebra, k) for k in kinds)
        self.kernel = _traced(formula, self.kinds, algebra)
        self.algebra = algebra

    @property
    def returns(self) -> Kind:
        """Kind of the first output, as proved."""
        return self.kernel.outputs[0].kind

    def _columns(self, arrays: Sequence[Any]) -> list[list[Any]]:
        return [
            [np.asarray(a, float)] if k.is_scalar_argument else list(np.moveaxis(np.asarray(a, float), -1, 0))
            for a, k in zip(arrays, self.kinds, strict=True)
        ]

    def all(self, *arrays: Any) -> list[Array]:
        """All outputs of the formula run on NumPy; the graph is run too and must agree."""
        columns = self._columns(arrays)
        ring = NumericRing()
        rows = self.kernel.reference(ring, columns)
        graph = self.kernel.evaluate_flat([c for column in columns for c in column], ring)
        lead = np.broadcast_shapes(*(np.shape(c) for column in columns for c in column))
        results = []
        for own, other in zip(rows, graph, strict=True):
            one, two = (np.stack([np.broadcast_to(v, lead) for v in values], -1) for values in (own, other))
            assert np.array_equal(np.isnan(one).any(-1), np.isnan(two).any(-1)), self.kernel.name
            size = np.max(np.abs(one), -1, initial=0, keepdims=True)
            regular = np.isfinite(size) & np.ones(one.shape, bool)
            difference = np.abs(np.where(regular, one, 0) - np.where(regular, two, 0))
            assert np.all(difference <= 1e-9 * np.where(np.isfinite(size), size, 1)), self.kernel.name
            results.append(one)
        return [
            r[..., 0] if o.role == "status" or o.kind.blades == (0,) else r
            for r, o in zip(results, self.kernel.outputs, strict=True)
        ]

    def __call__(self, *arrays: Any) -> Array:
        """The first output."""
        return self.all(*arrays)[0]


def multivector(kind: Kind, rows: Any) -> Multivector:
    """Rows as one numeric multivector."""
    return from_values(kind.algebra, NumericRing(), kind.blades, list(np.moveaxis(np.asarray(rows, float), -1, 0)))


def rows(kind: Kind, x: Multivector) -> Array:
    """A numeric multivector's coefficients on a kind's blades."""
    values = kind.values(x)
    lead = np.broadcast_shapes(*(np.shape(v) for v in values))
    return np.stack([np.broadcast_to(v, lead) for v in values], -1)


# -- 50 digits and more ------------------------------------------------------------------------------------


def precise(kind: Kind, row: Sequence[Any], ring: PrecisionRing) -> Multivector:
    """One row as a multivector of mpmath numbers."""
    number = ring.context.mpf
    return from_values(kind.algebra, ring, kind.blades, [number(float(v)) for v in row])


def series_exp(b: Multivector) -> Multivector:
    """exp(b) by halving the argument, its power series, and squaring: nothing known of b."""
    ring: PrecisionRing = b.ring  # type: ignore[assignment]
    size = float(sum(abs(c) for c in b.terms.values())) or 1.0
    halvings = max(0, math.ceil(math.log2(size)) + 10)
    small = b * Fraction(1, 2**halvings)
    term = total = b.constant(1)
    for n in range(1, ring.context.dps // 3 + 4):
        term = term * small / n
        total = total + term
    for _ in range(halvings):
        total = total * total
    return total


# -- homogeneous matrices ----------------------------------------------------------------------------------


def plain(p: int, q: int = 0, r: int = 0) -> Algebra:
    """An algebra of orthonormal vectors with the plain kinds."""
    algebra = orthonormal(p, q, r)
    add_plain_kinds(algebra)
    return algebra


def sandwich(r: Multivector, x: Multivector) -> Multivector:
    """r x ~r."""
    return r >> x
