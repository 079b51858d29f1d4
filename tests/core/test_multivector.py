"""Multivectors as objects: making, reading, indexing, printing, converting, kinds, and what is refused."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, errors
from bladesmith.codegen.algebra.loader import data_from_algebra

RANDOM = np.random.default_rng(5)


# -- making ------------------------------------------------------------------------------------------------


def test_by_blade(alg: Any) -> None:
    a = alg.multivector({"e1": 1.0, "e12": [2.0, 3.0]})
    assert a.shape == (2,) and a.grades == (1, 2) and [str(b) for b in a.blades] == ["e1", "e12"]
    assert np.array_equal(a.values, [[1, 2], [1, 3]]) and a.dtype == np.float64 and a.algebra is alg
    assert np.array_equal(a["e21"], [-2, -3]) and np.array_equal(a["e3"], [0, 0])
    tuples = alg.multivector({(1,): 1.0, (2, 1): [-2.0, -3.0]})
    assert tuples.isclose(a).all()
    assert alg.multivector({alg.blades[1]: 1.0, "e12": [2, 3]}).isclose(a).all()
    assert alg.multivector({"e12": 1.0, "e21": 1.0})["e12"] == 0
    assert alg.multivector({}).values.tolist() == [0.0]


def test_by_array(alg: Any) -> None:
    values = RANDOM.normal(size=(4, 4))
    b = alg.multivector(values, grades=[0, 2])
    assert [str(x) for x in b.blades] == ["1", "e12", "e13", "e23"] and np.array_equal(b.values, values)
    values[0, 0] = 7
    assert b.values[0, 0] != 7  # it was copied
    dense = alg.multivector(RANDOM.normal(size=8))
    assert dense.kind.name == "multivector" and dense.shape == ()
    named = alg.multivector([[1.0, 2.0]], blades=["e2", "e31"])
    assert named["e13"][0] == -2 and named["e2"][0] == 1
    assert alg.multivector([1, 2, 3], grades=[1]).dtype == np.float64
    assert alg.multivector(np.ones(3, np.float32), grades=[1]).dtype == np.float32
    assert alg.multivector({"e1": 1.0}, dtype="float32").dtype == np.float32


def test_wide_labels_and_null_vectors() -> None:
    wide = bs.algebra(12)
    x = wide.multivector({"e1_12": 2.0, (3, 11): 1.0})
    assert x["e12_1"] == -2 and [str(b) for b in x.blades] == ["e1_12", "e3_11"]
    pga = bs.algebra(2, 0, 1)
    assert [str(b) for b in pga.blades[:4]] == ["1", "e0", "e1", "e2"] and (pga.e0 * pga.e0).norm() == 0
    cga = bs.cga3d
    assert cga.multivector({"e12no": 1.0, "e1noni": 2.0})["e1nino"] == -2.0
    assert [str(b) for b in cga.blades[1:6]] == ["e1", "e2", "e3", "no", "ni"]


def test_algebras_are_one_object_each() -> None:
    assert bs.algebra(3, 0, 1) is bs.pga3d and bs.algebra(4, 1) is bs.algebra(4, 1, 0) is not bs.cga3d
    assert bs.algebra(0).dimension == 0 and (bs.algebra(0).multivector([2.0]) * 3).values.tolist() == [6.0]
    assert (bs.algebra(2).e1, bs.algebra(2).e12)[1]["e12"] == 1


@pytest.mark.parametrize(
    ("values", "options", "error", "words"),
    [
        ({"e4": 1.0}, {}, errors.BladeError, "e4"),
        ({"e11": 1.0}, {}, errors.BladeError, "twice"),
        ({"f1": 1.0}, {}, errors.BladeError, "f1"),
        ({5: 1.0}, {}, errors.BladeError, "not a blade"),
        ({(1, 7): 1.0}, {}, errors.BladeError, "not a blade"),
        ({"e1": "one"}, {}, errors.InputError, "real numbers"),
        ({"e1": 1j}, {}, errors.InputError, "real numbers"),
        ({"e1": [1.0, 2.0], "e2": [1.0, 2.0, 3.0]}, {}, errors.ShapeError, "do not broadcast"),
        (np.ones(7), {}, errors.ShapeError, "8. is needed"),
        (np.ones((2, 3)), {"grades": [2, 0]}, errors.ShapeError, "4. is needed"),
        (1.0, {}, errors.ShapeError, "8. is needed"),
        (np.ones(3), {"grades": [4]}, errors.GradeError, "grade"),
        (np.ones(3), {"grades": ["1"]}, errors.GradeError, "grade"),
        (np.ones(3), {"kind": "motr"}, errors.KindError, "no kind 'motr'"),
        ([[1.0], [1.0, 2.0]], {}, errors.InputError, "ragged"),
        (np.ones(8, bool), {}, errors.InputError, "truth"),
        ({"e1": 1.0}, {"basis": "polar"}, errors.InputError, "orthonormal"),
        ({"e1": 1.0}, {"dtype": int}, errors.InputError, "float64 or float32"),
        (np.ones(2), {"blades": ["e1", "e1"]}, errors.BladeError, "twice"),
    ],
)
def test_bad_values(alg: Any, values: Any, options: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        alg.multivector(values, **options)


@pytest.mark.parametrize("signature", [(25,), (13, 12), (-1,), (2.0,), (True,), ("3",), (3, None), (9, 9, 9)])
def test_bad_signatures(signature: tuple[Any, ...]) -> None:
    bs.algebra(3)
    bs.algebra(1)  # equal to True, which must not find it
    bs.algebra(2)
    assert bs.algebra(np.int64(3), 0, np.uint8(1)) is bs.algebra(3, 0, 1)
    with pytest.raises(errors.SignatureError):
        bs.algebra(*signature)


def test_unknown_names() -> None:
    with pytest.raises(AttributeError, match="e9"):
        _ = bs.algebra(3).e9
    with pytest.raises(AttributeError, match="nothing"):
        _ = bs.nothing
    with pytest.raises(errors.KindError, match="did you mean 'circle'"):
        bs.cga3d.kind("cirle")
    with pytest.raises(errors.BladeError, match="did you mean 'e1noni'"):
        bs.cga3d.multivector({"e1nonj": 1.0})


# -- reading and operators ---------------------------------------------------------------------------------


def test_values_are_read_only_and_copies_writable(alg: Any) -> None:
    a = alg.e1 + 0
    with pytest.raises(ValueError, match="read-only"):
        a.values[0] = 3
    with pytest.raises(ValueError, match="WRITEABLE"):
        a.values.setflags(write=True)
    b = bs.cga3d.point([1.0, 2.0, 3.0]).copy()
    assert b.kind == bs.cga3d.layout("point")  # what may be written to is a kind no longer
    b.values[0] = 5
    assert b["e1"] == 5 and bs.cga3d.point([1.0, 2.0, 3.0])["e1"] == 1


def test_numbers_on_either_side(alg: Any) -> None:
    a = alg.multivector([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], grades=[1])
    for product in (2 * a, a * 2, np.float64(2) * a, np.int32(2) * a, a / 0.5, np.array(2.0) * a):
        assert np.array_equal(product.values, 2 * a.values)
    items = np.array([1.0, 10.0])
    assert np.array_equal((items * a).values, items[:, None] * a.values)
    assert np.array_equal((a / items).values, a.values / items[:, None])
    assert (items[:, None] * a).shape == (2, 2)
    assert (a + 1)["1"].tolist() == [1, 1] and (1 - a)["e1"].tolist() == [-1, -4]
    assert (items + a)["1"].tolist() == [1, 10]
    assert (a ^ 2).isclose(2 * a).all() and (2 ^ a).isclose(2 * a).all()
    assert (a | 2).norm().max() == 0 and (2 | a).norm().max() == 0
    assert (1 / alg.e1).isclose(alg.e1) and (alg.e12 / alg.e2).isclose(alg.e1)
    assert (a >> 3).isclose(a * 3 * ~a).all() and (a - a).norm().max() == 0 and (+a) is a


def test_named_methods_are_the_operators(alg: Any) -> None:
    a, b = (alg.multivector(RANDOM.normal(size=(3, 8))) for _ in range(2))
    assert a.outer(b).isclose(a ^ b).all() and a.inner(b).isclose(a | b).all() and a.sandwich(b).isclose(a >> b).all()
    assert a.meet(b).isclose(a & b).all() and a.join(b).isclose(a ^ b).all() and a.reverse().isclose(~a).all()
    pga = bs.pga3d
    x, y = (pga.multivector(RANDOM.normal(size=16)) for _ in range(2))
    assert x.meet(y).isclose(x ^ y) and x.join(y).isclose(x & y)
    assert (a.involute().conjugate()).isclose(~a).all()
    assert sum((a.grade(g) for g in range(1, 4)), a.grade(0)).isclose(a).all() and a.grade().norm().max() == 0
    assert np.allclose(a.norm() ** 2, np.abs((a * ~a)["1"]))


@pytest.mark.parametrize("wrong", ["text", None, {"e1": 1.0}, object()])
def test_operands_that_are_none(alg: Any, wrong: Any) -> None:
    for operation in (lambda: alg.e1 * wrong, lambda: alg.e1 + wrong, lambda: alg.e1 ^ wrong, lambda: wrong * alg.e1):
        with pytest.raises((TypeError, errors.InputError)):
            operation()


def test_mixed_algebras(alg: Any) -> None:
    other = bs.algebra(2)
    for operation in (lambda: alg.e1 * other.e1, lambda: alg.e1 + other.e1, lambda: alg.e1 >> other.e1):
        with pytest.raises(errors.AlgebraMismatchError, match="cl3_0_0 and cl2_0_0"):
            operation()


def test_indexing(alg: Any) -> None:
    a = alg.multivector(RANDOM.normal(size=(5, 4, 3)), grades=[1])
    assert a[3].shape == (4,) and a[1:3].shape == (2, 4) and a[:, None].shape == (5, 1, 4) and a[..., 2].shape == (5,)
    assert a[2, 1].shape == () and a[np.array([0, 2])].shape == (2, 4) and a[a["e1"] > 0].ndim == 1
    assert np.array_equal(a[4, 3].values, a.values[4, 3]) and len(a) == 5 and [x.shape for x in a] == [(4,)] * 5
    assert a.reshape(20).shape == (20,) and a.reshape(-1, 2).shape == (10, 2) and a.size == 20
    with pytest.raises(IndexError):
        a[0, 0, 0]
    with pytest.raises(TypeError):
        len(a[0, 0])
    with pytest.raises(errors.BladeError):
        a["e7"]


def test_what_a_multivector_is_not(alg: Any) -> None:
    a = alg.e1
    with pytest.raises(TypeError, match="hashable"):
        hash(a)
    with pytest.raises(TypeError, match="truth value"):
        bool(a)
    with pytest.raises(TypeError, match="isclose"):
        _ = a == a
    with pytest.raises(TypeError, match="made by an algebra"):
        bs.Multivector(alg)


def test_isclose(alg: Any) -> None:
    a = alg.multivector([[1.0, 2.0], [1.0, 3.0]], blades=["e1", "e2"])
    assert a.isclose(a + 1e-12).tolist() == [True, True] and a.isclose(alg.e1 + 2 * alg.e2).tolist() == [True, False]
    assert (alg.e1 - alg.e1).isclose(0) is np.True_ and not (alg.e1 * np.nan).isclose(alg.e1 * np.nan)
    assert alg.e1.astype(np.float32).isclose(alg.e1 * 1.00001) and not alg.e1.isclose(alg.e1 * 1.00001)


def test_text(alg: Any) -> None:
    assert repr(alg.multivector({"e1": 1.0, "e12": -2.5})) == "e1_e12 of cl3_0_0: 1 e1 - 2.5 e12"
    assert repr(bs.cga3d.point([0.0, 0.0, 0.0])) == "point of cga3d: 1 no"
    batch = repr(bs.cga3d.point(np.zeros((100, 3))))
    assert batch.splitlines()[0] == "point of cga3d, shape (100,):" and len(batch.splitlines()) == 8
    assert "[99]" in batch and "..." in batch
    assert "INVALID" in repr(bs.cga3d.sphere([0.0, 0.0, 0.0], -1.0))
    assert alg.multivector({"1": 1.0, "e12": 1e-9})._repr_latex_() == r"$1 + 1 \cdot 10^{-9} \mathbf{e}_{12}$"
    assert bs.cga3d.ni._repr_latex_() == r"$1 \mathbf{n}_{\infty}$"
    assert r"\vdots" in (alg.e1 * np.ones(9))._repr_latex_()
    assert repr(bs.algebra(10).multivector(np.ones(45), grades=[2])).endswith("(45 terms)")


def test_copies_and_pickles(alg: Any) -> None:
    a = bs.cga3d.sphere(np.zeros((2, 3)), [1.0, -1.0])
    for again in (pickle.loads(pickle.dumps(a)), copy.copy(a), copy.deepcopy(a)):
        assert again.algebra is a.algebra and again.kind == a.kind and again.status.tolist() == [0, 6]
        assert np.array_equal(again.values, a.values, equal_nan=True)
    b = alg.e12.astype(np.float32) * np.ones(3, np.float32)
    assert pickle.loads(pickle.dumps(b)).algebra is alg and pickle.loads(pickle.dumps(b)).dtype == np.float32
    assert pickle.loads(pickle.dumps(bs.cga3d)) is bs.cga3d and pickle.loads(pickle.dumps(alg)) is alg
    own = bs.Algebra.from_data({**data_from_algebra(alg), "name": "own"})
    assert pickle.loads(pickle.dumps(own.e1)).algebra is own


# -- kinds -------------------------------------------------------------------------------------------------


def test_constraints_are_checked() -> None:
    cga = bs.cga3d
    c = cga.circle(RANDOM.normal(size=(4, 3)), [0.0, 0.0, 1.0], 2.0)
    loose = cga.multivector(c.values, kind=cga.layout("circle"))
    assert loose.kind.is_layout and loose.as_kind("circle").kind == cga.kind("circle")
    assert cga.multivector(c.values, kind="circle").kind == cga.kind("circle")
    values = c.values.copy()
    values[2, 0] += 0.1
    with pytest.raises(errors.KindError, match="item 2 is not a circle of cga3d: x \\* x - 1"):
        cga.multivector(values, kind="circle")
    with pytest.raises(errors.KindError, match="a coefficient of e1no, which a motor"):
        cga.multivector({"1": 1.0, "e12": 1.0, "e1no": 1.0}).as_kind("motor")
    far = cga.circle([1e6, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0)  # its square cancels numbers of 1e12
    assert cga.multivector(far.values, kind="circle").kind.name == "circle"


def test_kinds_of_results_are_proved() -> None:
    cga, pga = bs.cga3d, bs.pga3d
    r = cga.rotor([0.0, 0.0, 1.0], 0.3)
    t = cga.translator([1.0, 2.0, 3.0])
    assert (t * r).kind == cga.kind("motor") and (r * r).kind == cga.kind("rotor")
    assert (~t).kind == cga.kind("translator")
    assert (r >> cga.circle([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 2.0)).kind == cga.kind("circle")
    assert r.as_kind("motor").kind == cga.kind("motor")  # every rotor is a motor: nothing to check
    s = cga.sphere([1.0, 0.0, 0.0], 1.0)
    assert (t * r >> s).kind == cga.kind("sphere") and (-s).kind == cga.kind("sphere")
    assert (s + s).kind.is_layout and (2 * s).kind.is_layout and s.dual().grades == (1,)
    plane = pga.plane([0.0, 0.0, 1.0], 1.0)
    assert (-plane).kind == pga.kind("plane") and (plane & plane).kind.is_layout


def test_normalized() -> None:
    cga = bs.cga3d
    a, b, c = (cga.point(RANDOM.normal(size=(6, 3))) for _ in range(3))
    assert (a ^ b ^ c).kind.is_layout and (a ^ b ^ c).normalized().kind == cga.kind("circle")
    assert (a ^ b).normalized().kind == cga.kind("point_pair")
    assert (a ^ b ^ cga.ni).normalized().kind == cga.kind("line")
    assert (3 * a).normalized().kind == cga.kind("point") and (3 * a).normalized().isclose(a).all()
    x = (a ^ b ^ c) + (a[::-1] ^ b ^ cga.ni)  # no blade
    assert x.normalized().kind.is_layout and np.allclose(x.normalized().norm(), 1)
    insisted = x.normalized("circle")
    assert insisted.kind == cga.kind("circle") and (insisted.status == bs.Status.INVALID).all()
    assert np.isnan(insisted.values).all()
    with pytest.raises(errors.SingularError, match="item 0 is INVALID"):
        x.normalized("circle", strict=True)
    null = (cga.e1 + 0 * a) * 0
    assert (null.normalized().status == bs.Status.SINGULAR).all() and np.isnan(null.normalized().values).all()
    assert cga.multivector({"1": 2.0, "e12": 1.0}).normalized().kind == cga.kind("rotor")
    motor = cga.motor_from_matrix(np.eye(4)) * 1.001 + 1e-4 * cga.multivector({"e123ni": 1.0})
    assert motor.normalized().kind == cga.kind("motor")
    assert a.normalized() is a


@pytest.mark.compiles
def test_kernels_take_and_give_multivectors() -> None:
    cga = bs.cga3d

    @codegen.kernel(cga.kind("motor"), cga.layout("point"), name="moved_by_test")
    def moved(m: Any, x: Any) -> Any:
        return m * x * ~m

    r, x = cga.rotor([0.0, 0.0, 1.0], 0.4), cga.point(RANDOM.normal(size=(5, 3)))
    assert moved(r, x).isclose(r >> x).all() and moved(r, x).algebra is cga
    with pytest.raises(errors.KindError, match="argument m.*is not a motor.*normalized"):
        moved(cga.multivector({"1": 1.0, "e12": 1.0}), x)
    with pytest.raises(errors.AlgebraMismatchError, match="argument|belongs"):
        moved(bs.pga3d.rotor([0.0, 0.0, 1.0], 0.4), x)


def test_symbols() -> None:
    x = bs.cga3d.symbols("x", kind="motor")
    assert str(x.coefficient("e12")) == "x_e12"
    assert (x * ~x).grades == (0, 4)
    with pytest.raises(errors.SignatureError):
        bs.cga3d.symbols("x; import os")
