"""Tracing: what is proved, what is refused, and that graphs, formulas and derivatives agree."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bladesmith import codegen
from bladesmith.codegen.algebra.algebra import Algebra, Kind, scalar_argument
from bladesmith.codegen.algebra.kind_checks import check_kind
from bladesmith.codegen.algebra.loader import STOCK, algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.multivector import Multivector
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.errors import KindError, SpecError, TraceError
from bladesmith.codegen.formulas.objects.blades import blade_projector, project_to_blade
from bladesmith.codegen.trace.outputs import row
from bladesmith.codegen.trace.trace import trace

from ...support.formulas import sandwich

ALGEBRAS = {name: algebra_from_data(load_spec(stock_spec_path(name))) for name in STOCK}
CGA, PGA = ALGEBRAS["cga3d"], ALGEBRAS["pga3d"]


def members(kind: Kind, count: int, seed: int, scale: float = 1.0) -> np.ndarray:
    mv = sample(kind, NumericSource(count, seed, scale))
    return np.stack([np.broadcast_to(v, (count,)) for v in kind.values(mv)], -1)


@pytest.mark.parametrize("kind", [k for a in ALGEBRAS.values() for k in a.kinds.values()], ids=repr)
def test_random_members_obey_their_constraints(kind: Kind) -> None:
    check_kind(kind)


def test_a_wrong_member_is_found() -> None:
    data = load_spec(stock_spec_path("cga2d"))
    broken = {**data, "kinds": {"circle": {**data["kinds"]["circle"], "member": "e12no + scalar() * e12ni"}}}
    with pytest.raises(KindError, match="does not hold"):
        check_kind(algebra_from_data(broken).kind("circle"))


@pytest.mark.parametrize("name", ["point", "point_pair", "line", "circle", "plane", "sphere", "motor", "direction"])
def test_motors_keep_the_kind_of_what_they_move(name: str) -> None:
    kernel = trace(sandwich, [CGA.kind("motor"), CGA.kind(name)], name="move")
    assert kernel.outputs[0].kind == CGA.kind(name)


def test_the_projector_of_any_trivector_is_a_unit_circle_on_both_branches() -> None:
    kernel = trace(project_to_blade, [CGA.layout("circle")], returns=CGA.kind("circle"))
    assert kernel.outputs[0].kind is CGA.kind("circle")
    rng = np.random.default_rng(5)
    x = rng.normal(size=(4000, 10))
    y = np.stack(kernel.reference(NumericSource(1, 1).ring, [list(x.T)])[0], -1)
    sigma = np.stack(
        trace(lambda c: -(c * ~c).grade(0), [CGA.layout("circle")], name="s0").evaluate_flat(
            list(x.T), NumericSource(1, 1).ring
        )[0],
        -1,
    )
    real = np.isfinite(y).all(1)
    assert (sigma[real] > 0).any() and (sigma[real] < 0).any()


def test_what_does_not_hold_is_refused() -> None:
    with pytest.raises(TraceError, match=r"x \* ~x - 1 does not hold"):
        trace(lambda a, b: a + b, [CGA.kind("motor")] * 2, name="total", returns=CGA.kind("motor"))
    with pytest.raises(TraceError, match="identically zero"):
        trace(lambda x: 1 / (x * x), [CGA.kind("point")], name="bad")
    with pytest.raises(TraceError, match="takes 1 arguments"):
        trace(lambda x: x, [CGA.kind("point")] * 2, name="bad")
    with pytest.raises(TraceError, match="returns multivectors"):
        trace(lambda x: 3, [CGA.kind("point")], name="bad")


def test_exact_zero_is_seen_through_roots() -> None:
    def difference(x: Multivector, y: Multivector) -> Multivector:
        n = codegen.sqrt((x * x).grade(0) + (y * y).grade(0) + 1)
        return n * n - (x * x).grade(0) - (y * y).grade(0) - 1 + x * 0 + (x | y) * 0

    kernel = trace(difference, [PGA.layout("plane"), PGA.layout("plane")], name="nothing")
    assert [n.op for n in kernel.roots] == ["const"]


def blend(x: Multivector, y: Multivector, alpha: Multivector) -> Multivector:
    z = alpha * x + (1 - alpha) * y
    return blade_projector(z) * z


@pytest.fixture(scope="module")
def circles() -> tuple[np.ndarray, np.ndarray]:
    return members(CGA.kind("circle"), 50, 1), members(CGA.kind("circle"), 50, 2)


def finite_difference(f: Callable[[float], np.ndarray]) -> np.ndarray:
    h = 1e-6
    return (f(h) - f(-h)) / (2 * h)


@pytest.mark.slow
def test_derivatives_match_finite_differences(circles: tuple[np.ndarray, np.ndarray]) -> None:
    x, y = circles
    kernel = codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)(blend)
    value = kernel(x, y, 0.3)
    scale = np.abs(value).max(-1, keepdims=True)
    slope = kernel.derivative("alpha")(x, y, 0.3)
    numeric = finite_difference(lambda h: kernel(x, y, 0.3 + h))
    calm = np.abs(slope).max(-1) < 1e2 * scale[..., 0]  # near a singular projector differences are no measure
    assert calm.sum() > 25
    np.testing.assert_allclose(slope[calm], numeric[calm], rtol=1e-5, atol=1e-5 * float(scale[calm].max()))
    free = np.random.default_rng(3).normal(size=x.shape)
    along = kernel.derivative("x")
    assert along.arguments == ["x", "y", "alpha", "d_x"]
    exact = along(x, y, 0.3, free)
    numeric = finite_difference(lambda h: kernel.on("numpy")(x + h * free, y, 0.3))
    np.testing.assert_allclose(exact[calm], numeric[calm], rtol=1e-4, atol=1e-4 * float(scale[calm].max()))


def test_derivative_reference_has_fifty_digits(circles: tuple[np.ndarray, np.ndarray]) -> None:
    x, y = circles[0][0], circles[1][0]
    slope = codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)(blend).derivative("alpha")
    import mpmath

    precise = slope.reference(x, y, 0.3, digits=50)
    kernel = codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)(blend)
    with mpmath.workdps(50):
        h = mpmath.mpf(10) ** -15
        ends = [
            kernel.traced.reference(
                _ring(),
                [[mpmath.mpf(float(v)) for v in x], [mpmath.mpf(float(v)) for v in y], [mpmath.mpf(0.3) + s * h]],
            )[0]
            for s in (1, -1)
        ]
        for a, b, c in zip(*ends, precise, strict=True):
            assert abs((a - b) / (2 * h) - c) < mpmath.mpf(10) ** -25 * (1 + abs(c))


def _ring() -> Any:
    from bladesmith.codegen.rings.protocol import PrecisionRing

    return PrecisionRing(50)


def test_unknown_arguments_of_derivatives() -> None:
    kernel = codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)(blend)
    with pytest.raises(TraceError, match="no argument 'beta'"):
        kernel.derivative("beta")


def test_rows_of_numbers() -> None:
    def powers(c: tuple[Multivector, ...], t: Multivector) -> Any:
        return row([t, t * t, c[0] * t + c[1]])

    kernel = codegen.kernel(codegen.numbers(2), codegen.scalar, algebra=PGA)(powers)
    out = kernel(np.array([[2.0, 3.0], [4.0, 5.0]]), np.array([10.0, 20.0]))
    np.testing.assert_array_equal(out, [[10, 100, 23], [20, 400, 85]])


@pytest.mark.slow
def test_calls_are_shared_and_their_kinds_are_checked() -> None:
    project = codegen.kernel(CGA.layout("circle"), returns=CGA.kind("circle"))(project_to_blade)

    @codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)
    def shared(x: Multivector, y: Multivector, alpha: Multivector) -> Multivector:
        return project(alpha * x + (1 - alpha) * y)

    assert [k.name for k in shared.traced.callees] == ["project_to_blade"]
    assert shared.traced.outputs[0].kind == CGA.kind("circle")
    x, y = members(CGA.kind("circle"), 20, 8), members(CGA.kind("circle"), 20, 9)
    inlined = codegen.kernel(CGA.kind("circle"), CGA.kind("circle"), codegen.scalar)(blend)
    np.testing.assert_allclose(shared(x, y, 0.4), inlined(x, y, 0.4), rtol=1e-12)
    move = codegen.kernel(CGA.kind("motor"), CGA.kind("circle"))(sandwich)
    with pytest.raises(TraceError, match="is not a circle"):
        trace(lambda m, x: move(m, 2 * x), [CGA.kind("motor"), CGA.kind("circle")], name="twice")


@pytest.mark.parametrize(
    "text", ["__import__('os')", "x.terms", "lambda: 1", "[x]", "open('f')", "x if x else x", "e77", "x ** 2", ""]
)
def test_expressions_run_nothing_else(text: str) -> None:
    from bladesmith.codegen.algebra.spec_language import evaluate

    like = Multivector(CGA, NumericSource(1, 1).ring, {})
    with pytest.raises(SpecError):
        evaluate(text, like, {"x": like.constant(1)}, "a test")


@pytest.mark.compiles
def test_text_does_not_depend_on_the_hash_seed() -> None:
    program = (
        "from bladesmith.codegen.algebra.loader import algebra_from_data\n"
        "from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path\n"
        "from bladesmith.codegen.api import KernelFunction\n"
        "from bladesmith.codegen.formulas.objects.blades import project_to_blade\n"
        "a = algebra_from_data(load_spec(stock_spec_path('cga3d')))\n"
        "f = lambda m, x: m >> x\n"
        "print(KernelFunction(f, [a.kind('motor'), a.kind('line')], None, 'move', None).source('c'))\n"
        "print(KernelFunction(project_to_blade, [a.layout('circle')], None, 'p', None).source('c'))\n"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "77")
    }
    assert len(texts) == 1 and "cga3d_move" in texts.pop()


def test_scalar_kernels_need_an_algebra() -> None:
    with pytest.raises(TraceError, match="say which algebra"):
        codegen.kernel(codegen.scalar)(lambda t: t * t)
    assert scalar_argument(PGA).is_scalar_argument and isinstance(PGA, Algebra)


@pytest.mark.compiles
def test_arguments_may_have_any_name() -> None:
    @codegen.kernel(CGA.kind("motor"), CGA.kind("point"))
    def clash(out: Multivector, double: Multivector) -> Multivector:
        return out >> double

    m, x = members(CGA.kind("motor"), 9, 1), members(CGA.kind("point"), 9, 2)
    expected = codegen.kernel(CGA.kind("motor"), CGA.kind("point"))(sandwich)(m, x)
    np.testing.assert_array_equal(clash(m, x), expected)
    np.testing.assert_array_equal(clash.on("numpy")(m, x), expected)
