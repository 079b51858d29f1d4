"""Multivectors on JAX arrays and PyTorch tensors: numbers and kinds are NumPy's, derivatives those of differences."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.errors import (
    AlgebraMismatchError,
    BladesmithError,
    GradeError,
    InputError,
    KindError,
    ShapeError,
    SignatureError,
)

pytestmark = pytest.mark.peers

RNG = np.random.default_rng(0)
M, B = RNG.normal(size=(3, 8)), RNG.normal(size=6)
MOTOR, TWIST = pga.layout("motor"), pga.layout("twist")
X, Y = (pga.point(RNG.normal(size=(3, 3))) for _ in range(2))


@pytest.fixture
def jax() -> Iterator[Any]:
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@pytest.fixture(params=["jax", "torch"])
def array(request: Any) -> Callable[[Any], Any]:
    """Makes arrays of a package."""
    if request.param == "jax":
        request.getfixturevalue("jax")
        import jax.numpy as jnp

        return jnp.asarray
    torch = pytest.importorskip("torch")
    return lambda values: torch.tensor(np.asarray(values))


OPERATIONS: dict[str, Callable[[Any], Any]] = {
    "sums": lambda z: (z + pga.e1) + (2 - z) + (pga.e12 - z) + 1 + z,
    "scales": lambda z: 2 * z * np.arange(3.0) / 4 + np.arange(3.0) * z / np.arange(1, 4),
    "products": lambda z: (z * z) + (pga.e1 * z) + (z ^ pga.e1) + (pga.e1 ^ z) + (z | pga.e12) + (pga.e12 | z),
    "regressive": lambda z: (z & pga.e123) + (pga.e123 & z) + z.meet(pga.e1) + z.join(pga.e123),
    "by name": lambda z: z.commutator(pga.e12) + z.left_contraction(z) + z.scalar_product(z) + z.anticommutator(z),
    "linear maps": lambda z: ~z + (-z) + z.dual() + z.undual() + z.involute() + z.conjugate(),
    "grades": lambda z: z.grade(2),
    "no grade": lambda z: z.grade(1),
    "sandwich": lambda z: z >> X,
    "sandwich of it": lambda z: X >> z,
    "motor": lambda z: z.normalized(),
    "sandwich of a motor": lambda z: z.normalized() >> X,
    "logarithm": lambda z: z.normalized().log(),
    "root": lambda z: z.normalized().sqrt(),
    "exponential": lambda z: z.grade(2).exp(),
    "inverse": lambda z: z.inverse() + z / z + 1 / z + pga.e12 / z,
    "powers": lambda z: z**2 + z**-2 + z**0 + z ** np.int64(3),
    "powers of a motor": lambda z: z.normalized() ** 0.5 + z.normalized() ** np.array([0.5, 2, -1]),
    "versor's inverse": lambda z: z.normalized().inverse(),
    "items": lambda z: z[1] + z[:, None][..., 0] + z.reshape(3, 1)[0],
    "precision": lambda z: z.astype(np.float32) * 2.0,
    "constructor": lambda z: z >> pga.point(z.values[:, :3]),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_values_and_kinds_are_those_of_numpy(name: str, array: Callable[[Any], Any]) -> None:
    operation = OPERATIONS[name]
    found, true = operation(pga.multivector(array(M), kind=MOTOR)), operation(pga.multivector(M, kind=MOTOR))
    assert (found.kind, found.dtype, found.shape) == (true.kind, true.dtype, true.shape)
    np.testing.assert_allclose(np.asarray(found.values), true.values, rtol=1e-13, atol=1e-14)
    assert isinstance(found.numpy(), bs.Multivector) and found.numpy().kind == true.kind


def test_arrays_are_taken_as_they_are(array: Callable[[Any], Any]) -> None:
    own = array(M)
    x = pga.multivector(own, kind=MOTOR)
    assert x.values is own
    np.testing.assert_array_equal(np.asarray(x["e21"]), -M[:, 4])
    np.testing.assert_allclose(np.asarray(x.norm()), pga.multivector(M, kind=MOTOR).norm())
    np.testing.assert_array_equal(np.asarray(x), M)
    by_name = pga.multivector({"e1": array(np.arange(3.0)), "e21": 2.0})
    np.testing.assert_array_equal(np.asarray(by_name.values), [[0, -2], [1, -2], [2, -2]])
    mixed = pga.multivector(array([1.0, 2.0]), blades=["e2", "e21"])
    np.testing.assert_array_equal(np.asarray(mixed.values), [1, -2])
    numbers, plain = array(np.arange(3.0)), pga.multivector(M, kind=MOTOR)
    for made in (numbers * plain, plain * numbers, numbers + plain, plain - numbers):
        assert type(made) is type(x)


def test_objects_of_conformal_geometry(array: Callable[[Any], Any]) -> None:
    a, b = cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.circle((0, 1, 2), (0, 0.5, 1), 0.6)
    held = cga.multivector(array(a.values), kind="circle")
    rotor = bs.objects.rotor_between(held, b)
    assert rotor.kind == bs.objects.rotor_between(a, b).kind
    np.testing.assert_allclose(np.asarray((rotor >> held).values), b.values, atol=1e-14)
    with pytest.raises(GradeError, match="grade"):
        bs.objects.rotor_between(held, cga.plane((0, 0, 1), 1.0))
    scaled = cga.multivector(array(2 * cga.point((1, 2, 3)).values), kind=cga.layout("point")).normalized()
    np.testing.assert_allclose(np.asarray(scaled.values), cga.point((1, 2, 3)).values)


def test_what_has_no_answer_is_nan_and_what_is_wrong_an_error(array: Callable[[Any], Any]) -> None:
    x = pga.multivector(array(M), kind=MOTOR)
    assert np.isnan(np.asarray((0 * x).inverse().values)).all()
    for call, error, message in (
        (lambda: pga.multivector(array(M), kind="motor"), KindError, "is not a motor"),
        (lambda: pga.multivector(array(M), kind=TWIST), ShapeError, "6"),
        (lambda: x * x[:2], ShapeError, "do not broadcast"),
        (lambda: x + x[:2], ShapeError, "do not broadcast"),
        (lambda: x * array(np.ones(2)), ShapeError, "do not broadcast"),
        (lambda: x * cga.e1, AlgebraMismatchError, "different algebras"),
        (lambda: x + cga.e1, AlgebraMismatchError, "different algebras"),
        (lambda: cga.multivector(x), InputError, "not converted"),
        (lambda: x.exp(), GradeError, "a series"),
        (lambda: x.status, InputError, "no statuses"),
        (lambda: x**True, InputError, "the exponent"),
        (lambda: x**5000, InputError, "the exponent"),
        (lambda: x.outer("a"), InputError, "the other operand is 'a'"),
        (lambda: pga.outermorphism(np.eye(4)).apply(x), InputError, "x is on an array of"),
        (lambda: pga.multivector({"e1": array(np.ones(2)), "e2": array(np.ones(3))}), ShapeError, "do not broadcast"),
        (lambda: pga.multivector({"e1": array(np.ones(2)), "e2": "x"}), BladesmithError, "coefficient of 'e2'"),
        (lambda: x.copy(), InputError, "not written to"),
        (lambda: pga.multivector(array(M), basis="orthonormal"), InputError, "basis="),
        (lambda: bs.objects.trs_rotor(x, x), InputError, "a multivector is needed"),
        (lambda: bs.algebra(7).multivector(array(np.ones(128))) * bs.algebra(7).random(), SignatureError, "too large"),
    ):
        with pytest.raises(error, match=message):
            call()


def loss(b: Any) -> Any:
    motor = pga.multivector(b, kind=TWIST).exp()
    return (((motor >> X) - Y).values ** 2).sum()


def slopes(f: Callable[[Any], Any], b: Any, h: float = 1e-6) -> np.ndarray:
    """Central differences."""
    return np.array([(f(b + h * e) - f(b - h * e)) / (2 * h) for e in np.eye(len(b))])


def test_gradients_of_jax(jax: Any) -> None:
    import jax.numpy as jnp

    b = jnp.asarray(B)
    true = slopes(loss, B)
    for gradient in (jax.grad(loss), jax.jit(jax.grad(loss)), jax.jacfwd(loss)):
        np.testing.assert_allclose(gradient(b), true, rtol=1e-6)
    np.testing.assert_allclose(jax.grad(loss)(jnp.zeros(6)), slopes(loss, np.zeros(6)), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(jax.hessian(loss)(b)[0], slopes(lambda c: jax.grad(loss)(c)[0], b), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(jax.vmap(loss)(jnp.stack([b, 2 * b])), [loss(B), loss(2 * B)], rtol=1e-13)
    centers = jax.grad(lambda p: (cga.rotor((0, 0, 1), 0.5) >> cga.point(p)).values.sum())(jnp.ones(3))
    np.testing.assert_allclose(
        centers, slopes(lambda p: (cga.rotor((0, 0, 1), 0.5) >> cga.point(p)).values.sum(), np.ones(3)), rtol=1e-8
    )


def test_multivectors_are_trees_of_arrays_for_jax(jax: Any) -> None:
    import jax.numpy as jnp

    motor = pga.multivector(jnp.asarray(B), kind=TWIST).exp()
    moved = jax.jit(lambda m, p: m >> p)(motor, X)  # X is on NumPy arrays
    np.testing.assert_allclose(moved.values, (motor.numpy() >> X).values, rtol=1e-14)
    assert moved.kind == X.kind
    each = jax.vmap(lambda m, p: m >> p, (None, 0))(motor, X)
    np.testing.assert_array_equal(each.values, moved.values)
    last, sizes = jax.lax.scan(lambda c, _: (c * motor, c.norm()), motor, None, length=3)
    np.testing.assert_allclose(last.values, (motor.numpy() ** 4).values, rtol=1e-13, atol=1e-14)
    slope = jax.grad(lambda p: ((motor >> p).values ** 2).sum())(pga.multivector(jnp.asarray(X.values), kind="point"))
    assert slope.values.shape == X.values.shape and sizes.shape == (3,)
    on_numpy = jax.tree.map(np.asarray, moved)
    assert isinstance(on_numpy, bs.Multivector) and jax.tree.structure(moved) == jax.tree.structure(moved[0])
    with pytest.raises(KindError, match="check=False"):
        jax.jit(lambda v: pga.multivector(v, kind="motor"))(motor.values)
    with pytest.raises(InputError, match="traced"):
        jax.jit(lambda m: m.numpy().values)(motor)
    trusted = jax.jit(lambda v: pga.multivector(v, kind=MOTOR).as_kind("motor", check=False))(motor.values)
    assert trusted.kind == motor.kind


def test_arrays_of_single_precision_stay_so(jax: Any) -> None:
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", False)
    motor = pga.multivector(jnp.asarray(B), kind=TWIST).exp()
    assert motor.dtype == (motor >> X).dtype == (motor + pga.e1).dtype == np.float32
    assert jax.grad(loss)(jnp.asarray(B)).dtype == np.float32


def test_gradients_of_pytorch() -> None:
    torch = pytest.importorskip("torch")
    b = torch.tensor(B, requires_grad=True)
    loss(b).backward()
    np.testing.assert_allclose(b.grad, slopes(loss, B), rtol=1e-6)
    assert torch.autograd.gradgradcheck(loss, (b,))
    for wrong, word in ((b.half(), "float16"), (b.to("meta"), "meta")):
        with pytest.raises(InputError, match=word):
            pga.multivector(wrong, kind=TWIST)
    both = torch.from_dlpack(X), torch.from_dlpack(X.copy())
    assert all(np.array_equal(t.numpy(), X.values) for t in both)


def test_two_packages_do_not_mix(jax: Any) -> None:
    import jax.numpy as jnp

    torch = pytest.importorskip("torch")
    with pytest.raises(InputError, match="JAX and PyTorch"):
        pga.multivector(jnp.ones(8), kind=MOTOR) * pga.multivector(torch.ones(8), kind=MOTOR)


def test_values_go_to_jax_by_dlpack(jax: Any) -> None:
    import jax.numpy as jnp

    np.testing.assert_array_equal(jnp.from_dlpack(X), X.values)
    np.testing.assert_array_equal(jnp.asarray(X), X.values)


def test_numpy_multivectors_import_neither_package() -> None:
    text = (
        "import sys; from bladesmith import pga3d as p; (p.random('motor', seed=1) >> p.point((1, 2, 3))).normalized();"
        "assert not {'jax', 'torch'} & set(sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", text], check=False).returncode == 0
