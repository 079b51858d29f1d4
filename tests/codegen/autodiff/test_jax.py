"""Kernels as functions of JAX arrays, against the kernels themselves and JAX's own derivatives of other code."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, codegen
from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.codegen.errors import AlgebraMismatchError, InputError, KindError, ShapeError
from bladesmith.codegen.execute.reductions.sums import BLOCK
from bladesmith.codegen.trace.outputs import status

pytestmark = pytest.mark.peers


@pytest.fixture(autouse=True)
def jax() -> Iterator[Any]:
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@codegen.kernel(cga.layout("motor"), cga.layout("point"))
def move(m: Any, x: Any) -> Any:
    return m * x * ~m


@codegen.kernel(codegen.scalar, codegen.numbers(2), algebra=cga, reduce="sum")
def total(a: Any, b: Any) -> Any:
    return codegen.row([codegen.sin(a) * b[0], a * b[1] * b[1]])


@codegen.kernel(codegen.scalar, algebra=cga)
def root(a: Any) -> Any:
    return codegen.sqrt(a), status(codegen.select(a > 0, a.constant(0), a.constant(6)))


@codegen.kernel(codegen.numbers(2), algebra=cga, reduce="sum")
def pairs(a: Any) -> Any:
    return codegen.row([a[0], a[1]])


@codegen.kernel(codegen.scalar, algebra=cga, reduce="sum")
def roots(a: Any) -> Any:
    code = codegen.select(a > 5, a.constant(Status.NOT_UNIQUE), a.constant(Status.OK))
    return codegen.sqrt(a), status(codegen.select(a > 0, code, a.constant(Status.SINGULAR)))


M = cga.rotor((0, 0, 1), 0.5, point=(1, 0, 0)).as_kind("motor").values
X = cga.point(np.random.default_rng(0).normal(size=(6, 3))).values


def matrix_loss(jnp: Any, m: Any, x: Any, weight: Any) -> Any:
    """The loss from the dense table of products: JAX's own derivatives."""
    basis = cga.multivector(np.eye(32), grades=range(6))
    layout = basis.kind.layout
    table = jnp.asarray((basis[:, None] * basis[None]).as_kind(layout).values)
    signs = jnp.asarray((~basis).as_kind(layout).values)

    def place(kind: Any) -> Any:
        return jnp.asarray(np.eye(32)[[layout.blades.index(b) for b in kind.blades]])

    versor = m @ place(cga.kind("motor"))
    moved = jnp.einsum("i,nj,k,ijl,lko->no", versor, x @ place(cga.kind("point")), versor @ signs, table, table)
    return (moved @ place(move.outputs[0].kind).T * weight).sum()


def test_values_and_derivatives_are_those_of_dense_tables(jax: Any) -> None:
    import jax.numpy as jnp

    f = move.jax()
    np.testing.assert_array_equal(f(M, X), move(M, X))
    weight = jnp.asarray(np.random.default_rng(1).normal(size=(6, move.outputs[0].kind.size)))
    ours = lambda m, x: (f(m, x) * weight).sum()  # noqa: E731
    theirs = lambda m, x: matrix_loss(jnp, m, x, weight)  # noqa: E731
    for derivative in (jax.grad, jax.hessian):
        for found, true in zip(derivative(ours, (0, 1))(M, X), derivative(theirs, (0, 1))(M, X), strict=True):
            pairs = zip(found, true, strict=True) if isinstance(found, tuple) else [(found, true)]
            for a, b in pairs:
                np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)
    directions = jnp.ones(8), jnp.asarray(X)
    np.testing.assert_allclose(*(jax.jvp(g, (M, X), directions)[1] for g in (ours, theirs)), rtol=1e-12)


def test_transformations_compose(jax: Any) -> None:
    import jax.numpy as jnp
    from jax.test_util import check_grads

    f = move.jax()
    check_grads(f, (M, X), order=2, modes=["fwd", "rev"])
    several = jnp.stack([M, 2 * M, -M])
    one_by_one = jnp.stack([f(m, X) for m in several])
    np.testing.assert_allclose(jax.vmap(f, (0, None))(several, X), one_by_one, rtol=1e-15)
    np.testing.assert_allclose(jax.vmap(f, (None, 1), 1)(M, X[None].repeat(2, 0))[:, 3], f(M, X[[3, 3]]), rtol=1e-15)
    np.testing.assert_allclose(jax.vmap(jax.vmap(f, (None, 0)), (0, None))(several, X), one_by_one, rtol=1e-15)
    np.testing.assert_allclose(f(several[:, None], X), one_by_one, rtol=1e-15)
    gradient = jax.grad(lambda m, x: jnp.sum(f(m, x) ** 2))
    all_at_once = jax.jit(jax.vmap(gradient, (0, None)))(several, X)
    np.testing.assert_allclose(all_at_once, jnp.stack([gradient(m, X) for m in several]), rtol=1e-13, atol=1e-13)
    assert f(np.zeros((0, 8)), X[:1]).shape[0] == 0


def test_sums_over_all_items(jax: Any) -> None:
    import jax.numpy as jnp

    g = total.jax()
    a, b = np.random.default_rng(0).normal(size=300), np.array([0.5, -1.5])
    np.testing.assert_allclose(g(a, b), total(a, b), rtol=1e-15)
    np.testing.assert_allclose(jax.grad(lambda a, b: g(a, b)[0])(a, b), np.cos(a) * b[0], rtol=1e-14)
    np.testing.assert_allclose(jax.grad(lambda a, b: g(a, b)[1], 1)(a, b), [0, 2 * b[1] * a.sum()], rtol=1e-13)
    second = jax.hessian(lambda a, b: g(a, b).sum(), 1)(a, b)
    np.testing.assert_allclose(second, [[0, 0], [0, 2 * a.sum()]], rtol=1e-13, atol=1e-13)
    batched = jax.vmap(g, (0, None))(a.reshape(3, 100), b)
    np.testing.assert_allclose(batched, jnp.stack([g(r, b) for r in a.reshape(3, 100)]), rtol=1e-12)
    along = jax.jvp(g, (a, b), (np.ones(300), np.zeros(2)))[1]
    np.testing.assert_allclose(along, [(np.cos(a) * b[0]).sum(), 300 * 2.25])


def test_statuses_and_types(jax: Any) -> None:
    values, codes = root.jax()(np.array([4.0, -1.0]))
    assert codes.dtype == np.uint8 and codes.tolist() == [0, 6] and values.shape == (2, 1)
    slope = jax.grad(lambda a: root.jax()(a)[0].sum())(9.0)
    np.testing.assert_allclose(slope, 1 / 6)
    assert root.jax()(np.float32(4))[0].dtype == np.float32 and root.jax()(4)[0].dtype == np.float64
    with pytest.raises(InputError, match="float16"):
        move.jax()(M.astype(np.float16), X)
    with pytest.raises(InputError, match="complex"):
        move.jax()(M.astype(complex), X)
    with pytest.raises(ShapeError, match="8 entries"):
        move.jax()(X, X)
    with pytest.raises(ShapeError, match="broadcast"):
        move.jax()(np.ones((3, 8)), X)
    with pytest.raises(InputError, match="2 arguments"):
        move.jax()(X)


def test_multivectors_are_taken_on_the_blades_of_the_argument(jax: Any) -> None:
    rotor = cga.rotor((0, 0, 1), 0.5, point=(1, 0, 0))  # has fewer blades than a motor
    points = cga.point(np.random.default_rng(0).normal(size=(6, 3)))
    np.testing.assert_array_equal(move.jax()(x=points, m=rotor), move(M, X))
    with pytest.raises(KindError, match="argument x"):
        move.jax()(rotor, cga.multivector(np.ones(10), grades=[2]))
    with pytest.raises(AlgebraMismatchError, match="m belongs to pga3d"):
        move.jax()(pga.random("motor", seed=1), points)
    with pytest.raises(InputError, match="2 arguments"):
        move.jax()(rotor, points, m=rotor)


def test_sums_have_the_bits_and_statuses_of_the_kernel(jax: Any) -> None:
    rng = np.random.default_rng(1)
    for n in (0, 1, BLOCK, 2 * BLOCK + 3):
        rows = rng.normal(size=(n, 2)) * 10.0 ** rng.integers(-9, 9, (n, 1))
        np.testing.assert_array_equal(pairs.jax()(rows), pairs(rows))
        np.testing.assert_array_equal(pairs.jax()(rows.astype(np.float32)), pairs(rows.astype(np.float32)))
    values = np.array([[9.0, 4.0, -1.0, 9.0], [1.0, 9.0, 2.0, 1.0], [-1.0, 1.0, -2.0, 9.0], [1.0, 1.0, 1.0, 1.0]])
    codes = [int(roots(row)[1]) for row in values]
    assert codes == [Status.SINGULAR, Status.NOT_UNIQUE, Status.SINGULAR, Status.OK]
    assert jax.vmap(roots.jax())(values)[1].tolist() == codes == [int(roots.jax()(row)[1]) for row in values]
    assert jax.vmap(roots.jax())(values[:, :0])[1].tolist() == [0] * 4
    late = np.r_[np.ones(BLOCK), -1.0]
    assert roots.jax()(late)[1] == roots(late)[1] == Status.SINGULAR


def test_calls_at_once_share_threads(jax: Any) -> None:
    """Of XLA, several of whose computations run at a time: the same bits, and none waits for another."""
    rng, n = np.random.default_rng(2), 5 * BLOCK + 7
    rows, points = rng.normal(size=(n, 2)), np.repeat(X, n // len(X) + 1, 0)[:n]
    together = jax.jit(lambda m, x, r: (move.jax()(m, x), pairs.jax()(r), move.jax()(m[::-1], x), pairs.jax()(-r)))
    expected = move(M, points), pairs(rows), move(M[::-1].copy(), points), pairs(-rows)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: together(M, points, rows), range(12)):
            for a, b in zip(found, expected, strict=True):
                np.testing.assert_array_equal(a, b)


def test_where_nothing_is_compiled_python_is_called(jax: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from bladesmith.codegen.autodiff import jax_kernels

    monkeypatch.setattr(jax_kernels, "key_of", lambda *_: None)

    @codegen.kernel(cga.layout("motor"), cga.layout("point"))
    def apart(m: Any, x: Any) -> Any:
        return m * x * ~m

    f = jax.jit(apart.jax())
    np.testing.assert_array_equal(f(M, X), move(M, X))
    da = jax.grad(lambda m: f(m, X).sum())(M)
    np.testing.assert_allclose(da, apart.vjp(M, X)(np.ones((6, move.outputs[0].kind.size)))[0], rtol=1e-13)


def test_a_call_costs_little(jax: Any) -> None:
    import jax.numpy as jnp

    f, nothing = move.jax(), jax.jit(lambda m, x: m[:5] + x)
    m, x = jnp.asarray(M), jnp.asarray(X[0])

    def microseconds(g: Any) -> float:
        g(m, x).block_until_ready()
        start = time.perf_counter()
        for _ in range(200):
            g(m, x).block_until_ready()
        return (time.perf_counter() - start) / 200 * 1e6

    pairs = [(microseconds(f), microseconds(nothing)) for _ in range(7)]
    assert min(ours - empty for ours, empty in pairs) <= 20
