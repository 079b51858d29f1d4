"""Reverse derivatives of graphs where they go wrong: branches not taken, values that are none, shared nodes."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen
from bladesmith.codegen.errors import InputError, MissingExtraError, ShapeError, TraceError
from bladesmith.codegen.formulas.products.outcome import where_or_nan

from ...support.targets.elementary import stumpff


def pulled(formula: Callable[..., Any], *inputs: Any, cotangent: Any = 1.0) -> list[np.ndarray]:
    """Cotangents by the C text, which must be those of the NumPy text."""
    kernel = codegen.kernel(*[codegen.scalar] * len(inputs), algebra=cga, name="f")(formula)
    found = kernel.vjp(*inputs)(np.reshape(cotangent, (*np.shape(cotangent), 1)))
    pullback = kernel.pullback()
    columns = pullback.on("numpy")(*np.broadcast_arrays(*map(np.asarray, inputs)), np.reshape(cotangent, (-1, 1)))
    assert len(columns) == len(found) if isinstance(columns, tuple) else len(found) == 1
    return [np.asarray(x) for x in found]


def test_a_branch_that_is_not_taken_may_be_infinite() -> None:
    x = np.array([0.0, 4.0, -1.0])

    def root(x: Any) -> Any:
        return codegen.select(x > 0, codegen.sqrt(x), 0 * x) * (1 + x)

    np.testing.assert_allclose(pulled(root, x)[0], [0.0, 2 + 5 / 4, 0.0])

    def quotient(x: Any) -> Any:
        inverse = codegen.reciprocal(x)
        return codegen.select(x > 0, inverse * x * 3 + inverse, x) + codegen.select(x > 2, inverse, 2 * x)

    np.testing.assert_allclose(pulled(quotient, x)[0], [3.0, -1 / 8, 3.0])


def test_both_branches_of_one_comparison_are_whole() -> None:
    def formula(x: Any, y: Any) -> Any:
        inverse = codegen.reciprocal(y)
        return codegen.select(x > 0, inverse * x, inverse)

    found = pulled(formula, np.array([2.0, -2.0]), 4.0)
    np.testing.assert_allclose(found[0], [0.25, 0.0])
    np.testing.assert_allclose(found[1], -2 / 16 - 1 / 16)  # shared by two items


def test_nested_branches() -> None:
    def formula(x: Any) -> Any:
        inner = codegen.select(x > 1, codegen.log(x - 1), codegen.sqrt(-x))
        return codegen.select(x > 2, inner * x, codegen.select(x < -1, inner, x * x))

    x = np.array([3.0, 1.0, 0.0, -4.0, 1.5])
    np.testing.assert_allclose(pulled(formula, x)[0], [np.log(2) + 1.5, 2.0, 0.0, -0.25, 3.0])


def test_no_value_has_no_derivative() -> None:
    def root(x: Any) -> Any:
        return where_or_nan(x > 0, x * x) * 3

    found = pulled(root, np.array([2.0, -1.0]))[0]
    assert found[0] == 12.0 and np.isnan(found[1])

    def guarded(x: Any) -> Any:
        return codegen.select(x > 0, 1 / where_or_nan(x > 0, x), 5 * x)

    np.testing.assert_allclose(pulled(guarded, np.array([2.0, -1.0]))[0], [-0.25, 5.0])


def test_a_value_that_is_used_twice() -> None:
    def formula(x: Any, y: Any) -> Any:
        product = x * y
        return product * product + codegen.sin(product) + x * x * x

    x, y = 0.3, 1.7
    found = pulled(formula, x, y)
    outer = 2 * x * y + np.cos(x * y)
    np.testing.assert_allclose(found[0], outer * y + 3 * x * x, rtol=1e-15)
    np.testing.assert_allclose(found[1], outer * x, rtol=1e-15)


@pytest.mark.parametrize(
    ("formula", "slope"),
    [
        (lambda x: codegen.exp(x) + codegen.log(x), lambda x: np.exp(x) + 1 / x),
        (lambda x: codegen.cos(x) * codegen.absolute(x - 3), lambda x: np.sin(x) * (x - 3) - np.cos(x)),
        (lambda x: codegen.atan2(x, 2 * x * x), lambda x: -2 / (1 + 4 * x * x)),
        (lambda x: codegen.stumpff1(x * x) * x, np.cos),
    ],
)
def test_functions(formula: Any, slope: Any) -> None:
    x = np.array([0.3, 1.1, 2.9])
    np.testing.assert_allclose(pulled(formula, x)[0], slope(x), rtol=1e-13)


#: Zero, tiny ones, quarter and full turns and what is beside them, hyperbolic ones, ends of polynomials, large ones.
STUMPFF_ARGUMENTS = (
    0.0, 1e-300, -1e-300, 1e-9, -1e-9, 0.7, -0.7, 1.5, 6.0, 7.0, -9.1, 35.9, 36.1, -35.9, -36.1, -50.0, -1e3, -1e5,
    *((2 * np.pi * n) ** 2 * (1 + s) for n in (0.25, 0.5, 1, 2, 3) for s in (0, -1e-15, 1e-9)), 1e4, 1e6, 1e12, 1e100,
)  # fmt: skip


def slope_of_stumpff(k: int, w: Any, c: list[Any]) -> Any:
    """-sum over n of (n + 1) (-w)^n/(2n + k + 2)! or, where that is long, (c_(k-1) - k c_k)/(2w)."""
    if abs(w) < 1:
        return -sum((n + 1) * (-w) ** n / mp.factorial(2 * n + k + 2) for n in range(20))
    return ((c[k - 1] if k else -w * c[1]) - k * c[k]) / (2 * w)


def stumpff_row(*numbers: int) -> Any:
    def formula(x: Any) -> Any:
        return codegen.row([x.new({0: x.ring.apply(f"stumpff{k}", x.scalar())}) for k in numbers])

    return codegen.kernel(codegen.scalar, algebra=cga, name="f")(formula)


def test_slopes_of_stumpff_functions() -> None:
    """As good as the functions themselves, 8 ulp; c1 and c2 are no better than their argument where it is large."""
    kernel = stumpff_row(*range(6))
    for dtype, lowest, highest in ((np.float64, -1e6, 1e10), (np.float32, -7e3, 1e7)):
        w = np.array([x for x in STUMPFF_ARGUMENTS if lowest < x < np.finfo(dtype).max], dtype)
        found = kernel.vjp(w[:, None] + np.zeros(6, dtype))(np.eye(6, dtype=dtype) + np.zeros((len(w), 1, 1), dtype))[0]
        assert found.dtype == dtype and found.shape == (len(w), 6)
        eps = float(np.finfo(dtype).eps)
        np.testing.assert_array_equal(kernel.derivative("x")(w), found)
        for x, slopes in zip(w.tolist(), found.tolist(), strict=True):
            with mp.workdps(50):
                c = [stumpff(k, mp.mpf(x)) for k in range(8)]
                for k, slope in list(enumerate(slopes))[2 * (x > highest) :]:
                    size = (k * c[k + 2] + abs(c[k + 1])) / 2
                    assert abs(slope - slope_of_stumpff(k, mp.mpf(x), c)) <= 10 * eps * size + eps**2


def test_slopes_of_the_last_stumpff_functions_are_refused() -> None:
    for kernel in (stumpff_row(6), stumpff_row(7), stumpff_row(4).pullback(), stumpff_row(5).derivative("x")):
        for derivative in (kernel.pullback("x"), kernel.derivative("x")):
            with pytest.raises(TraceError, match="derivative of stumpff[67] needs .* beyond stumpff7"):
                _ = derivative.traced


def test_wrong_calls_are_refused() -> None:
    kernel = codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga, name="f")(lambda a, b: a * b)
    with pytest.raises(InputError, match="2 arguments"):
        kernel.vjp(1.0)
    with pytest.raises(InputError, match="1 cotangents"):
        kernel.vjp(1.0, 2.0)()
    with pytest.raises(ShapeError, match=r"^f: the cotangent of the result has shape \(3,\)\. Give \(1,\), the "):
        kernel.vjp(1.0, 2.0)(np.ones(3))
    with pytest.raises(ShapeError, match=r"has shape \(5, 2, 1\)\. Give \(2, 1\)"):
        kernel.vjp(np.ones(2), 2.0)(np.ones((5, 2, 1)))
    with pytest.raises(TraceError, match="no argument 'c'"):
        kernel.pullback("c")
    with pytest.raises(TraceError, match=r"no argument \['a'\]"):
        kernel.pullback(["a"])  # type: ignore[arg-type]
    for call in (lambda: kernel(1.0, [[1.0], [1.0, 2.0]]), lambda: kernel.vjp(1.0, [[1.0], [1.0, 2.0]])(1.0)):
        with pytest.raises(InputError, match="^b has rows of several lengths"):
            call()
    with pytest.raises(InputError, match="masks some"):
        kernel.vjp(np.ones(2), 2.0)(np.ma.masked_array(np.ones((2, 1)), [[False], [True]]))


def test_cotangents_of_one_number_have_the_shape_of_the_batch_or_none() -> None:
    kernel = codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga, name="f")(lambda a, b: a * a * b)
    rng = np.random.default_rng(0)
    for shape in ((), (1,), (5,), (5, 1), (3, 5)):
        a, b, c = rng.normal(size=shape), 2.0, rng.normal(size=shape)
        for given in (c, 1.5, 2, np.float64(0.5), c[..., None], c[:1][..., None] if shape else c):
            numbers = given[..., 0] if np.ndim(given) == len(shape) + 1 else given
            da, db = kernel.vjp(a, b)(given)
            np.testing.assert_allclose(da, np.broadcast_to(numbers, shape) * 2 * a * b, rtol=1e-14)
            np.testing.assert_allclose(db, (numbers * a * a).sum(), rtol=1e-13)
    single = kernel.vjp(a.astype(np.float32), np.float32(b))(1.5)
    assert {x.dtype for x in single} == {np.dtype(np.float32)}
    for bad in (np.ones(4), np.ones((5, 2)), np.ones((2, 5, 1)), np.ones((3, 5, 2))):
        with pytest.raises(ShapeError, match=r"^f: the cotangent of the result has shape .*\(3, 5, 1\)"):
            kernel.vjp(a, b)(bad)
    with pytest.raises(ShapeError, match=r"or \(3, 5\): c\[\.\.\., None\]"):
        kernel.vjp(a, b)(np.ones(4))
    with pytest.raises(InputError, match="^f: the cotangent of the result has type <U1"):
        kernel.vjp(a, b)("a")
    two = codegen.kernel(cga.kind("motor"), name="two")(lambda m: (m * m, m | m))
    with pytest.raises(ShapeError, match=r"^two: the cotangent of out has shape \(\)\. Give \(8,\)"):
        two.vjp(cga.rotor((0, 0, 1), 0.3))(1.0, np.ones(1))


def test_what_is_shared_has_the_sum() -> None:
    kernel = codegen.kernel(codegen.scalar, codegen.numbers(2), algebra=cga, name="f")(
        lambda a, b: codegen.row([a * b[0], a * a * b[1]])
    )
    rng = np.random.default_rng(0)
    a, b, g = rng.normal(size=(5000, 1)), rng.normal(size=(3, 2)), rng.normal(size=(5000, 3, 2))
    da, db = kernel.vjp(a, b)(g)
    each_a, each_b = kernel.vjp(a + np.zeros(3), b + np.zeros((5000, 3, 2)))(g)
    np.testing.assert_allclose(da, each_a.sum(1, keepdims=True), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(db, each_b.sum(0), rtol=1e-12)
    da, db = kernel.vjp(a[:, 0], b[0])(g[:, 0])
    np.testing.assert_allclose(db, (a ** np.arange(1, 3) * g[:, 0]).sum(0), rtol=1e-12)
    assert da.shape == (5000,) and kernel.vjp(2.0, b[0])(g[0, 0])[0].shape == ()
    empty = kernel.vjp(2.0, np.ones((1, 0, 2)))(np.ones((1, 0, 2)))
    assert empty[0] == 0 and empty[1].shape == (1, 0, 2)
    assert kernel.vjp(np.ones((0, 1)), b)(np.ones((0, 3, 2)))[1].tolist() == np.zeros((3, 2)).tolist()


def test_a_sum_over_all_items_has_one_cotangent() -> None:
    loss = codegen.kernel(codegen.scalar, codegen.scalar, algebra=cga, name="f", reduce="sum")(lambda a, b: a * a * b)
    a, b = np.random.default_rng(0).normal(size=(2, 70_001))
    da, db = loss.vjp(a, b[0])(np.array([2.0]))
    np.testing.assert_allclose(da, 4 * a * b[0], rtol=1e-14)
    assert db.shape == () and abs(db - 2 * math.fsum(a * a)) <= 1e-15 * db
    with pytest.raises(ShapeError, match=r"result has shape \(70001, 1\)\. Give \(1,\)"):
        loss.vjp(a, b)(np.ones((70_001, 1)))


@pytest.mark.parametrize("package", ["jax", "torch"])
def test_without_the_package_there_is_the_reverse_derivative(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (f"bladesmith.codegen.autodiff.{package}_kernels", package):
        monkeypatch.setitem(sys.modules, module, None)
        if module != package:
            monkeypatch.delitem(sys.modules, module)
    kernel = codegen.kernel(codegen.scalar, algebra=cga, name="f")(lambda a: a * a)
    with pytest.raises(MissingExtraError, match=rf"bladesmith\[{package}\]'\. The kernel's vjp gives .*NumPy alone"):
        getattr(kernel, package)()
    assert kernel.vjp(3.0)(1.0)[0] == 6.0


def test_arguments_of_another_size_are_told_what_makes_their_kind() -> None:
    kernel = codegen.kernel(cga.kind("motor"), cga.kind("point"), name="f")(lambda m, x: m >> x)
    m, x = cga.rotor((0, 0, 1), 0.3).as_kind("motor").values, np.ones((7, 3))
    for call in (lambda: kernel(m, x), lambda: kernel.vjp(m, x), lambda: kernel.on("numpy")(m, x)):
        with pytest.raises(ShapeError, match=r"^f: x has shape \(7, 3\).*cga3d\.point\(xyz\) makes a point"):
            found = call()
            found(1.0)
    with pytest.raises(ShapeError, match=r"^f: m has shape \(3, 3\).*cga3d\.motor_from_matrix\(matrix\) makes a motor"):
        kernel(np.eye(3), cga.point(x))
