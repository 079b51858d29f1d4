"""Runtime products against exact arithmetic: an independent blade product, on random signatures and bases."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith.codegen.algebra.algebra import add_plain_kinds
from bladesmith.codegen.algorithms.table_product import multiply_by_table
from bladesmith.core.multivector import Algebra
from bladesmith.dispatch import plans, product_tables

MOST = 6  # dimensions of random signatures


def naive_product(a: tuple[int, ...], b: tuple[int, ...], squares: list[int]) -> tuple[tuple[int, ...], int]:
    """Product of basis blades as sorted lists of vectors: swaps counted one by one, squares taken out."""
    word, sign = [*a, *b], 1
    for end in range(len(word) - 1, 0, -1):
        for i in range(end):
            if word[i] > word[i + 1]:
                word[i], word[i + 1], sign = word[i + 1], word[i], -sign
    out: list[int] = []
    for v in word:
        if out and out[-1] == v:
            out.pop()
            sign *= squares[v]
        else:
            out.append(v)
    return tuple(out), sign


def keeps(operation: str, a: int, b: int, c: int) -> bool:
    return {
        "geometric": True,
        "outer": c == a + b,
        "inner": c == abs(a - b) and a > 0 and b > 0,
        "left_contraction": c == b - a,
        "scalar_product": c == 0,
    }[operation]


def naive(operation: str, x: dict[Any, Fraction], y: dict[Any, Fraction], squares: list[int]) -> dict[Any, Fraction]:
    if operation in ("commutator", "anticommutator"):
        sign = -1 if operation == "commutator" else 1
        one, other = naive("geometric", x, y, squares), naive("geometric", y, x, squares)
        return {k: (one.get(k, Fraction(0)) + sign * other.get(k, Fraction(0))) / 2 for k in {*one, *other}}
    total: dict[Any, Fraction] = {}
    for a, p in x.items():
        for b, q in y.items():
            c, sign = naive_product(a, b, squares)
            if sign and keeps(operation, len(a), len(b), len(c)):
                total[c] = total.get(c, Fraction(0)) + sign * p * q
    return total


@st.composite
def signatures(draw: Any) -> tuple[int, int, int]:
    """Signatures to six dimensions; those with null vectors and those of all six are drawn often."""
    n = draw(st.one_of(st.just(MOST), st.integers(1, MOST)))
    r = draw(st.one_of(st.just(0), st.integers(1, n)))
    p = draw(st.integers(0, n - r))
    return p, n - r - p, r


@st.composite
def operands(draw: Any, n: int, most: int = 8) -> dict[tuple[int, ...], int]:
    """A sparse multivector with integer coefficients: products of doubles are then exact."""
    masks = draw(st.lists(st.integers(0, 2**n - 1), min_size=1, max_size=most, unique=True))
    return {tuple(i for i in range(n) if mask >> i & 1): draw(st.integers(-(10**6), 10**6)) for mask in masks}


def runtime(alg: Algebra, x: dict[tuple[int, ...], int]) -> bs.Multivector:
    return alg.multivector({tuple(alg.vectors[i] for i in blade): float(c) for blade, c in x.items()})


def coefficients(x: bs.Multivector) -> dict[tuple[int, ...], Fraction]:
    n = x.algebra.dimension
    return {
        tuple(i for i in range(n) if blade >> i & 1): Fraction(float(v))
        for blade, v in zip(x.blades, x.values, strict=True)
        if v
    }


PRODUCTS = {
    "geometric": lambda a, b: a * b,
    "outer": lambda a, b: a ^ b,
    "inner": lambda a, b: a | b,
    "left_contraction": lambda a, b: a.left_contraction(b),
    "scalar_product": lambda a, b: a.scalar_product(b),
    "commutator": lambda a, b: a.commutator(b),
    "anticommutator": lambda a, b: a.anticommutator(b),
}


@pytest.mark.slow
@settings(max_examples=600, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_products_equal_exact_ones(data: Any) -> None:
    p, q, r = data.draw(signatures())
    n = p + q + r
    alg = bs.algebra(p, q, r)
    squares = [int(alg.metric[i][i]) for i in range(n)]
    assert sorted(squares) == sorted([1] * p + [-1] * q + [0] * r)
    x, y = data.draw(operands(n)), data.draw(operands(n))
    operation = data.draw(st.sampled_from(sorted(PRODUCTS)))
    exact = {k: Fraction(v) for k, v in x.items()}, {k: Fraction(v) for k, v in y.items()}
    expected = {k: v for k, v in naive(operation, *exact, squares).items() if v}
    assert coefficients(PRODUCTS[operation](runtime(alg, x), runtime(alg, y))) == expected


@settings(max_examples=100, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_sandwiches_equal_exact_ones(data: Any) -> None:
    p, q, r = data.draw(signatures())
    alg = bs.algebra(p, q, r)
    squares = [int(alg.metric[i][i]) for i in range(p + q + r)]
    x, y = ({k: v % 1000 for k, v in data.draw(operands(p + q + r, 5)).items()} for _ in range(2))
    exact = {k: Fraction(v) for k, v in x.items()}, {k: Fraction(v) for k, v in y.items()}
    reverse = {k: -v if len(k) & 2 else v for k, v in exact[0].items()}
    expected = naive("geometric", naive("geometric", *exact, squares), reverse, squares)
    found = runtime(alg, x) >> runtime(alg, y)
    assert coefficients(found) == {k: v for k, v in expected.items() if v}


def null_algebra(p: int, q: int, pairs: int) -> Algebra:
    """An algebra on null pairs n . m = -1 beside orthonormal vectors."""
    n = p + q + 2 * pairs
    metric = [[0] * n for _ in range(n)]
    for i in range(p + q):
        metric[i][i] = 1 if i < p else -1
    for k in range(pairs):
        i = p + q + 2 * k
        metric[i][i + 1] = metric[i + 1][i] = -1
    alg = Algebra(f"null{p}_{q}_{pairs}", [str(i + 1) for i in range(n)], metric)
    add_plain_kinds(alg)
    return alg


NULL_ALGEBRAS = [null_algebra(*counts) for counts in [(3, 0, 1), (1, 1, 1), (0, 1, 2), (2, 0, 2)]]


@pytest.mark.slow
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(NULL_ALGEBRAS), st.data())
def test_products_on_null_bases_equal_those_on_orthonormal_ones(alg: Algebra, data: Any) -> None:
    x, y = (runtime(alg, {k: v % 100 for k, v in data.draw(operands(alg.dimension)).items()}) for _ in range(2))
    for operation in (*PRODUCTS, "regressive"):
        multiply = PRODUCTS.get(operation, lambda a, b: a & b)
        found = multiply(x, y).to_basis("orthonormal")
        expected = multiply(x.to_basis("orthonormal"), y.to_basis("orthonormal"))
        sign = _orientation(alg) if operation == "regressive" else 1
        assert found.isclose(sign * expected, atol=1e-9), operation


def _orientation(alg: Algebra) -> int:
    """Sign between the pseudoscalars of the two bases; a regressive product has one more of them than cancel."""
    unit = alg.multivector({alg.blades[-1]: 1.0}).to_basis("orthonormal")
    return int(np.sign(unit.values[-1]))


@pytest.mark.parametrize("signature", [(3, 0, 0), (4, 1, 0), (3, 0, 1), (2, 1, 2), (0, 0, 3)])
def test_duality(signature: tuple[int, int, int]) -> None:
    alg = bs.algebra(*signature)
    x = alg.multivector(np.random.default_rng(0).normal(size=(7, len(alg.blades))))
    assert x.dual().undual().isclose(x).all()
    pseudoscalar = alg.multivector({alg.blades[-1]: float(alg.pseudoscalar_sign)})
    if not alg.is_degenerate:
        assert x.dual().isclose(x * pseudoscalar).all()
        y = x[::-1]
        assert (x & y).isclose((x.dual() ^ y.dual()) * pseudoscalar).all()
    else:
        y = x[::-1]
        assert (x & y).isclose((x.dual() ^ y.dual()).undual()).all()
        for blade in alg.blades:  # X ^ J(X) = I
            unit = alg.multivector({blade: 1.0})
            assert (unit ^ unit.dual()).isclose(pseudoscalar)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("n", [1, 3, 4, 17, 1000])
def test_compiled_loop_has_the_bits_of_numpy(dtype: Any, n: int) -> None:
    if product_tables.library() is None:
        pytest.skip("the extension was not built")
    alg = bs.algebra(2, 1, 1)
    random = np.random.default_rng(n)
    table = product_tables.product_table(alg, "geometric", tuple(map(int, alg.blades)), tuple(map(int, alg.blades)))
    a, b = (random.normal(size=(n, 16)).astype(dtype) for _ in range(2))
    fast, slow = (np.empty((n, 16), dtype) for _ in range(2))
    plans.table_rows(table, int(dtype == np.float32))(fast, a, b, n)
    table.multiply(slow, a, b)
    assert np.array_equal(fast, slow)
    single = np.empty((n, 16), dtype)  # each item alone gives the same bits as in the batch
    for i in range(n):
        plans.table_rows(table, int(dtype == np.float32))(single[i : i + 1], a[i : i + 1], b[i : i + 1], 1)
    assert np.array_equal(single, fast)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("signature", [(2, 1, 1), (4, 1, 0)])
@pytest.mark.parametrize("operation", ["geometric", "outer", "regressive", "commutator"])
def test_numba_has_the_bits_of_numpy(
    signature: tuple[int, int, int], operation: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(product_tables, "NUMBA_TERMS", 0)
    alg, random = bs.algebra(*signature), np.random.default_rng(4)
    blades = tuple(map(int, alg.blades))
    table = product_tables.product_table(alg, operation, blades, blades[:7])
    a, b = random.normal(size=(23, len(blades))), random.normal(size=(23, 7))
    for x, y in ((a, b), (a[:1], b), (a, b[:1]), (a[::2][:5], np.asfortranarray(b[:5]))):
        fast, slow = (np.empty((max(len(x), len(y)), len(table.blades))) for _ in range(2))
        table.multiply(fast, x, y)
        table._multiply_by_numpy(slow, x, y)
        assert np.array_equal(fast, slow)


def test_the_loop_over_a_table_in_fifty_digits() -> None:
    alg, random = bs.algebra(2, 1, 1), np.random.default_rng(1)
    blades = tuple(map(int, alg.blades))
    table = product_tables.product_table(alg, "geometric", blades, blades)
    a, b = random.normal(size=(2, 16))
    context = mpmath.mp.clone()
    context.dps = 50
    numbers = (table.starts, table.left, table.right, table.weights, a, b, np.zeros(16))
    precise = multiply_by_table.reference(*numbers, numbers=context)
    double = multiply_by_table.reference(*numbers)
    assert max(abs(p - d) for p, d in zip(precise, double, strict=True)) < 16 * 2.0**-52 * 16
    found = np.empty((1, 16))
    plans.table_rows(table, 0)(found, a[None], b[None], 1)
    assert np.array_equal(double, found[0])


def test_instances_give_the_same_bits() -> None:
    module = product_tables.library()
    if module is None:
        pytest.skip("the extension was not built")
    alg = bs.algebra(3, 1)
    x, y = (alg.multivector(np.random.default_rng(i).normal(size=(101, 16))) for i in range(2))
    found = []
    try:
        for i in range(module.lib.bs_instance_count()):
            name = module.ffi.string(module.lib.bs_instance_name(i)).decode()
            if name.startswith("f64") and module.lib.bs_use_instance(i):
                found.append((x * y).values.tobytes())
    finally:
        module.lib.bs_initialize()
    assert len(found) >= 1 and len(set(found)) == 1


def test_without_the_extension(monkeypatch: pytest.MonkeyPatch) -> None:
    alg = bs.algebra(1, 3)
    x, y = (alg.multivector(np.random.default_rng(i).normal(size=(20, 16))) for i in range(2))
    expected = [x * y, x >> y, x[0] ^ y, x[0] & y[1]]
    monkeypatch.setattr(product_tables, "library", lambda: None)
    monkeypatch.setattr(plans, "PLANS", {})
    monkeypatch.setattr("bladesmith.core.operators.PLANS", plans.PLANS)
    found = [x * y, x >> y, x[0] ^ y, x[0] & y[1]]
    assert all(np.all(a.isclose(b, rtol=1e-13)) for a, b in zip(found, expected, strict=True))


def test_broadcasting_equals_repetition() -> None:
    alg = bs.algebra(3)
    x = alg.multivector(np.random.default_rng(0).normal(size=(5, 1, 8)))
    y = alg.multivector(np.random.default_rng(1).normal(size=(4, 8)))
    full = alg.multivector(np.broadcast_to(x.values, (5, 4, 8))) * alg.multivector(np.broadcast_to(y.values, (5, 4, 8)))
    assert (x * y).shape == (5, 4) and np.array_equal((x * y).values, full.values)
    assert np.array_equal((x[0, 0] * y).values, full.values[0])
    assert np.array_equal((y * x[0, 0])[2].values, (y[2] * x[0, 0]).values)
    assert (x[:0] * y).shape == (0, 4)
    with pytest.raises(bs.errors.ShapeError, match=r"\(5,\) and \(4,\)"):
        x[:, 0] * y


def test_precisions_mix() -> None:
    alg = bs.algebra(2)
    x = alg.multivector({"e1": 0.1, "e2": 0.2})
    assert (x.astype(np.float32) * x).dtype == np.float64
    assert (x.astype(np.float32) * x.astype(np.float32)).dtype == np.float32
    assert (x.astype(np.float32) * 2).dtype == (2.0 * x.astype(np.float32)).dtype == np.float32
    assert (x.astype(np.float32) + 1).dtype == np.float32
    assert (x.astype(np.float32) * np.ones(3)).dtype == np.float64


def test_products_of_points_in_a_large_conformal_algebra() -> None:
    start = time.process_time()
    alg = null_algebra(6, 0, 2)  # Cl(8,2)
    assert alg.signature == (8, 2, 0)
    x = alg.multivector(np.random.default_rng(0).normal(size=(100, 10)), grades=[1])
    assert (x * x[::-1]).grades == (0, 2) and (x ^ x[::-1] ^ x[50]).grades == (3,)
    assert time.process_time() - start <= 2.0
