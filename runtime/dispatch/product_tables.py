"""Bilinear products by a table of terms: they answer at once for every algebra and combination of kinds.

The loop is compiled into the package (generated/general); without the extension numba does it for large batches, and
NumPy for the rest: the bits are the same. A table comes from the metric alone; it is built in whole arrays where the
basis is orthogonal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra import product_terms as filters
from ..codegen.algebra.algebra import Algebra
from ..codegen.algebra.blades import MAX_DIMENSION, grade
from ..codegen.algebra.multivector import Multivector
from ..codegen.errors import SignatureError
from ..codegen.execute.ranges import parallel_for
from ..codegen.rings.protocol import RationalRing

if TYPE_CHECKING:
    from ..codegen.algebra.product_terms import Filter
    from ..codegen.algorithm_api import AlgorithmFunction
    from ..codegen.execute.items import Loop

Integers = NDArray[np.int32]
#: More pairs of blades than this are refused: the table alone would take gigabytes.
MAX_PAIRS = 2**25
#: The NumPy path makes this many numbers at a time, so that its temporary arrays stay in the cache.
CHUNK = 2**14
#: Bits of half a blade.
HALF = (MAX_DIMENSION + 1) // 2
#: Without the extension numba multiplies from so many terms on: it takes a second to load, or two to compile.
NUMBA_TERMS = 10**7

FILTERS: dict[str, Filter | None] = {
    "geometric": None,
    "outer": filters.keep_outer,
    "inner": filters.keep_inner,
    "left_contraction": filters.keep_left,
    "right_contraction": filters.keep_right,
    "scalar_product": filters.keep_scalar,
}
#: The halves of commutator and anticommutator: sign of the reversed product.
SYMMETRIC = {"commutator": -1, "anticommutator": 1}
OPERATIONS = (*FILTERS, *SYMMETRIC, "regressive")


@dataclass(frozen=True, eq=False)
class Table:
    """Terms of a bilinear product, grouped by the coefficient of the result that they add to.

    Attributes
    ----------
    blades : tuple of int
        Blades of the result in storage order.
    sizes : (int, int)
        Numbers of coefficients of the operands.
    starts, left, right, weights : arrays
        The terms of result ``k`` are those from ``starts[k]`` to ``starts[k + 1]``.
    """

    blades: tuple[int, ...]
    sizes: tuple[int, int]
    starts: Integers
    left: Integers
    right: Integers
    weights: NDArray[np.float64]

    @property
    def terms(self) -> int:
        """Number of terms."""
        return len(self.left)

    @cached_property
    def _struct(self) -> tuple[Any, Any]:
        """The C view of the table, and what keeps its memory alive."""
        module = library()
        assert module is not None
        ffi = module.ffi
        kept = [
            ffi.from_buffer("int32_t[]", self.starts),
            ffi.from_buffer("int32_t[]", self.left),
            ffi.from_buffer("int32_t[]", self.right),
            ffi.from_buffer("double[]", self.weights),
        ]
        return ffi.new("bs_product *", [len(self.blades), *self.sizes, *kept]), kept

    @property
    def pointer(self) -> Any:
        """Pointer to the C view; valid as long as the table."""
        return self._struct[0]

    def on(self, target: str) -> Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]]:
        """The product of rows (..., size) on one target, "c", "numba" or "cuda", with the bits of the compiled loop."""
        run = _table_algorithm().on(target)
        indices = [x.astype(np.int64) for x in (self.starts, self.left, self.right)]

        def product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
            dtype = np.result_type(a, b, np.float32)
            lead = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
            empty = np.zeros((*lead, len(self.blades)), dtype)
            found: NDArray[Any] = run(
                *indices, self.weights.astype(dtype), a.astype(dtype, copy=False), b.astype(dtype, copy=False), empty
            )
            return found

        return product

    def multiply(self, out: NDArray[Any], a: NDArray[Any], b: NDArray[Any]) -> None:
        """Product of rows, without C: ``out`` (n, k), ``a`` and ``b`` of n rows or one."""
        is_large = out.dtype == np.float64 and len(out) * self.terms >= NUMBA_TERMS
        loop = numba_loop() if is_large else None
        if loop is None:
            self._multiply_by_numpy(out, a, b)
            return
        table = [x.astype(np.int64) for x in (self.starts, self.left, self.right)]
        arrays = [*table, self.weights, np.ascontiguousarray(a), np.ascontiguousarray(b), out]
        strides = [0] * 4 + [x.shape[1] if len(x) > 1 else 0 for x in (a, b)] + [out.shape[1]]
        counts = [*map(len, arrays[:4]), a.shape[1], b.shape[1], out.shape[1]]
        held = [loop.hold(x) for x in arrays]
        parallel_for(loop.bind(held, loop.integers(strides), loop.integers(counts)), len(out))

    def _multiply_by_numpy(self, out: NDArray[Any], a: NDArray[Any], b: NDArray[Any]) -> None:
        """The first terms of all coefficients, then the second ones, and so on: sums are in the order of C."""
        out[...] = 0
        lengths = np.diff(self.starts)
        weights = self.weights.astype(out.dtype)
        rows = max(1, CHUNK // max(1, out.shape[1]))
        for begin in range(0, len(out), rows):
            end = min(begin + rows, len(out))
            x, y = (z if len(z) == 1 else z[begin:end] for z in (a, b))
            for n in range(lengths.max(initial=0)):
                those = np.flatnonzero(lengths > n)
                t = self.starts[those] + n
                with np.errstate(all="ignore"):
                    out[begin:end, those] += weights[t] * (x[:, self.left[t]] * y[:, self.right[t]])


@cache
def library() -> Any:
    """The compiled loop, or None where it was not built."""
    try:
        module = import_module("...generated.general._kernels", __name__)
    except ImportError:
        return None
    module.lib.bs_initialize()
    return module


@cache
def _table_algorithm() -> AlgorithmFunction:
    """The loop over a table, as one that is compiled where it is called."""
    from ..codegen.algorithm_api import algorithm
    from ..codegen.algorithms.table_product import multiply_by_table

    return algorithm(multiply_by_table.function)


@cache
def numba_loop() -> Loop | None:
    """The loop by numba, in double precision; None where that is not installed."""
    if find_spec("numba") is None:
        return None
    from ..codegen.algorithms.table_product import multiply_by_table
    from ..codegen.execute.items import NumbaLoop
    from ..codegen.programs.algorithms import algorithm_numba

    function = multiply_by_table.specialised([p.type for p in multiply_by_table.text.parameters])
    return NumbaLoop(function.name, algorithm_numba(function), function)


@lru_cache(maxsize=4096)
def product_table(
    algebra: Algebra,
    operation: str,
    blades_a: tuple[int, ...],
    blades_b: tuple[int, ...],
    blades_c: tuple[int, ...] = (),
) -> Table:
    """Table of a product between two sets of blades.

    Parameters
    ----------
    algebra : Algebra
    operation : str
        One of `OPERATIONS`, or "reversed": a ~b, the second half of a sandwich.
    blades_a, blades_b : tuple of int
    blades_c : tuple of int, optional
        Blades of the result; default: all that a term leads to.

    Raises
    ------
    SignatureError
        If there are too many pairs of blades.
    """
    if len(blades_a) * len(blades_b) > MAX_PAIRS:
        raise SignatureError(
            f"the product of {len(blades_a)} by {len(blades_b)} blades in {algebra.name} has too many terms.",
            remedy="Use sparser multivectors: grades, or single blades",
        )
    left, right, result, weights = _terms(algebra, operation, blades_a, blades_b)
    found = set(np.unique(result).tolist())
    blades = blades_c or algebra.order(found) or (0,)
    target = _places(np.array(blades, np.int64), result)
    order = np.argsort(target, kind="stable")
    order = order[target[order] >= 0]
    starts = np.searchsorted(target[order], np.arange(len(blades) + 1)).astype(np.int32)
    return Table(
        tuple(blades),
        (len(blades_a), len(blades_b)),
        starts,
        np.ascontiguousarray(left[order], np.int32),
        np.ascontiguousarray(right[order], np.int32),
        np.ascontiguousarray(weights[order], np.float64),
    )


Terms = tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[np.float64]]


def _terms(algebra: Algebra, operation: str, blades_a: tuple[int, ...], blades_b: tuple[int, ...]) -> Terms:
    """Left index, right index, blade and weight of every term."""
    if operation == "regressive":
        return _regressive_terms(algebra, blades_a, blades_b)
    if operation == "outer" or algebra.is_diagonal:
        return _diagonal_terms(algebra, operation, blades_a, blades_b)
    return _general_terms(algebra, operation, blades_a, blades_b)


def _diagonal_terms(algebra: Algebra, operation: str, blades_a: Sequence[int], blades_b: Sequence[int]) -> Terms:
    """Whole arrays of terms: for an orthogonal basis, and for the outer product in any."""
    a = np.array(blades_a, np.int32).reshape(-1, 1)
    b = np.array(blades_b, np.int32).reshape(1, -1)
    c = a ^ b
    weight = _product_weights(algebra, a, b)
    ga, gb, gc = _grades(a), _grades(b), _grades(c)
    if operation in SYMMETRIC:
        weight = (weight + SYMMETRIC[operation] * _product_weights(algebra, b, a)) / 2
    elif operation == "reversed":
        weight = weight * np.where(gb & 2, -1.0, 1.0)
    elif keep := FILTERS.get(operation):
        weight = np.where(keep(ga, gb, gc), weight, 0.0)
    left, right = np.nonzero(weight)
    return left, right, c[left, right], weight[left, right]


def _product_weights(algebra: Algebra, a: NDArray[Any], b: NDArray[Any]) -> NDArray[np.float64]:
    """Sign of reordering times the squares of the common vectors."""
    swaps = np.zeros(np.broadcast_shapes(a.shape, b.shape), np.int16)
    for shift in range(1, algebra.dimension):
        swaps += _grades((a >> shift) & b)
    weight = np.where(swaps & 1, -1.0, 1.0)
    common = a & b
    for i in range(algebra.dimension):
        square = float(algebra.metric[i][i])
        if square != 1.0:
            weight[(common >> i & 1).astype(bool)] *= square
    return weight


@cache
def _population() -> NDArray[np.int16]:
    """Number of bits of every half of a blade there can be."""
    return np.array([i.bit_count() for i in range(1 << HALF)], np.int16)


def _grades(blades: NDArray[Any]) -> NDArray[np.int16]:
    population = _population()
    grades: NDArray[np.int16] = population[blades & ((1 << HALF) - 1)] + population[blades >> HALF]
    return grades


def _general_terms(algebra: Algebra, operation: str, blades_a: Sequence[int], blades_b: Sequence[int]) -> Terms:
    """Terms for any metric, blade by blade, in exact arithmetic."""
    multiply = _blade_product(algebra, operation)
    rows = [
        (i, j, blade, float(weight))
        for i, a in enumerate(blades_a)
        for j, b in enumerate(blades_b)
        for blade, weight in multiply(a, b)
        if weight
    ]
    columns: Iterable[Any] = zip(*rows, strict=True) if rows else ((), (), (), ())
    left, right, blades, weights = (list(column) for column in columns)
    return np.array(left, np.int32), np.array(right, np.int32), np.array(blades, np.int32), np.array(weights, float)


def _blade_product(algebra: Algebra, operation: str) -> Callable[[int, int], Iterable[tuple[int, Fraction]]]:
    if operation == "reversed":
        return lambda a, b: [(c, -w if grade(b) & 2 else w) for c, w in algebra.product(a, b)]
    if operation in FILTERS:
        keep = FILTERS[operation] or (lambda *_: True)
        return lambda a, b: [(c, w) for c, w in algebra.product(a, b) if keep(grade(a), grade(b), grade(c))]
    method = getattr(Multivector, operation)
    return lambda a, b: method(basis_blade(algebra, a), basis_blade(algebra, b)).terms.items()


def _regressive_terms(algebra: Algebra, blades_a: tuple[int, ...], blades_b: tuple[int, ...]) -> Terms:
    """X v Y: the outer product of the duals, mapped back; three linear maps and one table."""
    dual_a, index_a, weight_a = linear_map(algebra, "dual", blades_a)
    dual_b, index_b, weight_b = linear_map(algebra, "dual", blades_b)
    left, right, blades, weights = _diagonal_terms(algebra, "outer", dual_a.tolist(), dual_b.tolist())
    weights = weights * weight_a[left] * weight_b[right]
    distinct = tuple(sorted(set(blades.tolist())))
    image, source, scale = linear_map(algebra, "undual" if algebra.is_degenerate else "times_pseudoscalar", distinct)
    # join the two lists on the blade in the middle
    order = np.argsort(source, kind="stable")
    first = np.searchsorted(source[order], np.arange(len(distinct) + 1))
    middle = np.searchsorted(np.array(distinct, np.int64), blades)
    counts = np.diff(first)[middle]
    term = np.repeat(np.arange(len(blades)), counts)
    within = np.arange(len(term)) - np.repeat(np.cumsum(counts) - counts, counts)
    entry = order[first[middle[term]] + within]
    return index_a[left[term]], index_b[right[term]], image[entry], weights[term] * scale[entry]


def linear_map(
    algebra: Algebra, name: str, blades: Sequence[int]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Entries of a linear map on basis blades: the image's blade, the index of the source, the weight."""
    function = LINEAR[name]
    rows = [
        (image, i, float(weight))
        for i, blade in enumerate(blades)
        for image, weight in function(basis_blade(algebra, blade)).terms.items()
    ]
    columns = list(zip(*rows, strict=True)) or [(), (), ()]
    return np.array(columns[0], np.int64), np.array(columns[1], np.int64), np.array(columns[2], np.float64)


def _places(blades: NDArray[np.int64], wanted: NDArray[Any]) -> NDArray[np.int64]:
    """Places of blades in a list of distinct ones; -1 where it lacks one."""
    order = np.argsort(blades)
    rank = np.minimum(np.searchsorted(blades[order], wanted), len(blades) - 1)
    return np.where(blades[order][rank] == wanted, order[rank], -1)


#: Linear maps by name, on exact basis blades.
LINEAR: dict[str, Callable[[Multivector], Multivector]] = {
    "negative": lambda x: -x,
    "reverse": lambda x: ~x,
    "involute": lambda x: x.involute(),
    "conjugate": lambda x: x.conjugate(),
    "dual": lambda x: x.dual(),
    "undual": lambda x: x.undual(),
    "complement": lambda x: x.complement(),
    "times_pseudoscalar": lambda x: x * x.pseudoscalar(),
}


def basis_blade(algebra: Algebra, blade: int) -> Multivector:
    """A basis blade with an exact coefficient."""
    return Multivector(algebra, RationalRing(), {blade: Fraction(1)})
