"""Inverses, exponentials and logarithms of multivectors where they are singular, of any scale, empty or not finite."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import errors

RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("method", ["shirokov", "hitzer", "matrix"])
def test_singular_inverses(method: str) -> None:
    alg = bs.algebra(2, 0, 1)
    x = alg.multivector({"1": [1.0, 1.0, 0.0, np.nan], "e1": [0.5, 1.0, 0.0, 1.0], "e0": [2.0, 2.0, 3.0, 1.0]})
    inverse = x.inverse(method)
    assert inverse.status.tolist() == [bs.Status.OK, bs.Status.SINGULAR, bs.Status.SINGULAR, bs.Status.INVALID]
    assert (x[0] * inverse[0]).isclose(1) and np.isnan(inverse.values[1:]).all()
    with pytest.raises(errors.NotInvertibleError, match="item 1"):
        x.inverse(method, strict=True)
    with pytest.raises(errors.InputError, match="shirokov"):
        x.inverse("cramer")


@pytest.mark.parametrize("method", ["shirokov", "hitzer", "matrix"])
@pytest.mark.parametrize("scale", [1e160, 1e-300, 3e80])
def test_scale_does_not_matter(method: str, scale: float) -> None:
    alg = bs.cga3d
    x = alg.multivector({"1": [1.0, 0.0, 1.0], "e12": [0.5, 1.0, 0.0], "e123no": [0.2, 0.0, 0.0]}) * scale
    inverse = x.inverse(method)
    assert (inverse.status == bs.Status.OK).all() and (x * inverse).isclose(1).all()
    e1 = alg.e1 * scale
    assert np.isclose(e1.norm(), scale, rtol=1e-15) and e1.normalized().isclose(alg.e1)
    mixed = alg.multivector({"e1": [0.0, 1e200, 2.0, np.nan]})
    assert np.allclose(mixed.norm(), [0, 1e200, 2, np.nan], rtol=1e-15, equal_nan=True)
    assert mixed.normalized().status[:3].tolist() == [bs.Status.SINGULAR, bs.Status.OK, bs.Status.OK]
    single = (alg.e1 + alg.e23).astype(np.float32) * 1e30
    assert single.dtype == np.float32 and (single * single.inverse(method)).isclose(1)


def test_batches_of_none() -> None:
    x = bs.pga3d.multivector(np.zeros((0, 16)))
    assert all(x.inverse(method).shape == (0,) for method in ("shirokov", "hitzer", "matrix"))
    assert x.norm().shape == x.normalized().shape == x.values.shape[:1] == (0,)


def test_exponentials_that_are_not_finite_say_so() -> None:
    cga = bs.cga3d
    turned = cga.multivector({"e12": [np.nan, 1.0, 1e300]}).exp()
    assert turned.status.tolist() == [bs.Status.INVALID, bs.Status.OK, bs.Status.INVALID]
    general = cga.multivector({"e1": [np.inf, 1.0]}).exp()
    assert general.status.tolist() == [bs.Status.INVALID, bs.Status.OK]
    assert np.isclose(general[1]["1"], np.cosh(1))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_an_exponential_does_not_depend_on_the_rest_of_its_batch(dtype: type) -> None:
    algebra, numbers = bs.algebra(3), RANDOM.normal(size=(20, 8))
    blades = algebra.multivector(np.ones(8)).blades
    batch = algebra.multivector(numbers, blades=blades).astype(dtype)
    large = numbers[:3] * np.array([1e6, 1e12, 1e37])[:, None]
    mixed = algebra.multivector(np.concatenate([numbers, large]), blades=blades).astype(dtype)
    mixed._data[-1] = np.finfo(dtype).max
    alone = np.stack([x.exp().values for x in batch])
    with np.errstate(all="ignore"):
        assert (mixed.exp().values[:20] == alone).all() and (batch.exp().values == alone).all()
        assert (mixed.reshape(23, 1).exp().values[:20, 0] == alone).all()
    assert mixed.exp().status[-1] == bs.Status.INVALID and (mixed.exp().status[:20] == bs.Status.OK).all()


@pytest.mark.parametrize("grade", ["x", 99, -1, 2.5, True])
def test_grades_that_are_none(grade: Any) -> None:
    with pytest.raises(errors.GradeError, match="a whole number from 0 to 5"):
        bs.cga3d.e1.grade(grade)


def test_shapes_numbers_and_indices_that_do_not_fit() -> None:
    a = bs.cga3d.point(np.zeros((5, 3)))
    for call in (lambda: np.ones(3) * a, lambda: a / np.ones(3)):
        with pytest.raises(errors.ShapeError, match="broadcast"):
            call()
    for call in (lambda: a * 10**400, lambda: a / 10**400):
        with pytest.raises(errors.InputError, match="too large"):
            call()
    with pytest.raises(IndexError, match=r"2 indices for items of shape \(5,\)"):
        a[0, 0]
    with pytest.raises(IndexError, match="out of bounds"):
        a[9]
    with pytest.raises(errors.InputError, match="masks"):
        bs.cga3d.point(np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False]))


def test_inverses_of_versors_are_reverses() -> None:
    cga = bs.cga3d
    m = cga.translator([1.0, 2.0, 3.0]) * cga.rotor([1.0, 0.0, 0.0], 1.0)
    assert m.inverse().kind == cga.kind("motor") and (m * m.inverse()).isclose(1)
    s = cga.sphere([1.0, 0.0, 0.0], 2.0)
    assert (s * s.inverse()).isclose(1) and s.inverse().kind == cga.kind("sphere")


def test_exponentials() -> None:
    cga = bs.cga3d
    b = cga.multivector(RANDOM.normal(size=(20, 6)), kind=cga.layout("twist"))
    motor = b.exp()
    assert motor.kind == cga.kind("motor") and (motor.log().exp()).isclose(motor, rtol=1e-12).all()
    assert (motor.sqrt() * motor.sqrt()).isclose(motor, rtol=1e-12).all()
    alg = bs.algebra(3, 1, 1)
    x = alg.multivector(RANDOM.normal(size=(3, 32)))
    e = x.exp()
    assert (e * (-x).exp()).isclose(1, rtol=1e-7, atol=1e-7).all()
    assert ((x / 3).exp() * (x / 3).exp() * (x / 3).exp()).isclose(e, rtol=1e-8).all()
    assert (alg.e1 * 0.5).exp().isclose(np.cosh(0.5) + np.sinh(0.5) * alg.e1, rtol=1e-15)
    assert (1000.0 * bs.algebra(2).e12).exp().isclose(np.cos(1000.0) + np.sin(1000.0) * bs.algebra(2).e12, rtol=1e-10)


def test_logs_of_what_is_no_rotor() -> None:
    cga = bs.cga3d
    with pytest.raises(errors.NotARotorError, match="point"):
        cga.point([1.0, 2.0, 3.0]).log()
    x = cga.multivector({"1": [1.0, 2.0], "e12": [0.0, 3.0]})
    assert x.log().status.tolist() == [bs.Status.OK, bs.Status.INVALID]
    with pytest.raises(errors.NotARotorError, match="item 1"):
        x.log(strict=True)
    with pytest.raises(errors.NotARotorError):
        x.sqrt(strict=True)


def test_statuses_travel_with_items_and_not_with_operations() -> None:
    s = bs.cga3d.sphere(np.zeros((3, 3)), [1.0, 0.0, 2.0])
    assert s.status.tolist() == [0, 6, 0] and s[1].status is bs.Status.INVALID and s[::-1][1:].status.tolist() == [6, 0]
    assert (-s).status.tolist() == [0, 0, 0] and np.isnan((-s).values[1]).all()


def test_what_is_not_finite_is_invalid_to_every_function_of_one_multivector() -> None:
    cga = bs.cga3d
    point, circle = cga.point([1.0, 2.0, 3.0]), cga.circle([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0)
    for x, kind in ((point, "point"), (circle, "circle"), (cga.translator([1.0, 2.0, 3.0]), "motor")):
        rows = np.stack([x.values] * 3)
        rows[1, 0], rows[2, -1] = np.nan, np.inf
        broken = cga.wrap(x.kind.layout, rows)
        wrapped = cga.wrap(x.kind, rows)
        found = [broken.normalized(), broken.normalized(kind), wrapped.normalized(), wrapped.inverse()]
        found += [broken.normalized(kind, tolerance=1e-6), broken.inverse("matrix"), broken.inverse()]
        for y in found:
            assert y.status[1:].tolist() == [bs.Status.INVALID] * 2 and np.isnan(y.values[1:]).all()
        with pytest.raises(errors.SingularError, match="item 1 is INVALID"):
            broken.normalized(kind, strict=True)
    lost = (0 * circle).normalized()
    assert lost.status is lost.normalized().status is lost.inverse().status is bs.Status.SINGULAR
