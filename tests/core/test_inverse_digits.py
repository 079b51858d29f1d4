"""The default inverse in larger algebras against exact arithmetic: as many digits as the best method has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith.core.functions import inverses
from bladesmith.dispatch.product_tables import product_table

#: Fixed point of the exact inverse, and what its residual is below.
BITS, EXACT = 700, 300


def fixed(values: np.ndarray) -> np.ndarray:
    """Floating-point numbers as integers, times 2^BITS."""
    mantissa, exponent = np.frexp(values)
    return np.ldexp(mantissa, 53).astype(np.int64).astype(object) << (exponent - 53 + BITS).astype(object)


def dense(x: Any) -> np.ndarray:
    rows = np.zeros((*x.shape, len(x.algebra.blades)))
    place = {int(b): i for i, b in enumerate(x.algebra.blades)}
    rows[..., [place[int(b)] for b in x.blades]] = x.values
    return rows


def exact_inverse(x: Any, start: Any) -> np.ndarray:
    """Newton's steps in integers; the residual proves the result."""
    blades = tuple(int(b) for b in x.algebra.blades)
    table = product_table(x.algebra, "geometric", blades, blades, blades)
    weights = table.weights.astype(int).astype(object)

    def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.add.reduceat(a[table.left] * b[table.right] * weights, table.starts[:-1]) >> BITS

    own, y = fixed(dense(x)), fixed(dense(start))
    one = fixed(np.eye(1, len(blades))[0])
    for _ in range(10):
        residual = times(own, y) - one
        if max(abs(int(r)) for r in residual) < 1 << (BITS - EXACT):
            return y
        y = y - times(y, residual)
    raise AssertionError("the start is no inverse")


def error(y: Any, exact: np.ndarray) -> float:
    """Largest error of a coefficient, relative to the largest coefficient."""
    off = max(abs(int(v)) for v in fixed(dense(y)) - exact)
    return off / max(abs(int(v)) for v in exact)


def multivectors(algebra: Any, loss: float | None, seed: int) -> Any:
    """A random multivector; or one that is a factor ``loss`` from a singular one."""
    random = np.random.default_rng(seed)
    n = algebra.dimension
    if loss is None:
        return algebra.multivector(random.normal(size=2**n))
    u, w = (algebra.multivector(random.normal(size=1 + n), grades=[0, 1]) for _ in "uw")
    return u * (1 + (1 - loss) * algebra.e1) * w + algebra.multivector(np.zeros(2**n))


SIGNATURES = [(2, 2, 0), (4, 1, 1), (3, 3, 0), (3, 2, 2), (7, 0, 0), (4, 4, 0), (2, 3, 3), (6, 3, 0)]


@pytest.mark.parametrize("loss", [None, 1e-3, 1e-6])
@pytest.mark.parametrize("signature", [*SIGNATURES[:-1], pytest.param(SIGNATURES[-1], marks=pytest.mark.slow)])
def test_as_many_digits_as_the_best_method(signature: tuple[int, ...], loss: float | None) -> None:
    algebra = bs.algebra(*signature)
    x = multivectors(algebra, loss, 7)
    best, default = x.inverse("matrix"), x.inverse()
    exact = exact_inverse(x, best)
    assert default.status is bs.Status.OK
    bound = 1e-14 if algebra.dimension > 5 else 1e-12  # small algebras keep the recursion where it is good enough
    assert error(default, exact) <= max(4 * error(best, exact), bound)


@pytest.mark.slow
def test_what_the_recursion_alone_loses() -> None:
    algebra = bs.algebra(6, 3)
    x = multivectors(algebra, None, 7)
    best = x.inverse("matrix")
    exact = exact_inverse(x, best)
    assert error(x.inverse("shirokov"), exact) > 1e3 * error(x.inverse(), exact)
    batch = algebra.multivector(np.stack([x.values, np.zeros(512), x.values * 1e200, np.full(512, np.nan)]))
    found = batch.inverse()
    assert found.status.tolist() == [bs.Status.OK, bs.Status.SINGULAR, bs.Status.OK, bs.Status.INVALID]
    assert found[0].isclose(x.inverse(), rtol=1e-12) and np.isnan(found.values[[1, 3]]).all()
    assert found[2].isclose(1e-200 * x.inverse(), rtol=1e-12)
    singular = (1 + algebra.e1) * algebra.multivector(np.random.default_rng(1).normal(size=512))
    assert singular.inverse().status is bs.Status.SINGULAR
    with pytest.raises(bs.errors.NotInvertibleError):
        singular.inverse(strict=True)


def test_small_algebras_keep_their_bits() -> None:
    for algebra in (bs.cga3d, bs.pga3d, bs.cga2d, bs.algebra(3), bs.algebra(2, 1), bs.algebra(4)):
        x = algebra.multivector(np.random.default_rng(2).normal(size=(500, 2**algebra.dimension)))
        same = (x.inverse().values == x.inverse("shirokov").values).all(-1)
        assert same.mean() > 0.99 and x.inverse()[~same].isclose(x.inverse("matrix")[~same], rtol=1e-12).all()


def test_shapes_and_precisions() -> None:
    algebra = bs.algebra(3, 3)
    x = algebra.multivector(np.random.default_rng(3).normal(size=(2, 3, 64)))
    y = x.inverse()
    assert y.shape == (2, 3) and (x * y).isclose(1, rtol=1e-12).all() and y[1, 2].isclose(x[1, 2].inverse(), rtol=1e-13)
    single = x.astype(np.float32).inverse()
    assert single.dtype == np.float32 and (x.astype(np.float32) * single).isclose(1, rtol=1e-3).all()
    assert algebra.multivector(np.zeros((0, 64))).inverse().shape == (0,)
    even = algebra.multivector(np.random.default_rng(4).normal(size=(5, 32)), grades=[0, 2, 4, 6])
    assert even.inverse().grades == (0, 2, 4, 6) and (even * even.inverse()).isclose(1, rtol=1e-11).all()
    with pytest.raises(bs.errors.InputError, match="auto"):
        x.inverse(method="best")


def test_single_precision_inverts_what_double_does() -> None:
    """Bounds by the matrix's condition are far from sharp: 2600 is no reason to refuse numbers of seven digits."""
    algebra = bs.algebra(5, 2)
    x = algebra.multivector(np.random.default_rng(0).normal(size=(400, 128)).astype(np.float32))
    expected = x.astype(np.float64).inverse()
    for some, method in ((x, "auto"), (x[250:260], "matrix")):
        found, wanted = some.inverse(method), expected if some is x else expected[250:260]
        assert found.dtype == np.float32 and (found.status == bs.Status.OK).all()
        assert (np.abs(found.values - wanted.values).max(-1) <= 1e-4 * np.abs(wanted.values).max(-1)).all()
    singular = x[:40] * (1 + algebra.e1.astype(np.float32))
    assert (singular.inverse().status == bs.Status.SINGULAR).all()
    assert (singular.inverse("matrix").status == bs.Status.SINGULAR).all()


def test_matrices_are_solved_few_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that an interrupt is seen between them; the bits are those of one at a time."""
    algebra, sizes = bs.algebra(4), []
    x = algebra.multivector(np.random.default_rng(1).normal(size=(3, 4, 16)))
    expected = np.stack([[item.inverse("matrix").values for item in row] for row in x])
    solve = inverses._solve_matrices
    monkeypatch.setattr(inverses, "_solve_matrices", lambda part: sizes.append(part.size) or solve(part))
    monkeypatch.setattr(inverses, "MATRIX_WORK", 5 * 16**3)
    monkeypatch.setattr(inverses, "SLOW_ROWS", 2)  # and in another thread
    assert (x.inverse("matrix").values == expected).all() and sizes == [5, 5, 2]
